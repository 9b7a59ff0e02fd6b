//! Records as readable text and as JSON with ids in hexadecimal.

use std::fmt::Write;

use serde_json::Value;
use vestibule_dat::record::{BspTag, BspTree, OtherCell, Record};

/// Items of a list shown unless all are wanted.
const SHOWN_ITEMS: usize = 12;
/// Width that a line of plain values may have.
const LINE: usize = 100;

/// Fields whose numbers are ids or flags, and are written in hexadecimal.
const HEX_FIELDS: &[&str] = &[
    "id",
    "id_again",
    "surfaces",
    "environment",
    "other_cell_id",
    "stabs",
    "restriction",
    "model_id",
    "parts",
    "texture",
    "textures",
    "palette",
    "gfx_obj",
    "object_id",
    "degrade_id",
    "default_animation",
    "default_script",
    "default_motion_table",
    "default_sound_table",
    "default_script_table",
    "sound_table",
    "scenes",
    "pes",
    "detail_texture",
    "game_map",
    "autotest_map",
    "clear_cell",
    "clear_monster",
    "flags",
    "colors",
    "color",
    "dir_color",
    "amb_color",
    "fog_color",
    "surface_type",
    "properties",
    "pack_mask",
    "parts_mask",
];

/// A record as JSON: its fields by name, ids and flags as `"0x..."`, long runs of bytes as one string of hexadecimal
/// digits.
pub fn to_json(record: &Record) -> Value {
    let mut value = fields(record);
    tidy(&mut value, "");
    value
}

/// A record as text, a field a line. Long lists are cut short unless `all`.
///
/// ```
/// use vestibule::dat::record::{Palette, Record};
///
/// let palette = Palette { id: 0x0400_0001, colors: Vec::new() };
/// let text = vestibule::describe::to_text(&Record::Palette(palette), false);
/// assert!(text.contains("id      0x04000001"));
/// ```
pub fn to_text(record: &Record, all: bool) -> String {
    let mut out = String::new();
    for note in notes(record) {
        let _ = writeln!(out, "{note}");
    }
    if !out.is_empty() {
        out.push('\n');
    }
    let mut value = to_json(record);
    strip_trees(&mut value);
    write_fields(&mut out, &value, 0, all);
    out
}

/// What a reader would want to know first.
fn notes(record: &Record) -> Vec<String> {
    let mut out = Vec::new();
    match record {
        Record::EnvCell(cell) => {
            let sees = if cell.seen_outside() {
                "the landscape can be seen from here"
            } else {
                "sealed from the landscape"
            };
            out.push(sees.to_owned());
            for (i, portal) in cell.portals.iter().enumerate() {
                let to = match portal.other_cell() {
                    OtherCell::Outside => "the outside".to_owned(),
                    OtherCell::Cell(id) => match portal.other_portal() {
                        Some(other) => format!("0x{id:08X}, its portal {other}"),
                        None => format!("0x{id:08X}"),
                    },
                };
                let exact = if portal.exact_match() {
                    "exact"
                } else {
                    "not exact"
                };
                let side = if portal.portal_side() == 1 {
                    "negative"
                } else {
                    "positive"
                };
                out.push(format!(
                    "portal {i}: polygon {} to {to}; {exact}, interior on the {side} side",
                    portal.polygon_id
                ));
            }
        }
        Record::LandBlockInfo(info) => {
            out.push(format!(
                "{} env cells, {} buildings, {} static objects",
                info.num_cells,
                info.buildings.len(),
                info.objects.len()
            ));
        }
        Record::Environment(environment) => {
            for cell in &environment.cell_structs {
                out.push(format!(
                    "cell structure {}: {} vertices, {} polygons ({} portals), {} to collide with",
                    cell.id,
                    cell.vertices.vertices.len(),
                    cell.polygons.len(),
                    cell.portals.len(),
                    cell.physics_polygons.len()
                ));
                out.push(format!("  cell tree:    {}", tree(&cell.cell_bsp)));
                out.push(format!("  physics tree: {}", tree(&cell.physics_bsp)));
                if let Some(drawing) = &cell.drawing_bsp {
                    out.push(format!("  drawing tree: {}", tree(drawing)));
                }
            }
        }
        Record::GfxObj(model) => {
            let (low, high) = model.bounding_box();
            out.push(format!(
                "{} vertices in a box of {:.2} x {:.2} x {:.2} m",
                model.vertices.vertices.len(),
                high.x - low.x,
                high.y - low.y,
                high.z - low.z
            ));
            for (name, part) in [("physics", &model.physics), ("drawing", &model.drawing)] {
                if let Some(part) = part {
                    out.push(format!(
                        "{name}: {} polygons; {}",
                        part.polygons.len(),
                        tree(&part.bsp)
                    ));
                }
            }
        }
        Record::Setup(setup) => out.push(format!(
            "{} parts, {} cylinders, {} spheres to collide with",
            setup.parts.len(),
            setup.cyl_spheres.len(),
            setup.spheres.len()
        )),
        Record::RenderSurface(surface) => {
            out.push(format!(
                "{} x {} pixels, {} bytes",
                surface.width,
                surface.height,
                surface.pixels.len()
            ));
        }
        _ => {}
    }
    out
}

/// A tree in one line: its size and what tags it has.
fn tree(bsp: &BspTree) -> String {
    let mut tags: Vec<(u32, usize)> = Vec::new();
    for node in &bsp.nodes {
        match tags.iter_mut().find(|(tag, _)| *tag == node.tag()) {
            Some((_, n)) => *n += 1,
            None => tags.push((node.tag(), 1)),
        }
    }
    let tags: Vec<String> = tags
        .iter()
        .map(|&(tag, n)| format!("{n} {}", BspTag::text(tag)))
        .collect();
    format!("{} nodes ({})", bsp.nodes.len(), tags.join(", "))
}

/// The record's fields, without the name of its type around them.
fn fields(record: &Record) -> Value {
    match serde_json::to_value(record) {
        Ok(Value::Object(map)) if map.len() == 1 => map.into_iter().next().map_or(Value::Null, |(_, v)| v),
        Ok(value) => value,
        Err(_) => Value::Null,
    }
}

/// Ids to hexadecimal, bytes to strings of digits, strings of the file to text.
fn tidy(value: &mut Value, key: &str) {
    if let Some(text) = legacy_string(value) {
        *value = text.into();
        return;
    }
    if matches!(key, "pixels" | "payload" | "bytes") {
        if let Value::Array(items) = value {
            let bytes: Option<Vec<u8>> = items
                .iter()
                .map(|item| item.as_u64().and_then(|b| u8::try_from(b).ok()))
                .collect();
            if let Some(bytes) = bytes {
                *value = hex_digits(&bytes).into();
            }
        }
        return;
    }
    match value {
        Value::Object(map) => map.iter_mut().for_each(|(key, value)| tidy(value, key)),
        Value::Array(items) => items.iter_mut().for_each(|value| tidy(value, key)),
        Value::Number(number) if key == "tag" => {
            if let Some(tag) = number.as_u64().and_then(|n| u32::try_from(n).ok()) {
                *value = BspTag::text(tag).into();
            }
        }
        Value::Number(number) if HEX_FIELDS.contains(&key) => {
            if let Some(id) = number.as_u64() {
                // Small numbers under these names are counters of their own, such as vertex ids.
                let is_flags = key.contains("flags") || key.contains("mask") || key.contains("type");
                if id > 0xFFFF {
                    *value = format!("0x{id:08X}").into();
                } else if is_flags {
                    *value = format!("0x{id:X}").into();
                }
            }
        }
        _ => {}
    }
}

/// The text of a string as records store it.
fn legacy_string(value: &Value) -> Option<String> {
    let map = value
        .as_object()
        .filter(|map| map.len() == 2 && map.contains_key("long_form"))?;
    let bytes: Option<Vec<u8>> = map
        .get("bytes")?
        .as_array()?
        .iter()
        .map(|b| b.as_u64().and_then(|b| u8::try_from(b).ok()))
        .collect();
    Some(
        vestibule_dat::primitive::LegacyString::new(bytes?)
            .text()
            .into_owned(),
    )
}

fn hex_digits(bytes: &[u8]) -> String {
    bytes
        .iter()
        .fold(String::with_capacity(2 * bytes.len()), |mut out, byte| {
            let _ = write!(out, "{byte:02x}");
            out
        })
}

/// Trees are for machines: the notes say how large they are.
fn strip_trees(value: &mut Value) {
    match value {
        Value::Object(map) => {
            if let (true, Some(Value::Array(nodes))) = (map.contains_key("kind"), map.get("nodes")) {
                *value = format!("tree of {} nodes (--json shows them)", nodes.len()).into();
                return;
            }
            map.values_mut().for_each(strip_trees);
        }
        Value::Array(items) => items.iter_mut().for_each(strip_trees),
        _ => {}
    }
}

fn write_fields(out: &mut String, value: &Value, indent: usize, all: bool) {
    let Value::Object(map) = value else {
        let _ = writeln!(out, "{}{}", " ".repeat(indent), inline(value).unwrap_or_default());
        return;
    };
    let width = map.keys().map(String::len).max().unwrap_or(0);
    for (key, value) in map {
        let pad = " ".repeat(indent);
        let text = inline(value).filter(|t| t.chars().count() + width + indent <= LINE || !has_parts(value));
        match (text, value) {
            (Some(text), _) => {
                let text = shorten_run(text, all);
                let _ = writeln!(out, "{pad}{key:width$}  {text}");
            }
            (None, Value::Array(items)) => write_list(out, key, items, indent, all),
            (None, value) => {
                let _ = writeln!(out, "{pad}{key}");
                write_fields(out, value, indent + 2, all);
            }
        }
    }
}

/// One long word, such as pixels.
fn shorten_run(text: String, all: bool) -> String {
    let length = text.chars().count();
    if all || length <= 2 * LINE {
        return text;
    }
    let start: String = text.chars().take(LINE).collect();
    format!("{start}... ({length} characters, --all shows them)")
}

fn write_list(out: &mut String, key: &str, items: &[Value], indent: usize, all: bool) {
    let pad = " ".repeat(indent);
    let _ = writeln!(out, "{pad}{key} ({})", items.len());
    let numbers = items.iter().all(|item| !has_parts(item));
    if numbers {
        // Terrain has 9 a side; everything else goes by what fits.
        let per_line = if items.len() == 81 { 9 } else { 16 };
        let texts: Vec<String> = items.iter().filter_map(inline).collect();
        let widest = texts.iter().map(|t| t.chars().count()).max().unwrap_or(0);
        let lines = if all || items.len() == 81 {
            usize::MAX
        } else {
            SHOWN_ITEMS
        };
        for line in texts.chunks(per_line).take(lines) {
            let line: Vec<String> = line.iter().map(|t| format!("{t:>widest$}")).collect();
            let _ = writeln!(out, "{pad}  {}", line.join(" "));
        }
        let hidden = texts.len().saturating_sub(lines.saturating_mul(per_line));
        if hidden > 0 {
            let _ = writeln!(out, "{pad}  ... {hidden} more (--all shows them)");
        }
        return;
    }
    // Lists within lists are cut shorter, or the whole would not be seen for its parts.
    let shown = match (all, indent) {
        (true, _) => items.len(),
        (false, 0) => SHOWN_ITEMS,
        (false, _) => SHOWN_ITEMS / 3,
    };
    for (i, item) in items.iter().enumerate().take(shown) {
        match inline(item).filter(|t| t.chars().count() + indent <= 2 * LINE) {
            Some(text) => {
                let _ = writeln!(out, "{pad}  [{i}] {text}");
            }
            None => {
                let _ = writeln!(out, "{pad}  [{i}]");
                write_fields(out, item, indent + 6, all);
            }
        }
    }
    if items.len() > shown {
        let _ = writeln!(out, "{pad}  ... {} more (--all shows them)", items.len() - shown);
    }
}

fn has_parts(value: &Value) -> bool {
    matches!(value, Value::Object(_) | Value::Array(_))
}

/// A value on one line, if it is simple enough.
fn inline(value: &Value) -> Option<String> {
    match value {
        Value::Null => Some("none".to_owned()),
        Value::Bool(b) => Some(b.to_string()),
        Value::Number(n) => Some(number(n)),
        Value::String(s) => Some(s.clone()),
        Value::Array(items) if items.is_empty() => Some("none".to_owned()),
        Value::Array(items) => {
            if items.len() > 16 {
                return None;
            }
            let plain = items.iter().all(|item| !has_parts(item));
            let texts: Option<Vec<String>> = items.iter().map(inline).collect();
            let texts = texts?;
            let text = format!("[{}]", texts.join(if plain { " " } else { ", " }));
            // Lists of lists and of objects only where they are short.
            (plain || text.chars().count() <= LINE / 2 && !items.iter().any(Value::is_object)).then_some(text)
        }
        Value::Object(map) => {
            if let (Some(origin), Some(Value::Array(q)), 2) =
                (map.get("origin"), map.get("rotation"), map.len())
            {
                // glam writes x y z w; people write w first.
                let [x, y, z, w] = q.as_slice() else { return None };
                let q: Option<Vec<String>> = [w, x, y, z].into_iter().map(inline).collect();
                return Some(format!("{} {}", inline(origin)?, q?.join(" ")));
            }
            let mut out = Vec::new();
            for (key, value) in map {
                out.push(format!("{key} {}", inline(value)?));
            }
            let text = out.join(", ");
            (text.chars().count() <= 2 * LINE).then_some(text)
        }
    }
}

/// Numbers of single precision as they are read, not as their double is written.
fn number(n: &serde_json::Number) -> String {
    match n.as_f64() {
        Some(value) if n.is_f64() => {
            let single = value as f32;
            if f64::from(single) == value {
                plain(format!("{single:?}"))
            } else {
                plain(format!("{value:?}"))
            }
        }
        _ => n.to_string(),
    }
}

/// Without the `.0` of whole numbers.
fn plain(text: String) -> String {
    text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
}
