//! How pictures differ.

use vestibule_render::{IdImage, Oracle, PixelId, PixelKind};
use vestibule_view::Camera;

/// How two id pictures differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Difference {
    pub pixels: usize,
    pub differing: usize,
    /// Of these: surfaces meet within the pixel, and it shows one of those that do.
    pub at_edges: usize,
    /// Of these: surfaces meet within the pixel, but it shows another.
    pub at_seams: usize,
    /// Of these: two rooms do not agree on the opening between them.
    pub disputed: usize,
    /// Pixels that kept the clear colour.
    pub clear: usize,
    /// Of these: where two rooms do not agree on their opening.
    pub clear_disputed: usize,
}

impl Difference {
    pub fn add(&mut self, o: Difference) {
        self.pixels += o.pixels;
        self.differing += o.differing;
        self.at_edges += o.at_edges;
        self.at_seams += o.at_seams;
        self.disputed += o.disputed;
        self.clear += o.clear;
        self.clear_disputed += o.clear_disputed;
    }

    pub fn unexplained(&self) -> usize {
        self.differing - self.at_edges - self.at_seams - self.disputed
    }
}

/// Pixels that differ between two pictures.
pub fn compare(a: &IdImage, b: &IdImage) -> Difference {
    Difference {
        pixels: a.ids().len(),
        differing: a.ids().iter().zip(b.ids()).filter(|(a, b)| a != b).count(),
        clear: a.count(PixelKind::Background),
        ..Difference::default()
    }
}

/// Compares a picture with the oracle. Where they differ, rays are cast all over the square of one pixel to each
/// side: surfaces meet within the pixel when they do not all meet the same.
pub fn compare_with_oracle(
    picture: &IdImage,
    oracle: &Oracle,
    camera: &Camera,
    mut report: impl FnMut(u32, u32, PixelId, PixelId),
) -> Difference {
    let mut out = Difference {
        pixels: picture.ids().len(),
        clear: picture.count(PixelKind::Background),
        ..Difference::default()
    };
    for y in 0..picture.height() {
        for x in 0..picture.width() {
            let (cx, cy) = (x as f32 + 0.5, y as f32 + 0.5);
            let shown = picture.get(x, y).unwrap();
            let truth = oracle.pixel(camera, cx, cy);
            if shown == truth.id {
                continue;
            }
            out.differing += 1;
            let (mut uniform, mut met, mut disputed) = (true, false, truth.disputed);
            for r in [0.02f32, 1.0] {
                for k in 0..81 {
                    let (dx, dy) = ((k % 9 - 4) as f32 * r / 4.0, (k / 9 - 4) as f32 * r / 4.0);
                    let hit = oracle.pixel(camera, cx + dx, cy + dy);
                    uniform &= hit.id == truth.id;
                    met |= hit.id == shown;
                    disputed |= hit.disputed;
                }
            }
            out.clear_disputed += usize::from(disputed && shown == PixelId::BACKGROUND);
            if disputed {
                out.disputed += 1;
                if std::env::var_os("DISPUTED").is_some() {
                    report(x, y, shown, truth.id);
                }
            } else if met {
                out.at_edges += 1;
            } else if !uniform {
                out.at_seams += 1;
                if std::env::var_os("SEAMS").is_some() {
                    report(x, y, shown, truth.id);
                }
            } else {
                report(x, y, shown, truth.id);
            }
        }
    }
    out
}
