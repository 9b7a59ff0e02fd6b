//! Writing SVG: panels of metres, one under the other.

use std::fmt::Write;

use glam::Vec2;

/// Width of the picture, pixels.
const WIDTH: f32 = 1000.0;
/// Space around panels, pixels.
const MARGIN: f32 = 24.0;
/// Height of a panel's heading, pixels.
const HEADING: f32 = 30.0;

const STYLE: &str = "\
text{font-family:Helvetica,Arial,sans-serif;fill:#222}\
.h{font-size:15px;font-weight:bold}.t{font-size:20px;font-weight:bold}.s{font-size:11px;fill:#555}\
.id{font-weight:bold;text-anchor:middle;fill:#1b3a57;paint-order:stroke;stroke:#fff;stroke-width:3px}\
.lid{font-size:9px;fill:#00000055;text-anchor:middle}\
.fl{stroke:#9aa7b1;stroke-width:.5}.wa{fill:none;stroke:#3b3f46;stroke-width:2;stroke-linecap:round}\
.po{fill:none;stroke:#12924f;stroke-width:4;stroke-linecap:round}\
.ex{fill:none;stroke:#e07b00;stroke-width:5;stroke-linecap:round}\
.hole{fill:#12924f22;stroke:#12924f;stroke-width:1.5;stroke-dasharray:5 3}\
.skylight{fill:#e07b0022;stroke:#e07b00;stroke-width:1.5;stroke-dasharray:5 3}\
.st{fill:#b08a5bcc;stroke:#6b4f2a;stroke-width:1}\
.bu{fill:#8d8d96;stroke:#33333c;stroke-width:1.5}.gr{stroke:#00000022;stroke-width:.5}\
.co{stroke:#00000038;stroke-width:.7;fill:none}.ci{stroke:#00000066;stroke-width:1;fill:none}\
.ro{stroke:#8b6b43;stroke-width:7;stroke-linecap:round;stroke-opacity:.6;fill:none}\
.tr{fill:none;stroke:#d0021b;stroke-width:1.6;stroke-linejoin:round;stroke-opacity:.75}\
.fr{fill:none;stroke:#777}";

/// A picture that grows downwards.
pub(super) struct Svg {
    body: String,
    height: f32,
}

impl Svg {
    pub(super) fn new() -> Self {
        Svg {
            body: String::new(),
            height: MARGIN,
        }
    }

    pub(super) fn title(&mut self, text: &str) {
        let y = self.height + 16.0;
        let _ = writeln!(self.body, r#"<text class="t" x="{MARGIN}" y="{y}">{text}</text>"#);
        self.legend(y);
        self.height += 52.0;
    }

    fn legend(&mut self, y: f32) {
        let y = y + 24.0;
        let mut x = MARGIN;
        for (class, text) in [
            ("ex", "way outside"),
            ("po", "opening between cells"),
            ("hole", "opening in a floor or ceiling"),
            ("wa", "wall"),
            ("st", "static object"),
            ("tr", "trail"),
        ] {
            let _ = match class {
                "hole" | "st" => {
                    writeln!(
                        self.body,
                        r#"<rect class="{class}" x="{x}" y="{}" width="18" height="9"/>"#,
                        y - 9.0
                    )
                }
                _ => writeln!(self.body, r#"<path class="{class}" d="M{x} {0}h18"/>"#, y - 4.0),
            };
            let _ = writeln!(
                self.body,
                r#"<text class="s" x="{}" y="{y}">{text}</text>"#,
                x + 24.0
            );
            x += 40.0 + 6.2 * text.len() as f32;
        }
    }

    /// Adds a panel for the rectangle from `low` to `high`, metres, at most `most` pixels a metre.
    pub(super) fn panel(&mut self, heading: &str, low: Vec2, high: Vec2, most: f32) -> Panel<'_> {
        let size = (high - low).max(Vec2::splat(1.0));
        let room = WIDTH - 2.0 * MARGIN;
        let scale = (room / size.x).min(1400.0 / size.y).min(most);
        let top = self.height + HEADING;
        let _ = writeln!(
            self.body,
            r#"<text class="h" x="{MARGIN}" y="{}">{heading}</text>"#,
            top - 9.0
        );
        self.height = top + size.y * scale + MARGIN;
        Panel {
            out: &mut self.body,
            low,
            scale,
            left: MARGIN,
            bottom: top + size.y * scale,
            size,
        }
    }

    pub(super) fn finish(self) -> String {
        let height = self.height;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height:.0}\" \
             viewBox=\"0 0 {WIDTH} {height:.0}\">\n<style>{STYLE}</style>\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#fdfcf9\"/>\n{}</svg>\n",
            self.body
        )
    }
}

/// A part of the picture in which lengths are metres and north is up.
pub(super) struct Panel<'a> {
    out: &'a mut String,
    low: Vec2,
    scale: f32,
    left: f32,
    bottom: f32,
    size: Vec2,
}

impl Panel<'_> {
    /// Pixels a metre.
    pub(super) fn scale(&self) -> f32 {
        self.scale
    }

    fn at(&self, p: Vec2) -> (f32, f32) {
        (
            self.left + (p.x - self.low.x) * self.scale,
            self.bottom - (p.y - self.low.y) * self.scale,
        )
    }

    fn path(&self, points: &[Vec2]) -> String {
        let mut d = String::with_capacity(points.len() * 14);
        for (i, &p) in points.iter().enumerate() {
            let (x, y) = self.at(p);
            let _ = write!(d, "{}{x:.1} {y:.1}", if i == 0 { 'M' } else { 'L' });
        }
        d
    }

    fn titled(title: &str) -> String {
        if title.is_empty() {
            "/>".to_owned()
        } else {
            format!("><title>{title}</title></path>")
        }
    }

    pub(super) fn line(&mut self, points: &[Vec2], class: &str, title: &str) {
        if points.len() > 1 {
            let d = self.path(points);
            let _ = writeln!(
                self.out,
                r#"<path class="{class}" d="{d}"{}"#,
                Self::titled(title)
            );
        }
    }

    pub(super) fn polygon(&mut self, points: &[Vec2], class: &str, title: &str) {
        if points.len() > 2 {
            let d = self.path(points);
            let _ = writeln!(
                self.out,
                r#"<path class="{class}" d="{d}Z"{}"#,
                Self::titled(title)
            );
        }
    }

    /// A polygon of one colour, without an edge of its own where `class` gives none.
    pub(super) fn filled(&mut self, points: &[Vec2], class: &str, fill: &str, title: &str) {
        if points.len() > 2 {
            let d = self.path(points);
            let end = Self::titled(title);
            let _ = writeln!(self.out, r#"<path class="{class}" fill="{fill}" d="{d}Z"{end}"#);
        }
    }

    pub(super) fn circle(&mut self, center: Vec2, radius: f32, class: &str, title: &str) {
        let (x, y) = self.at(center);
        let r = (radius * self.scale).max(1.5);
        let _ = writeln!(
            self.out,
            r#"<circle class="{class}" cx="{x:.1}" cy="{y:.1}" r="{r:.1}"><title>{title}</title></circle>"#
        );
    }

    pub(super) fn text(&mut self, at: Vec2, class: &str, size: f32, text: &str) {
        let (x, y) = self.at(at);
        let y = y + size * 0.35;
        let _ = writeln!(
            self.out,
            r#"<text class="{class}" font-size="{size:.0}" x="{x:.1}" y="{y:.1}">{text}</text>"#
        );
    }

    /// Frame, scale bar and north arrow.
    pub(super) fn furniture(&mut self) {
        let (w, h) = (self.size.x * self.scale, self.size.y * self.scale);
        let (left, top, bottom) = (self.left, self.bottom - h, self.bottom);
        let _ = writeln!(
            self.out,
            r#"<rect class="fr" x="{left:.1}" y="{top:.1}" width="{w:.1}" height="{h:.1}"/>"#
        );
        let metres = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];
        let length = metres
            .into_iter()
            .find(|m| m * self.scale > 50.0)
            .unwrap_or(100.0);
        let end = length * self.scale;
        let (x, y) = (left + w - end - 10.0, bottom - 8.0);
        let _ = writeln!(
            self.out,
            r##"<path d="M{x:.1} {0:.1}v6h{end:.1}v-6" fill="none" stroke="#222" stroke-width="1.5"/>"##,
            y - 6.0
        );
        let _ = writeln!(
            self.out,
            r#"<text class="s" x="{:.1}" y="{:.1}">{length} m</text>"#,
            x - 34.0,
            y
        );
        let (nx, ny) = (left + w - 14.0, top + 28.0);
        let _ = writeln!(
            self.out,
            r##"<path d="M{nx:.1} {ny:.1}v-16m-4 6l4 -7l4 7" fill="none" stroke="#222" stroke-width="1.5"/><text class="s" x="{:.1}" y="{:.1}">N</text>"##,
            nx - 14.0,
            ny - 2.0
        );
    }
}

/// The smallest convex polygon around points, counter-clockwise.
pub(super) fn convex_hull(mut points: Vec<Vec2>) -> Vec<Vec2> {
    points.retain(|p| p.is_finite());
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let half = |points: &mut dyn Iterator<Item = Vec2>| {
        let mut out: Vec<Vec2> = Vec::new();
        for p in points {
            while let [.., a, b] = out.as_slice() {
                if (*b - *a).perp_dot(p - *a) > 0.0 {
                    break;
                }
                out.pop();
            }
            out.push(p);
        }
        out.pop();
        out
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_of_a_square_with_points_inside_is_the_square() {
        let points = [
            (0.0, 0.0),
            (2.0, 0.0),
            (1.0, 1.0),
            (2.0, 2.0),
            (0.0, 2.0),
            (1.0, 0.0),
        ];
        let hull = convex_hull(points.iter().map(|&(x, y)| Vec2::new(x, y)).collect());
        assert_eq!(hull.len(), 4);
    }
}
