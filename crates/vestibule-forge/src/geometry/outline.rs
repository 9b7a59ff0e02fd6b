//! Plane outlines, cut into convex parts.

use glam::DVec2;

fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - b)
}

/// Twice the signed area of an outline: positive when it runs counter-clockwise.
fn signed_area(outline: &[DVec2]) -> f64 {
    let next = outline.iter().cycle().skip(1);
    outline.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum()
}

fn crosses_itself(outline: &[DVec2]) -> bool {
    let n = outline.len();
    let edge = |i: usize| (outline[i], outline[(i + 1) % n]);
    (0..n).any(|i| {
        (i + 2..n).filter(|j| (j + 1) % n != i).any(|j| {
            let ((a, b), (c, d)) = (edge(i), edge(j));
            turn(a, b, c) * turn(a, b, d) <= 0.0 && turn(c, d, a) * turn(c, d, b) <= 0.0
        })
    })
}

/// Cuts an outline, given by its corners in either direction, into convex parts that run counter-clockwise and
/// use its corners only: triangles, joined as long as they stay convex. `None` when it crosses itself or has no
/// area.
pub fn convex_parts(outline: &[DVec2]) -> Option<Vec<Vec<DVec2>>> {
    let mut points = outline.to_vec();
    let area = signed_area(&points);
    if points.len() < 3 || area.abs() < 1.0e-9 || crosses_itself(&points) {
        return None;
    }
    if area < 0.0 {
        points.reverse();
    }
    let mut ring: Vec<usize> = (0..points.len()).collect();
    let mut parts: Vec<Vec<usize>> = Vec::new();
    while ring.len() > 3 {
        let n = ring.len();
        let is_ear = |k: usize| {
            let [a, b, c] = [(k + n - 1) % n, k, (k + 1) % n].map(|i| points[ring[i]]);
            let holds = |p: DVec2| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
            let corner = |p: DVec2| p == a || p == b || p == c;
            turn(a, b, c) > 1.0e-12 && !ring.iter().any(|&i| !corner(points[i]) && holds(points[i]))
        };
        let ear = (0..n).find(|&k| is_ear(k))?;
        parts.push([(ear + n - 1) % n, ear, (ear + 1) % n].map(|i| ring[i]).to_vec());
        ring.remove(ear);
    }
    parts.push(ring);
    'again: loop {
        for i in 0..parts.len() {
            for j in i + 1..parts.len() {
                if let Some(joined) = join(&parts[i], &parts[j], &points) {
                    parts.remove(j);
                    parts[i] = joined;
                    continue 'again;
                }
            }
        }
        return Some(
            parts
                .iter()
                .map(|part| part.iter().map(|&i| points[i]).collect())
                .collect(),
        );
    }
}

/// Joins two parts along a common edge if the result is convex.
fn join(a: &[usize], b: &[usize], points: &[DVec2]) -> Option<Vec<usize>> {
    let (n, m) = (a.len(), b.len());
    for i in 0..n {
        for j in 0..m {
            if a[i] == b[(j + 1) % m] && a[(i + 1) % n] == b[j] {
                let mut joined: Vec<usize> = (0..n).map(|k| a[(i + 1 + k) % n]).collect();
                joined.extend((2..m).map(|k| b[(j + k) % m]));
                let k = joined.len();
                let at = |i: usize| points[joined[i % k]];
                return (0..k)
                    .all(|i| turn(at(i), at(i + 1), at(i + 2)) >= -1.0e-12)
                    .then_some(joined);
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_l_is_cut_in_two() {
        let l = [
            (0.0, 0.0),
            (4.0, 0.0),
            (4.0, 2.0),
            (2.0, 2.0),
            (2.0, 5.0),
            (0.0, 5.0),
        ]
        .map(DVec2::from);
        for outline in [l.to_vec(), l.iter().rev().copied().collect()] {
            let parts = convex_parts(&outline).unwrap_or_default();
            assert_eq!(parts.len(), 2);
            let area: f64 = parts.iter().map(|p| signed_area(p)).sum();
            assert!((area - 2.0 * 14.0).abs() < 1e-9);
        }
    }

    #[test]
    fn outlines_that_cross_themselves_are_refused() {
        assert!(convex_parts(&[(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)].map(DVec2::from)).is_none());
    }
}
