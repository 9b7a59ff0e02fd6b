//! Who uses a record.

use vestibule_dat::record::{Record, Reference};
use vestibule_dat::{DatFile, DatKind, DatSet, Entries, Entry, RecordKind};
use vestibule_world::Store;

/// Which of the two id spaces a mention is in.
pub fn store_of(kind: RecordKind) -> Store {
    match kind {
        RecordKind::LandBlock | RecordKind::LandBlockInfo | RecordKind::EnvCell => Store::Cell,
        _ => Store::Portal,
    }
}

/// Every mention of another record in `record`: those of [`Record::references`], and the env cells that a landblock
/// has by their number.
pub fn of_record(record: &Record) -> Vec<Reference> {
    let mut out = record.references();
    if let Record::LandBlockInfo(info) = record {
        // Ids run without gaps from 0x0100; a larger count than there are ids is damage.
        for low in 0x100..0x100 + info.num_cells.min(0xFFFD - 0x100 + 1) {
            let id = info.id & 0xFFFF_0000 | low;
            out.push(Reference {
                kind: RecordKind::EnvCell,
                id,
                field: "num_cells",
            });
        }
    }
    out
}

/// A record that uses another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct User {
    /// The file it is in.
    pub file: DatKind,
    /// Its id.
    pub id: u32,
    /// What it is.
    pub kind: RecordKind,
    /// The fields that name the other record.
    pub fields: Vec<String>,
}

/// Who uses a record, from [`users_of`].
#[derive(Clone, Debug, Default)]
pub struct Users {
    /// The users, by file and id.
    pub users: Vec<User>,
    /// Records and directory nodes that could not be read, as errors.
    pub unreadable: Vec<String>,
}

/// Every record that names record `id` of `store`. Reads all records whose type can name others; `progress` is called with
/// the number of records looked at.
pub fn users_of(dats: &DatSet, store: Store, id: u32, progress: &mut dyn FnMut(u64)) -> Users {
    let mut out = Users::default();
    let mut done = 0;
    for (file_kind, file) in dats.files() {
        for entry in users_in(file_kind, store, id, file) {
            done += 1;
            progress(done);
            let entry = match entry {
                Ok(entry) => entry,
                Err(e) => {
                    out.unreadable.push(e.to_string());
                    continue;
                }
            };
            let kind = RecordKind::of(file_kind, entry.id);
            if !can_refer(kind, store) {
                continue;
            }
            match read(file, &entry, kind) {
                Ok(record) => {
                    let fields: Vec<String> = of_record(&record)
                        .into_iter()
                        .filter(|r| store_of(r.kind) == store && r.id == id)
                        .map(|r| r.field.to_owned())
                        .collect();
                    if !fields.is_empty() {
                        out.users.push(User {
                            file: file_kind,
                            id: entry.id,
                            kind,
                            fields,
                        });
                    }
                }
                Err(e) => out.unreadable.push(e),
            }
        }
    }
    out
}

/// The entries of a file that may name the record: only those of its landblock where a cell record is named.
fn users_in<'a>(kind: DatKind, store: Store, id: u32, file: &'a DatFile) -> Entries<'a> {
    match (kind, store) {
        (DatKind::Cell, Store::Cell) => file.range(id & 0xFFFF_0000..=id | 0xFFFF),
        (DatKind::Cell, Store::Portal) | (_, Store::Portal) => file.iter(),
        (_, Store::Cell) => file.range(0..0),
    }
}

fn can_refer(kind: RecordKind, store: Store) -> bool {
    use RecordKind as K;
    match kind {
        K::LandBlock => store == Store::Cell,
        K::LandBlockInfo | K::EnvCell => true,
        K::GfxObj | K::Setup | K::Region | K::Surface | K::SurfaceTexture => store == Store::Portal,
        K::RenderSurface | K::Scene | K::GfxObjDegradeInfo => store == Store::Portal,
        _ => false,
    }
}

fn read(file: &DatFile, entry: &Entry, kind: RecordKind) -> Result<Record, String> {
    let bytes = file.read(entry).map_err(|e| e.to_string())?;
    Record::parse(kind, entry.id, &bytes).map_err(|e| format!("{e}, in {}", file.name()))
}
