// Shared by all shaders. Everything is in camera axes: x right, y forward, z up, metres, the eye at the origin.

struct Frame {
    // Slopes of the half angles across and up, near plane distance.
    lens: vec4<f32>,
    // Towards the sun, camera axes, unit.
    sun: vec4<f32>,
    // The same in landscape axes.
    sun_land: vec4<f32>,
    sun_color: vec4<f32>,
    terrain_light: vec4<f32>,
    outdoor_light: vec4<f32>,
    indoor_light: vec4<f32>,
    // Colour; w: 1 when there is fog.
    fog: vec4<f32>,
    // Start, end.
    fog_range: vec4<f32>,
    right: vec4<f32>,
    forward: vec4<f32>,
    up: vec4<f32>,
    horizon: vec4<f32>,
    zenith: vec4<f32>,
    // Its length is the brightness, landscape axes.
    sky_sun: vec4<f32>,
    // x: soft light indoors. y: the nearest mip level, as the reference picks it. z: keep behind the exits.
    // w: there is a viewer's lamp.
    flags: vec4<u32>,
    // Position and falloff; colour and intensity.
    viewer: array<vec4<f32>, 2>,
};

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var limit_depth: texture_2d<f32>;
// Lamps (position and falloff; colour and intensity) and planes (normal, and how far outside still counts).
@group(0) @binding(2) var<uniform> lists: array<vec4<f32>, 1024>;
// Where the corner of each landblock lies.
@group(0) @binding(3) var<uniform> lands: array<vec4<f32>, 1024>;

fn project(place: vec3<f32>) -> vec4<f32> {
    return vec4<f32>(place.x / frame.lens.x, place.z / frame.lens.y, frame.lens.z, place.y);
}

fn fogged(c: vec3<f32>, place: vec3<f32>) -> vec3<f32> {
    if (frame.fog.w == 0.0) {
        return c;
    }
    let span = max(frame.fog_range.y - frame.fog_range.x, 0.001);
    let clear = clamp((frame.fog_range.y - length(place)) / span, 0.0, 1.0);
    return frame.fog.rgb + (c - frame.fog.rgb) * clear;
}

// Whether something lies before an exit that the landscape is seen through.
fn before_exit(at: vec4<f32>) -> bool {
    if (frame.flags.z == 0u) {
        return false;
    }
    let limit = textureLoad(limit_depth, vec2<i32>(at.xy), 0).x;
    return limit > 0.0 && at.z > limit * 1.0001;
}

// The share of a texture's larger side that one pixel covers, as the reference measures it. `inverse` is 1 / distance.
fn slope(uv: vec2<f32>, inverse: f32) -> f32 {
    let q = uv * inverse;
    let du = (dpdx(q) - uv * dpdx(inverse)) / inverse;
    let dv = (dpdy(q) - uv * dpdy(inverse)) / inverse;
    let a = dot(du, du);
    let b = dot(dv, dv);
    return max(sqrt(sqrt(a * b)), sqrt(max(a, b)) * 0.35);
}

fn level(texels: f32) -> f32 {
    let lod = log2(max(texels, 1.0));
    return select(0.0, floor(lod + 0.5), lod > 0.5);
}
