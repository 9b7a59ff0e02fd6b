// Meshes: shells, rooms, objects and things in the sky (`rendering.md` 12, 14).

override CUT: bool = false;
override PIXEL_LIT: bool = false;

// Textures repeat.
override WRAP: bool = false;

@group(1) @binding(0) var pictures: texture_2d_array<f32>;
@group(1) @binding(1) var clamping: sampler;
@group(1) @binding(2) var repeating: sampler;

struct Corner {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) polygon: u32,
    // Flags (4 fog, 8 alpha counts), from 16 the layer of the texture.
    @location(10) surface: u32,
    // Luminosity, diffuse, least alpha (0: no test).
    @location(11) paint: vec3<f32>,
};

struct Instance {
    // Rows of the placement.
    @location(4) row0: vec4<f32>,
    @location(5) row1: vec4<f32>,
    @location(6) row2: vec4<f32>,
    // Luminosity where the light is its own, opacity.
    @location(7) fade: vec2<f32>,
    // x, from the lowest bits: 2 kind of light (0 sun, 1 shell, 2 object indoors, 3 its own), 16 the item is the polygon,
    // from 8 number of lamps, from 24 number of planes. y: first lamp, from 16 first plane. z, w: lamps of an object, 8
    // bits each.
    @location(8) how: vec4<u32>,
    // Cell, code and item.
    @location(9) id: vec2<u32>,
};

struct Seen {
    @builtin(position) at: vec4<f32>,
    @location(0) place: vec3<f32>,
    // The normal, or the light when it is computed at the corners.
    @location(1) light: vec3<f32>,
    @location(2) uv: vec2<f32>,
    // Luminosity, diffuse, least alpha, opacity.
    @location(3) @interpolate(flat, either) material: vec4<f32>,
    // As the instance has it, with the flags and the layer of the corner.
    @location(4) @interpolate(flat, either) how: vec4<u32>,
    @location(5) @interpolate(flat, either) id: vec2<u32>,
};

fn soft_channel(v: f32) -> f32 {
    if (v <= 0.5) {
        return max(v, 0.0);
    }
    let x = (v - 0.5) * 2.0;
    return 1.0 - 0.5 / (1.0 + x + x * x * 0.5);
}

fn finish(c: vec3<f32>, kind: u32) -> vec3<f32> {
    if (frame.flags.x != 0u && kind != 0u) {
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

// What walls throw back.
fn thrown_back(at: vec4<f32>, color: vec4<f32>, place: vec3<f32>) -> vec3<f32> {
    let gap = at.xyz - place;
    let square = dot(gap, gap);
    let range = at.w * 1.3;
    if (!(square < range * range)) {
        return vec3<f32>(0.0);
    }
    let k = (1.0 - sqrt(square) / range) * color.w / max(square, 1.0);
    return color.rgb * (0.3 * min(k, 1.0));
}

fn light_at(place: vec3<f32>, normal: vec3<f32>, material: vec4<f32>, how: vec4<u32>) -> vec3<f32> {
    let own = vec3<f32>(material.x);
    let diffuse = material.y;
    let kind = how.x & 3u;
    let first = how.y & 0xFFFFu;
    let count = min((how.x >> 8u) & 255u, 40u);
    switch kind {
        case 0u: {
            let facing = max(dot(normal, frame.sun.xyz), 0.0);
            return finish(own + (frame.outdoor_light.rgb + frame.sun_color.rgb * facing) * diffuse, kind);
        }
        case 1u: {
            var dynamic = frame.indoor_light.rgb;
            if (frame.flags.w != 0u) {
                dynamic += on_object(frame.viewer[0], frame.viewer[1], place, normal);
            }
            var baked = vec3<f32>(0.0);
            for (var k = 0u; k < count; k++) {
                let i = min(first + 2u * k, 1022u);
                baked += on_shell(lists[i], lists[i + 1u], place, normal);
            }
            baked = clamp(baked, vec3<f32>(0.0), vec3<f32>(1.0));
            return finish(own + baked + dynamic * diffuse, kind);
        }
        case 2u: {
            var sum = frame.indoor_light.rgb;
            for (var k = 0u; k < min(count, 8u); k++) {
                let four = select(how.z, how.w, k >= 4u);
                let i = min(first + 2u * ((four >> (8u * (k & 3u))) & 255u), 1022u);
                sum += on_object(lists[i], lists[i + 1u], place, normal);
                if (frame.flags.x != 0u) {
                    sum += thrown_back(lists[i], lists[i + 1u], place);
                }
            }
            if (frame.flags.w != 0u) {
                sum += on_object(frame.viewer[0], frame.viewer[1], place, normal);
            }
            return finish(own + sum * diffuse, kind);
        }
        default: {
            return own;
        }
    }
}

@vertex
fn vertex(corner: Corner, it: Instance) -> Seen {
    let p = vec4<f32>(corner.position, 1.0);
    let n = corner.normal;
    var out: Seen;
    out.place = vec3<f32>(dot(it.row0, p), dot(it.row1, p), dot(it.row2, p));
    let turned = vec3<f32>(dot(it.row0.xyz, n), dot(it.row1.xyz, n), dot(it.row2.xyz, n));
    let size = length(turned);
    let normal = select(vec3<f32>(0.0), turned / size, size > 0.0);
    // By its own light it has no fog, and the alpha of its texture counts.
    let own = (it.how.x & 3u) == 3u;
    let surface = select(corner.surface, (corner.surface & ~4u) | 8u, own);
    out.material = vec4<f32>(select(corner.paint.x, it.fade.x, own), corner.paint.yz, it.fade.y);
    out.how = vec4<u32>(it.how.x | surface, it.how.yzw);
    if (PIXEL_LIT) {
        out.light = normal;
    } else {
        out.light = light_at(out.place, normal, out.material, out.how);
    }
    out.at = project(out.place);
    out.uv = corner.uv;
    out.id = vec2<u32>(it.id.x, it.id.y | select(0u, corner.polygon, (it.how.x & 16u) != 0u));
    return out;
}

fn cut_away(seen: Seen) -> bool {
    if (before_exit(seen.at)) {
        return true;
    }
    let ray = seen.place / seen.place.y;
    let first = seen.how.y >> 16u;
    for (var k = 0u; k < min(seen.how.x >> 24u, 32u); k++) {
        let plane = lists[min(first + k, 1023u)];
        if (dot(plane.xyz, ray) + plane.w < 0.0) {
            return true;
        }
    }
    return false;
}

@fragment
fn color(seen: Seen) -> @location(0) vec4<f32> {
    let layer = (seen.how.x >> 16u) & 255u;
    var c: vec4<f32>;
    if (frame.flags.y != 0u) {
        let size = vec2<f32>(textureDimensions(pictures));
        let lod = level(slope(seen.uv, seen.at.w) * max(size.x, size.y));
        if (WRAP) {
            c = textureSampleLevel(pictures, repeating, seen.uv, layer, lod);
        } else {
            c = textureSampleLevel(pictures, clamping, seen.uv, layer, lod);
        }
    } else if (WRAP) {
        c = textureSample(pictures, repeating, seen.uv, layer);
    } else {
        c = textureSample(pictures, clamping, seen.uv, layer);
    }
    if (CUT && cut_away(seen)) {
        discard;
    }
    if (seen.material.z > 0.0 && c.a < seen.material.z) {
        discard;
    }
    var light = seen.light;
    if (PIXEL_LIT) {
        let size = length(seen.light);
        let normal = select(vec3<f32>(0.0), seen.light / size, size > 0.0);
        light = light_at(seen.place, normal, seen.material, seen.how);
    }
    var lit = c.rgb * light;
    if ((seen.how.x & 4u) != 0u) {
        lit = fogged(lit, seen.place);
    }
    let alpha = select(1.0, c.a, (seen.how.x & 8u) != 0u);
    return vec4<f32>(lit, alpha * seen.material.w);
}

@fragment
fn ids(seen: Seen) -> @location(0) vec2<u32> {
    if (CUT && cut_away(seen)) {
        discard;
    }
    return seen.id;
}
