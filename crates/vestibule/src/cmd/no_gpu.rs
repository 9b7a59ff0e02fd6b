//! A program that was built without the renderer for graphics cards.

use vestibule::render::Image;
use vestibule::studio::{Shot, Studio};
use vestibule::view::Camera;
use vestibule::world::World;

use super::gpu_cost::Costs;

/// There is none.
pub(crate) enum Graphics {}

impl Graphics {
    /// Why there is none.
    pub(crate) fn open() -> Result<Self, String> {
        Err("this program was built without it: cargo build --release --features explore".to_owned())
    }

    pub(crate) fn name(&self) -> String {
        match *self {}
    }

    pub(crate) fn picture(&self, _: &Studio<'_>, _: &Shot) -> Result<Image, String> {
        match *self {}
    }

    pub(crate) fn costs(
        &self,
        _: &World,
        _: (u32, u32),
        _: Option<Vec<(String, Camera)>>,
        _: &mut dyn FnMut(),
    ) -> anyhow::Result<Costs> {
        match *self {}
    }
}
