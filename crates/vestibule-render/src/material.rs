//! Materials: what a Surface record says about drawing (`rendering.md` 14.1, 14.2).

use std::sync::Arc;

use vestibule_dat::record::{Paint, Surface};

use crate::texture::Texture;

/// A factor of a blend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Factor {
    /// 0.
    Zero,
    /// 1.
    One,
    /// The alpha of what is drawn.
    SrcAlpha,
    /// 1 minus that.
    InvSrcAlpha,
}

/// How a colour is put over what is there: `source * src + destination * dst`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Blend {
    /// Factor of what is drawn.
    pub src: Factor,
    /// Factor of what is there.
    pub dst: Factor,
}

impl Blend {
    /// Replaces what is there.
    pub const OPAQUE: Blend = Blend {
        src: Factor::One,
        dst: Factor::Zero,
    };
    /// Straight alpha.
    pub const ALPHA: Blend = Blend {
        src: Factor::SrcAlpha,
        dst: Factor::InvSrcAlpha,
    };
}

/// When a material is drawn (`rendering.md` 14.2, 14.7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawList {
    /// At once.
    Now,
    /// With the next flush, before what is blended.
    CutOut,
    /// With the next flush, far to near.
    Blended,
}

/// How polygons of one surface are drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The picture; one pixel for a colour, a magenta checker for what could not be had.
    pub texture: Arc<Texture>,
    /// How it is put over what is there.
    pub blend: Blend,
    /// Pixels with less alpha (0…255) are not drawn.
    pub alpha_test: Option<u8>,
    /// Alpha of the vertices.
    pub opacity: f32,
    /// Light reflected, 0…1.
    pub diffuse: f32,
    /// Light of its own, 0…1.
    pub luminosity: f32,
    /// Additive surfaces are not fogged (`rendering.md` 13.2).
    pub fogged: bool,
    /// It has a picture; colours stand on dummy polygons of shells and are left out there (14.4).
    pub has_image: bool,
    /// When it is drawn.
    pub list: DrawList,
}

impl Material {
    /// The rules of `rendering.md` 14.2 for a surface whose texture is at hand. `paletted` tells whether the
    /// texture has a palette.
    pub fn new(surface: &Surface, texture: Arc<Texture>, paletted: bool) -> Self {
        let has = |bit: u32| surface.surface_type & bit != 0;
        let additive = has(Surface::ADDITIVE);
        let (src, dst) = if has(Surface::ALPHA) {
            (
                Factor::SrcAlpha,
                if additive {
                    Factor::One
                } else {
                    Factor::InvSrcAlpha
                },
            )
        } else if has(Surface::INVERSE_ALPHA) {
            (
                Factor::InvSrcAlpha,
                if additive { Factor::One } else { Factor::SrcAlpha },
            )
        } else if additive {
            (Factor::One, Factor::One)
        } else {
            (Factor::One, Factor::Zero)
        };
        let mut blend = Blend { src, dst };
        let mut alpha_test = None;
        let clip_map = has(Surface::CLIP_MAP);
        if clip_map {
            alpha_test = Some(if paletted { 100 } else { 200 });
            if blend == Blend::OPAQUE {
                blend.dst = Factor::InvSrcAlpha;
            }
        }
        let translucent = has(Surface::TRANSLUCENT);
        if translucent && (clip_map || blend == Blend::OPAQUE || blend == Blend::ALPHA) {
            blend = Blend::ALPHA;
            alpha_test = None;
        }
        let list = if has(Surface::ALPHA) || has(Surface::INVERSE_ALPHA) || additive {
            DrawList::Blended
        } else if clip_map {
            DrawList::CutOut
        } else if translucent {
            DrawList::Blended
        } else {
            DrawList::Now
        };
        let unit = |v: f32| {
            if v > 1.0 {
                1.0
            } else if v > 0.0 {
                v
            } else {
                0.0
            }
        };
        Material {
            texture,
            blend,
            alpha_test,
            opacity: if translucent {
                1.0 - unit(surface.translucency)
            } else {
                1.0
            },
            diffuse: unit(surface.diffuse),
            luminosity: unit(surface.luminosity),
            fogged: !additive,
            has_image: matches!(surface.paint, Paint::Image { .. }),
            list,
        }
    }

    /// The visible stand-in for a surface that is missing or damaged: bright, opaque, counted by whoever uses it.
    pub fn placeholder() -> Self {
        Material {
            texture: Arc::new(Texture::placeholder()),
            blend: Blend::OPAQUE,
            alpha_test: None,
            opacity: 1.0,
            diffuse: 1.0,
            luminosity: 0.5,
            fogged: true,
            has_image: true,
            list: DrawList::Now,
        }
    }

    /// An opaque colour, for things that do not come from records.
    pub fn solid(color: [u8; 3]) -> Self {
        let [r, g, b] = color;
        Material {
            texture: Arc::new(Texture::solid([r, g, b, 255])),
            luminosity: 0.0,
            has_image: false,
            ..Material::placeholder()
        }
    }

    /// Whether it writes depth: opaque draws and those with an alpha test do.
    pub fn writes_depth(&self) -> bool {
        self.list == DrawList::Now || self.alpha_test.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vestibule_dat::primitive::Argb;

    fn material(bits: u32, translucency: f32) -> Material {
        let surface = Surface {
            surface_type: bits,
            paint: Paint::Color(Argb(0)),
            translucency,
            luminosity: 0.0,
            diffuse: 1.0,
        };
        Material::new(&surface, Arc::new(Texture::placeholder()), false)
    }

    #[test]
    fn r14_2_blend_table() {
        use Factor::{InvSrcAlpha, One, SrcAlpha, Zero};
        let blend = |bits| {
            let b = material(bits, 0.0).blend;
            (b.src, b.dst)
        };
        assert_eq!(blend(Surface::IMAGE), (One, Zero));
        assert_eq!(blend(Surface::ALPHA), (SrcAlpha, InvSrcAlpha));
        assert_eq!(blend(Surface::ALPHA | Surface::ADDITIVE), (SrcAlpha, One));
        assert_eq!(blend(Surface::INVERSE_ALPHA), (InvSrcAlpha, SrcAlpha));
        assert_eq!(
            blend(Surface::INVERSE_ALPHA | Surface::ADDITIVE),
            (InvSrcAlpha, One)
        );
        assert_eq!(blend(Surface::ADDITIVE), (One, One));
        assert_eq!(blend(Surface::CLIP_MAP), (One, InvSrcAlpha));
        assert_eq!(
            blend(Surface::CLIP_MAP | Surface::TRANSLUCENT),
            (SrcAlpha, InvSrcAlpha)
        );
        assert_eq!(blend(Surface::TRANSLUCENT | Surface::ADDITIVE), (One, One));
    }

    #[test]
    fn r14_2_lists_and_alpha() {
        assert_eq!(material(Surface::IMAGE, 0.5).list, DrawList::Now);
        assert_eq!(material(Surface::IMAGE, 0.5).opacity, 1.0);
        let glass = material(Surface::TRANSLUCENT, 0.25);
        assert_eq!((glass.list, glass.opacity), (DrawList::Blended, 0.75));
        assert!(!glass.writes_depth());
        let leaves = material(Surface::CLIP_MAP, 0.0);
        assert_eq!((leaves.list, leaves.alpha_test), (DrawList::CutOut, Some(200)));
        assert!(leaves.writes_depth());
        assert!(!material(Surface::ADDITIVE, 0.0).fogged);
    }
}
