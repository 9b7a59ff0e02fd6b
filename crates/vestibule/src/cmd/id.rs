//! Ids as arguments.

use vestibule::world::BlockId;

/// A record id of eight hexadecimal digits, with or without `0x`.
pub(crate) fn parse_record_id(text: &str) -> Result<u32, String> {
    parse_hex(text, 8)
        .ok_or_else(|| "write a record id as eight hexadecimal digits, as 0xA9B40100".to_owned())
}

/// A landblock: four hexadecimal digits, or any id in it.
pub(crate) fn parse_block(text: &str) -> Result<BlockId, String> {
    let block = parse_hex(text, 4).or_else(|| parse_hex(text, 8).map(|id| id >> 16));
    let help = "write a landblock as four hexadecimal digits, as A9B4 (or the id of a cell in it)";
    let block = block
        .and_then(|b| u16::try_from(b).ok())
        .map(BlockId)
        .ok_or(help)?;
    if !block.is_on_map() {
        return Err("that landblock is off the map, whose indices go from 00 to FE".to_owned());
    }
    Ok(block)
}

fn parse_hex(text: &str, digits: usize) -> Option<u32> {
    let hex = text
        .strip_prefix("0x")
        .or_else(|| text.strip_prefix("0X"))
        .unwrap_or(text);
    let sound = hex.len() == digits && hex.bytes().all(|b| b.is_ascii_hexdigit());
    if sound {
        u32::from_str_radix(hex, 16).ok()
    } else {
        None
    }
}

/// An id as text.
pub(crate) fn hex(id: u32) -> String {
    format!("0x{id:08X}")
}
