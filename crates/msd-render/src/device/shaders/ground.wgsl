struct Patch {
    @location(0) centre: vec3f,
    @location(1) half: f32,
    @location(2) u: vec3f,
    @location(3) normal: vec3f,
}

struct Ground {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    // Coordinates along the plane, metres, and from the centre as a fraction of the size.
    @location(1) along: vec2f,
    @location(2) from_centre: vec2f,
    @location(3) @interpolate(flat) normal: vec3f,
}

@vertex
fn vs_main(@builtin(vertex_index) index: u32, part: Patch) -> Ground {
    let corner = quad_corner(index);
    let v = cross(part.normal, part.u);
    let world = part.centre + (part.u * corner.x + v * corner.y) * part.half;
    let clip = globals.view_projection * vec4f(world, 1.0);
    let along = vec2f(dot(world, part.u), dot(world, v));
    // Pushed away a little, so that what lies on the plane is seen. Not by `pulled`: its limit is
    // not linear, and a corner of this quad may lie behind the eye.
    let pushed = vec4f(clip.xy, clip.z * 0.9985, clip.w);
    return Ground(pushed, world, along, corner, part.normal);
}

// Lines around whole numbers, 0 to 1: one to two pixels wide, fading where they get too dense.
// After Ben Golus, "The Best Darn Grid Shader (Yet)", 2023.
fn lines(at: vec2f, pixel: vec2f, width: f32) -> f32 {
    let drawn = clamp(vec2f(width), pixel * 1.2, pixel * 2.4);
    let soft = pixel * 1.2;
    let from_line = 1.0 - abs(fract(at) * 2.0 - 1.0);
    var strength = 1.0 - smoothstep(drawn - soft, drawn + soft, from_line);
    strength *= clamp(width / drawn, vec2f(0.35), vec2f(1.0));
    strength *= 1.0 - smoothstep(vec2f(0.12), vec2f(0.45), pixel);
    return max(strength.x, strength.y);
}

fn grid(along: vec2f, pixel: vec2f) -> f32 {
    let one = lines(along, pixel, 0.02);
    let ten = lines(along * 0.1, pixel * 0.1, 0.004);
    let hundred = lines(along * 0.01, pixel * 0.01, 0.001);
    return max(one * 0.30, max(ten, hundred) * 0.60);
}

fn rim(from_centre: vec2f) -> f32 {
    return 1.0 - smoothstep(0.30, 0.96, length(from_centre));
}

@fragment
fn fs_front(in: Ground) -> @location(0) vec4f {
    let line = grid(in.along, fwidth(in.along)) * globals.look.y;
    let albedo = mix(vec3f(0.60, 0.60, 0.595), vec3f(0.13, 0.17, 0.25), line);
    let sun = sunlight(in.world, in.normal);
    let facing = max(dot(in.normal, globals.light.xyz), 0.0);
    let ambient = mix(GROUND_LIGHT, SKY_LIGHT, 0.5 + 0.5 * in.normal.y);
    let colour = shown(albedo * (ambient + SUN * (facing * sun)), rim(in.from_centre));
    return colour + vec4f(vec3f(dither(in.clip.xy) / 255.0), 0.0);
}

// From behind a plane is glass: a hint of it, and its grid.
@fragment
fn fs_back(in: Ground) -> @location(0) vec4f {
    let line = grid(in.along, fwidth(in.along)) * globals.look.y;
    let opacity = (0.10 + 0.5 * line) * rim(in.from_centre);
    return shown_srgb(vec3f(0.30, 0.34, 0.42), opacity);
}
