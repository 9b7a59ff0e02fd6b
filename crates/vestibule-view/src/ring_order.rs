//! The fixed order of a square grid around a centre (`rendering.md` 6.2.1).

/// Writes the offsets of the rings around the centre to `out`, near to far: the centre first. `radius` rings;
/// drawing walks it from the end.
pub(crate) fn rings(radius: i32, out: &mut Vec<(i32, i32)>) {
    out.clear();
    out.push((0, 0));
    for r in 1..=radius {
        for s in 0..r {
            out.extend_from_slice(&[
                (-s, r),
                (-r, -s),
                (s, -r),
                (r, s),
                (s + 1, r),
                (-r, s + 1),
                (-s - 1, -r),
                (r, -s - 1),
            ]);
        }
    }
}

/// The land cells of a block far to near, by column and row from 0: the rings around the one nearest to the viewer, walked
/// from the end, as far as they lie in the block.
pub(crate) fn cells_far_to_near(nearest: (i32, i32), rings: &[(i32, i32)]) -> [(u8, u8); 64] {
    let mut out = [(0, 0); 64];
    let cells = rings
        .iter()
        .rev()
        .map(|&(dx, dy)| (nearest.0 + dx, nearest.1 + dy));
    let inside = cells.filter(|(x, y)| (0..8).contains(x) && (0..8).contains(y));
    for (slot, (x, y)) in out.iter_mut().zip(inside) {
        *slot = (x as u8, y as u8);
    }
    out
}

/// The cell of a block, by its coordinates 0…7, that is nearest to the viewer in another block `dx` to the west and
/// `dy` to the south of it (0 for its own): `viewer` are the viewer's coordinates in its own block.
pub(crate) fn nearest_cell(dx: i32, dy: i32, viewer: (i32, i32)) -> (i32, i32) {
    let axis = |d: i32, own: i32| match d {
        0 => own,
        d if d > 0 => 0,
        _ => 7,
    };
    (axis(dx, viewer.0), axis(dy, viewer.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn r6_2_1_rings_hold_each_offset_once_corners_farthest() {
        let mut out = Vec::new();
        rings(5, &mut out);
        assert_eq!(out.len(), 121);
        let mut sorted = out.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), 121);
        let ring = |p: &(i32, i32)| p.0.abs().max(p.1.abs());
        assert!(out.windows(2).all(|p| ring(&p[0]) <= ring(&p[1])));
        // Near to far: the axis blocks come first in a ring, the corners last.
        assert_eq!(
            &out[1..9],
            &[
                (0, 1),
                (-1, 0),
                (0, -1),
                (1, 0),
                (1, 1),
                (-1, 1),
                (-1, -1),
                (1, -1)
            ]
        );
    }

    #[test]
    fn r6_2_1_every_cell_of_a_block_once_the_nearest_last() {
        let mut around = Vec::new();
        rings(7, &mut around);
        for nearest in [(0, 0), (7, 3), (4, 4)] {
            let cells = cells_far_to_near(nearest, &around);
            assert_eq!(cells[63], (nearest.0 as u8, nearest.1 as u8));
            let mut sorted = cells;
            sorted.sort_unstable();
            assert!(sorted.iter().zip(0..64).all(|(&c, k)| c == (k / 8, k % 8)));
        }
    }

    #[test]
    fn r6_2_1_the_nearest_cell_faces_the_viewer() {
        assert_eq!(nearest_cell(0, 0, (3, 5)), (3, 5));
        assert_eq!(nearest_cell(0, 1, (3, 5)), (3, 0));
        assert_eq!(nearest_cell(-1, 0, (3, 5)), (7, 5));
        assert_eq!(nearest_cell(1, -1, (3, 5)), (0, 7));
    }
}
