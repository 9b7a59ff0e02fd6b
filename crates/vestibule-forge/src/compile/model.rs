//! Models of static objects: GfxObj records, and Setups for those that need one.

use glam::Vec3;
use vestibule_dat::primitive::{Argb, CylSphere, Frame, Sphere};
use vestibule_dat::record::{Light, PlacementFrame, Setup};

use super::room::painted;
use super::structure::ModelParts;
use super::world::{Problem, Records};
use crate::geometry::Polytope;
use crate::scene::{Collide, ModelDef};

/// Adds a model; answers the id by which objects name it.
pub(crate) fn add_model(
    records: &mut Records,
    model: &ModelDef,
    surfaces: &[u32],
    sizes: &[f64],
) -> Result<u32, Problem> {
    let parts: Vec<Polytope> = model
        .solids
        .iter()
        .flat_map(|s| painted(s, &model.paint, false))
        .collect();
    let collides = model.collide == Collide::Polygons;
    let id = records.next_id(0x0100_0001);
    let built = ModelParts::of_solids(&parts, collides).build(id, surfaces, sizes)?;
    let around = built
        .record
        .drawing
        .as_ref()
        .map(|d| d.bsp.bounding_sphere())
        .unwrap_or_default();
    records.portal.insert(id, built.record.encode()?);
    let (mut cyl_spheres, mut spheres) = (Vec::new(), Vec::new());
    match model.collide {
        Collide::Cylinder(radius, height) => cyl_spheres.push(CylSphere {
            low_point: Vec3::ZERO,
            radius: radius as f32,
            height: height as f32,
        }),
        Collide::Sphere(height, radius) => {
            spheres.push(Sphere {
                center: Vec3::Z * height as f32,
                radius: radius as f32,
            });
        }
        Collide::Polygons if model.lights.is_empty() => return Ok(id),
        Collide::Polygons | Collide::Nothing if model.lights.is_empty() && collides => return Ok(id),
        Collide::Nothing if model.lights.is_empty() => return Ok(id),
        Collide::Polygons | Collide::Nothing => {}
    }
    let (low, high) = parts.iter().map(Polytope::bounds).fold(
        (glam::DVec3::INFINITY, glam::DVec3::NEG_INFINITY),
        |(low, high), (a, b)| (low.min(a), high.max(b)),
    );
    let lights = (0i32..).zip(&model.lights).map(|(key, light)| {
        let [r, g, b] = light.color.map(u32::from);
        Light {
            key,
            frame: Frame {
                origin: light.at.as_vec3(),
                ..Frame::IDENTITY
            },
            color: Argb(0xFF00_0000 | r << 16 | g << 8 | b),
            intensity: light.intensity as f32,
            falloff: light.falloff as f32,
            cone_angle: 0.0,
        }
    });
    let setup = Setup {
        id: records.next_id(0x0200_0001),
        flags: if collides { Setup::HAS_PHYSICS_BSP } else { 0 },
        parts: vec![id],
        placement_frames: vec![PlacementFrame {
            placement: Setup::DEFAULT_PLACEMENT,
            frames: vec![Frame::IDENTITY],
            hooks: Vec::new(),
        }],
        cyl_spheres,
        spheres,
        height: high.z.max(0.0) as f32,
        radius: ((high - low).truncate().max_element() * 0.5) as f32,
        sorting_sphere: around,
        selection_sphere: around,
        lights: lights.collect(),
        ..Setup::default()
    };
    records.portal.insert(setup.id, setup.encode()?);
    Ok(setup.id)
}
