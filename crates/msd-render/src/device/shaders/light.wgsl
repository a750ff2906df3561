// Light and shadow, shared by the lit programs.
@group(1) @binding(0) var shadow_map: texture_depth_2d;
@group(1) @binding(1) var shadow_sampler: sampler_comparison;
@group(1) @binding(2) var ground_map: texture_depth_2d;
@group(1) @binding(3) var shade_map: texture_2d<f32>;
@group(1) @binding(4) var shade_sampler: sampler;

const SUN: vec3f = vec3f(1.20, 1.13, 1.01);
const SKY_LIGHT: vec3f = vec3f(0.31, 0.34, 0.39);
const GROUND_LIGHT: vec3f = vec3f(0.18, 0.171, 0.16);
// From where one looks, where the sun does not shine: what faces away from it keeps its shape.
const FILL_LIGHT: vec3f = vec3f(0.06, 0.062, 0.068);
// Half of the width of the softest rim of a shadow, texels.
const SOFTEST: f32 = 48.0;

// Places on a disc of radius one, spread evenly: a sunflower after Vogel, 1979.
fn sunflower(index: f32, count: f32, turn: f32) -> vec2f {
    let angle = 2.39996323 * index + turn;
    return vec2f(cos(angle), sin(angle)) * sqrt((index + 0.5) / count);
}

// The share of sunlight that reaches a point, 0 to 1.
fn sunlight(world: vec3f, normal: vec3f, pixel: vec2f) -> f32 {
    // Pushed off the surface by a few texels, more where the light grazes, against self-shadow.
    let grazing = 1.0 - clamp(dot(normal, globals.light.xyz), 0.0, 1.0);
    let offset = normal * (globals.shadow.x * (1.0 + 2.5 * grazing));
    let clip = globals.light_projection * vec4f(world + offset, 1.0);
    let uv = vec2f(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y);
    // What faces away has no sunlight to lose.
    let faces = dot(normal, globals.light.xyz) > -0.5;
    let inside = faces && globals.light.w > 0.5 && all(abs(clip.xy) < vec2f(1.0));
    // Behind the farthest caster the map still tells whether anything is in the way.
    let depth = min(clip.z, 1.0) - 0.0008;
    var sum = 0.0;
    if FINE {
        // How far away what is in the way is, from a few places and distances: a shadow is sharp
        // where it begins and soft far away (Fernando, Percentage-closer soft shadows, 2005).
        let turn = 6.2831853 * dither(pixel);
        let reach = globals.look.w * 0.06 / globals.shadow.z;
        let around = SOFTEST * globals.shadow.y;
        var blocked = 0.0;
        let probes = select(0, 5, inside);
        for (var i = 0; i < probes; i++) {
            let at = uv + sunflower(f32(i), 5.0, turn) * around;
            blocked += 1.0 - textureSampleCompareLevel(shadow_map, shadow_sampler, at, depth);
        }
        // Most places are lit: what follows is for the others.
        let is_shaded = blocked > 0.0;
        var far = 0.0;
        let farther = select(0, 15, is_shaded);
        for (var i = 0; i < farther; i++) {
            let at = uv + sunflower(f32(i % 5), 5.0, turn) * around;
            let k = f32(i / 5 + 1);
            let away = depth - k * k * reach;
            let open = textureSampleCompareLevel(shadow_map, shadow_sampler, at, away);
            far += (2.0 * k - 1.0) * (1.0 - open);
        }
        let distance = far / max(blocked, 0.2) * (reach * globals.shadow.z);
        let radius = clamp(distance * 0.25 / globals.shadow.x, 1.2, SOFTEST) * globals.shadow.y;
        let taps = select(0, 16, is_shaded);
        for (var i = 0; i < taps; i++) {
            let at = uv + sunflower(f32(i), 16.0, turn) * radius;
            sum += textureSampleCompareLevel(shadow_map, shadow_sampler, at, depth);
        }
        return select(1.0, sum / 16.0, is_shaded);
    }
    // A loop that does not start costs nothing outside the map; a branch would.
    let taps = select(0, 4, inside);
    for (var i = 0; i < taps; i++) {
        let corner = vec2f(f32(i & 1), f32(i >> 1u)) - 0.5;
        let at = uv + corner * (1.4 * globals.shadow.y);
        sum += textureSampleCompareLevel(shadow_map, shadow_sampler, at, depth);
    }
    return select(1.0, 0.25 * sum, inside);
}

// What the map of shade has at a place, by a spline of second order: no texels show, and there is
// no noise. Two samples of equal weight between texels are the three texels of an axis.
fn shade(uv: vec2f) -> f32 {
    let at = uv / globals.ground.y;
    let middle = floor(at) + 0.5;
    let left = middle - (0.5 - at + middle) * (0.5 - at + middle);
    let right = middle + (0.5 + at - middle) * (0.5 + at - middle);
    var sum = 0.0;
    for (var i = 0; i < 4; i++) {
        let place = select(left, right, vec2<bool>((i & 1) == 1, i > 1));
        sum += textureSampleLevel(shade_map, shade_sampler, place * globals.ground.y, 0.0).r;
    }
    return 0.25 * sum;
}

// The share of the light of the sky that reaches a point of the ground, 0 to 1: what hovers close
// above it takes most.
fn skylight(world: vec3f, pixel: vec2f) -> f32 {
    let clip = globals.ground_projection * vec4f(world, 1.0);
    let uv = vec2f(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y);
    let inside = globals.light.w > 0.5 && all(abs(clip.xy) < vec2f(1.0));
    if !FINE {
        return 1.0 - 0.8 * select(0.0, shade(uv), inside);
    }
    let size = globals.look.w;
    var taken = 0.0;
    let layers = select(0, 4, inside);
    let grain = dither(pixel);
    for (var layer = 0; layer < layers; layer++) {
        // What is below this height, over a disc that grows with it.
        let share = f32(layer + 1) * 0.25;
        let height = size * 0.9 * share * share;
        let depth = clamp(clip.z + height / globals.ground.z, 0.0, 0.9999);
        let radius = (0.03 + 0.45 * share * share) * size / globals.ground.x * globals.ground.y;
        var here = 0.0;
        for (var i = 0; i < 5; i++) {
            let spread = sunflower(f32(i), 5.0, 6.2831853 * grain) * radius;
            here += 1.0 - textureSampleCompareLevel(ground_map, shadow_sampler, uv + spread, depth);
        }
        taken += here / 20.0;
    }
    return 1.0 - 0.8 * taken;
}

// What a surface is like.
struct Finish {
    albedo: vec3f,
    // 0 mirrors, 1 is dull.
    roughness: f32,
    // 1 mirrors in its own colour.
    metal: f32,
    // The share of light that passes thin parts.
    translucency: f32,
    // -1 at an edge, 0 where it is flat, 1 in a valley.
    hollow: f32,
}

// The share of sunlight that comes through a body to a point of its surface, by how thick it is
// there along the light; the same everywhere where pictures are to be cheap.
fn through(world: vec3f, normal: vec3f, translucency: f32, pixel: vec2f) -> f32 {
    let inwards = world - normal * (2.0 * globals.shadow.x);
    let clip = globals.light_projection * vec4f(inwards, 1.0);
    let uv = vec2f(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y);
    let layers = select(0, 8, FINE && translucency > 0.0 && globals.light.w > 0.5);
    var sum = 0.0;
    for (var layer = 0; layer < layers; layer++) {
        // Elsewhere in its layer from pixel to pixel, and beside the point: no terraces.
        let part = f32(layer) + 0.5 + dither(pixel + 17.0 * f32(layer));
        let thickness = globals.look.w * 0.11 * part;
        let depth = clip.z - thickness / globals.shadow.z;
        let beside = sunflower(f32(layer), 8.0, 6.2831853 * dither(pixel));
        let at = uv + beside * (6.0 * globals.shadow.y);
        sum += textureSampleCompareLevel(shadow_map, shadow_sampler, at, depth);
    }
    return select(0.25, sum / 8.0, layers > 0) * translucency;
}

// Light from sky, ground and sun off a surface, linear.
fn lit(finish: Finish, normal: vec3f, world: vec3f, sun: f32, pixel: vec2f) -> vec3f {
    let to_eye = normalize(globals.eye.xyz - world);
    let to_light = globals.light.xyz;
    let facing = dot(normal, to_light);
    // Near the ground less light comes from below and the sides, and what comes is that of ground.
    let above = max(world.y - globals.level.x, 0.0) / (0.35 * globals.look.w);
    let close = globals.level.w * (0.5 - 0.5 * normal.y) / (1.0 + 6.0 * above * above);
    let up = 0.5 + 0.5 * normal.y;
    // Little of the sky is seen from a valley.
    let seen = 1.0 - 0.6 * max(finish.hollow, 0.0);
    let ambient = mix(GROUND_LIGHT, SKY_LIGHT, up) * ((1.0 - 0.4 * close) * seen);
    // Light that goes round inside: it wraps around the edge, and shines through thin parts.
    let wrap = 0.7 * finish.translucency;
    let diffuse = max((facing + wrap) / (1.0 + wrap), 0.0);
    // An edge is thin whatever the light.
    let inner = through(world, normal, finish.translucency, pixel) * (1.0 - max(facing, 0.0))
        + 1.3 * finish.translucency * max(-finish.hollow, 0.0);
    // What faces away is in its own shadow, which the map, pushed off the surface, shows with a rim.
    let open = sun * smoothstep(0.0, 0.2, facing);
    let sunny = diffuse * mix(open, 1.0, 0.35 * wrap) * (1.0 - 0.55 * finish.translucency)
        + 0.75 * inner;
    // Blinn's highlight, as bright in all as the sharper it is.
    let gloss = 1.0 - finish.roughness;
    let power = exp2(1.0 + 9.0 * gloss);
    let half_way = normalize(to_eye + to_light);
    let highlight = pow(max(dot(normal, half_way), 0.0), power) * max(facing, 0.0) * sun;
    let away = 1.0 - max(dot(normal, to_eye), 0.0);
    let fresnel = away * away * away * away * away;
    let mirror = mix(vec3f(0.04), finish.albedo, finish.metal) + fresnel * 0.6 * gloss;
    let sky = mix(ambient, sky_colour(reflect(-to_eye, normal)), gloss * gloss);
    let mirrored = mirror * (sky + SUN * (highlight * (0.3 + 0.05 * power * gloss)));
    let fill = FILL_LIGHT * (max(dot(normal, to_eye), 0.0) * max(1.0 - sunny, 0.0));
    let matt = finish.albedo * (1.0 - 0.9 * finish.metal) * (ambient + fill + SUN * sunny);
    return toned(matt + mirrored);
}
