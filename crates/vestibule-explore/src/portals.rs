//! What became of each portal in the traversal, and why (`visibility.md` 4, 5).

use glam::{Vec2, Vec3};
use vestibule_view::{Camera, Flood, FrameView, SeenCell};
use vestibule_world::{CellId, CellPortal, EnvCell, PortalTarget, World};

/// What the traversal did with a portal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It was passed: the cell behind is seen through it.
    Passed,
    /// It leads outside, and the landscape is seen through it.
    Outside,
    /// The eye is behind it.
    FacesAway,
    /// It lies outside the regions through which its cell is seen.
    OutOfView,
    /// The cell behind it is not loaded.
    NotLoaded,
    /// Nothing of it was left after clipping.
    ClippedAway,
}

impl Verdict {
    /// All, as a legend lists them.
    pub const ALL: [Verdict; 6] = [
        Verdict::Passed,
        Verdict::Outside,
        Verdict::FacesAway,
        Verdict::OutOfView,
        Verdict::ClippedAway,
        Verdict::NotLoaded,
    ];

    /// The verdict in a few words.
    pub fn text(self) -> &'static str {
        match self {
            Verdict::Passed => "passed",
            Verdict::Outside => "shows the outside",
            Verdict::FacesAway => "refused: faces away",
            Verdict::OutOfView => "refused: out of view",
            Verdict::NotLoaded => "refused: cell not loaded",
            Verdict::ClippedAway => "refused: clipped away",
        }
    }

    /// Its colour in overlays.
    pub fn color(self) -> [u8; 3] {
        match self {
            Verdict::Passed => [70, 220, 90],
            Verdict::Outside => [80, 190, 255],
            Verdict::FacesAway => [150, 150, 160],
            Verdict::OutOfView => [255, 150, 40],
            Verdict::NotLoaded => [255, 40, 200],
            Verdict::ClippedAway => [255, 70, 60],
        }
    }
}

/// Where a portal leads, in a word.
pub(crate) fn leads_to(target: PortalTarget) -> String {
    match target {
        PortalTarget::Outside => "outside".to_owned(),
        PortalTarget::Cell(id) => format!("{:04X}", id.low()),
    }
}

/// A portal's corners relative to the eye, landscape axes.
pub(crate) fn corners(camera: &Camera, cell: &EnvCell, portal: &CellPortal) -> Vec<Vec3> {
    let eye = camera.eye_in(cell.id.block());
    cell.portal_vertices(portal)
        .iter()
        .map(|v| cell.frame.local_to_global(*v) - eye)
        .collect()
}

/// What became of a portal of a listed cell.
pub fn verdict(
    world: &World,
    camera: &Camera,
    flood: &Flood<'_>,
    seen: &SeenCell,
    cell: &EnvCell,
    portal: &CellPortal,
) -> Verdict {
    let own = flood.views(seen).as_ptr_range();
    let came_from_here = |parent: Option<u32>| {
        let view = parent.and_then(|k| flood.view(k));
        view.is_some_and(|v| own.contains(&core::ptr::from_ref(v)))
    };
    let through =
        |v: &vestibule_view::SeenView| v.portal == Some(portal.record_index) && came_from_here(v.parent);
    match portal.other {
        PortalTarget::Outside => {
            if flood.outside_views().iter().any(through) {
                return Verdict::Outside;
            }
        }
        PortalTarget::Cell(id) => {
            let found = flood.cells().iter().find(|c| c.id == id);
            if found.is_some_and(|c| flood.views(c).iter().any(through)) {
                return Verdict::Passed;
            }
            if !world.is_resident(id) {
                return Verdict::NotLoaded;
            }
        }
    }
    let eye = cell.frame.global_to_local(camera.eye_in(cell.id.block()));
    let side = portal.plane.dist(eye);
    let inside = if portal.interior_is_negative { -side } else { side };
    if inside < 0.0 {
        return Verdict::FacesAway;
    }
    let corners = corners(camera, cell, portal);
    let beyond = |region: vestibule_view::Region<'_>| {
        let edges = region.edges().iter();
        edges
            .clone()
            .any(|e| corners.iter().all(|c| e.normal.dot(*c) < 0.0))
            || corners.iter().all(|c| camera.forward().dot(*c) < 0.0)
    };
    if flood.regions(seen).all(beyond) {
        return Verdict::OutOfView;
    }
    Verdict::ClippedAway
}

/// A portal, and what became of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JudgedPortal {
    /// The cell it belongs to.
    pub from: CellId,
    /// Number of the portal in its cell's record.
    pub record: u16,
    /// Where it leads.
    pub to: PortalTarget,
    /// What the traversal did with it.
    pub verdict: Verdict,
    /// Metres from the eye.
    pub distance: f32,
}

/// The portals of listed cells that lie at a pixel of a camera, the nearest first. Portals are listed once, by the
/// side that the traversal came from.
pub fn along(world: &World, frame: &FrameView, camera: &Camera, pixel: Vec2) -> Vec<JudgedPortal> {
    let Some(judge) = frame.camera() else {
        return Vec::new();
    };
    let ray = camera.ray_through(pixel).normalize_or_zero();
    let mut out: Vec<JudgedPortal> = Vec::new();
    for flood in frame.floods().iter() {
        for seen in flood.cells() {
            let Some(cell) = world.env_cell(seen.id) else {
                continue;
            };
            for portal in &cell.portals {
                let Some(distance) = pierced(&corners(camera, cell, portal), ray) else {
                    continue;
                };
                let verdict = verdict(world, judge, &flood, seen, cell, portal);
                // What faces away is the back of one that is listed already.
                if verdict != Verdict::FacesAway {
                    out.push(JudgedPortal {
                        from: seen.id,
                        record: portal.record_index,
                        to: portal.other,
                        verdict,
                        distance,
                    });
                }
            }
        }
    }
    out.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    out.dedup_by_key(|p| (p.from, p.record));
    out
}

/// How far along a ray from the eye a flat convex polygon lies; `None` if it is missed.
fn pierced(corners: &[Vec3], ray: Vec3) -> Option<f32> {
    let side = |k: usize| corners[k].cross(corners[(k + 1) % corners.len()]).dot(ray);
    let all = |sign: f32| (0..corners.len()).all(|k| side(k) * sign >= 0.0);
    let [a, b, c, ..] = corners else { return None };
    let normal = (*b - *a).cross(*c - *a);
    let distance = normal.dot(*a) / normal.dot(ray);
    (distance.is_finite() && distance > 0.0 && (all(1.0) || all(-1.0))).then_some(distance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::hollow;
    use glam::Vec2;
    use vestibule_view::{FrameInput, FrameView, Openings, WorldObjects};
    use vestibule_world::CellId;

    #[test]
    fn a_ray_through_the_doorway_meets_its_portals_in_order() {
        let (world, _) = hollow();
        let at = CellId(0xA9B4_0101);
        let size = Vec2::new(320.0, 240.0);
        let camera = Camera::new(at, Vec3::new(155.4, 12.4, 95.2), Vec3::Y, Vec3::Z, 1.0, size).unwrap();
        let mut frame = FrameView::default();
        let objects = WorldObjects::new(&world);
        frame.update(&world, &Openings::new(), &objects, &FrameInput::new(camera));
        let met = along(&world, &frame, &camera, size * 0.5);
        let verdicts: Vec<Verdict> = met.iter().map(|p| p.verdict).collect();
        assert_eq!(verdicts, [Verdict::Passed, Verdict::Outside], "{met:?}");
        assert!(met[0].from == at && met[0].distance < met[1].distance);
        assert_eq!(along(&world, &frame, &camera, Vec2::new(0.0, 239.0)), []);
    }

    #[test]
    fn portals_tell_what_became_of_them() {
        let (world, _) = hollow();
        let eye = Vec3::new(155.4, 13.4, 95.6);
        let look = |forward: Vec3| {
            let camera = Camera::new(
                CellId(0xA9B4_0101),
                eye,
                forward,
                Vec3::Z,
                1.0,
                Vec2::new(320.0, 240.0),
            )
            .unwrap();
            let mut frame = FrameView::default();
            frame.update(
                &world,
                &Openings::new(),
                &WorldObjects::new(&world),
                &FrameInput::new(camera),
            );
            let flood = frame.interior().unwrap();
            let mut out = Vec::new();
            for seen in flood.cells() {
                let cell = world.env_cell(seen.id).unwrap();
                for portal in &cell.portals {
                    out.push((seen.id, verdict(&world, &camera, &flood, seen, cell, portal)));
                }
            }
            out
        };
        let north = look(Vec3::Y);
        assert!(north.iter().any(|v| v.1 == Verdict::Passed), "{north:?}");
        assert!(north.iter().any(|v| v.1 == Verdict::Outside), "{north:?}");
        let south = look(-Vec3::Y);
        assert!(south.iter().any(|v| v.1 == Verdict::OutOfView), "{south:?}");
        assert!(!south.iter().any(|v| v.1 == Verdict::Outside), "{south:?}");
    }
}
