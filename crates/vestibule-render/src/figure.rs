//! A mannequin, drawn for bodies without a model of their own.

use std::sync::{Arc, OnceLock};

use glam::Vec3;

use crate::material::Material;
use crate::mesh::Mesh;

/// Height of the mannequin at scale 1, metres.
pub const FIGURE_HEIGHT: f32 = 1.8;

/// The mannequin: feet at the origin, facing north (+y), x to its right, [`FIGURE_HEIGHT`] tall.
pub fn figure() -> Arc<Mesh> {
    static FIGURE: OnceLock<Arc<Mesh>> = OnceLock::new();
    FIGURE.get_or_init(|| Arc::new(build())).clone()
}

fn build() -> Mesh {
    let mut mesh = Mesh {
        materials: [
            [196, 154, 122],
            [58, 84, 140],
            [84, 66, 52],
            [52, 40, 32],
            [170, 44, 44],
        ]
        .map(|c| Arc::new(Material::solid(c)))
        .into(),
        ..Mesh::default()
    };
    const SKIN: u32 = 0;
    const COAT: u32 = 1;
    const TROUSERS: u32 = 2;
    const DARK: u32 = 3;
    const BELT: u32 = 4;
    // A limb: rings (height, half width, half depth, forward, outward), stacked. `side` is 1 on the right, -1 on the
    // left.
    let mut limb = |side: f32, sides: usize, material: u32, rings: &[[f32; 5]]| {
        let ring = |r: &[f32; 5]| -> Vec<Vec3> {
            (0..sides)
                .map(|k| {
                    let (s, c) = libm::sincosf(k as f32 * core::f32::consts::TAU / sides as f32);
                    Vec3::new(side * r[4] + c * r[1], r[3] + s * r[2], r[0])
                })
                .collect()
        };
        for pair in rings.windows(2) {
            let (low, high) = (ring(&pair[0]), ring(&pair[1]));
            for k in 0..sides {
                let n = (k + 1) % sides;
                mesh.push_flat(&[low[k], low[n], high[n], high[k]], material, 0);
            }
        }
        if let [first, .., last] = rings {
            let mut bottom = ring(first);
            bottom.reverse();
            mesh.push_flat(&bottom, material, 0);
            mesh.push_flat(&ring(last), material, 0);
        }
    };
    for side in [-1.0, 1.0] {
        limb(
            side,
            8,
            DARK,
            &[[0.0, 0.06, 0.13, 0.05, 0.1], [0.09, 0.055, 0.10, 0.02, 0.1]],
        );
        limb(
            side,
            8,
            TROUSERS,
            &[
                [0.07, 0.055, 0.06, 0.0, 0.1],
                [0.45, 0.065, 0.07, 0.01, 0.1],
                [0.86, 0.085, 0.095, 0.0, 0.095],
            ],
        );
        // The sleeve begins within the shoulder.
        limb(
            side,
            8,
            COAT,
            &[
                [0.92, 0.045, 0.05, 0.04, 0.275],
                [1.2, 0.052, 0.06, -0.01, 0.26],
                [1.40, 0.062, 0.068, 0.0, 0.22],
                [1.47, 0.045, 0.05, 0.0, 0.185],
            ],
        );
        limb(
            side,
            8,
            SKIN,
            &[[0.76, 0.03, 0.045, 0.07, 0.275], [0.92, 0.035, 0.04, 0.04, 0.275]],
        );
    }
    limb(
        0.0,
        12,
        COAT,
        &[
            [0.78, 0.215, 0.16, 0.0, 0.0],
            [1.0, 0.17, 0.12, 0.0, 0.0],
            [1.28, 0.21, 0.135, 0.0, 0.0],
            [1.42, 0.20, 0.115, 0.0, 0.0],
            [1.48, 0.12, 0.085, 0.0, 0.0],
            [1.51, 0.065, 0.06, 0.0, 0.0],
        ],
    );
    limb(
        0.0,
        12,
        BELT,
        &[[0.96, 0.183, 0.133, 0.0, 0.0], [1.02, 0.18, 0.13, 0.0, 0.0]],
    );
    limb(
        0.0,
        8,
        SKIN,
        &[[1.46, 0.055, 0.055, 0.0, 0.0], [1.58, 0.05, 0.05, 0.01, 0.0]],
    );
    limb(
        0.0,
        12,
        SKIN,
        &[
            [1.54, 0.05, 0.06, 0.02, 0.0],
            [1.62, 0.08, 0.095, 0.01, 0.0],
            [1.70, 0.085, 0.10, 0.0, 0.0],
            [1.74, 0.08, 0.095, 0.0, 0.0],
        ],
    );
    limb(
        0.0,
        12,
        DARK,
        &[
            [1.66, 0.088, 0.085, -0.022, 0.0],
            [1.74, 0.09, 0.105, -0.005, 0.0],
            [FIGURE_HEIGHT, 0.045, 0.05, -0.01, 0.0],
        ],
    );
    mesh
}
