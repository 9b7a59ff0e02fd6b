//! The statements at the top of a scene, and materials and models.

use std::collections::BTreeMap;

use glam::{DQuat, DVec2};
use vestibule_world::BlockId;

use super::placement::rotation;
use super::read_site::RoomBody;
use super::{
    Collide, LightDef, Material, ModelDef, Paint, PlaceDef, Scatter, Scene, SiteDef, SolidDef, Start,
    StaticDef, pattern_named, terrain_named,
};
use crate::text::{Above, Args, Messages, Skip, Statement, Word, closest};

const TOP_KEYWORDS: &[&str] = &[
    "scene", "land", "heights", "terrain", "material", "model", "shape", "building", "dungeon", "static",
    "scatter", "start",
];

/// Reads the statements of a scene. Names may be used before they are defined.
pub(crate) fn read(statements: &[Statement], messages: &mut Messages) -> Scene {
    let block = BlockId::new(0x80, 0x80);
    let mut reader = Reader {
        messages,
        materials: Vec::new(),
        models: Vec::new(),
        shapes: BTreeMap::new(),
        scene: Scene {
            name: "scene".to_owned(),
            south_west: block,
            north_east: block,
            origin: block,
            height_step: 0.5,
            terrain: Vec::new(),
            materials: Vec::new(),
            models: Vec::new(),
            sites: Vec::new(),
            statics: Vec::new(),
            scatters: Vec::new(),
            start: None,
        },
    };
    let of = |keyword: &'static str| statements.iter().filter(move |s| s.keyword.text == keyword);
    for s in of("material") {
        let material = reader.material(s);
        reader.materials.extend(material);
    }
    if reader.materials.is_empty() {
        reader.materials.push(Material::default_material());
    }
    for s in of("model") {
        let model = reader.model(s);
        reader.models.extend(model);
    }
    for s in of("shape") {
        // Errors have been reported; the scene goes on without it.
        let _ = reader.shape(s);
    }
    for s in statements {
        let _ = reader.top(s);
    }
    let Reader {
        materials,
        models,
        mut scene,
        ..
    } = reader;
    scene.materials = materials;
    scene.models = models;
    scene
}

/// Reads statements, with what is known so far.
pub(super) struct Reader<'a> {
    pub(super) messages: &'a mut Messages,
    pub(super) materials: Vec<Material>,
    pub(super) models: Vec<ModelDef>,
    pub(super) shapes: BTreeMap<String, RoomBody>,
    pub(super) scene: Scene,
}

impl Reader<'_> {
    /// Reports a keyword that is none of `known`.
    pub(super) fn unknown(&mut self, keyword: &Word, known: &[&str], place: &str) -> Skip {
        let help = match closest(&keyword.text, known.iter().copied()) {
            Some(best) => format!("did you mean `{best}`?"),
            None => format!("known here: {}", known.join(", ")),
        };
        let message = format!("unknown statement `{}` in {place}", keyword.text);
        self.messages.error(keyword.span, message, help);
        Skip
    }

    fn unknown_name<'n>(
        &mut self,
        word: &Word,
        what: &str,
        known: impl Iterator<Item = &'n str> + Clone,
    ) -> Skip {
        let help = match closest(&word.text, known.clone()) {
            Some(best) => format!("did you mean `{best}`?"),
            None => match known.collect::<Vec<_>>() {
                names if names.is_empty() => format!("define it: {what} {} …", word.text),
                names => format!("known: {}", names.join(", ")),
            },
        };
        self.messages
            .error(word.span, format!("there is no {what} `{}`", word.text), help);
        Skip
    }

    fn top(&mut self, s: &Statement) -> Result<(), Skip> {
        match s.keyword.text.as_str() {
            "scene" => {
                let mut args = Args::new(s, "scene \"Name\"");
                self.scene.name = args.text("a name", self.messages)?;
                args.end(self.messages)
            }
            "land" => self.land(s),
            "heights" => {
                let mut args = Args::new(s, "heights METRES_PER_STEP");
                let step = args.number("metres per height step", self.messages)?;
                if !(0.01..=3.0).contains(&step) {
                    let help = "use 0.01 to 3 metres: 256 steps must cover the land";
                    self.messages
                        .error(args.keyword_span(), format!("a height step of {step} m"), help);
                    return Err(Skip);
                }
                self.scene.height_step = step;
                args.end(self.messages)
            }
            "terrain" => self.terrain(s),
            "material" | "model" | "shape" => Ok(()),
            "building" | "dungeon" => {
                let site: SiteDef = self.site(s)?;
                if let Some(other) = self.scene.sites.iter().find(|o| o.name.text == site.name.text) {
                    let message = format!("a second site named `{}`", site.name.text);
                    let help = format!(
                        "the first is in line {}; give this one another name",
                        other.name.span.line
                    );
                    self.messages.error(site.name.span, message, help);
                }
                self.scene.sites.push(site);
                Ok(())
            }
            "static" => {
                let object = self.static_object(s, false)?;
                self.scene.statics.push(object);
                Ok(())
            }
            "scatter" => self.scatter(s),
            "start" => self.start(s),
            _ => Err(self.unknown(&s.keyword, TOP_KEYWORDS, "the scene")),
        }
    }

    fn land(&mut self, s: &Statement) -> Result<(), Skip> {
        let mut args = Args::new(s, "land 0xSWSW 0xNENE [origin 0xXXYY]");
        let south_west = BlockId(args.hex("the landblock in the south-west, as 0xA8B3,", self.messages)?);
        let north_east = BlockId(args.hex("the landblock in the north-east, as 0xAAB5,", self.messages)?);
        let origin = match args.accept("origin") {
            true => BlockId(args.hex("a landblock", self.messages)?),
            false => south_west,
        };
        let ordered = south_west.x() <= north_east.x() && south_west.y() <= north_east.y();
        let count = |a: u8, b: u8| usize::from(b.saturating_sub(a)) + 1;
        let blocks = count(south_west.x(), north_east.x()) * count(south_west.y(), north_east.y());
        if !ordered || !north_east.is_on_map() || blocks > 1024 {
            let message = format!("land from {south_west} to {north_east}");
            let help = "the first is the south-west corner; use at most 1024 landblocks, 0x0000 to 0xFEFE";
            self.messages.error(args.keyword_span(), message, help);
            return Err(Skip);
        }
        (self.scene.south_west, self.scene.north_east, self.scene.origin) = (south_west, north_east, origin);
        args.end(self.messages)
    }

    pub(super) fn material_named(&mut self, word: &Word) -> Result<usize, Skip> {
        if let Some(at) = self.materials.iter().position(|m| m.name.text == word.text) {
            return Ok(at);
        }
        let names: Vec<String> = self.materials.iter().map(|m| m.name.text.clone()).collect();
        Err(self.unknown_name(word, "material", names.iter().map(String::as_str)))
    }

    fn color(&mut self, args: &mut Args<'_>) -> Result<[u8; 3], Skip> {
        let mut out = [0; 3];
        for channel in &mut out {
            let span = args.span();
            let value = args.number("red, green and blue from 0 to 255", self.messages)?;
            if !(0.0..=255.0).contains(&value) {
                let message = format!("{value} is not a brightness");
                self.messages
                    .error(span, message, "red, green and blue run from 0 to 255");
                return Err(Skip);
            }
            *channel = value as u8;
        }
        Ok(out)
    }

    fn material(&mut self, s: &Statement) -> Option<Material> {
        let usage = "material NAME PATTERN color R G B [second R G B] [size METRES] [seed N]";
        let mut args = Args::new(s, usage);
        let name = args.word("a name", self.messages).ok()?;
        let kind = args.word("a pattern", self.messages).ok()?;
        let pattern = match pattern_named(&kind.text) {
            Ok(pattern) => pattern,
            Err(known) => {
                self.unknown_name(&kind, "pattern", known.iter().copied());
                return None;
            }
        };
        let mut material = Material {
            name,
            pattern,
            color: [128; 3],
            second: [80; 3],
            size: 2.0,
            seed: 0,
        };
        while let Some(word) = args.any_word() {
            match word.text.as_str() {
                "color" => material.color = self.color(&mut args).ok()?,
                "second" => material.second = self.color(&mut args).ok()?,
                "size" => material.size = args.number("metres", self.messages).ok()?.clamp(0.05, 100.0),
                "seed" => material.seed = args.number("a seed", self.messages).ok()? as u32,
                _ => {
                    self.unknown(&word, &["color", "second", "size", "seed"], "a material");
                    return None;
                }
            }
        }
        args.end(self.messages).ok()?;
        Some(material)
    }

    fn model(&mut self, s: &Statement) -> Option<ModelDef> {
        let mut args = Args::new(s, "model NAME { … }");
        let name = args.word("a name", self.messages).ok()?;
        args.end(self.messages).ok()?;
        let mut model = ModelDef {
            name,
            solids: Vec::new(),
            paint: Paint::plain(0),
            collide: Collide::Polygons,
            lights: Vec::new(),
        };
        let mut complete = true;
        for s in s.block.iter().flatten() {
            complete &= self.model_statement(s, &mut model).is_ok();
        }
        if model.solids.is_empty() && complete {
            let message = format!("model `{}` has no shape", model.name.text);
            self.messages.error(
                model.name.span,
                message,
                "add a box, prism, hull, column, cone or ball to it",
            );
            return None;
        }
        Some(model)
    }

    fn model_statement(&mut self, s: &Statement, model: &mut ModelDef) -> Result<(), Skip> {
        if let Some(solid) = self.solid(s)? {
            model.solids.push(solid);
            return Ok(());
        }
        if self.solid_paint(s, &mut model.paint)? {
            return Ok(());
        }
        match s.keyword.text.as_str() {
            "collide" => {
                let usage =
                    "collide polygons | nothing | cylinder RADIUS HEIGHT | sphere CENTRE_HEIGHT RADIUS";
                let mut args = Args::new(s, usage);
                let kind = args.word("polygons, nothing, cylinder or sphere", self.messages)?;
                model.collide = match kind.text.as_str() {
                    "polygons" => Collide::Polygons,
                    "nothing" => Collide::Nothing,
                    "cylinder" => {
                        let radius = args.number("a radius", self.messages)?;
                        Collide::Cylinder(radius, args.number("a height", self.messages)?)
                    }
                    "sphere" => {
                        let height = args.number("the height of the centre", self.messages)?;
                        Collide::Sphere(height, args.number("a radius", self.messages)?)
                    }
                    _ => {
                        return Err(self.unknown(
                            &kind,
                            &["polygons", "nothing", "cylinder", "sphere"],
                            "collide",
                        ));
                    }
                };
                args.end(self.messages)
            }
            "light" => {
                let mut args = Args::new(s, "light (x y z) R G B INTENSITY FALLOFF");
                let at = args.point3(self.messages)?;
                let color = self.color(&mut args)?;
                let intensity = args.number("an intensity", self.messages)?;
                let falloff = args.number("a falloff in metres", self.messages)?;
                model.lights.push(LightDef {
                    at,
                    color,
                    intensity,
                    falloff,
                });
                args.end(self.messages)
            }
            _ => Err(self.unknown(&s.keyword, MODEL_KEYWORDS, "a model")),
        }
    }

    /// `static MODEL [in ROOM] at (x y z) [turn DEG]`, or `door … open DEG`.
    pub(super) fn static_object(&mut self, s: &Statement, in_site: bool) -> Result<StaticDef, Skip> {
        let usage = match in_site {
            true => "static MODEL in ROOM at (x y z) [turn DEGREES] [open DEGREES]",
            false => "static MODEL at (x y ~z) [turn DEGREES]",
        };
        let mut args = Args::new(s, usage);
        let name = args.word("a model", self.messages)?;
        let Some(model) = self.models.iter().position(|m| m.name.text == name.text) else {
            let names: Vec<String> = self.models.iter().map(|m| m.name.text.clone()).collect();
            return Err(self.unknown_name(&name, "model", names.iter().map(String::as_str)));
        };
        let room = match in_site && args.accept("in") {
            true => Some(args.word("a room", self.messages)?),
            false => None,
        };
        let place = self.place(&mut args)?;
        args.end(self.messages)?;
        Ok(StaticDef {
            span: s.keyword.span,
            model,
            room,
            place,
        })
    }

    /// `at (x y z) [turn DEG] [tilt DEG] [roll DEG] [open DEG]`.
    pub(super) fn place(&mut self, args: &mut Args<'_>) -> Result<PlaceDef, Skip> {
        let span = args.span();
        let (mut at, mut height) = (
            DVec2::ZERO,
            Above {
                metres: 0.0,
                ground: false,
            },
        );
        let (mut turn, mut tilt, mut roll) = (0.0, 0.0, 0.0);
        while let Some(word) = args.any_word() {
            match word.text.as_str() {
                "at" => (at, height) = args.place(self.messages)?,
                "turn" | "open" => turn += args.number("degrees", self.messages)?,
                "tilt" => tilt = args.number("degrees", self.messages)?,
                "roll" => roll = args.number("degrees", self.messages)?,
                _ => return Err(self.unknown(&word, &["at", "turn", "tilt", "roll", "open"], "a place")),
            }
        }
        let rotation = if (turn, tilt, roll) == (0.0, 0.0, 0.0) {
            DQuat::IDENTITY
        } else {
            rotation(turn, tilt, roll)
        };
        Ok(PlaceDef {
            at,
            height,
            rotation,
            span,
        })
    }

    fn scatter(&mut self, s: &Statement) -> Result<(), Skip> {
        let usage = "scatter MODEL COUNT (x y) (x y) [seed N] [clear METRES] [on TERRAIN_TYPE]";
        let mut args = Args::new(s, usage);
        let name = args.word("a model", self.messages)?;
        let Some(model) = self.models.iter().position(|m| m.name.text == name.text) else {
            let names: Vec<String> = self.models.iter().map(|m| m.name.text.clone()).collect();
            return Err(self.unknown_name(&name, "model", names.iter().map(String::as_str)));
        };
        let count = args.number("a count", self.messages)?.clamp(0.0, 10_000.0) as u32;
        let (a, b) = (args.point2(self.messages)?, args.point2(self.messages)?);
        let mut scatter = Scatter {
            model,
            count,
            seed: 1,
            low: a.min(b),
            high: a.max(b),
            clear: 3.0,
            on: None,
        };
        while let Some(word) = args.any_word() {
            match word.text.as_str() {
                "seed" => scatter.seed = args.number("a seed", self.messages)? as u32,
                "clear" => scatter.clear = args.number("metres", self.messages)?,
                "on" => scatter.on = Some(self.terrain_type(&mut args)?),
                _ => return Err(self.unknown(&word, &["seed", "clear", "on"], "scatter")),
            }
        }
        self.scene.scatters.push(scatter);
        args.end(self.messages)
    }

    pub(super) fn terrain_type(&mut self, args: &mut Args<'_>) -> Result<u8, Skip> {
        let word = args.word("a terrain type", self.messages)?;
        terrain_named(&word.text).ok_or_else(|| {
            let known = super::TERRAIN_TYPES.iter().map(|(n, _)| *n).take(32);
            self.unknown_name(&word, "terrain type", known)
        })
    }

    fn start(&mut self, s: &Statement) -> Result<(), Skip> {
        let mut args = Args::new(s, "start [SITE ROOM] at (x y ~z) [turn DEGREES]");
        let room = if args.accept("in") {
            Some((
                args.word("a site", self.messages)?,
                args.word("a room", self.messages)?,
            ))
        } else {
            None
        };
        let place = self.place(&mut args)?;
        self.scene.start = Some(Start {
            span: s.keyword.span,
            room,
            place,
        });
        args.end(self.messages)
    }
}

const MODEL_KEYWORDS: &[&str] = &[
    "box", "prism", "hull", "column", "cone", "ball", "ramp", "wedge", "poly", "material", "sides", "top",
    "bottom", "face", "collide", "light",
];

impl Material {
    /// Used when a scene defines no material.
    fn default_material() -> Self {
        let name = Word {
            text: "plain".to_owned(),
            span: Default::default(),
        };
        let pattern = super::Pattern::Grain;
        Material {
            name,
            pattern,
            color: [150, 145, 135],
            second: [110; 3],
            size: 2.0,
            seed: 0,
        }
    }
}

impl Paint {
    pub(super) fn plain(material: usize) -> Self {
        Paint {
            up: material,
            side: material,
            down: material,
            special: Vec::new(),
        }
    }
}

impl SolidDef {
    pub(super) fn new() -> Self {
        SolidDef {
            parts: Vec::new(),
            polygons: Vec::new(),
            all: None,
            top: None,
        }
    }
}
