// Light and shadow, shared by the lit programs.
@group(1) @binding(0) var shadow_map: texture_depth_2d;
@group(1) @binding(1) var shadow_sampler: sampler_comparison;

const SUN: vec3f = vec3f(1.06, 1.00, 0.90);
const SKY_LIGHT: vec3f = vec3f(0.38, 0.43, 0.50);
const GROUND_LIGHT: vec3f = vec3f(0.24, 0.22, 0.20);

// The share of sunlight that reaches a point, 0 to 1, from 3 x 3 smoothed taps.
fn sunlight(world: vec3f, normal: vec3f) -> f32 {
    // Pushed off the surface by a few texels, more where the light grazes, against self-shadow.
    let grazing = 1.0 - clamp(dot(normal, globals.light.xyz), 0.0, 1.0);
    let offset = normal * (globals.shadow.x * (1.0 + 2.5 * grazing));
    let clip = globals.light_projection * vec4f(world + offset, 1.0);
    let uv = vec2f(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y);
    let inside = globals.light.w > 0.5 && all(abs(clip.xy) < vec2f(1.0));
    // Behind the farthest caster the map still tells whether anything is in the way.
    let depth = min(clip.z, 1.0) - 0.0008;
    var sum = 0.0;
    // A loop that does not start costs nothing outside the map; a branch would.
    let rows = select(-2, 1, inside);
    for (var y = -1; y <= rows; y++) {
        for (var x = -1; x <= 1; x++) {
            let at = uv + vec2f(f32(x), f32(y)) * (1.35 * globals.shadow.y);
            sum += textureSampleCompareLevel(shadow_map, shadow_sampler, at, depth);
        }
    }
    return select(1.0, sum / 9.0, inside);
}

// Light from sky, ground and sun off a surface with a soft highlight, linear.
fn lit(albedo: vec3f, normal: vec3f, world: vec3f, sun: f32, gloss: f32) -> vec3f {
    let to_eye = normalize(globals.eye.xyz - world);
    let to_light = globals.light.xyz;
    let facing = max(dot(normal, to_light), 0.0);
    let ambient = mix(GROUND_LIGHT, SKY_LIGHT, 0.5 + 0.5 * normal.y);
    let half_way = normalize(to_eye + to_light);
    let highlight = pow(max(dot(normal, half_way), 0.0), 48.0) * facing * sun;
    let away = 1.0 - max(dot(normal, to_eye), 0.0);
    let rim = away * away * away * away;
    let mirrored = highlight * 0.55 + rim * 0.22 * (0.4 + 0.6 * sun);
    return albedo * (ambient + SUN * (facing * sun)) + gloss * mirrored * SKY_LIGHT;
}
