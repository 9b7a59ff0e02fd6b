//! Block-compressed textures: DXT1, DXT3 and DXT5 (BC1 to BC3), straight alpha (`rendering.md` 15).

/// Which of the three.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dxt {
    One,
    Three,
    Five,
}

/// Decodes `width` x `height` pixels. Blocks that the bytes lack stay as `missing`.
pub(crate) fn decode(kind: Dxt, bytes: &[u8], width: usize, height: usize, missing: [u8; 4]) -> Vec<[u8; 4]> {
    let mut out = vec![missing; width * height];
    let block_size = if kind == Dxt::One { 8 } else { 16 };
    let columns = width.div_ceil(4);
    for (index, block) in bytes.chunks_exact(block_size).enumerate() {
        let (bx, by) = (index % columns * 4, index / columns * 4);
        if by >= height {
            break;
        }
        let texels = match kind {
            Dxt::One => colors(block, true),
            Dxt::Three => {
                let mut texels = colors(&block[8..], false);
                for (i, t) in texels.iter_mut().enumerate() {
                    let nibble = block[i / 2] >> (i % 2 * 4) & 15;
                    t[3] = nibble * 17;
                }
                texels
            }
            Dxt::Five => {
                let mut texels = colors(&block[8..], false);
                let alphas = alpha_ramp(block[0], block[1]);
                let bits = block[2..8]
                    .iter()
                    .rev()
                    .fold(0u64, |bits, &b| bits << 8 | u64::from(b));
                for (i, t) in texels.iter_mut().enumerate() {
                    t[3] = alphas[(bits >> (3 * i) & 7) as usize];
                }
                texels
            }
        };
        for (i, texel) in texels.into_iter().enumerate() {
            let (x, y) = (bx + i % 4, by + i / 4);
            if x < width && y < height {
                out[y * width + x] = texel;
            }
        }
    }
    out
}

fn rgb565(v: u16) -> [u8; 3] {
    let (r, g, b) = (v >> 11, v >> 5 & 63, v & 31);
    [
        (r << 3 | r >> 2) as u8,
        (g << 2 | g >> 4) as u8,
        (b << 3 | b >> 2) as u8,
    ]
}

/// The 16 texels of a colour block; `punch` allows the one-bit transparent code of DXT1.
fn colors(block: &[u8], punch: bool) -> [[u8; 4]; 16] {
    let word = |i: usize| u16::from_le_bytes([block[i], block[i + 1]]);
    let (c0, c1) = (word(0), word(2));
    let (a, b) = (rgb565(c0), rgb565(c1));
    let mix = |wa: u16, wb: u16, total: u16| -> [u8; 4] {
        let m = |k: usize| ((u16::from(a[k]) * wa + u16::from(b[k]) * wb + total / 2) / total) as u8;
        [m(0), m(1), m(2), 255]
    };
    let ramp = if c0 > c1 || !punch {
        [mix(1, 0, 1), mix(0, 1, 1), mix(2, 1, 3), mix(1, 2, 3)]
    } else {
        [mix(1, 0, 1), mix(0, 1, 1), mix(1, 1, 2), [0; 4]]
    };
    let bits = u32::from_le_bytes([block[4], block[5], block[6], block[7]]);
    core::array::from_fn(|i| ramp[(bits >> (2 * i) & 3) as usize])
}

fn alpha_ramp(a: u8, b: u8) -> [u8; 8] {
    let mix =
        |wa: u16, wb: u16, total: u16| ((u16::from(a) * wa + u16::from(b) * wb + total / 2) / total) as u8;
    if a > b {
        [
            a,
            b,
            mix(6, 1, 7),
            mix(5, 2, 7),
            mix(4, 3, 7),
            mix(3, 4, 7),
            mix(2, 5, 7),
            mix(1, 6, 7),
        ]
    } else {
        [
            a,
            b,
            mix(4, 1, 5),
            mix(3, 2, 5),
            mix(2, 3, 5),
            mix(1, 4, 5),
            0,
            255,
        ]
    }
}
