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
    // A limb: rings (height, half width, half depth, forward), stacked.
    let mut limb = |x: f32, sides: usize, material: u32, rings: &[[f32; 4]]| {
        let ring = |r: &[f32; 4]| -> Vec<Vec3> {
            (0..sides)
                .map(|k| {
                    let (s, c) = libm::sincosf(k as f32 * core::f32::consts::TAU / sides as f32);
                    Vec3::new(x + c * r[1], r[3] + s * r[2], r[0])
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
    for x in [-0.1, 0.1] {
        limb(x, 8, DARK, &[[0.0, 0.06, 0.13, 0.05], [0.09, 0.055, 0.10, 0.02]]);
        limb(
            x,
            8,
            TROUSERS,
            &[
                [0.07, 0.055, 0.06, 0.0],
                [0.45, 0.07, 0.075, 0.01],
                [0.88, 0.095, 0.105, 0.0],
            ],
        );
    }
    limb(
        0.0,
        10,
        COAT,
        &[
            [0.80, 0.20, 0.14, 0.0],
            [1.0, 0.165, 0.115, 0.0],
            [1.28, 0.215, 0.135, 0.0],
            [1.46, 0.17, 0.10, 0.0],
            [1.50, 0.07, 0.06, 0.0],
        ],
    );
    limb(
        0.0,
        10,
        BELT,
        &[[0.96, 0.178, 0.128, 0.0], [1.02, 0.175, 0.125, 0.0]],
    );
    for x in [-0.27, 0.27] {
        limb(
            x,
            7,
            COAT,
            &[
                [0.92, 0.045, 0.05, 0.03],
                [1.2, 0.055, 0.06, -0.01],
                [1.45, 0.06, 0.065, 0.0],
            ],
        );
        limb(
            x,
            7,
            SKIN,
            &[[0.78, 0.03, 0.045, 0.05], [0.92, 0.035, 0.04, 0.03]],
        );
    }
    limb(
        0.0,
        7,
        SKIN,
        &[[1.46, 0.055, 0.055, 0.0], [1.58, 0.05, 0.05, 0.01]],
    );
    limb(
        0.0,
        10,
        SKIN,
        &[
            [1.54, 0.05, 0.06, 0.02],
            [1.62, 0.08, 0.095, 0.01],
            [1.70, 0.085, 0.10, 0.0],
            [1.74, 0.08, 0.095, 0.0],
        ],
    );
    limb(
        0.0,
        10,
        DARK,
        &[
            [1.66, 0.088, 0.085, -0.022],
            [1.74, 0.09, 0.105, -0.005],
            [FIGURE_HEIGHT, 0.045, 0.05, -0.01],
        ],
    );
    mesh
}
