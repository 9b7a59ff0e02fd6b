//! What is under the mouse: a picture of one pixel, as ids (`rendering.md` 17.6).

use glam::{Vec2, Vec3};
use vestibule_render::{PixelKind, RenderSettings, Scene, render_commands_ids};
use vestibule_view::{Camera, Command, FrameInput, FrameView, Openings, WorldObjects};
use vestibule_world::{CellId, World};

use crate::portals::JudgedPortal;

/// Something that was clicked.
#[derive(Clone, Debug, PartialEq)]
pub struct Picked {
    /// What it is, in a few words.
    pub what: String,
    /// The cell it belongs to.
    pub cell: Option<CellId>,
    /// More about it, name and value.
    pub facts: Vec<(&'static str, String)>,
    /// Portals between the eye and it that the traversal judged, the nearest first.
    pub portals: Vec<JudgedPortal>,
}

/// What a camera shows at a pixel. The traversal is made anew for that pixel alone.
pub fn pick(
    scene: &Scene<'_>,
    openings: &Openings,
    input: &FrameInput,
    hidden: impl Fn(&Command) -> bool,
    pixel: Vec2,
) -> Option<Picked> {
    let whole = &input.camera;
    let ray = whole.ray_through(pixel);
    let up = if ray.normalize_or_zero().z.abs() > 0.99 {
        Vec3::Y
    } else {
        Vec3::Z
    };
    // As wide as the pixel.
    let fov = (2.0 * whole.slopes().y / whole.viewport().y).clamp(1.0e-4, 0.1);
    let camera = Camera::new(whole.cell(), whole.eye(), ray, up, fov, Vec2::ONE).ok()?;
    let mut source = WorldObjects::new(scene.world);
    if let Some(population) = scene.population {
        source = source.with_population(population);
    }
    let mut frame = FrameView::default();
    frame.update(scene.world, openings, &source, &FrameInput { camera, ..*input });
    let commands: Vec<Command> = frame.commands().iter().filter(|c| !hidden(c)).copied().collect();
    let (ids, _) = render_commands_ids(scene, &frame, &commands, &RenderSettings::default()).ok()?;
    let id = ids.get(0, 0)?;
    let cell = id.cell();
    let mut facts = Vec::new();
    if let Some(cell) = cell {
        facts.push(("cell", cell.to_string()));
    }
    let what = match id.kind() {
        PixelKind::Background => "nothing: the clear colour".to_owned(),
        PixelKind::Sky => "the sky".to_owned(),
        PixelKind::Terrain => {
            facts.extend(cell.and_then(|c| ground(scene.world, c)));
            "the ground".to_owned()
        }
        PixelKind::Building => {
            let building = cell.and_then(|c| scene.world.building_on(c));
            let model = building.and_then(|b| b.shape.parts.first()).map(|p| p.model_id);
            if let Some(model) = model {
                facts.push(("model", format!("0x{model:08X}")));
                let surface = surface_of_model(scene, model, id.item() as u16);
                facts.extend(surface.map(|s| ("surface", s)));
            }
            facts.push(("polygon", id.item().to_string()));
            "the shell of a building".to_owned()
        }
        PixelKind::Room => {
            if let Some(room) = cell.and_then(|c| scene.world.env_cell(c)) {
                let s = &room.structure;
                facts.push(("environment", format!("0x{:08X} / {}", s.environment, s.key)));
                facts.extend(surface_of_room(scene, room, id.item() as u16).map(|s| ("surface", s)));
            }
            facts.push(("polygon", id.item().to_string()));
            "a room".to_owned()
        }
        PixelKind::Object => {
            let block = cell.and_then(|c| scene.world.loaded_block(c.block()));
            match block.and_then(|b| b.statics.get(id.item() as usize)) {
                Some(object) => {
                    facts.push(("shape", format!("0x{:08X}", object.shape.id)));
                    facts.push(("object", format!("static {} of its landblock", id.item())));
                    let o = object.frame.origin;
                    facts.push(("stands at", format!("{:.2} {:.2} {:.2}", o.x, o.y, o.z)));
                    "an object".to_owned()
                }
                None => "a body".to_owned(),
            }
        }
    };
    Some(Picked {
        what,
        cell,
        facts,
        portals: Vec::new(),
    })
}

fn ground(world: &World, cell: CellId) -> Option<(&'static str, String)> {
    let land = world.land_cell(cell)?;
    Some(("split", format!("{:?}, water {:?}", land.split, land.water)))
}

fn surface_of_room(scene: &Scene<'_>, room: &vestibule_world::EnvCell, polygon: u16) -> Option<String> {
    let mesh = scene.assets.cell_shell(scene.world, room)?;
    let face = mesh.faces.iter().find(|f| f.polygon == polygon)?;
    let id = room.surfaces.get(face.material as usize)?;
    Some(surface(&mesh, face.material, Some(*id)))
}

fn surface_of_model(scene: &Scene<'_>, model: u32, polygon: u16) -> Option<String> {
    let mesh = scene.assets.model(scene.world, model, None)?;
    let face = mesh.faces.iter().find(|f| f.polygon == polygon)?;
    Some(surface(&mesh, face.material, None))
}

fn surface(mesh: &vestibule_render::Mesh, index: u32, id: Option<u32>) -> String {
    let texture = mesh.materials.get(index as usize).map(|m| &m.texture);
    let size = texture.map_or(String::new(), |t| {
        format!(", {} x {} texels", t.width(), t.height())
    });
    match id {
        Some(id) => format!("0x{id:08X} (number {index}{size})"),
        None => format!("number {index}{size}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::hollow;
    use vestibule_render::Assets;

    #[test]
    fn a_click_names_room_polygon_and_surface() {
        let (world, _) = hollow();
        let assets = Assets::new();
        let scene = Scene::new(&world, &assets);
        let eye = Vec3::new(155.4, 13.4, 95.6);
        let size = Vec2::new(320.0, 240.0);
        let at = |forward: Vec3| {
            let camera = Camera::new(CellId(0xA9B4_0101), eye, forward, Vec3::Z, 1.0, size).unwrap();
            let input = FrameInput::new(camera);
            pick(&scene, &Openings::new(), &input, |_| false, size * 0.5).unwrap()
        };
        let floor = at(Vec3::new(0.0, 0.3, -1.0));
        assert_eq!(floor.what, "a room");
        assert!(floor.facts.iter().any(|f| f.0 == "surface"), "{floor:?}");
        assert!(floor.facts.iter().any(|f| f.0 == "polygon"));
    }
}
