//! JPEG files in RenderSurface records (`rendering.md` 15).

use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// The pixels of a file; `None` when it is damaged or not of this size.
pub(crate) fn decode(bytes: &[u8], width: u32, height: u32) -> Option<Vec<[u8; 4]>> {
    let (width, height) = (width as usize, height as usize);
    // Portable code only: the same pixels on every machine. Larger files are refused before anything is allocated.
    let options = DecoderOptions::new_safe()
        .set_max_width(width)
        .set_max_height(height)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().ok()?;
    if decoder.dimensions() != Some((width, height)) {
        return None;
    }
    let rgb = decoder.decode().ok()?;
    let pixels: Vec<[u8; 4]> = rgb.chunks_exact(3).map(|c| [c[0], c[1], c[2], 255]).collect();
    (pixels.len() == width * height).then_some(pixels)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A file of 8 x 8 pixels of one colour: per component one coefficient of 64…127 or -127…-64, in steps of 8.
    pub(crate) fn file(components: &[i32]) -> Vec<u8> {
        let n = components.len() as u8;
        let mut out = vec![0xFF, 0xD8];
        let mut segment = |marker: u8, body: &[u8]| {
            out.extend([0xFF, marker, 0, body.len() as u8 + 2]);
            out.extend(body);
        };
        segment(0xDB, &[&[0u8][..], &[8u8; 64][..]].concat());
        let mut frame = vec![8, 0, 8, 0, 8, n];
        frame.extend((1..=n).flat_map(|k| [k, 0x11, 0]));
        segment(0xC0, &frame);
        // One code of one bit each: a difference of seven bits; the end of the block.
        let table = |class: u8, symbol: u8| {
            let mut t = vec![class, 1];
            t.extend([0; 15]);
            t.push(symbol);
            t
        };
        segment(0xC4, &table(0x00, 7));
        segment(0xC4, &table(0x10, 0));
        let mut scan = vec![n];
        scan.extend((1..=n).flat_map(|k| [k, 0]));
        scan.extend([0, 63, 0]);
        segment(0xDA, &scan);
        let mut bits = Vec::new();
        for &c in components {
            let code = if c < 0 { c + 127 } else { c };
            bits.push(0);
            bits.extend((0..7).rev().map(|k| code >> k & 1));
            bits.push(0);
        }
        while bits.len() % 8 != 0 {
            bits.push(1);
        }
        out.extend(
            bits.chunks(8)
                .map(|b| b.iter().fold(0u8, |v, &bit| v << 1 | bit as u8)),
        );
        out.extend([0xFF, 0xD9]);
        out
    }

    fn close(a: [u8; 4], b: [u8; 4]) -> bool {
        a.iter().zip(b).all(|(&a, b)| a.abs_diff(b) <= 2)
    }

    #[test]
    fn colours_and_greys() {
        let grey = decode(&file(&[72]), 8, 8).unwrap();
        assert!(
            grey.iter().all(|&p| close(p, [200, 200, 200, 255])),
            "{:?}",
            grey[0]
        );
        // Y 200, Cb 56, Cr 200.
        let color = decode(&file(&[72, -72, 72]), 8, 8).unwrap();
        assert!(
            color.iter().all(|&p| close(p, [255, 173, 72, 255])),
            "{:?}",
            color[0]
        );
    }

    #[test]
    fn other_sizes_and_damage_are_refused() {
        assert!(decode(&file(&[72]), 4, 8).is_none());
        assert!(decode(&file(&[72]), 80, 80).is_none());
        assert!(decode(b"not a picture", 8, 8).is_none());
        assert!(decode(&[], 8, 8).is_none());
    }
}
