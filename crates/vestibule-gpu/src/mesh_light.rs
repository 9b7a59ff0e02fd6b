//! The light on a mesh as shaders read it.

use glam::Vec4;
use vestibule_render::{Piece, PieceLight};
use vestibule_view::Camera;
use vestibule_world::CellId;

use crate::uniforms::{LightKind, Lists, Part};

/// The light on a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshLight {
    pub(crate) kind: LightKind,
    pub(crate) lamps: Part,
    pub(crate) planes: Part,
    pub(crate) count: u32,
    pub(crate) near: [u32; 2],
    /// Luminosity in place of the material's, for [`LightKind::Own`].
    pub(crate) own: f32,
}

impl MeshLight {
    pub(crate) fn plain(kind: LightKind) -> Self {
        MeshLight {
            kind,
            lamps: Part::default(),
            planes: Part::default(),
            count: 0,
            near: [0; 2],
            own: 0.0,
        }
    }
    /// The light on a piece; lamps and planes go into the lists.
    pub(crate) fn of(piece: &Piece<'_>, camera: &Camera, lists: &mut Lists, planes: &mut Vec<Vec4>) -> Self {
        planes.clear();
        if !piece.edges.is_empty() {
            let (slopes, size) = (camera.slopes(), camera.viewport());
            planes.extend(piece.edges.iter().map(|n| {
                let n = n.as_vec3();
                // A hundredth of a pixel more, as the reference has it.
                let across = (n.x * 2.0 * slopes.x / size.x).abs() + (n.z * 2.0 * slopes.y / size.y).abs();
                n.extend(across * (2.0 / 256.0))
            }));
        }
        match piece.light {
            PieceLight::Sun if planes.is_empty() => MeshLight::plain(LightKind::Sun),
            PieceLight::Sun => MeshLight {
                planes: lists.add(CellId(0), &[], planes).1,
                ..MeshLight::plain(LightKind::Sun)
            },
            PieceLight::Shell { cell, lamps } => {
                let (lamps, planes) = lists.add(cell, lamps, planes);
                MeshLight {
                    lamps,
                    planes,
                    count: u32::from(lamps.count),
                    ..MeshLight::plain(LightKind::Shell)
                }
            }
            PieceLight::Indoor { cell, lamps, near } => {
                let (lamps, planes) = lists.add(cell, lamps, planes);
                let mut light = MeshLight {
                    lamps,
                    planes,
                    count: near.len() as u32,
                    ..MeshLight::plain(LightKind::Indoor)
                };
                for (k, &lamp) in near.iter().enumerate() {
                    light.near[(k / 4) & 1] |= u32::from(lamp) << (8 * (k % 4));
                }
                light
            }
        }
    }
}
