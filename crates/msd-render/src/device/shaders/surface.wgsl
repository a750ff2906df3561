struct Vertex {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) colour: vec4f,
}

struct Surface {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) colour: vec3f,
}

@vertex
fn vs_main(in: Vertex) -> Surface {
    let clip = globals.view_projection * vec4f(in.position, 1.0);
    return Surface(clip, in.position, in.normal, in.uv, srgb_to_linear(in.colour.rgb));
}

// A checkerboard of 0 and 1 whose borders are one pixel soft, and which turns to one half where
// the squares get smaller than pixels.
fn checker(uv: vec2f, width: vec2f) -> f32 {
    let wave = abs(fract(uv) * 2.0 - 1.0) - 0.5;
    let soft = clamp(wave / max(2.0 * width, vec2f(1e-5)), vec2f(-0.5), vec2f(0.5));
    let fine = clamp(1.5 - 2.0 * max(width.x, width.y), 0.0, 1.0);
    return 0.5 + 2.0 * soft.x * soft.y * fine;
}

@fragment
fn fs_main(in: Surface, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    // Toward the viewer on either side: for sheets, and for the inside of a torn solid.
    let length = max(length(in.normal), 1e-6);
    let normal = select(-in.normal, in.normal, front) / length;
    let uv = in.uv * 5.0;
    let square = checker(uv, fwidth(uv));
    let light = mix(in.colour, vec3f(1.0), 0.17);
    let albedo = mix(in.colour, light, (1.0 - square) * globals.look.x);
    return shown(lit(albedo, normal, in.world, sunlight(in.world, normal), 1.0), 1.0);
}
