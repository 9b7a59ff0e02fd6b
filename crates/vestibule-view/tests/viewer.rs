//! The viewer's sweep: conformance test 7 of the study, `rendering.md` 3 and tests R5, R21, in the worlds of the
//! test vectors.

mod common;

use std::io::Write as _;
use std::path::Path;

use common::maze::Random;
use glam::{Vec2, Vec3};
use vestibule_dat::DatSet;
use vestibule_physics::{Population, Scratch};
use vestibule_view::{
    CameraMode, CameraRig, ChaseCamera, FramePath, FrameView, Openings, PIVOT_OFFSET, PlayerCell,
    VIEWER_SPHERE_RADIUS, Viewer, ViewerCell, ViewerSource, ViewerTarget, WorldObjects, update_viewer,
};
use vestibule_world::{BlockId, CellId, EnvCell, Frame, Landblock, Position, World};

fn world(name: &str) -> Option<World> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/vectors/worlds")
        .join(name);
    if !folder.exists() {
        let _ = writeln!(std::io::stderr(), "skipped: no world at {}", folder.display());
        return None;
    }
    Some(World::open(DatSet::open(folder).unwrap()).unwrap())
}

const VESTIBULE: CellId = CellId(0xA9B4_0100);
const MAIN: CellId = CellId(0xA9B4_0101);
/// Feet in the main room, 6 m north of the door; and in the yard, south of it.
const IN_ROOM: Vec3 = Vec3::new(84.0, 83.0, 40.105);
const IN_YARD: Vec3 = Vec3::new(84.0, 77.5, 40.105);

struct Stage {
    world: World,
    population: Population,
    scratch: Scratch,
    openings: Openings,
}

impl Stage {
    fn open(name: &str) -> Option<Self> {
        let (population, scratch) = (Population::new(), Scratch::new());
        Some(Stage {
            world: world(name)?,
            population,
            scratch,
            openings: Openings::new(),
        })
    }

    fn view(&mut self, target: &ViewerTarget, sought: &Position) -> Viewer {
        update_viewer(
            &self.world,
            &self.population,
            &mut self.scratch,
            target,
            PIVOT_OFFSET,
            sought,
        )
    }

    fn path(&self, viewer: &Viewer, target: &ViewerTarget) -> FramePath {
        let input = viewer
            .frame_input(target.cell, 1.0, Vec2::new(640.0, 480.0))
            .unwrap();
        let mut frame = FrameView::default();
        frame.update(
            &self.world,
            &self.openings,
            &WorldObjects::new(&self.world),
            &input,
        )
    }
}

fn standing(cell: CellId, feet: Vec3) -> ViewerTarget {
    let land = feet == IN_YARD;
    let cell = if land {
        cell.adjust_to_outside(feet).unwrap().0
    } else {
        cell
    };
    ViewerTarget::at(Position::new(cell, feet))
}

/// The sought position at an offset from the pivot, looking back at it.
fn sought(target: &ViewerTarget, offset: Vec3) -> Position {
    let origin = target.pivot(PIVOT_OFFSET).origin + offset;
    Position {
        cell: target.position.cell,
        frame: Frame::at(origin),
    }
}

#[test]
fn study_test_7_the_camera_cell_follows_the_camera() {
    let Some(mut stage) = Stage::open("cottage-1") else {
        return;
    };
    let outside = standing(MAIN, IN_YARD);
    // Player in the yard, camera swung through the open door into the main room.
    let viewer = stage.view(&outside, &sought(&outside, Vec3::new(0.0, 4.5, 0.2)));
    assert_eq!(
        (viewer.source, viewer.cell),
        (ViewerSource::Swept, Some(ViewerCell(MAIN)))
    );
    assert_eq!(stage.path(&viewer, &outside), FramePath::SeesOut);
    // And back.
    let viewer = stage.view(&outside, &sought(&outside, Vec3::new(0.0, -2.5, 0.75)));
    let cell = viewer.cell.unwrap();
    assert!(cell.0.is_land_cell(), "{cell:?}");
    assert_eq!(stage.path(&viewer, &outside), FramePath::Outdoors);
}

#[test]
fn r5_player_inside_camera_outside_and_the_reverse() {
    let Some(mut stage) = Stage::open("cottage-1") else {
        return;
    };
    let inside = standing(MAIN, Vec3::new(84.0, 80.2, 40.105));
    for (offset, want, path) in [
        (Vec3::new(0.0, 2.0, 0.2), Some(MAIN), FramePath::SeesOut),
        (Vec3::new(0.0, -0.9, 0.0), Some(VESTIBULE), FramePath::SeesOut),
        (Vec3::new(0.0, -3.0, 0.2), None, FramePath::Outdoors),
    ] {
        let viewer = stage.view(&inside, &sought(&inside, offset));
        assert_eq!(viewer.source, ViewerSource::Swept);
        match want {
            Some(cell) => assert_eq!(viewer.cell, Some(ViewerCell(cell))),
            None => assert!(viewer.cell.unwrap().0.is_land_cell()),
        }
        assert_eq!(
            inside.cell,
            Some(PlayerCell(MAIN)),
            "the player's cell is its own"
        );
        assert_eq!(stage.path(&viewer, &inside), path, "{offset}");
    }
}

#[test]
fn r21_walls_ceilings_and_fallbacks() {
    let Some(mut stage) = Stage::open("cottage-1") else {
        return;
    };
    let inside = standing(MAIN, IN_ROOM);
    let pivot = inside.pivot(PIVOT_OFFSET).origin;
    // Free.
    let viewer = stage.view(&inside, &sought(&inside, Vec3::new(0.0, 2.0, 0.5)));
    assert!((viewer.position.frame.origin - viewer.sought.frame.origin).length() < 1e-4);
    // A wall behind: the north wall stands at 88.5.
    let viewer = stage.view(&inside, &sought(&inside, Vec3::new(0.0, 9.0, 0.0)));
    let y = viewer.position.frame.origin.y;
    assert!(y <= 88.2 + 1e-3 && y > 87.9, "{y}");
    assert_eq!(viewer.cell, Some(ViewerCell(MAIN)));
    // The ceiling at 43.5.
    let viewer = stage.view(&inside, &sought(&inside, Vec3::new(0.0, 0.0, 5.0)));
    let z = viewer.position.frame.origin.z;
    assert!(z <= 43.2 + 1e-3 && z > 42.9, "{z}");
    // Rotation is the sought one, whatever stopped the eye.
    let mut turned = sought(&inside, Vec3::new(0.0, 9.0, 0.0));
    turned
        .frame
        .set_rotation(vestibule_physics::heading_to_rotation(137.0));
    assert_eq!(
        stage.view(&inside, &turned).position.frame.rotation(),
        turned.frame.rotation()
    );
    // The player in no cell: its own position, and no cell.
    let nowhere = ViewerTarget { cell: None, ..inside };
    let viewer = stage.view(&nowhere, &sought(&inside, Vec3::Y));
    assert_eq!((viewer.source, viewer.cell), (ViewerSource::Player, None));
    assert_eq!(viewer.position, inside.position);
    // The player in a cell that does not exist: the sweep fails, and so does everything else.
    let absent = ViewerTarget::at(Position::new(CellId(0xA9B4_0190), IN_ROOM));
    let viewer = stage.view(&absent, &sought(&absent, Vec3::Y));
    assert_eq!((viewer.source, viewer.cell), (ViewerSource::Player, None));
    // A player that is lost, a camera that is not: the sought place has a cell.
    let viewer = stage.view(&absent, &Position::new(MAIN, pivot));
    assert_eq!(
        (viewer.source, viewer.cell),
        (ViewerSource::Adjusted, Some(ViewerCell(MAIN)))
    );
    // Numbers that are none.
    let viewer = stage.view(&inside, &Position::new(MAIN, Vec3::NAN));
    assert_eq!((viewer.source, viewer.cell), (ViewerSource::Player, None));
}

#[test]
fn r21_r3_7b_rest_is_rest_to_the_bit() {
    let Some(mut stage) = Stage::open("cottage-1") else {
        return;
    };
    let target = standing(MAIN, IN_ROOM);
    let mut rig = CameraRig::new(ChaseCamera::default());
    let mut step = |stage: &mut Stage| {
        let (world, population) = (&stage.world, &stage.population);
        *rig.update(world, population, &mut stage.scratch, Some(&target), 1.0 / 60.0)
            .unwrap()
    };
    let mut settled = step(&mut stage);
    for _ in 0..400 {
        settled = step(&mut stage);
    }
    for _ in 0..100 {
        let again = step(&mut stage);
        assert_eq!(again.position, settled.position);
        assert_eq!(again.cell, settled.cell);
    }
}

#[test]
fn r3_3_a_scripted_camera_stays_and_no_player_changes_nothing() {
    let Some(mut stage) = Stage::open("cottage-1") else {
        return;
    };
    let target = standing(MAIN, IN_ROOM);
    let mut rig = CameraRig::new(ChaseCamera::default());
    assert!(
        rig.update(&stage.world, &stage.population, &mut stage.scratch, None, 0.1)
            .is_none()
    );
    let first = *rig
        .update(
            &stage.world,
            &stage.population,
            &mut stage.scratch,
            Some(&target),
            0.1,
        )
        .unwrap();
    rig.is_static = true;
    let moved = standing(MAIN, IN_ROOM + Vec3::Y);
    let kept = *rig
        .update(
            &stage.world,
            &stage.population,
            &mut stage.scratch,
            Some(&moved),
            0.1,
        )
        .unwrap();
    assert_eq!(first, kept);
    rig.is_static = false;
    rig.camera.set_mode(CameraMode::FirstPerson);
    for _ in 0..3 {
        rig.update(
            &stage.world,
            &stage.population,
            &mut stage.scratch,
            Some(&moved),
            0.1,
        );
    }
    let eye = rig.viewer().unwrap().position.frame.origin;
    assert!(
        (eye - (IN_ROOM + Vec3::Y + Vec3::new(0.0, 0.18, 1.5))).length() < 1e-3,
        "{eye}"
    );
}

/// A solid polygon, landblock frame.
struct Wall {
    /// Part of a building's shell, which stops only who is outdoors (`world.md` C5).
    shell: bool,
    vertices: Vec<Vec3>,
    normal: Vec3,
    d: f32,
}

impl Wall {
    fn of(frame: &Frame, vertices: &[Vec3], shell: bool) -> Self {
        let vertices: Vec<Vec3> = vertices.iter().map(|&p| frame.local_to_global(p)).collect();
        let plane = vestibule_world::Plane::of_polygon(&vertices);
        Wall {
            shell,
            vertices,
            normal: plane.normal,
            d: plane.d,
        }
    }

    fn distance(&self, p: Vec3) -> f32 {
        let off = self.normal.dot(p) + self.d;
        let flat = p - self.normal * off;
        let sides = || self.vertices.iter().zip(self.vertices.iter().cycle().skip(1));
        if sides().all(|(&a, &b)| self.normal.cross(b - a).dot(flat - a) >= 0.0) {
            return off.abs();
        }
        sides()
            .map(|(&a, &b)| {
                let along = b - a;
                let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                (p - a - along * t).length()
            })
            .fold(f32::INFINITY, f32::min)
    }

    /// Whether the way from `a` to `b` goes through it.
    fn is_crossed(&self, a: Vec3, b: Vec3) -> bool {
        let (da, db) = (self.normal.dot(a) + self.d, self.normal.dot(b) + self.d);
        if (da > 0.0) == (db > 0.0) {
            return false;
        }
        let at = a + (b - a) * (da / (da - db));
        let mut sides = self.vertices.iter().zip(self.vertices.iter().cycle().skip(1));
        sides.all(|(&a, &b)| self.normal.cross(b - a).dot(at - a) >= 0.0)
    }
}

fn walls(block: &Landblock) -> Vec<Wall> {
    let mut out = Vec::new();
    let mut add = |frame: &Frame, set: &vestibule_world::PolygonSet, shell: bool| {
        out.extend(
            set.polygons()
                .iter()
                .map(|p| Wall::of(frame, set.vertices(p), shell)),
        );
    };
    for cell in block.env_cells() {
        if let Some(physics) = &cell.structure.physics {
            add(&cell.frame, physics.polygons(), false);
        }
    }
    for building in &block.buildings {
        let model = building.shape.parts.first().and_then(|p| p.model.as_ref());
        if let Some(physics) = model.and_then(|m| m.physics.as_ref()) {
            add(&building.part_frames[0], physics.polygons(), true);
        }
    }
    out
}

fn a_point_in(cell: &EnvCell, random: &mut Random) -> Option<Vec3> {
    let b = cell.structure.bounds?;
    let p = Vec3::new(
        random.within(b.min.x, b.max.x),
        random.within(b.min.y, b.max.y),
        random.within(b.min.z, b.max.z),
    );
    let p = cell.frame.local_to_global(p);
    cell.contains_point(p).then_some(p)
}

/// 100,000 random camera sweeps: the eye never ends behind a wall, nor nearer to one than its sphere (3.7c).
#[test]
fn r3_7c_the_camera_never_ends_behind_a_wall() {
    let (mut sweeps, mut blocked, mut left_the_room, mut failed) = (0, 0, 0, 0);
    for (name, count) in [
        ("cottage-1", 25_000),
        ("cottage-2", 15_000),
        ("dungeon-1", 25_000),
        ("gallery-1", 15_000),
        ("maze-1", 20_000),
    ] {
        let Some(mut stage) = Stage::open(name) else {
            return;
        };
        let blocks = (0..=u16::MAX).map(BlockId).filter(|b| b.is_on_map());
        let block_id = blocks
            .into_iter()
            .find(|&b| {
                stage
                    .world
                    .block(b)
                    .is_some_and(|b| b.env_cells().next().is_some())
            })
            .unwrap();
        let (walls, cells): (Vec<Wall>, Vec<CellId>) = {
            let block = stage.world.block(block_id).unwrap();
            (walls(block), block.env_cells().map(|c| c.id).collect())
        };
        let mut random = Random(1);
        let mut done = 0;
        while done < count {
            let cell = cells[random.below(cells.len())];
            let Some(pivot) = a_point_in(stage.world.env_cell(cell).unwrap(), &mut random) else {
                continue;
            };
            if walls
                .iter()
                .any(|w| w.distance(pivot) < VIEWER_SPHERE_RADIUS + 0.05)
            {
                continue;
            }
            let target = ViewerTarget::at(Position::new(cell, pivot - PIVOT_OFFSET));
            // Several looks from one place.
            for _ in 0..20 {
                let yaw = random.within(0.0, core::f32::consts::TAU);
                let pitch = random.within(-1.2, 1.2);
                let level = libm::cosf(pitch);
                let direction = Vec3::new(
                    level * libm::sinf(yaw),
                    level * libm::cosf(yaw),
                    libm::sinf(pitch),
                );
                let reach = random.within(0.5, 6.0);
                let viewer = stage.view(&target, &sought(&target, direction * reach));
                done += 1;
                sweeps += 1;
                if viewer.source != ViewerSource::Swept {
                    failed += 1;
                    continue;
                }
                let viewer_cell = viewer.cell.unwrap().0;
                let eye = viewer.position.frame.origin
                    + vestibule_world::ids::block_offset(block_id, viewer.position.cell.block());
                let went = (eye - pivot).length();
                blocked += usize::from(went < reach - 0.01);
                left_the_room += usize::from(viewer_cell != cell);
                let what =
                    format!("{name}: from {cell} {pivot} along {direction} for {reach}: {viewer_cell} {eye}");
                for wall in walls.iter().filter(|w| !w.shell || viewer_cell.is_land_cell()) {
                    assert!(!wall.is_crossed(pivot, eye), "behind a wall: {what}");
                    // Outdoors the edges of a room's floor and walls may be nearer, on the far side of its door.
                    assert!(
                        viewer_cell.is_land_cell() || wall.distance(eye) >= VIEWER_SPHERE_RADIUS - 1.0e-3,
                        "{} from a wall: {what}",
                        wall.distance(eye)
                    );
                }
                if let Some(room) = stage.world.env_cell(viewer_cell) {
                    assert!(room.contains_point(eye), "not in its cell: {what}");
                } else {
                    let ground = stage
                        .world
                        .ground_at(viewer_cell, viewer.position.frame.origin)
                        .unwrap();
                    assert!(eye.z > ground.z, "under the ground: {what}");
                }
            }
        }
    }
    let _ = writeln!(
        std::io::stderr(),
        "{sweeps} camera sweeps: {blocked} blocked, {left_the_room} ended in another cell, {failed} fell back"
    );
    assert!(failed * 1000 < sweeps, "{failed} of {sweeps} sweeps fell back");
}
