//! What is odd about a record that can be read all the same (`dat-format.md` D4, G15 and others).
//!
//! [`lint`] looks at one record by itself; [`lint_references`] also at the records it names.

mod cells;
mod geometry;
mod objects;
mod references;
mod region;

pub use references::{LookUp, lint_references};

use std::fmt;

use glam::{Quat, Vec3};

use super::Record;
use crate::data_id::RecordKind;
use crate::primitive::{Frame, Plane, Sphere};

/// Something odd in a record. The record is usable; the thing itself may be ignored or look wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lint {
    /// Data id of the record, as the directory has it.
    pub id: u32,
    /// The rule that is broken, by its tag in `dat-format.md`.
    pub rule: &'static str,
    /// Where in the record, as a path of field names.
    pub field: String,
    /// What is odd there.
    pub message: String,
}

impl fmt::Display for Lint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "record {:08X}, {}: {} ({})",
            self.id, self.field, self.message, self.rule
        )
    }
}

/// Checks a record by itself; `id` is its data id in the directory.
///
/// ```
/// use vestibule_dat::record::{EnvCell, Record, lint::lint};
///
/// let cell = EnvCell { id: 0x1234_0100, id_again: 0x1234_0101, ..EnvCell::default() };
/// let lints = lint(0x1234_0100, &Record::EnvCell(cell));
/// assert_eq!((lints[0].rule, lints[0].field.as_str()), ("D4", "id_again"));
/// ```
pub fn lint(id: u32, record: &Record) -> Vec<Lint> {
    let mut lints = Lints::new(id);
    if let Some(stored) = record.stored_id()
        && stored != id
    {
        lints.add(
            "F6",
            format_args!("id"),
            format_args!("is {stored:08X}, the directory has {id:08X}"),
        );
    }
    match record {
        Record::LandBlockInfo(info) => lints.land_block_info(info),
        Record::EnvCell(cell) => lints.env_cell(cell),
        Record::Environment(environment) => lints.environment(environment),
        Record::GfxObj(model) => lints.gfx_obj(model),
        Record::Setup(setup) => lints.setup(setup),
        Record::Region(region) => lints.region(region),
        Record::Surface(surface) => lints.surface(surface),
        Record::SurfaceTexture(texture) => lints.surface_texture(texture),
        Record::RenderSurface(texture) => lints.render_surface(texture),
        Record::Scene(scene) => lints.scene(scene),
        Record::GfxObjDegradeInfo(info) => lints.degrade_info(info),
        Record::Iteration(list) => {
            if !list.is_complete() {
                lints.add(
                    "V2",
                    format_args!("runs"),
                    format_args!("the file is incompletely patched"),
                );
            }
        }
        Record::LandBlock(_) | Record::Palette(_) | Record::Raw { .. } => {}
    }
    lints.list
}

/// How far the length of a quaternion may be off 1 (D4).
const QUATERNION_TOLERANCE: f32 = 1e-3;

/// Collects lints of one record.
struct Lints {
    id: u32,
    list: Vec<Lint>,
}

impl Lints {
    fn new(id: u32) -> Self {
        Self { id, list: Vec::new() }
    }

    fn add(&mut self, rule: &'static str, field: fmt::Arguments<'_>, message: fmt::Arguments<'_>) {
        let (field, message) = (field.to_string(), message.to_string());
        self.list.push(Lint {
            id: self.id,
            rule,
            field,
            message,
        });
    }

    fn float(&mut self, field: fmt::Arguments<'_>, value: f32) {
        if !value.is_finite() {
            self.add("D4", field, format_args!("is {value}"));
        }
    }

    /// Several numbers with their names.
    fn floats(&mut self, values: &[(&str, f32)]) {
        for (name, value) in values {
            self.float(format_args!("{name}"), *value);
        }
    }

    fn vec3(&mut self, field: fmt::Arguments<'_>, value: Vec3) {
        if !value.is_finite() {
            self.add("D4", field, format_args!("is {value}"));
        }
    }

    fn quat(&mut self, field: fmt::Arguments<'_>, value: Quat) {
        let length = value.length();
        let off = (length - 1.0).abs();
        if off > QUATERNION_TOLERANCE || off.is_nan() {
            self.add("D4", field, format_args!("has length {length}, not 1"));
        }
    }

    fn frame(&mut self, field: fmt::Arguments<'_>, value: &Frame) {
        self.vec3(format_args!("{field}.origin"), value.origin);
        self.quat(format_args!("{field}.rotation"), value.rotation);
    }

    fn plane(&mut self, field: fmt::Arguments<'_>, value: &Plane) {
        self.vec3(format_args!("{field}.normal"), value.normal);
        self.float(format_args!("{field}.d"), value.d);
    }

    fn sphere(&mut self, field: fmt::Arguments<'_>, value: &Sphere) {
        self.vec3(format_args!("{field}.center"), value.center);
        self.float(format_args!("{field}.radius"), value.radius);
    }

    /// An id that must name a model.
    fn object_id(&mut self, field: fmt::Arguments<'_>, id: u32) {
        if !matches!(
            RecordKind::of_asset_id(id),
            RecordKind::GfxObj | RecordKind::Setup
        ) {
            self.add(
                "9.2",
                field,
                format_args!("{id:08X} is neither a GfxObj nor a Setup"),
            );
        }
    }
}
