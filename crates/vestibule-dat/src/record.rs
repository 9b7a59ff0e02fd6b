//! Records: the contents of the files, one type a file of this module (`dat-format.md` sections 6 and 8 to 10).
//!
//! Every type parses and encodes without loss: what has more than one spelling is kept as it was read (D5).
//! [`Record`] is any of them; types this crate does not know pass through as bytes.
//!
//! ```
//! use vestibule_dat::record::{Palette, Record};
//! use vestibule_dat::{DatKind, RecordKind};
//!
//! let bytes = [1, 0, 0, 4, 1, 0, 0, 0, 0x30, 0x20, 0x10, 0xFF];
//! let palette = Palette::parse(0x0400_0001, &bytes)?;
//! assert_eq!(palette.colors[0].red(), 0x10);
//! assert_eq!(palette.encode()?, bytes);
//!
//! // Or without knowing the type beforehand:
//! let kind = RecordKind::of(DatKind::Portal, 0x0400_0001);
//! assert!(matches!(Record::parse(kind, 0x0400_0001, &bytes)?, Record::Palette(_)));
//! # Ok::<(), vestibule_dat::record::RecordError>(())
//! ```

mod bsp;
mod degrade_info;
mod env_cell;
mod environment;
mod error;
#[cfg(test)]
mod examples;
mod gfx_obj;
mod iteration;
mod land_block;
mod land_block_info;
pub mod lint;
mod load;
mod palette;
mod polygon;
mod references;
pub mod region;
mod render_surface;
mod round_trip;
mod scene;
mod setup;
mod short_id;
mod stab;
mod surface;
mod surface_texture;
mod vertex;

pub use bsp::{BspKind, BspLeafPhysics, BspNode, BspTag, BspTree};
pub use degrade_info::{Degrade, GfxObjDegradeInfo};
pub use env_cell::{CellPortal, EnvCell, OtherCell};
pub use environment::{CellStruct, Environment};
pub use error::{RecordError, RecordErrorKind};
pub use gfx_obj::{GfxObj, GfxObjPolygons};
pub use land_block::LandBlock;
pub use land_block_info::{Building, BuildingPortal, LandBlockInfo};
pub use palette::Palette;
pub use polygon::{Polygon, Sides, find_polygon};
pub use references::Reference;
pub use region::Region;
pub use render_surface::{PixelFormat, RenderSurface};
pub use round_trip::{RoundTrip, round_trip};
pub use scene::{ObjectDesc, Scene};
pub use setup::{Hook, Light, Location, PlacementFrame, Setup};
pub use stab::Stab;
pub use surface::{Paint, Surface};
pub use surface_texture::SurfaceTexture;
pub use vertex::{Vertex, VertexArray};

use std::ops::Range;

use crate::container::IterationRecord;
use crate::data_id::RecordKind;
use crate::primitive::{Reader, Writer};

/// A record type: how it is read and written. The types themselves have `parse` and `encode`, which are easier to
/// call; this trait is for code that is generic over them.
pub trait DatRecord: Sized {
    /// Reads the record from its start.
    ///
    /// # Errors
    /// The bytes are not such a record.
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError>;

    /// Writes the record.
    ///
    /// # Errors
    /// The value contradicts itself, or has more of something than the format can count.
    fn write(&self, writer: &mut Writer) -> Result<(), RecordError>;

    /// The data id that the record itself holds; some types hold none.
    fn stored_id(&self) -> Option<u32>;
}

/// Reads a whole record: `T::read`, then nothing may be left (F6).
///
/// # Errors
/// The bytes are not such a record.
pub fn parse<T: DatRecord>(id: u32, bytes: &[u8]) -> Result<T, RecordError> {
    let mut reader = Reader::new(id, bytes);
    let record = T::read(&mut reader)?;
    reader.finish()?;
    Ok(record)
}

/// Writes a whole record. The id, which errors name, is that stored in the record, or 0.
///
/// # Errors
/// The value contradicts itself, or has more of something than the format can count.
pub fn encode<T: DatRecord>(record: &T) -> Result<Vec<u8>, RecordError> {
    write_record(record, record.stored_id().unwrap_or(0)).map(|(bytes, _)| bytes)
}

fn write_record<T: DatRecord>(record: &T, id: u32) -> Result<(Vec<u8>, Vec<Range<usize>>), RecordError> {
    let mut writer = Writer::new(id);
    record.write(&mut writer)?;
    Ok(writer.finish())
}

/// Serialises an array that is too long for serde's own implementations.
#[cfg(feature = "serde")]
pub(crate) fn serialize_array<T: serde::Serialize, S: serde::Serializer, const N: usize>(
    array: &[T; N],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serde::Serialize::serialize(array.as_slice(), serializer)
}

/// Gives a record type `parse` and `encode` of its own.
macro_rules! inherent_parse_and_encode {
    ($name:ident) => {
        impl $name {
            /// Reads the record from its bytes; `id` is its data id in the directory, named in errors.
            ///
            /// # Errors
            /// The bytes are not such a record, or bytes are left over after it.
            pub fn parse(id: u32, bytes: &[u8]) -> Result<Self, RecordError> {
                $crate::record::parse(id, bytes)
            }

            /// The bytes of the record; of a record that was parsed, the same bytes (padding aside).
            ///
            /// # Errors
            /// Fields contradict each other, or there is more of something than the format can count.
            pub fn encode(&self) -> Result<Vec<u8>, RecordError> {
                $crate::record::encode(self)
            }
        }
    };
}
pub(crate) use inherent_parse_and_encode;

macro_rules! any_record {
    ($($(#[$doc:meta])* $name:ident($type:ty);)*) => {
        /// Any record.
        #[derive(Debug, Clone, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize))]
        #[non_exhaustive]
        pub enum Record {
            $($(#[$doc])* $name($type),)*
            /// A type that this crate does not know; passes through untouched.
            Raw {
                /// What it is by its id.
                kind: RecordKind,
                /// Its bytes.
                bytes: Vec<u8>,
            },
        }

        impl Record {
            /// Reads a record of this kind; [`RecordKind::of`] tells the kind from file and id.
            ///
            /// # Errors
            /// The bytes are not such a record.
            pub fn parse(kind: RecordKind, id: u32, bytes: &[u8]) -> Result<Self, RecordError> {
                match kind {
                    $(RecordKind::$name => Ok(Self::$name(parse::<$type>(id, bytes)?)),)*
                    _ => Ok(Self::Raw { kind, bytes: bytes.to_vec() }),
                }
            }

            /// What it is.
            pub fn kind(&self) -> RecordKind {
                match self {
                    $(Self::$name(_) => RecordKind::$name,)*
                    Self::Raw { kind, .. } => *kind,
                }
            }

            /// The data id that the record itself holds; some types hold none.
            pub fn stored_id(&self) -> Option<u32> {
                match self {
                    $(Self::$name(record) => record.stored_id(),)*
                    Self::Raw { .. } => None,
                }
            }

            /// The bytes and which of them are padding.
            fn write(&self, id: u32) -> Result<(Vec<u8>, Vec<Range<usize>>), RecordError> {
                match self {
                    $(Self::$name(record) => write_record(record, id),)*
                    Self::Raw { bytes, .. } => Ok((bytes.clone(), Vec::new())),
                }
            }
        }
    };
}

any_record! {
    /// Terrain of a landblock.
    LandBlock(LandBlock);
    /// Objects and buildings of a landblock.
    LandBlockInfo(LandBlockInfo);
    /// An indoor cell.
    EnvCell(EnvCell);
    /// Shapes of indoor cells.
    Environment(Environment);
    /// A rigid model.
    GfxObj(GfxObj);
    /// An object of several parts.
    Setup(Setup);
    /// Settings of a landscape.
    Region(Box<Region>);
    /// How a polygon is painted.
    Surface(Surface);
    /// The sizes of a texture.
    SurfaceTexture(SurfaceTexture);
    /// Pixels of a texture.
    RenderSurface(RenderSurface);
    /// Colours by index.
    Palette(Palette);
    /// Scenery.
    Scene(Scene);
    /// Coarser versions of a model.
    GfxObjDegradeInfo(GfxObjDegradeInfo);
    /// Which patch iterations a file holds.
    Iteration(IterationRecord);
}

impl Record {
    /// The bytes of the record; of a record that was parsed, the same bytes (padding aside).
    ///
    /// # Errors
    /// Fields contradict each other, or there is more of something than the format can count.
    pub fn encode(&self) -> Result<Vec<u8>, RecordError> {
        self.write(self.stored_id().unwrap_or(0)).map(|(bytes, _)| bytes)
    }
}

impl<T: DatRecord> DatRecord for Box<T> {
    fn read(reader: &mut Reader<'_>) -> Result<Self, RecordError> {
        T::read(reader).map(Box::new)
    }

    fn write(&self, writer: &mut Writer) -> Result<(), RecordError> {
        T::write(self, writer)
    }

    fn stored_id(&self) -> Option<u32> {
        T::stored_id(self)
    }
}
