// The ground: terrain textures, blend maps and roads (`rendering.md` 11.5, 12.4).

override CUT: bool = false;
// The base texture is all there is: most land cells.
override PLAIN: bool = false;

@group(1) @binding(0) var pictures: texture_2d_array<f32>;
@group(1) @binding(1) var picture_sampler: sampler;
@group(1) @binding(2) var maps: texture_2d_array<f32>;
@group(1) @binding(3) var map_sampler: sampler;

struct Corner {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    // East and south in the land cell, 0 to 1.
    @location(2) uv: vec2<f32>,
    @location(3) cell: u32,
    // Base and overlays.
    @location(4) layers: vec4<u32>,
    @location(5) roads: vec2<u32>,
    @location(6) land: u32,
};

struct Seen {
    @builtin(position) at: vec4<f32>,
    @location(0) place: vec3<f32>,
    @location(1) light: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) @interpolate(flat, either) cell: u32,
    @location(4) @interpolate(flat, either) layers: vec4<u32>,
    @location(5) @interpolate(flat, either) roads: vec2<u32>,
};

@vertex
fn vertex(corner: Corner) -> Seen {
    let p = vec4<f32>(corner.position, 1.0);
    let o = lands[corner.land];
    var out: Seen;
    out.place = vec3<f32>(
        dot(vec4<f32>(frame.right.xyz, o.x), p),
        dot(vec4<f32>(frame.forward.xyz, o.y), p),
        dot(vec4<f32>(frame.up.xyz, o.z), p),
    );
    out.at = project(out.place);
    let facing = max(dot(corner.normal, frame.sun_land.xyz), 0.0);
    let light = frame.terrain_light.rgb + frame.sun_color.rgb * facing;
    out.light = clamp(light, vec3<f32>(0.0), vec3<f32>(1.0));
    out.uv = corner.uv;
    out.cell = corner.cell;
    out.layers = corner.layers;
    out.roads = corner.roads;
    return out;
}

fn sample_type(layer: u32, uv: vec2<f32>, cover: f32, dx: vec2<f32>, dy: vec2<f32>) -> vec3<f32> {
    let tiling = f32((layer >> 6u) & 127u);
    let index = i32(layer & 63u);
    if (frame.flags.y != 0u) {
        let lod = level(cover * tiling * f32(textureDimensions(pictures).x));
        return textureSampleLevel(pictures, picture_sampler, uv * tiling, index, lod).rgb;
    }
    return textureSampleGrad(pictures, picture_sampler, uv * tiling, index, dx * tiling, dy * tiling).rgb;
}

// The weight of what lies below: 0 where the layer covers.
fn below(layer: u32, uv: vec2<f32>) -> f32 {
    switch (layer >> 13u) & 3u {
        case 1u: {
            var at = uv;
            switch (layer >> 21u) & 3u {
                case 1u: { at = vec2<f32>(1.0 - uv.y, uv.x); }
                case 2u: { at = vec2<f32>(1.0) - uv; }
                case 3u: { at = vec2<f32>(uv.y, 1.0 - uv.x); }
                default: {}
            }
            return textureSampleLevel(maps, map_sampler, at, i32((layer >> 15u) & 63u), 0.0).r;
        }
        case 2u: {
            let mask = (layer >> 15u) & 15u;
            let sw = f32(mask & 1u);
            let se = f32((mask >> 1u) & 1u);
            let ne = f32((mask >> 2u) & 1u);
            let nw = f32((mask >> 3u) & 1u);
            let south = mix(sw, se, uv.x);
            let north = mix(nw, ne, uv.x);
            let t = clamp((mix(north, south, uv.y) - 0.5) * 2.5 + 0.5, 0.0, 1.0);
            return 1.0 - t * t * (3.0 - 2.0 * t);
        }
        case 3u: { return 0.0; }
        default: { return 1.0; }
    }
}

@fragment
fn color(seen: Seen) -> @location(0) vec4<f32> {
    let dx = dpdx(seen.uv);
    let dy = dpdy(seen.uv);
    let cover = slope(seen.uv, seen.at.w);
    if (CUT && before_exit(seen.at)) {
        discard;
    }
    var c = sample_type(seen.layers.x, seen.uv, cover, dx, dy);
    if (!PLAIN) {
        for (var k = 1; k < 4; k++) {
            let layer = seen.layers[k];
            let a = below(layer, seen.uv);
            if (a < 1.0) {
                c = mix(sample_type(layer, seen.uv, cover, dx, dy), c, a);
            }
        }
        let a = below(seen.roads.x, seen.uv) * below(seen.roads.y, seen.uv);
        if (a < 1.0) {
            c = mix(sample_type(seen.roads.x, seen.uv, cover, dx, dy), c, a);
        }
    }
    return vec4<f32>(fogged(c * seen.light, seen.place), 1.0);
}

@fragment
fn ids(seen: Seen) -> @location(0) vec2<u32> {
    if (CUT && before_exit(seen.at)) {
        discard;
    }
    return vec2<u32>(seen.cell, 1u << 28u);
}
