// Meshes: shells, rooms, objects and things in the sky (`rendering.md` 12, 14).

override CUT: bool = false;
override PIXEL_LIT: bool = false;

@group(1) @binding(0) var<uniform> draw: Draw;
@group(1) @binding(1) var<uniform> lights: Lights;
@group(2) @binding(0) var picture: texture_2d<f32>;
@group(2) @binding(1) var picture_sampler: sampler;

struct Corner {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) polygon: u32,
};

struct Seen {
    @builtin(position) at: vec4<f32>,
    @location(0) place: vec3<f32>,
    // The normal, or the light when it is computed at the corners.
    @location(1) light: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) @interpolate(flat, either) polygon: u32,
};

fn soft_channel(v: f32) -> f32 {
    if (v <= 0.5) {
        return max(v, 0.0);
    }
    let x = (v - 0.5) * 2.0;
    return 1.0 - 0.5 / (1.0 + x + x * x * 0.5);
}

fn finish(c: vec3<f32>) -> vec3<f32> {
    if (frame.flags.x != 0u && draw.how.x != 0u) {
        return vec3<f32>(soft_channel(c.x), soft_channel(c.y), soft_channel(c.z));
    }
    return clamp(c, vec3<f32>(0.0), vec3<f32>(1.0));
}

fn on_shell(at: vec4<f32>, color: vec4<f32>, place: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let gap = at.xyz - place;
    let square = dot(gap, gap);
    let range = at.w * 1.3;
    if (!(square < range * range)) {
        return vec3<f32>(0.0);
    }
    let d = sqrt(square);
    let w = (0.5 * d + dot(normal, gap)) / 1.5;
    if (!(w > 0.0)) {
        return vec3<f32>(0.0);
    }
    var k = 0.0;
    if (d > 1.0) {
        k = w / (square * d);
    } else if (d > 0.0) {
        k = w / d;
    }
    k = k * (1.0 - d / range) * color.w;
    return color.rgb * min(k, 1.0);
}

fn on_object(at: vec4<f32>, color: vec4<f32>, place: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let gap = at.xyz - place;
    let square = dot(gap, gap);
    let range = at.w * 1.5;
    if (!(square < range * range) || !(square > 0.0)) {
        return vec3<f32>(0.0);
    }
    let facing = dot(normal, gap) / square;
    return color.rgb * (color.w * max(facing, 0.0));
}

fn picked(k: u32) -> u32 {
    if (k < 4u) {
        return draw.picks0[k];
    }
    return draw.picks1[k - 4u];
}

fn light_at(place: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let own = vec3<f32>(draw.material.x);
    let diffuse = draw.material.y;
    switch draw.how.x {
        case 0u: {
            let facing = max(dot(normal, frame.sun.xyz), 0.0);
            return finish(own + (frame.outdoor_light.rgb + frame.sun_color.rgb * facing) * diffuse);
        }
        case 1u: {
            var dynamic = frame.indoor_light.rgb;
            if (lights.counts.y != 0u) {
                dynamic += on_object(lights.viewer[0], lights.viewer[1], place, normal);
            }
            var baked = vec3<f32>(0.0);
            for (var k = 0u; k < min(lights.counts.x, 40u); k++) {
                baked += on_shell(lights.lamps[2u * k], lights.lamps[2u * k + 1u], place, normal);
            }
            baked = clamp(baked, vec3<f32>(0.0), vec3<f32>(1.0));
            return finish(own + baked + dynamic * diffuse);
        }
        case 2u: {
            var sum = frame.indoor_light.rgb;
            for (var k = 0u; k < min(draw.how.z, 8u); k++) {
                let i = min(picked(k), 39u);
                sum += on_object(lights.lamps[2u * i], lights.lamps[2u * i + 1u], place, normal);
            }
            if (lights.counts.y != 0u) {
                sum += on_object(lights.viewer[0], lights.viewer[1], place, normal);
            }
            return finish(own + sum * diffuse);
        }
        default: {
            return own;
        }
    }
}

@vertex
fn vertex(corner: Corner) -> Seen {
    let p = vec4<f32>(corner.position, 1.0);
    let n = corner.normal;
    var out: Seen;
    out.place = vec3<f32>(dot(draw.row0, p), dot(draw.row1, p), dot(draw.row2, p));
    let turned = vec3<f32>(dot(draw.row0.xyz, n), dot(draw.row1.xyz, n), dot(draw.row2.xyz, n));
    let size = length(turned);
    let normal = select(vec3<f32>(0.0), turned / size, size > 0.0);
    if (PIXEL_LIT) {
        out.light = normal;
    } else {
        out.light = light_at(out.place, normal);
    }
    out.at = project(out.place);
    out.uv = corner.uv;
    out.polygon = corner.polygon;
    return out;
}

fn cut_away(seen: Seen) -> bool {
    if (before_exit(seen.at)) {
        return true;
    }
    let ray = seen.place / seen.place.y;
    for (var k = 0u; k < min(lights.counts.z, 32u); k++) {
        let plane = lights.planes[k];
        if (dot(plane.xyz, ray) + plane.w < 0.0) {
            return true;
        }
    }
    return false;
}

@fragment
fn color(seen: Seen) -> @location(0) vec4<f32> {
    var c: vec4<f32>;
    if (frame.flags.y != 0u) {
        let size = vec2<f32>(textureDimensions(picture));
        let lod = level(slope(seen.uv, seen.at.w) * max(size.x, size.y));
        c = textureSampleLevel(picture, picture_sampler, seen.uv, lod);
    } else {
        c = textureSample(picture, picture_sampler, seen.uv);
    }
    if (CUT && cut_away(seen)) {
        discard;
    }
    if (draw.material.z > 0.0 && c.a < draw.material.z) {
        discard;
    }
    var light = seen.light;
    if (PIXEL_LIT) {
        let size = length(seen.light);
        light = light_at(seen.place, select(vec3<f32>(0.0), seen.light / size, size > 0.0));
    }
    var lit = c.rgb * light;
    if ((draw.how.y & 1u) != 0u) {
        lit = fogged(lit, seen.place);
    }
    let alpha = select(1.0, c.a, (draw.how.y & 2u) != 0u);
    return vec4<f32>(lit, alpha * draw.material.w);
}

@fragment
fn ids(seen: Seen) -> @location(0) vec2<u32> {
    if (CUT && cut_away(seen)) {
        discard;
    }
    return vec2<u32>(draw.id.x, draw.id.y | select(0u, seen.polygon, draw.id.z != 0u));
}
