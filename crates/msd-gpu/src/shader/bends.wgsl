// A force less the pulls of the bends of a particle, in the order of the core. Each of its particles
// computes the pull of a bend by itself.
fn with_bends(at: At, force: vec3<f32>) -> vec3<f32> {
    var f = force;
    if params[ME].bends_at == 0u {
        return f;
    }
    let list = topology[4u * at.slice + 3u] + at.lane;
    let last = topology[list + 1u];
    for (var entry = topology[list]; entry < last; entry++) {
        let part = topology[entry];
        let row = params[ME].bends_at + 3u * (part >> 2u);
        let ends = 2u * (numbers[row] + vec4<u32>(params[ME].first));
        let weights = bitcast<vec4<f32>>(numbers[row + 1u]);
        let law = bitcast<vec4<f32>>(numbers[row + 2u]);
        let pull = bend(state[ends.x].xyz, state[ends.y].xyz, state[ends.z].xyz, state[ends.w].xyz,
            state[ends.x + 1u].xyz, state[ends.y + 1u].xyz, state[ends.z + 1u].xyz,
            state[ends.w + 1u].xyz, weights.x, weights.y, weights.z, weights.w, law.x, law.y);
        f = subtract(f, scaled(pull, weights[part & 3u]));
    }
    return f;
}
