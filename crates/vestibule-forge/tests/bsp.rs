//! Trees of random rooms and objects, against brute force.

use glam::{DQuat, DVec2, DVec3, Vec3};
use vestibule_dat::record::{BspNode, BspTree};
use vestibule_forge::bsp::{Piece, bounding_sphere, cell_bsp, drawing_bsp, inward_planes, physics_bsp};
use vestibule_forge::geometry::{Polygon, Polytope, carve, convex_parts, merge_convex, union_faces};

mod common;
use common::random::Random;

fn turn(random: &mut Random) -> DQuat {
    let mut side = || random.between(-1.0, 1.0);
    let (x, y, z) = (side(), side(), side());
    DQuat::from_xyzw(x, y, z, random.between(0.1, 1.0)).normalize()
}

/// A random solid's surface, facing outwards: a hull, a prism over a bent outline, or boxes run into each other.
fn surface(random: &mut Random, kind: usize) -> Vec<Polygon> {
    let parts: Vec<Polytope> = match kind % 3 {
        0 => {
            let points: Vec<DVec3> = (0..10).map(|_| random.point(5.0)).collect();
            Polytope::hull(&points).into_iter().collect()
        }
        1 => {
            let corners = 5 + (random.next() * 6.0) as usize;
            let outline: Vec<DVec2> = (0..corners)
                .map(|k| {
                    let angle =
                        (k as f64 + random.between(-0.3, 0.3)) / corners as f64 * core::f64::consts::TAU;
                    DVec2::new(libm::cos(angle), libm::sin(angle)) * random.between(1.5, 6.0)
                })
                .collect();
            let height = random.between(2.0, 5.0);
            let lift = |p: &DVec2| [p.extend(0.0), p.extend(height)];
            let part = |part: &Vec<DVec2>| Polytope::hull(&part.iter().flat_map(lift).collect::<Vec<_>>());
            convex_parts(&outline)
                .unwrap_or_default()
                .iter()
                .filter_map(part)
                .collect()
        }
        _ => (0..3)
            .filter_map(|_| {
                let low = random.point(2.0);
                let size = DVec3::new(
                    random.between(1.0, 6.0),
                    random.between(1.0, 6.0),
                    random.between(2.0, 4.0),
                );
                Polytope::cuboid(low, low + size)
            })
            .collect(),
    };
    let turn = turn(random);
    let moved: Vec<Polytope> = parts.iter().filter_map(|p| p.mapped(|p| turn * p)).collect();
    union_faces(&moved).into_iter().map(|f| f.polygon).collect()
}

/// Inside by counting what a ray crosses; `None` when the answer hangs on a hair.
fn inside(polygons: &[Polygon], p: DVec3, ray: DVec3) -> Option<bool> {
    let mut crossed = 0;
    for polygon in polygons {
        let (dist, speed) = (polygon.plane.dist(p), polygon.plane.normal.dot(ray));
        if dist.abs() < 1.0e-3 || speed.abs() < 1.0e-4 {
            return None;
        }
        let t = -dist / speed;
        if t > 0.0 {
            let hit = p + ray * t;
            let margin = polygon
                .edge_planes()
                .map(|e| e.dist(hit))
                .fold(f64::INFINITY, f64::min);
            if margin.abs() < 1.0e-6 {
                return None;
            }
            crossed += usize::from(margin > 0.0);
        }
    }
    Some(crossed % 2 == 1)
}

fn area(polygons: &[Polygon]) -> f64 {
    polygons.iter().map(Polygon::area).sum()
}

fn pieces_area(pieces: &[Piece]) -> f64 {
    pieces.iter().map(|p| p.polygon.area()).sum()
}

/// `transition.md` 6.5.1, in f64.
fn hits_sphere(polygon: &Polygon, center: DVec3, radius: f64) -> bool {
    let (s, rho) = (polygon.plane.dist(center), radius - 0.0002);
    if rho < s.abs() {
        return false;
    }
    let contact = center - polygon.plane.normal * s;
    let q = rho * rho - s * s;
    let n = polygon.points.len();
    let edge = |i: usize| {
        let (from, to) = (polygon.points[(i + n - 1) % n], polygon.points[i]);
        let e = to - from;
        (e, polygon.plane.normal.cross(e), contact - from)
    };
    if (0..n).all(|i| edge(i).2.dot(edge(i).1) >= 0.0) {
        return true;
    }
    for i in 0..n {
        let (e, c, w) = edge(i);
        let out = w.dot(c);
        if out < 0.0 {
            if c.length_squared() * q < out * out {
                return false;
            }
            if (0.0..=e.length_squared()).contains(&w.dot(e)) {
                return true;
            }
        }
        if w.length_squared() <= q {
            return true;
        }
    }
    false
}

/// The walk of `transition.md` 6.1: every polygon of every leaf that is reached.
fn walk(tree: &BspTree, at: u32, center: Vec3, radius: f32, out: &mut Vec<u16>) {
    let prune = |s: &vestibule_dat::primitive::Sphere| {
        let reach = s.radius + radius;
        s.center.distance_squared(center) - reach * reach >= 0.0002
    };
    match &tree.nodes[at as usize] {
        BspNode::Leaf {
            physics: Some(leaf), ..
        } => {
            if !leaf.polys.is_empty() && !prune(&leaf.sphere) {
                out.extend(&leaf.polys);
            }
        }
        BspNode::Inner {
            plane,
            pos,
            neg,
            sphere,
            ..
        } => {
            if sphere.as_ref().is_some_and(prune) {
                return;
            }
            let (s, reach) = (plane.normal.dot(center) + plane.d, radius - 0.0002);
            for child in [pos.filter(|_| s > -reach), neg.filter(|_| s < reach)]
                .into_iter()
                .flatten()
            {
                walk(tree, child, center, radius, out);
            }
        }
        other => panic!("a physics tree with {other:?}"),
    }
}

/// `transition.md` 6.3.1.
fn point_in_solid(tree: &BspTree, p: Vec3) -> (bool, bool) {
    let mut at = 0u32;
    loop {
        match &tree.nodes[at as usize] {
            BspNode::Leaf {
                physics: Some(leaf), ..
            } => return (!leaf.polys.is_empty(), leaf.solid != 0),
            BspNode::Inner { plane, pos, neg, .. } => {
                let side = if plane.normal.dot(p) + plane.d >= 0.0 {
                    pos
                } else {
                    neg
                };
                at = side.unwrap_or_else(|| panic!("no child"));
            }
            other => panic!("a physics tree with {other:?}"),
        }
    }
}

#[test]
fn g14_the_cells_of_1000_random_rooms_hold_exactly_the_points_inside() {
    let mut random = Random(1);
    let (mut tested, mut cells_made) = (0, 0);
    for kind in 0..1000 {
        let outwards = surface(&mut random, kind);
        let walls: Vec<Polygon> = outwards.iter().map(Polygon::flipped).collect();
        let cells = merge_convex(carve(&walls));
        cells_made += cells.len();
        let trees: Vec<_> = cells
            .iter()
            .map(|c| vestibule_world::compile::cell_bsp(&cell_bsp(&inward_planes(c))))
            .collect();
        for _ in 0..60 {
            let p = random.point(8.0);
            let ray = random.point(1.0).normalize();
            let Some(expected) = inside(&outwards, p, ray) else {
                continue;
            };
            let found = trees.iter().any(|t| t.contains_point(p.as_vec3()));
            assert_eq!(found, expected, "room {kind} at {p}");
            tested += 1;
        }
    }
    assert!(tested > 40_000, "{tested}");
    assert!(
        cells_made < 6_000,
        "rooms are cut into too many cells: {cells_made}"
    );
}

#[test]
fn physics_trees_of_1000_random_objects_find_what_brute_force_finds() {
    let mut random = Random(2);
    let mut hits = 0;
    for kind in 0..1000 {
        let polygons = surface(&mut random, kind);
        let built = physics_bsp(&polygons, &[], &[]).unwrap_or_else(|e| panic!("{e}"));
        assert!(
            (pieces_area(&built.pieces) / area(&polygons) - 1.0).abs() < 1.0e-3,
            "object {kind} lost area"
        );
        for _ in 0..40 {
            let (center, radius) = (random.point(8.0), random.between(0.1, 1.5));
            let mut found = Vec::new();
            walk(&built.tree, 0, center.as_vec3(), radius as f32, &mut found);
            for (id, piece) in built.pieces.iter().enumerate() {
                // A tenth of a millimetre is what splitting may leave on the other side of a plane.
                if hits_sphere(&piece.polygon, center, radius - 1.0e-3) {
                    assert!(
                        found.contains(&(id as u16)),
                        "object {kind}: piece {id} at {center} r {radius}"
                    );
                    hits += 1;
                }
            }
            let whole = polygons.iter().any(|p| hits_sphere(p, center, radius - 2.0e-3));
            let parts = built
                .pieces
                .iter()
                .any(|p| hits_sphere(&p.polygon, center, radius));
            assert!(
                !whole || parts,
                "object {kind}: a hit was lost by splitting at {center}"
            );
        }
    }
    assert!(hits > 5_000, "{hits}");
}

#[test]
fn g9_solid_leaves_of_1000_random_objects_are_their_insides() {
    let mut random = Random(3);
    let mut tested = 0;
    for kind in 0..1000 {
        let polygons = surface(&mut random, kind);
        let built = physics_bsp(&polygons, &[], &[]).unwrap_or_else(|e| panic!("{e}"));
        for _ in 0..40 {
            let p = random.point(7.0);
            let Some(expected) = inside(&polygons, p, random.point(1.0).normalize()) else {
                continue;
            };
            let (has_polygons, solid) = point_in_solid(&built.tree, p.as_vec3());
            assert_eq!(has_polygons, expected, "object {kind} at {p}");
            assert_eq!(solid, expected, "object {kind} at {p}");
            tested += 1;
        }
    }
    assert!(tested > 25_000, "{tested}");
}

#[test]
fn physics_trees_of_cells_leave_what_is_behind_the_walls_open() {
    let mut random = Random(4);
    for kind in 0..300 {
        for cell in merge_convex(carve(
            &surface(&mut random, kind)
                .iter()
                .map(Polygon::flipped)
                .collect::<Vec<_>>(),
        )) {
            let walls: Vec<Polygon> = cell.faces.iter().map(|f| f.polygon.flipped()).collect();
            let built = physics_bsp(&walls, &[], &inward_planes(&cell)).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(
                built.pieces.len(),
                walls.len(),
                "walls of a convex cell are never cut"
            );
            let solid = |n: &BspNode| matches!(n, BspNode::Leaf { physics: Some(l), .. } if l.solid != 0);
            assert!(!built.tree.nodes.iter().any(solid));
        }
    }
}

/// Area of the polygons that a drawing tree names, its portals, and whether all below a node lies on its side.
fn check_drawing(tree: &BspTree, at: u32, pieces: &[Piece], seen: &mut Vec<u16>, portals: &mut Vec<u16>) {
    let node = &tree.nodes[at as usize];
    if let BspNode::Portal { portal_polys, .. } = node {
        portals.extend(portal_polys.iter().map(|(_, index)| index));
    }
    let Some(plane) = node.plane() else { return };
    seen.extend(node.polys());
    for id in node.polys() {
        let polygon = &pieces[usize::from(*id)].polygon;
        let off = polygon
            .points
            .iter()
            .map(|p| (plane.normal.dot(p.as_vec3()) + plane.d).abs());
        assert!(
            off.fold(0.0, f32::max) < 2.0e-4,
            "a polygon of a node lies in its plane"
        );
    }
    let (pos, neg) = node.children();
    for (child, sign) in [(pos, 1.0f32), (neg, -1.0)] {
        let Some(child) = child else { continue };
        let first = seen.len();
        check_drawing(tree, child, pieces, seen, portals);
        for id in &seen[first..] {
            for p in &pieces[usize::from(*id)].polygon.points {
                let dist = plane.normal.dot(p.as_vec3()) + plane.d;
                assert!(
                    sign * dist > -2.0e-4,
                    "polygon {id} lies on the wrong side of a node"
                );
            }
        }
    }
}

#[test]
fn drawing_trees_of_300_random_shells_keep_area_and_every_portal() {
    let mut random = Random(5);
    for kind in 0..300 {
        let mut polygons = surface(&mut random, kind);
        // The middle of some faces becomes a portal.
        let mut portals = Vec::new();
        for k in (0..polygons.len()).step_by(3) {
            let face = polygons[k].clone();
            let middle = face.center();
            let points = face.points.iter().map(|p| middle.lerp(*p, 0.4)).collect();
            if let Some(hole) = Polygon::in_plane(points, face.plane).filter(|h| h.area() > 0.01) {
                polygons.extend(face.without(&hole));
                polygons[k] = hole.clone();
                portals.push(hole);
            }
        }
        polygons.retain(|p| !portals.contains(p));
        let built = drawing_bsp(&polygons, &portals).unwrap_or_else(|e| panic!("{e}"));
        assert!(
            (pieces_area(&built.pieces) / area(&polygons) - 1.0).abs() < 1.0e-3,
            "shell {kind} lost area"
        );
        let (mut seen, mut found) = (Vec::new(), Vec::new());
        check_drawing(&built.tree, 0, &built.pieces, &mut seen, &mut found);
        seen.sort_unstable();
        found.sort_unstable();
        assert_eq!(
            seen,
            (0..built.pieces.len() as u16).collect::<Vec<_>>(),
            "each piece once"
        );
        assert_eq!(
            found,
            (0..portals.len() as u16).collect::<Vec<_>>(),
            "g12: a bijection onto the portals"
        );
    }
}

#[test]
fn slivers_and_coplanar_faces_do_no_harm() {
    let thin = Polytope::cuboid(DVec3::ZERO, DVec3::new(4.0, 3.0, 0.001)).into_iter();
    let flush = Polytope::cuboid(DVec3::new(1.0, 1.0, 0.001), DVec3::new(2.0, 2.0, 0.5)).into_iter();
    let grazing = Polytope::cuboid(DVec3::new(3.999_95, 0.0, 0.0), DVec3::new(6.0, 3.0, 1.0)).into_iter();
    let parts: Vec<Polytope> = thin.chain(flush).chain(grazing).collect();
    assert_eq!(parts.len(), 3);
    let mut polygons: Vec<Polygon> = union_faces(&parts).into_iter().map(|f| f.polygon).collect();
    // The same face twice, and once more from behind.
    polygons.push(polygons[0].clone());
    polygons.push(polygons[0].flipped());
    let physics = physics_bsp(&polygons, &[], &[]).unwrap_or_else(|e| panic!("{e}"));
    let drawing = drawing_bsp(&polygons, &[]).unwrap_or_else(|e| panic!("{e}"));
    for pieces in [&physics.pieces, &drawing.pieces] {
        assert!((pieces_area(pieces) / area(&polygons) - 1.0).abs() < 1.0e-3);
    }
}

#[test]
fn bounding_spheres_hold_their_points() {
    let mut random = Random(6);
    for _ in 0..1000 {
        let points: Vec<DVec3> = (0..8).map(|_| random.point(500.0)).collect();
        let sphere = bounding_sphere(points.iter().copied());
        assert!(
            points
                .iter()
                .all(|p| p.as_vec3().distance(sphere.center) <= sphere.radius)
        );
    }
}
