// Data of a step, and what all methods share: forces, planes, and the guard. Several instances of
// scenes lie one after the other, each from the start of a slice of 64 particles.

struct Plane {
    normal: vec4<f32>,
    law: vec4<f32>,
}
// What an instance does not share with others.
struct Params {
    gravity: vec4<f32>,
    force: vec4<f32>,
    // A substep, its half, quarter and sixth, seconds.
    h: f32,
    half: f32,
    quarter: f32,
    sixth: f32,
    drag: f32,
    // Seconds by which velocities are ahead of the displacement of a substep.
    lag: f32,
    // Bits of the largest coordinate and of the largest speed.
    extent: u32,
    speed: u32,
    // Particles, planes and grabs.
    count: u32,
    planes: u32,
    grabs: u32,
    substeps: u32,
    // Places of its first particle, law, grab, flag and bend.
    first: u32,
    laws_at: u32,
    grabs_at: u32,
    flags_at: u32,
    bends_at: u32,
    unused: array<u32, 3>,
    list: array<Plane, MOST_PLANES>,
}
@group(0) @binding(1) var<storage, read> params: array<Params>;
// Of each slice its first and last group, its instance and its lists of bends; of each group its
// first and last row; rows, and the numbers of rows that name their springs: see `rows.rs`; lists of
// bends: see `bends.rs`.
@group(0) @binding(2) var<storage, read> topology: array<u32>;
// The bits of rest length, stiffness and damping of springs; of each bend its particles, and the
// bits of their weights and of its law; of each grab the bits of its goal, its particle, and the
// bits of its law.
@group(0) @binding(3) var<storage, read> numbers: array<vec4<u32>>;
// Of each particle its position and reciprocal mass, and its velocity and mass.
@group(1) @binding(0) var<storage, read> state: array<vec4<f32>>;
@group(1) @binding(1) var<storage, read_write> next: array<vec4<f32>>;
// What the method keeps of each particle. The fourth number of the first is its stiffness.
@group(1) @binding(2) var<storage, read_write> own: array<vec4<f32>>;
// Of each instance whether a step was refused, the number of steps begun, and for each substep
// whether a particle lies on a plane at its start and whether one bounced at its end.
@group(1) @binding(3) var<storage, read_write> flags: array<atomic<u32>>;
// The state at the start of the last step begun.
@group(1) @binding(4) var<storage, read_write> good: array<vec4<f32>>;
@group(2) @binding(0) var<uniform> substep: vec4<u32>;

// The instance of a thread, where there are several.
var<private> me: u32;

const REFUSED = 0u;
const BEGUN = 1u;
const LIES = 2u;

fn flag(number: u32) -> u32 {
    return params[ME].flags_at + number;
}
fn refuse() {
    atomicStore(&flags[flag(REFUSED)], 1u);
}
fn lies(number: u32) -> bool {
    return atomicLoad(&flags[flag(LIES + number)]) != 0u;
}
fn note_lies(number: u32) {
    if number < params[ME].substeps {
        atomicStore(&flags[flag(LIES + number)], 1u);
    }
}
fn bounced(number: u32) -> bool {
    return atomicLoad(&flags[flag(LIES + params[ME].substeps + number)]) != 0u;
}

struct At {
    i: u32,
    slice: u32,
    lane: u32,
    // Whether the thread has a particle and the run goes on.
    is_there: bool,
}
fn place(group: vec3<u32>, lane: u32) -> At {
    let slice = group.y * 65535u + group.x;
    let i = slice * 64u + lane;
    // Beyond the last slice there are groups without particles.
    let is_slice = slice < substep.z;
    me = topology[4u * select(0u, slice, is_slice) + 2u];
    let is_particle = is_slice && i - params[ME].first < params[ME].count;
    return At(i, slice, lane, is_particle && atomicLoad(&flags[flag(REFUSED)]) == 0u);
}

// All forces on a particle: the fields, then the springs in the order of the sums of the core, then
// the bends and the grabs.
fn forces(at: At, x: vec3<f32>, v: vec3<f32>, mass: f32) -> vec3<f32> {
    var f = field(params[ME].gravity.xyz, params[ME].force.xyz, mass, params[ME].drag, v);
    let last = topology[4u * at.slice + 1u];
    for (var g = topology[4u * at.slice]; g < last; g += 2u) {
        let start = topology[g];
        let end = topology[g + 1u];
        // Added to the force one by one, or summed on their own first.
        let direct = (start & 0x80000000u) != 0u;
        var sum = select(vec3<f32>(0f), f, direct);
        for (var r = start & 0x7fffffffu; r < end; r += 4u) {
            let way = topology[r];
            let law = topology[r + 1u];
            var other = at.i;
            var number = law;
            if (law & 0x80000000u) != 0u {
                other = at.i + topology[way + at.lane];
                number = topology[way + 64u + at.lane];
            } else {
                let mask = topology[r + 2u + (at.lane >> 5u)];
                other = select(at.i, at.i + way, ((mask >> (at.lane & 31u)) & 1u) != 0u);
            }
            let material = bitcast<vec3<f32>>(numbers[params[ME].laws_at + number].xyz);
            let there = 2u * other;
            sum = subtract(sum, pull(x, v, state[there].xyz, state[there + 1u].xyz, material));
        }
        f = select(add(f, sum), sum, direct);
    }
    BENDS
    for (var g = 0u; g < params[ME].grabs; g++) {
        let hand = params[ME].grabs_at + 2u * g;
        if numbers[hand].w == at.i - params[ME].first {
            let goal = bitcast<vec3<f32>>(numbers[hand].xyz);
            f = add(f, grab(x, v, goal, bitcast<vec3<f32>>(numbers[hand + 1u].xyz)));
        }
    }
    return f;
}

// The plane that a particle lies on, from 1, or 0. One on several planes is left to the processor.
fn plane_below(x: vec3<f32>, w: f32) -> u32 {
    var found = 0u;
    for (var n = 0u; n < params[ME].planes && w != 0f; n++) {
        let p = params[ME].list[n];
        let there = at_plane(p.normal.xyz, p.normal.w, p.law.xyz, x);
        if there.x != 0f && there.y == 0f {
            if found != 0u {
                refuse();
            }
            found = n + 1u;
        }
    }
    return found;
}

// A velocity after a kick of a particle on a plane.
fn held(below: u32, v: vec3<f32>, a: vec3<f32>, length: f32, loses: bool) -> vec3<f32> {
    if below == 0u {
        return v;
    }
    let p = params[ME].list[below - 1u];
    var settled = settle(p.normal.xyz, p.normal.w, p.law.xyz, v, a, length, params[ME].h);
    if loses {
        settled = settle_losing(p.normal.xyz, p.normal.w, p.law.xyz, v, a, length, params[ME].h);
    }
    return select(v, settled[0], settled[1].x != 0f);
}

// Position and velocity of a particle at the end of a substep that `began` there, after the
// planes that it is in. One in several is left to the processor.
fn arrive(motion: array<vec3<f32>, 2>, began: vec3<f32>, f: vec3<f32>, w: f32, stiffness: f32)
    -> array<vec3<f32>, 2> {
    var near = 0u;
    var is_inside = false;
    for (var n = 0u; n < params[ME].planes && w != 0f; n++) {
        let p = params[ME].list[n];
        let there = at_plane(p.normal.xyz, p.normal.w, p.law.xyz, motion[0]);
        near += u32(there.x != 0f);
        is_inside = is_inside || there.INSIDE != 0f;
    }
    if !is_inside {
        return motion;
    }
    var end = motion;
    var met = 0u;
    for (var n = 0u; n < params[ME].planes; n++) {
        let p = params[ME].list[n];
        let after_it = MEET(p.normal.xyz, p.normal.w, p.law.xyz, end[0], end[1], began, f, w,
            stiffness, params[ME].h, params[ME].lag);
        if after_it[2].x != 0f {
            met++;
            end[0] = after_it[0];
            end[1] = after_it[1];
            if after_it[2].y == 0f {
                atomicStore(&flags[flag(LIES + params[ME].substeps + substep.x)], 1u);
            }
        }
    }
    if near > 1u || met > 1u {
        refuse();
    }
    return end;
}

// Writes the state of a particle at the end of a substep. At the end of a step it must be inside
// the world, and not cross all of it in a substep; a NaN is neither.
fn leave(at: At, motion: array<vec3<f32>, 2>, w: f32, mass: f32) {
    next[2u * at.i] = vec4<f32>(motion[0], w);
    next[2u * at.i + 1u] = vec4<f32>(motion[1], mass);
    if substep.x + 1u == params[ME].substeps {
        let x = bitcast<vec3<u32>>(motion[0]) & vec3<u32>(0x7fffffffu);
        let v = bitcast<vec3<u32>>(motion[1]) & vec3<u32>(0x7fffffffu);
        if any(x > vec3<u32>(params[ME].extent)) || any(v > vec3<u32>(params[ME].speed)) {
            refuse();
        }
    }
}

// The start of a step.
fn begin_step(at: At, xw: vec4<f32>, vm: vec4<f32>) {
    good[2u * at.i] = xw;
    good[2u * at.i + 1u] = vm;
    if at.i == params[ME].first {
        atomicAdd(&flags[flag(BEGUN)], 1u);
    }
}

// Forgets the flags of the substeps of the last step: a group for each instance.
@compute @workgroup_size(64)
fn run_clear_flags(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    me = group.y * 65535u + group.x;
    if me >= substep.w {
        return;
    }
    for (var n = lane; n < 2u * params[ME].substeps; n += 64u) {
        atomicStore(&flags[flag(LIES + n)], 0u);
    }
}
