// Explicit and symplectic Euler, by the velocity of the drift: a dispatch for each substep.

fn advance(at: At, xw: vec4<f32>, vm: vec4<f32>) {
    let f = forces(at, xw.xyz, vm.xyz, vm.w);
    let v = after(vm.xyz, f, times(xw.w, params[ME].h).x);
    let x = after(xw.xyz, VELOCITY, params[ME].h);
    let began = start(x, v, f, xw.w, params[ME].lag, params[ME].h);
    leave(at, arrive(array<vec3<f32>, 2>(x, v), began, f, xw.w, own[at.i].w), xw.w, vm.w);
}
