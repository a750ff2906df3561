// Explicit Euler, where ahead is false, and symplectic Euler: a dispatch for each substep.

@compute @workgroup_size(64)
fn advance(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let at = place(group, lane);
    if !at.is_there {
        return;
    }
    let xw = state[2u * at.i];
    let vm = state[2u * at.i + 1u];
    let f = forces(at, xw.xyz, vm.xyz, vm.w);
    let v = after(vm.xyz, f, times(xw.w, params[ME].h).x);
    let x = after(xw.xyz, VELOCITY, params[ME].h);
    let began = start(x, v, f, xw.w, params[ME].lag, params[ME].h);
    leave(at, arrive(array<vec3<f32>, 2>(x, v), began, f, xw.w, own[at.i].w), xw.w, vm.w);
}
