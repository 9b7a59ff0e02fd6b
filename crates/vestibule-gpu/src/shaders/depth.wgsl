// Punches and seals: depth and nothing else (`rendering.md` 7, 9.3).

struct Corner {
    // Camera axes; w: the depth to write, below zero for the polygon's own.
    @location(0) place: vec4<f32>,
};

@vertex
fn vertex(corner: Corner) -> @builtin(position) vec4<f32> {
    var at = project(corner.place.xyz);
    if (corner.place.w >= 0.0) {
        at.z = corner.place.w * at.w;
    } else {
        // A corner that rounding put before the near plane must not be clipped.
        at.z = min(at.z, at.w);
    }
    return at;
}

@fragment
fn nothing() {}
