// What casts shadows, seen from the light. For the sun only depth is written. Seen from below, what
// is lowest also writes how much of the light of the sky it takes, by its height above the ground.
@fragment
fn fs_shade(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let ground = globals.light_projection * vec4f(0.0, globals.level.x, 0.0, 1.0);
    let above = max(at.z - ground.z, 0.0) * globals.shadow.z / (0.3 * globals.look.w);
    return vec4f(1.0 / (1.0 + above * above), 0.0, 0.0, 1.0);
}

@vertex
fn vs_surface(@location(0) position: vec3f) -> @builtin(position) vec4f {
    return globals.light_projection * vec4f(position, 1.0);
}

// A line casts the shadow of a thin ribbon that faces the light.
@vertex
fn vs_line(
    @builtin(vertex_index) index: u32,
    @location(0) a: vec3f,
    @location(1) width: f32,
    @location(2) b: vec3f,
    @location(5) radius: f32,
) -> @builtin(position) vec4f {
    let corner = quad_corner(index);
    let across = cross(b - a, globals.light.xyz);
    let length = length(across);
    let side = select(vec3f(0.0), across / max(length, 1e-9), length > 1e-9);
    // As wide as the line is drawn, seen from the eye.
    let at = select(a, b, corner.x > 0.0);
    let distance = max(dot(at - globals.eye.xyz, globals.forward.xyz), 0.0);
    let drawn = width * globals.up.w * distance / globals.screen.y;
    let half = max(max(radius, drawn), 0.6 * globals.shadow.x);
    let world = at + side * (corner.y * half);
    return globals.light_projection * vec4f(world, 1.0);
}

// A point casts the shadow of a polygon of twelve sides that faces the light: round, no discard.
@vertex
fn vs_point(
    @builtin(vertex_index) index: u32,
    @location(0) centre: vec3f,
    @location(1) radius: f32,
) -> @builtin(position) vec4f {
    let size = max(radius, 1.2 * globals.shadow.x);
    let step = f32(index / 3u) + select(0.0, 1.0, index % 3u == 2u);
    let angle = step * 0.523598776;
    let rim = select(1.0, 0.0, index % 3u == 0u);
    let clip = globals.light_projection * vec4f(centre, 1.0);
    // The projection is orthographic with square texels: a metre is as long in x as in y.
    let metre = globals.shadow.y / globals.shadow.x * 2.0;
    return clip + vec4f(cos(angle), sin(angle), 0.0, 0.0) * (rim * size * metre);
}
