// The picture onto the window, whose size may be another.

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var picture_sampler: sampler;

override LINEAR: bool = false;

struct Seen {
    @builtin(position) at: vec4<f32>,
    @location(0) uv: vec2<f32>,
};

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Seen {
    let x = f32(i32(index & 1u) * 4 - 1);
    let y = f32(i32(index >> 1u) * 4 - 1);
    var out: Seen;
    out.at = vec4<f32>(x, y, 0.0, 1.0);
    out.uv = vec2<f32>(x + 1.0, 1.0 - y) * 0.5;
    return out;
}

@fragment
fn color(seen: Seen) -> @location(0) vec4<f32> {
    var c = textureSample(picture, picture_sampler, seen.uv).rgb;
    if (LINEAR) {
        // The window encodes what it is given: undo that beforehand.
        let low = c / 12.92;
        let high = pow((c + 0.055) / 1.055, vec3<f32>(2.4));
        c = select(high, low, c <= vec3<f32>(0.04045));
    }
    return vec4<f32>(c, 1.0);
}
