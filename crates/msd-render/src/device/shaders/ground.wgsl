struct Patch {
    @location(0) centre: vec3f,
    @location(1) half: vec2f,
    @location(2) u: vec3f,
    @location(3) normal: vec3f,
    @location(4) opacity: f32,
}

struct Ground {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    // Coordinates along the plane, metres, and from the centre as a fraction of the size.
    @location(1) along: vec2f,
    @location(2) from_centre: vec2f,
    @location(3) @interpolate(flat) normal: vec3f,
    @location(4) @interpolate(flat) opacity: f32,
}

@vertex
fn vs_main(@builtin(vertex_index) index: u32, part: Patch) -> Ground {
    let corner = quad_corner(index);
    let v = cross(part.normal, part.u);
    let world = part.centre + part.u * corner.x * part.half.x + v * corner.y * part.half.y;
    let clip = globals.view_projection * vec4f(world, 1.0);
    let along = vec2f(dot(world, part.u), dot(world, v));
    // Pushed away a little, so that what lies on the plane is seen. Not by `pulled`: its limit is
    // not linear, and a corner of this quad may lie behind the eye.
    let pushed = vec4f(clip.xy, clip.z * 0.9985, clip.w);
    return Ground(pushed, world, along, corner, part.normal, part.opacity);
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

// How much of a plane there is at a place: a floor goes on into the haze, a wall does along the
// floor, and ends above.
fn present(in: Ground) -> f32 {
    let at = abs(in.from_centre);
    let pixel = fwidth(in.from_centre);
    let ends = clamp((1.0 - at) / max(pixel, vec2f(1e-6)), vec2f(0.0), vec2f(1.0));
    let lost = vec2f(1.0 - smoothstep(0.3, 0.96, length(at)), 1.0 - smoothstep(0.05, 0.5, at.x));
    let wall = ends.y * select(ends.x, lost.y, abs(in.normal.y) < 0.1);
    return in.opacity * select(wall, lost.x, in.normal.y > 0.95);
}

@fragment
fn fs_front(in: Ground) -> @location(0) vec4f {
    var line = 0.0;
    if FINE {
        line = grid(in.along, fwidth(in.along)) * globals.look.y;
    }
    let is_floor = in.normal.y > 0.95;
    let stone = select(vec3f(0.72, 0.71, 0.69), vec3f(0.58, 0.575, 0.56), is_floor);
    let albedo = mix(stone, vec3f(0.20, 0.22, 0.26), line * 0.8);
    let sun = sunlight(in.world, in.normal, in.clip.xy);
    let facing = max(dot(in.normal, globals.light.xyz), 0.0);
    let sky = select(1.0, skylight(in.world, in.clip.xy), is_floor);
    let above = mix(GROUND_LIGHT, SKY_LIGHT, 0.5 + 0.5 * in.normal.y);
    let to_eye = globals.eye.xyz - in.world;
    let away = length(to_eye);
    let sunny = facing * sun * (0.4 + 0.6 * sky);
    let fill = select(max(dot(in.normal, to_eye) / away, 0.0) * (1.0 - sunny), 0.0, is_floor);
    var light = above * sky + SUN * sunny;
    if !FINE {
        // As bright, in the colour of both together: less of the blue sky would make it brown.
        let both = above + SUN * (facing * sun);
        light = both * (light.g / both.g);
    }
    light += FILL_LIGHT * fill;
    // Air between the eye and the ground: it ends in the horizon.
    let haze = select(0.0, smoothstep(6.0, 45.0, away / globals.look.w), is_floor);
    let colour = mix(toned(albedo * light), HAZE, haze);
    let seen = shown(colour, present(in));
    return seen + vec4f(vec3f(dither(in.clip.xy) / 255.0), 0.0);
}

// From behind a plane is glass: a hint of it, and its grid.
@fragment
fn fs_back(in: Ground) -> @location(0) vec4f {
    let line = grid(in.along, fwidth(in.along)) * globals.look.y;
    let opacity = (0.04 + 0.14 * line) * present(in);
    return shown_srgb(vec3f(0.30, 0.34, 0.42), opacity);
}
