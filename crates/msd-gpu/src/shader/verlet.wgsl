// Velocity Verlet. Of a particle `own` keeps the velocity between the kicks, its acceleration and
// the one before.

// The first half kick, the drift, and the prediction of the velocity for dampers.
fn begin(
    at: At,
    motion: array<vec3<f32>, 2>,
    now: vec3<f32>,
    before: vec3<f32>,
    w: f32,
    mass: f32,
) {
    let below = plane_below(motion[0], w);
    if below != 0u {
        note_lies(substep.y);
    }
    let v = held(below, after(motion[1], now, params[ME].half), now, params[ME].half, true);
    let predicted = after(v, add(now, before), params[ME].quarter);
    let u = held(below, predicted, now, params[ME].half, false);
    next[2u * at.i] = vec4<f32>(after(motion[0], v, params[ME].h), w);
    next[2u * at.i + 1u] = vec4<f32>(u, mass);
    own[3u * at.i] = vec4<f32>(v, own[3u * at.i].w);
    own[3u * at.i + 1u] = vec4<f32>(now, 0f);
}

// The second half kick and contact.
fn end(at: At, x: vec3<f32>, f: vec3<f32>, now: vec3<f32>, w: f32) -> array<vec3<f32>, 2> {
    let kept = own[3u * at.i];
    let below = plane_below(x, w);
    var v = after(kept.xyz, now, params[ME].half);
    if lies(substep.x) {
        v = held(below, v, now, params[ME].half, false);
    }
    let began = start(x, v, f, w, params[ME].lag, params[ME].h);
    return arrive(array<vec3<f32>, 2>(x, v), began, f, w, kept.w);
}

// The first part of a substep by itself. Forces are evaluated anew at the start of a step and after
// a bounce.
fn first_part(at: At, xw: vec4<f32>, vm: vec4<f32>) {
    var now = own[3u * at.i + 1u].xyz;
    var before = own[3u * at.i + 2u].xyz;
    if substep.y == 0u || bounced(substep.y - 1u) {
        now = scaled(forces(at, xw.xyz, vm.xyz, vm.w), xw.w);
        before = now;
    }
    begin(at, array<vec3<f32>, 2>(xw.xyz, vm.xyz), now, before, xw.w, vm.w);
}

fn last_part(at: At, xw: vec4<f32>, um: vec4<f32>) {
    let f = forces(at, xw.xyz, um.xyz, um.w);
    let now = scaled(f, xw.w);
    let before = own[3u * at.i + 1u];
    leave(at, end(at, xw.xyz, f, now, xw.w), xw.w, um.w);
    own[3u * at.i + 1u] = vec4<f32>(now, 0f);
    own[3u * at.i + 2u] = before;
}

// The last part of a substep and the first of the next, where nothing bounces.
fn both_parts(at: At, xw: vec4<f32>, um: vec4<f32>) {
    let f = forces(at, xw.xyz, um.xyz, um.w);
    let now = scaled(f, xw.w);
    let before = own[3u * at.i + 1u].xyz;
    begin(at, end(at, xw.xyz, f, now, xw.w), now, before, xw.w, um.w);
}
