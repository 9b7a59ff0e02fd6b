//! From a frame of the world to camera axes, in f64 so that walls of different frames still meet.

use glam::{DMat3, DVec3, Vec3};
use vestibule_view::Camera;
use vestibule_world::ids::block_offset;
use vestibule_world::{BlockId, Frame};

/// A camera's eye and axes in f64. Camera axes are x right, y forward, z up, metres, the eye at the origin
/// (`visibility.md` 14.2).
#[derive(Clone, Copy, Debug)]
pub struct EyeFrame {
    camera: Camera,
    /// Rows: right, forward, up.
    rows: [DVec3; 3],
    eye: DVec3,
}

/// A frame as the camera sees it: `p` lies at `matrix p + origin` in camera axes.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    matrix: DMat3,
    origin: DVec3,
}

impl EyeFrame {
    /// The frame of a camera.
    pub fn new(camera: &Camera) -> Self {
        EyeFrame {
            camera: *camera,
            rows: camera.axes().map(|a| a.as_dvec3()),
            eye: camera.eye().as_dvec3(),
        }
    }

    /// The eye in the frame of a landblock, unrounded.
    pub fn eye_in(&self, block: BlockId) -> DVec3 {
        self.eye + block_offset(block, self.camera.cell().block()).as_dvec3()
    }

    /// An eye-relative vector in landscape axes, in camera axes.
    #[inline]
    pub fn turn(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.rows[0].dot(v), self.rows[1].dot(v), self.rows[2].dot(v))
    }

    /// A direction in camera axes, in landscape axes.
    #[inline]
    pub fn turn_back(&self, v: DVec3) -> DVec3 {
        self.rows[0] * v.x + self.rows[1] * v.y + self.rows[2] * v.z
    }

    /// A frame of a landblock, with a scale of its local axes.
    pub fn place(&self, block: BlockId, frame: &Frame, scale: Vec3) -> Placed {
        self.place_axes(self.eye_in(block), frame.origin, frame.axes(), scale)
    }

    /// As [`EyeFrame::place`], of a frame's origin and axes; the eye as [`EyeFrame::eye_in`] has it.
    pub(crate) fn place_axes(&self, eye: DVec3, origin: Vec3, axes: &[Vec3; 3], scale: Vec3) -> Placed {
        let axes = axes.map(|a| self.turn(a.as_dvec3()));
        let s = scale.as_dvec3();
        Placed {
            matrix: DMat3::from_cols(axes[0] * s.x, axes[1] * s.y, axes[2] * s.z),
            origin: self.turn(origin.as_dvec3() - eye),
        }
    }

    /// The landblock itself.
    pub fn place_block(&self, block: BlockId) -> Placed {
        self.place(block, &Frame::IDENTITY, Vec3::ONE)
    }
}

impl Placed {
    /// A point of the frame in camera axes.
    #[inline]
    pub fn point(&self, p: Vec3) -> DVec3 {
        self.matrix * p.as_dvec3() + self.origin
    }

    /// Whether the scale mirrors: then the other side of every face shows (`rendering.md` 2.7).
    pub fn mirrors(&self) -> bool {
        self.matrix.determinant() < 0.0
    }

    /// The largest stretch along an axis.
    pub fn reach(&self) -> f64 {
        let m = &self.matrix;
        m.x_axis.length().max(m.y_axis.length()).max(m.z_axis.length())
    }

    /// Rows for a shader: x, y and z in camera axes are the products of each with (p, 1).
    pub fn rows(&self) -> [[f32; 4]; 3] {
        let (m, o) = (&self.matrix, self.origin);
        let row = |x: f64, y: f64, z: f64, w: f64| [x as f32, y as f32, z as f32, w as f32];
        [
            row(m.x_axis.x, m.y_axis.x, m.z_axis.x, o.x),
            row(m.x_axis.y, m.y_axis.y, m.z_axis.y, o.y),
            row(m.x_axis.z, m.y_axis.z, m.z_axis.z, o.z),
        ]
    }
}
