struct Vertex {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    // One is once the pattern.
    @location(2) uv: vec2f,
    // How hollow the surface is there in w: 0 at an edge, 0.5 where it is flat, 1 in a valley.
    @location(3) colour: vec4f,
    // The other side; w is the pattern, as its number over 255.
    @location(4) back: vec4f,
    // Roughness, metal, translucency, and whether there is another side.
    @location(5) finish: vec4f,
}

struct Surface {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) colour: vec3f,
    @location(4) back: vec3f,
    @location(5) @interpolate(flat) finish: vec4f,
    @location(6) @interpolate(flat) pattern: f32,
    @location(7) hollow: f32,
}

@vertex
fn vs_main(in: Vertex) -> Surface {
    let clip = globals.view_projection * vec4f(in.position, 1.0);
    let colour = srgb_to_linear(in.colour.rgb);
    let back = srgb_to_linear(in.back.rgb);
    let pattern = round(in.back.a * 255.0);
    let hollow = 2.0 * in.colour.a - 1.0;
    return Surface(clip, in.position, in.normal, in.uv, colour, back, in.finish, pattern, hollow);
}

// A wave of -1 and 1 whose borders are one pixel soft; 0 where it gets finer than pixels.
fn square_wave(at: vec2f, width: vec2f) -> vec2f {
    let wave = 4.0 * abs(fract(at + 0.25) - 0.5) - 1.0;
    let soft = clamp(wave / max(4.0 * width, vec2f(1e-5)), vec2f(-1.0), vec2f(1.0));
    return soft * clamp(1.5 - 2.0 * width, vec2f(0.0), vec2f(1.0));
}

// How light a pattern is, -1 to 1.
fn pattern_at(pattern: f32, uv: vec2f, width: vec2f) -> f32 {
    let grain = vec2f(0.0, 0.25 * sin(0.9 * uv.x + 0.5 * sin(1.3 * uv.y)) + 0.04 * sin(4.0 * uv.x));
    let at = select(0.5 * uv, uv + grain, pattern > 3.5);
    let wave = square_wave(at, select(0.5 * width, width, pattern > 3.5));
    // A thread is round, and lies over every second one across; where it is finer than
    // three pixels nothing is left of it.
    let fine = clamp(1.5 - 4.0 * max(width.x, width.y), 0.0, 1.0);
    let round_thread = abs(sin(3.14159265 * uv));
    let over = wave.x * wave.y > 0.0;
    let weave = (select(round_thread.y, round_thread.x, over) * 1.6 - 1.2) * fine;
    let ring = 1.0 - 2.0 * pow(fract(at.y), 2.5);
    let fade = clamp(1.2 - 2.0 * width.y, 0.0, 1.0);
    var value = select(0.0, wave.x * wave.y, pattern > 0.5);
    value = select(value, wave.y, pattern > 1.5);
    value = select(value, weave, pattern > 2.5);
    return select(value, ring * fade, pattern > 3.5);
}

@fragment
fn fs_main(in: Surface, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    // Toward the viewer on either side: for sheets, and for the inside of a torn solid.
    let length = max(length(in.normal), 1e-6);
    let normal = select(-in.normal, in.normal, front) / length;
    let own = select(in.back, in.colour, front || in.finish.a < 0.5);
    let value = pattern_at(in.pattern, in.uv, fwidth(in.uv)) * globals.look.x;
    let strength = select(select(0.20, 0.11, in.pattern > 2.5), 0.14, in.pattern > 3.5);
    let albedo = own * (1.0 + strength * value) + max(value, 0.0) * 0.5 * strength * (1.0 - own);
    let hollow = select(-in.hollow, in.hollow, front);
    let finish = Finish(albedo, in.finish.x, in.finish.y, in.finish.z, hollow);
    let sun = sunlight(in.world, normal, in.clip.xy);
    return shown(lit(finish, normal, in.world, sun, in.clip.xy), 1.0);
}
