//! The `terrain` block.

use super::read::Reader;
use super::{Area, TerrainOp};
use crate::text::{Args, Skip, Statement};

const KEYWORDS: &[&str] = &[
    "base", "noise", "hill", "ridge", "bowl", "level", "set", "paint", "road",
];

impl Reader<'_> {
    pub(super) fn terrain(&mut self, s: &Statement) -> Result<(), Skip> {
        Args::new(s, "terrain { … }").end(self.messages)?;
        for s in s.block.iter().flatten() {
            if let Ok(op) = self.terrain_statement(s) {
                self.scene.terrain.push(op);
            }
        }
        Ok(())
    }

    fn terrain_statement(&mut self, s: &Statement) -> Result<TerrainOp, Skip> {
        let usage = match s.keyword.text.as_str() {
            "base" => "base HEIGHT",
            "noise" => "noise HEIGHT WAVELENGTH [SEED]",
            "hill" => "hill (x y) RADIUS HEIGHT",
            "ridge" => "ridge (x y) (x y) HALF_WIDTH HEIGHT",
            "bowl" => "bowl (x y) INNER_RADIUS OUTER_RADIUS HEIGHT",
            "level" => "level (x y) (x y) HEIGHT",
            "set" => "set (x y) HEIGHT",
            "paint" => {
                "paint TYPE everywhere | box (x y) (x y) | circle (x y) RADIUS | above Z | below Z | steeper SLOPE \
                 | patches SHARE [SEED]"
            }
            "road" => "road (x y) (x y) …",
            _ => return Err(self.unknown(&s.keyword, KEYWORDS, "terrain")),
        };
        let mut args = Args::new(s, usage);
        let a = &mut args;
        let op = match s.keyword.text.as_str() {
            "base" => TerrainOp::Base(a.number("a height", self.messages)?),
            "noise" => {
                let height = a.number("a height", self.messages)?;
                let length = a.number("a wavelength", self.messages)?;
                if length < 24.0 {
                    let help = "terrain has a vertex every 24 m; use 24 or more";
                    self.messages
                        .error(s.keyword.span, format!("a wavelength of {length} m"), help);
                    return Err(Skip);
                }
                TerrainOp::Noise(height, length, a.any_number().unwrap_or(1.0) as u32)
            }
            "hill" => {
                let center = a.point2(self.messages)?;
                let radius = a.number("a radius", self.messages)?;
                TerrainOp::Hill(center, radius.max(1.0), a.number("a height", self.messages)?)
            }
            "ridge" => {
                let (from, to) = (a.point2(self.messages)?, a.point2(self.messages)?);
                let width = a.number("half the width", self.messages)?;
                TerrainOp::Ridge(from, to, width.max(1.0), a.number("a height", self.messages)?)
            }
            "bowl" => {
                let center = a.point2(self.messages)?;
                let inner = a.number("the inner radius", self.messages)?;
                let outer = a.number("the outer radius", self.messages)?;
                TerrainOp::Bowl(
                    center,
                    inner,
                    outer.max(inner + 1.0),
                    a.number("a height", self.messages)?,
                )
            }
            "level" => {
                let (p, q) = (a.point2(self.messages)?, a.point2(self.messages)?);
                TerrainOp::Level(p.min(q), p.max(q), a.number("a height", self.messages)?)
            }
            "set" => TerrainOp::Set(a.point2(self.messages)?, a.number("a height", self.messages)?),
            "paint" => {
                let kind = self.terrain_type(a)?;
                TerrainOp::Paint(kind, self.area(a)?)
            }
            _ => TerrainOp::Road(a.points2(2, self.messages)?, s.keyword.span),
        };
        args.end(self.messages)?;
        Ok(op)
    }

    fn area(&mut self, args: &mut Args<'_>) -> Result<Area, Skip> {
        let word = args.word("where", self.messages)?;
        Ok(match word.text.as_str() {
            "everywhere" => Area::Everywhere,
            "box" => {
                let (p, q) = (args.point2(self.messages)?, args.point2(self.messages)?);
                Area::Box(p.min(q), p.max(q))
            }
            "circle" => {
                let center = args.point2(self.messages)?;
                Area::Circle(center, args.number("a radius", self.messages)?)
            }
            "above" => Area::Above(args.number("a height", self.messages)?),
            "below" => Area::Below(args.number("a height", self.messages)?),
            "steeper" => Area::Steeper(args.number("a slope", self.messages)?),
            "patches" => {
                let share = args.number("a share from 0 to 1", self.messages)?;
                Area::Patches(share, args.any_number().unwrap_or(1.0) as u32)
            }
            _ => {
                let known = [
                    "everywhere",
                    "box",
                    "circle",
                    "above",
                    "below",
                    "steeper",
                    "patches",
                ];
                return Err(self.unknown(&word, &known, "paint"));
            }
        })
    }
}
