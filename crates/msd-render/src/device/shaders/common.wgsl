// Shared by every program: the uniforms and the way to the screen. The layout is that of `Globals`
// in uniforms.rs.
struct Globals {
    view_projection: mat4x4f,
    light_projection: mat4x4f,
    // From the world to the map of what is above the ground, seen from below.
    ground_projection: mat4x4f,
    eye: vec4f,
    // Axes of the camera; right and up are scaled by the tangents of half the angles of view.
    right: vec4f,
    up: vec4f,
    forward: vec4f,
    // Direction to the light; w is 1 with shadows and 0 without.
    light: vec4f,
    // Width and height in pixels; z is 1 if the shader must encode sRGB; w is the near distance.
    screen: vec4f,
    // Size of a texel of the shadow map: x in metres, y as a fraction; z depth of the map, m.
    shadow: vec4f,
    // The same of the map of what is above the ground.
    ground: vec4f,
    // Whether to show x the pattern, y the grid; z pixels per point; w radius of the scene, m.
    look: vec4f,
    // Height of the ground, m, if there is one: w is 1 then; y and z are the upper left corner of
    // the picture, pixels.
    level: vec4f,
}

@group(0) @binding(0) var<uniform> globals: Globals;

// Within 0.003 of the exact curve, by roots instead of powers: a third of the time in software.
fn linear_to_srgb(colour: vec3f) -> vec3f {
    let c = clamp(colour, vec3f(0.0), vec3f(1.0));
    let second = sqrt(c);
    let fourth = sqrt(second);
    let eighth = sqrt(fourth);
    return 0.662002687 * second + 0.684122060 * fourth - 0.323583601 * eighth - 0.0225411470 * c;
}

fn srgb_to_linear(colour: vec3f) -> vec3f {
    let low = colour / 12.92;
    let high = pow((colour + 0.055) / 1.055, vec3f(2.4));
    return select(high, low, colour <= vec3f(0.04045));
}

// What a fragment returns for a linear colour: the target may or may not encode by itself.
fn shown(linear: vec3f, opacity: f32) -> vec4f {
    return vec4f(select(linear, linear_to_srgb(linear), globals.screen.z > 0.5), opacity);
}

// The same for a colour that is sRGB already.
fn shown_srgb(colour: vec3f, opacity: f32) -> vec4f {
    return vec4f(select(srgb_to_linear(colour), colour, globals.screen.z > 0.5), opacity);
}

// Draws something as if it were nearer to the eye by this fraction of its distance. Depth is
// near / distance, so scaling z does just that; the limit keeps it in front of the near plane.
fn pulled(clip: vec4f, fraction: f32) -> vec4f {
    return vec4f(clip.xy, min(clip.z * (1.0 + fraction), clip.w * 0.9999), clip.w);
}

// A hash of the pixel, -0.5 to 0.5, to hide the steps of 8-bit gradients.
fn dither(pixel: vec2f) -> f32 {
    let at = pixel - globals.level.yz;
    return fract(52.9829189 * fract(dot(at, vec2f(0.06711056, 0.00583715)))) - 0.5;
}

// The corner of a quad of two triangles: x and y are -1 or 1.
fn quad_corner(index: u32) -> vec2f {
    let x = select(-1.0, 1.0, index == 1u || index == 2u || index == 4u);
    let y = select(-1.0, 1.0, index == 2u || index == 4u || index == 5u);
    return vec2f(x, y);
}

const HORIZON: vec3f = vec3f(0.77, 0.82, 0.87);
// Ground far away, through air.
const HAZE: vec3f = vec3f(0.67, 0.70, 0.73);

// Colour of the sky in a direction, linear: below the horizon that of ground far away.
fn sky_colour(direction: vec3f) -> vec3f {
    let height = clamp(direction.y * 1.5, 0.0, 1.0);
    let depth = clamp(-direction.y * 2.5, 0.0, 1.0);
    let above = mix(HORIZON, vec3f(0.24, 0.42, 0.68), height * (2.0 - height));
    let below = mix(HAZE, vec3f(0.47, 0.50, 0.54), depth * (2.0 - depth));
    // The edge between them is soft: air lies over it.
    return mix(below, above, smoothstep(-0.035, 0.015, direction.y));
}

// Bright light fades into white as on film, instead of being cut off; dark light stays.
fn toned(linear: vec3f) -> vec3f {
    let bright = max(linear - 0.6, vec3f(0.0));
    return min(linear, vec3f(0.6)) + 0.4 * bright / (bright + 0.4);
}
