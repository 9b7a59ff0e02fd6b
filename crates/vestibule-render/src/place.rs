//! From a frame of the world to camera axes, in f64 so that walls of different frames still meet.

use glam::{DMat3, DVec3, Vec3};
use vestibule_view::Camera;
use vestibule_world::ids::block_offset;
use vestibule_world::{BlockId, Frame};

/// A camera's eye and axes in f64.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EyeFrame {
    camera: Camera,
    /// Rows: right, forward, up.
    rows: [DVec3; 3],
    eye: DVec3,
}

/// A frame as the camera sees it: `p` lies at `matrix p + origin` in camera axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    matrix: DMat3,
    origin: DVec3,
}

impl EyeFrame {
    pub(crate) fn new(camera: &Camera) -> Self {
        EyeFrame {
            camera: *camera,
            rows: camera.axes().map(|a| a.as_dvec3()),
            eye: camera.eye().as_dvec3(),
        }
    }

    /// The eye in the frame of a landblock, unrounded.
    pub(crate) fn eye_in(&self, block: BlockId) -> DVec3 {
        self.eye + block_offset(block, self.camera.cell().block()).as_dvec3()
    }

    /// An eye-relative vector in landscape axes, in camera axes.
    #[inline]
    pub(crate) fn turn(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.rows[0].dot(v), self.rows[1].dot(v), self.rows[2].dot(v))
    }

    /// A direction in camera axes, in landscape axes.
    #[inline]
    pub(crate) fn turn_back(&self, v: DVec3) -> DVec3 {
        self.rows[0] * v.x + self.rows[1] * v.y + self.rows[2] * v.z
    }

    /// A frame of a landblock, with a scale of its local axes.
    pub(crate) fn place(&self, block: BlockId, frame: &Frame, scale: Vec3) -> Placed {
        let axes = frame.axes().map(|a| self.turn(a.as_dvec3()));
        let s = scale.as_dvec3();
        Placed {
            matrix: DMat3::from_cols(axes[0] * s.x, axes[1] * s.y, axes[2] * s.z),
            origin: self.turn(frame.origin.as_dvec3() - self.eye_in(block)),
        }
    }

    /// The landblock itself.
    pub(crate) fn place_block(&self, block: BlockId) -> Placed {
        self.place(block, &Frame::IDENTITY, Vec3::ONE)
    }
}

impl Placed {
    #[inline]
    pub(crate) fn point(&self, p: Vec3) -> DVec3 {
        self.matrix * p.as_dvec3() + self.origin
    }

    /// Whether the scale mirrors: then the other side of every face shows (`rendering.md` 2.7).
    pub(crate) fn mirrors(&self) -> bool {
        self.matrix.determinant() < 0.0
    }
}
