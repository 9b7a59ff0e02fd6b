//! Setups, surfaces, textures, scenery.

use super::Lints;
use crate::record::{GfxObjDegradeInfo, Location, RenderSurface, Scene, Setup, Surface, SurfaceTexture};

impl Lints {
    pub(super) fn setup(&mut self, setup: &Setup) {
        let parts = setup.parts.len();
        for (i, &parent) in setup.parent_indices.iter().flatten().enumerate() {
            if parent != u32::MAX && parent as usize >= parts {
                let field = format_args!("parent_indices[{i}]");
                self.add(
                    "10.3",
                    field,
                    format_args!("is {parent}, there are {parts} parts"),
                );
            }
        }
        for (i, &scale) in setup.default_scales.iter().flatten().enumerate() {
            self.vec3(format_args!("default_scales[{i}]"), scale);
        }
        self.locations("holding_locations", &setup.holding_locations, parts);
        self.locations("connection_points", &setup.connection_points, parts);
        for (i, pose) in setup.placement_frames.iter().enumerate() {
            for (k, frame) in pose.frames.iter().enumerate() {
                self.frame(format_args!("placement_frames[{i}].frames[{k}]"), frame);
            }
        }
        for (i, cylinder) in setup.cyl_spheres.iter().enumerate() {
            self.vec3(format_args!("cyl_spheres[{i}].low_point"), cylinder.low_point);
            self.float(format_args!("cyl_spheres[{i}].radius"), cylinder.radius);
            self.float(format_args!("cyl_spheres[{i}].height"), cylinder.height);
        }
        for (i, sphere) in setup.spheres.iter().enumerate() {
            self.sphere(format_args!("spheres[{i}]"), sphere);
        }
        self.floats(&[
            ("height", setup.height),
            ("radius", setup.radius),
            ("step_up_height", setup.step_up_height),
            ("step_down_height", setup.step_down_height),
        ]);
        self.sphere(format_args!("sorting_sphere"), &setup.sorting_sphere);
        self.sphere(format_args!("selection_sphere"), &setup.selection_sphere);
        for (i, light) in setup.lights.iter().enumerate() {
            self.frame(format_args!("lights[{i}].frame"), &light.frame);
            self.float(format_args!("lights[{i}].intensity"), light.intensity);
            self.float(format_args!("lights[{i}].falloff"), light.falloff);
            self.float(format_args!("lights[{i}].cone_angle"), light.cone_angle);
        }
    }

    fn locations(&mut self, at: &str, locations: &[Location], parts: usize) {
        for (i, location) in locations.iter().enumerate() {
            self.frame(format_args!("{at}[{i}].frame"), &location.frame);
            if usize::try_from(location.part).is_ok_and(|part| part >= parts) {
                let part = location.part;
                self.add(
                    "10.3",
                    format_args!("{at}[{i}].part"),
                    format_args!("is {part}, there are {parts} parts"),
                );
            }
        }
    }

    pub(super) fn surface(&mut self, surface: &Surface) {
        self.floats(&[
            ("translucency", surface.translucency),
            ("luminosity", surface.luminosity),
            ("diffuse", surface.diffuse),
        ]);
    }

    pub(super) fn surface_texture(&mut self, texture: &SurfaceTexture) {
        if texture.textures.is_empty() {
            self.add("X11", format_args!("textures"), format_args!("are none"));
        }
    }

    pub(super) fn render_surface(&mut self, texture: &RenderSurface) {
        let sides = 1..=RenderSurface::MAX_SIDE;
        for (field, side) in [("width", texture.width), ("height", texture.height)] {
            if !sides.contains(&side) {
                let limit = format_args!("is {side}, not 1 to {}", RenderSurface::MAX_SIDE);
                self.add("X15", format_args!("{field}"), limit);
            }
        }
        let Some(format) = texture.pixel_format() else {
            let unsupported = format_args!("{:#x} is not supported", texture.format);
            return self.add("X12", format_args!("format"), unsupported);
        };
        let (width, height) = (texture.width.unsigned_abs(), texture.height.unsigned_abs());
        if let Some(wanted) = format.byte_length(width, height)
            && wanted != texture.pixels.len()
        {
            let found = texture.pixels.len();
            let fate = if found < wanted {
                "the texture is unusable"
            } else {
                "the surplus is ignored"
            };
            self.add(
                "X15",
                format_args!("pixels"),
                format_args!("{found} bytes, {wanted} wanted; {fate}"),
            );
        }
    }

    pub(super) fn scene(&mut self, scene: &Scene) {
        for (i, object) in scene.objects.iter().enumerate() {
            self.frame(format_args!("objects[{i}].base_loc"), &object.base_loc);
            for (name, value) in [
                ("frequency", object.frequency),
                ("displace_x", object.displace_x),
                ("displace_y", object.displace_y),
                ("min_scale", object.min_scale),
                ("max_scale", object.max_scale),
                ("max_rotation", object.max_rotation),
                ("min_slope", object.min_slope),
                ("max_slope", object.max_slope),
            ] {
                self.float(format_args!("objects[{i}].{name}"), value);
            }
        }
    }

    pub(super) fn degrade_info(&mut self, info: &GfxObjDegradeInfo) {
        for (i, degrade) in info.degrades.iter().enumerate() {
            self.float(format_args!("degrades[{i}].min_dist"), degrade.min_dist);
            self.float(format_args!("degrades[{i}].ideal_dist"), degrade.ideal_dist);
            self.float(format_args!("degrades[{i}].max_dist"), degrade.max_dist);
        }
    }
}
