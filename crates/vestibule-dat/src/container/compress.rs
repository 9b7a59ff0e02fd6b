//! Compressed records (`dat-format.md` 3.4).

use crate::error::{ErrorKind, Fault, Limits};
use flate2::{Compress, Compression, Decompress, FlushCompress, FlushDecompress, Status};

/// The word with the size plus the shortest zlib stream (B10).
const SHORTEST: usize = 12;
/// Inflating asks for memory in steps of this size, so that a lie about the size costs nothing.
const STEP: usize = 64 << 10;

/// Inflates `stored` (B9, B10) into `out`, which is cleared first.
pub(crate) fn inflate(stored: &[u8], limits: Limits, out: &mut Vec<u8>) -> Result<(), Fault> {
    let corrupt = |why| Fault::new("uncompressed_size", ErrorKind::Compressed(why));
    out.clear();
    if stored.len() < SHORTEST {
        return Err(corrupt("shorter than 12 bytes"));
    }
    let (size, stream) = stored.split_at(4);
    let size = u32::from_le_bytes([size[0], size[1], size[2], size[3]]);
    if size > limits.inflated {
        let kind = ErrorKind::OverLimit {
            size: u64::from(size),
            limit: u64::from(limits.inflated),
        };
        return Err(Fault::new("uncompressed_size", kind));
    }
    let size = size as usize;
    let mut zlib = Decompress::new(true);
    loop {
        // One byte more than announced is asked for, so that a longer stream shows.
        let room = (size + 1 - out.len()).min(STEP);
        if room == 0 {
            return Err(corrupt("inflates to more than it announces"));
        }
        out.reserve(room);
        let (eaten, made) = (zlib.total_in() as usize, out.len());
        let input = stream.get(eaten..).unwrap_or_default();
        let status = zlib
            .decompress_vec(input, out, FlushDecompress::None)
            .map_err(|_| corrupt("bad zlib stream"))?;
        if out.len() > size {
            return Err(corrupt("inflates to more than it announces"));
        }
        match status {
            Status::StreamEnd if out.len() == size => return Ok(()),
            Status::StreamEnd => return Err(corrupt("inflates to less than it announces")),
            Status::Ok | Status::BufError => {
                if zlib.total_in() as usize == eaten && out.len() == made {
                    return Err(corrupt("the zlib stream is cut off"));
                }
            }
        }
    }
}

/// The stored form of `plain`, or `None` when that is not shorter (B10).
pub(crate) fn deflate(plain: &[u8]) -> Option<Vec<u8>> {
    let size = u32::try_from(plain.len()).ok()?;
    let mut out = Vec::with_capacity(plain.len());
    out.extend_from_slice(&size.to_le_bytes());
    let mut zlib = Compress::new(Compression::best(), true);
    // The capacity is the plain length: what does not fit is not shorter.
    match zlib.compress_vec(plain, &mut out, FlushCompress::Finish) {
        Ok(Status::StreamEnd) if out.len() < plain.len() => Some(out),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inflated(stored: &[u8]) -> Result<Vec<u8>, Fault> {
        let mut out = Vec::new();
        inflate(stored, Limits::default(), &mut out).map(|()| out)
    }

    #[test]
    fn b9_round_trip() {
        for n in [100usize, 70_000, 400_000] {
            let plain: Vec<u8> = (0..n).map(|i| (i / 7) as u8).collect();
            let stored = deflate(&plain).unwrap();
            assert_eq!(stored[..4], (n as u32).to_le_bytes());
            assert_eq!(inflated(&stored).unwrap(), plain);
        }
    }

    #[test]
    fn b10_plain_bytes_when_not_longer() {
        assert_eq!(deflate(b"short"), None);
        assert_eq!(deflate(b""), None);
    }

    #[test]
    fn b10_size_word_must_be_true_and_below_the_limit() {
        let stored = deflate(&[5; 1000]).unwrap();
        for lie in [0u32, 999, 1001, 100_000] {
            let mut bad = stored.clone();
            bad[..4].copy_from_slice(&lie.to_le_bytes());
            assert!(
                matches!(inflated(&bad).unwrap_err().kind, ErrorKind::Compressed(_)),
                "{lie}"
            );
        }
        let mut out = Vec::new();
        let e = inflate(&stored, Limits { inflated: 999 }, &mut out).unwrap_err();
        assert!(matches!(
            e.kind,
            ErrorKind::OverLimit {
                size: 1000,
                limit: 999
            }
        ));
        assert!(inflate(&stored, Limits { inflated: 1000 }, &mut out).is_ok());
    }

    #[test]
    fn b10_short_cut_off_and_broken_streams() {
        let stored = deflate(&[5; 1000]).unwrap();
        assert!(inflated(&stored[..11]).is_err());
        assert!(inflated(&stored[..stored.len() - 1]).is_err());
        let mut bad = stored;
        bad[4] = 0xFF;
        assert!(inflated(&bad).is_err());
    }
}
