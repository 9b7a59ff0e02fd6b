// The sky behind everything: a gradient, a haze and the sun's disc (`rendering.md` 16.6).

struct Seen {
    @builtin(position) at: vec4<f32>,
    @location(0) screen: vec2<f32>,
};

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Seen {
    let x = f32(i32(index & 1u) * 4 - 1);
    let y = f32(i32(index >> 1u) * 4 - 1);
    var out: Seen;
    out.at = vec4<f32>(x, y, 0.0, 1.0);
    out.screen = vec2<f32>(x, y);
    return out;
}

@fragment
fn color(seen: Seen) -> @location(0) vec4<f32> {
    let ray = normalize(vec3<f32>(seen.screen.x * frame.lens.x, 1.0, seen.screen.y * frame.lens.y));
    let direction = frame.right.xyz * ray.x + frame.forward.xyz * ray.y + frame.up.xyz * ray.z;
    let t = sqrt(clamp(direction.z, 0.0, 1.0));
    var c = frame.horizon.rgb + (frame.zenith.rgb - frame.horizon.rgb) * t;
    let bright = length(frame.sky_sun.xyz);
    if (bright > 0.01) {
        let cos = dot(frame.sky_sun.xyz, direction) / bright;
        if (cos > 0.9) {
            let near = (cos - 0.9) / 0.1;
            let glow = near * near * near;
            let strength = min(bright, 1.0);
            // The colour comes with the brightness in it.
            c += frame.sun_color.rgb / bright * (0.35 * glow * glow * strength);
            if (cos > 0.999) {
                let edge = clamp((cos - 0.999) / 0.0004, 0.0, 1.0);
                c += (vec3<f32>(1.0) - c) * (edge * strength);
            }
        }
    }
    // The reference cuts to whole steps where targets round.
    return vec4<f32>(c - vec3<f32>(0.5 / 255.0), 1.0);
}

@fragment
fn ids(seen: Seen) -> @location(0) vec2<u32> {
    return vec2<u32>(0xFFFFFFFFu, 0xFFFFFFFFu);
}
