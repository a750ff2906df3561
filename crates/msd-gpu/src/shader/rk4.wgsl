// The classical method of Runge and Kutta: four dispatches for each substep. Of a particle `own`
// keeps position and velocity at the start of the substep and the sums of their slopes.

// The velocity of a stage, or of the end, of a particle that a plane holds.
fn held_in_stage(x: vec3<f32>, v: vec3<f32>, v0: vec3<f32>, w: f32, reach: f32, is_last: bool)
    -> vec3<f32> {
    if !lies(substep.x) {
        return v;
    }
    let kick = divided(subtract(v, v0), reach);
    return held(plane_below(x, w), v, kick, reach, is_last);
}

fn next_stage(
    at: At,
    xw: vec4<f32>,
    vm: vec4<f32>,
    weight: f32,
    reach: f32,
    is_first: bool,
) {
    let stiffness = own[4u * at.i].w;
    var x0 = own[4u * at.i].xyz;
    var v0 = own[4u * at.i + 1u].xyz;
    var sum_x = own[4u * at.i + 2u].xyz;
    var sum_v = own[4u * at.i + 3u].xyz;
    if is_first {
        x0 = xw.xyz;
        v0 = vm.xyz;
        sum_x = vec3<f32>(0f);
        sum_v = vec3<f32>(0f);
    }
    let a = scaled(forces(at, xw.xyz, vm.xyz, vm.w), xw.w);
    own[4u * at.i] = vec4<f32>(x0, stiffness);
    own[4u * at.i + 1u] = vec4<f32>(v0, 0f);
    own[4u * at.i + 2u] = vec4<f32>(after(sum_x, vm.xyz, weight), 0f);
    own[4u * at.i + 3u] = vec4<f32>(after(sum_v, a, weight), 0f);
    let x = after(x0, vm.xyz, reach);
    let v = held_in_stage(x, after(v0, a, reach), v0, xw.w, reach, false);
    next[2u * at.i] = vec4<f32>(x, xw.w);
    next[2u * at.i + 1u] = vec4<f32>(v, vm.w);
}

fn stage_1(at: At, xw: vec4<f32>, vm: vec4<f32>) {
    next_stage(at, xw, vm, exact.one, params[ME].half, true);
}

fn stage_2(at: At, xw: vec4<f32>, vm: vec4<f32>) {
    next_stage(at, xw, vm, 2f, params[ME].half, false);
}

fn stage_3(at: At, xw: vec4<f32>, vm: vec4<f32>) {
    next_stage(at, xw, vm, 2f, params[ME].h, false);
}

fn stage_4(at: At, xw: vec4<f32>, vm: vec4<f32>) {
    let kept = own[4u * at.i];
    let v0 = own[4u * at.i + 1u].xyz;
    let f = forces(at, xw.xyz, vm.xyz, vm.w);
    let x = after(kept.xyz, add(own[4u * at.i + 2u].xyz, vm.xyz), params[ME].sixth);
    let slope = add(own[4u * at.i + 3u].xyz, scaled(f, xw.w));
    let v = held_in_stage(x, after(v0, slope, params[ME].sixth), v0, xw.w, params[ME].h, true);
    let motion = arrive(array<vec3<f32>, 2>(x, v), kept.xyz, f, xw.w, kept.w);
    leave(at, motion, xw.w, vm.w);
}

// Finds whether a particle lies on a plane at the start of a substep, for all stages of it.
fn find_resting(at: At, xw: vec4<f32>, vm: vec4<f32>) {
    if plane_below(xw.xyz, xw.w) != 0u {
        note_lies(substep.x);
    }
}
