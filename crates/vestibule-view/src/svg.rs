//! A picture of a traversal: the clip polygons on the screen, labelled by cell, as SVG.

use core::fmt::{self, Write};

use vestibule_world::CellId;

use crate::camera::Camera;
use crate::flood::{Flood, FloodArena};
use crate::frame::FrameView;
use crate::view::Region;

/// Colours of cells, in the order of the list; then they repeat.
const COLOURS: [&str; 10] = [
    "#4e79a7", "#f28e2b", "#59a14f", "#e15759", "#76b7b2", "#edc948", "#b07aa1", "#ff9da7", "#9c755f",
    "#bab0ac",
];

/// Writes the regions of a traversal as an SVG picture the size of the camera's screen: far cells first, each region
/// outlined and labelled with its cell, the outside in blue.
pub fn flood_svg(flood: &Flood<'_>, camera: &Camera) -> String {
    let mut out = Picture::begin(camera);
    out.flood(flood, "");
    out.finish()
}

/// Writes the regions of a frame: the outside, what is seen in buildings (dashed), and the rooms.
pub fn frame_svg(frame: &FrameView) -> String {
    let Some(camera) = frame.camera() else {
        return String::new();
    };
    let mut out = Picture::begin(camera);
    for region in frame.landscape_views() {
        out.region(region, OUTSIDE_STYLE, "outside");
    }
    let floods: &FloodArena = frame.floods();
    for flood in floods.iter().skip(usize::from(frame.interior().is_some())) {
        out.flood(&flood, " stroke-dasharray=\"6 4\"");
    }
    if let Some(interior) = frame.interior() {
        out.flood(&interior, "");
    }
    out.finish()
}

const OUTSIDE_STYLE: &str = "fill=\"#a0d8f0\" fill-opacity=\"0.6\" stroke=\"#2080b0\"";

struct Picture<'a> {
    text: String,
    camera: &'a Camera,
}

impl<'a> Picture<'a> {
    fn begin(camera: &'a Camera) -> Self {
        let (w, h) = (camera.viewport().x, camera.viewport().y);
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
             font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{w}\" height=\"{h}\" fill=\"#202020\"/>"
        );
        Picture { text, camera }
    }

    fn flood(&mut self, flood: &Flood<'_>, style: &str) {
        for (at, cell) in flood.cells().iter().enumerate().rev() {
            let colour = COLOURS[at % COLOURS.len()];
            let style = format!("fill=\"{colour}\" fill-opacity=\"0.35\" stroke=\"{colour}\"{style}");
            for region in flood.regions(cell) {
                self.region(region, &style, &Label(cell.id, at).to_string());
            }
        }
        for region in flood.outside() {
            self.region(region, OUTSIDE_STYLE, "outside");
        }
    }

    fn region(&mut self, region: Region<'_>, style: &str, label: &str) {
        let mut points = String::new();
        for p in region.pixels(self.camera) {
            let _ = write!(points, "{:.2},{:.2} ", p.x, p.y);
        }
        let area = region.pixel_area(self.camera);
        let _ = writeln!(
            self.text,
            "<polygon points=\"{}\" {style} stroke-width=\"1.5\"><title>{label}: {area:.1} px</title></polygon>",
            points.trim_end()
        );
        if let Some(at) = region.middle().and_then(|m| self.camera.project(m)) {
            let _ = writeln!(
                self.text,
                "<text x=\"{:.1}\" y=\"{:.1}\" fill=\"#ffffff\" text-anchor=\"middle\">{label}</text>",
                at.x, at.y
            );
        }
    }

    fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }
}

/// A cell and its place in the list.
struct Label(CellId, usize);

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {:04X}", self.1, self.0.low())
    }
}
