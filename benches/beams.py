#!/usr/bin/env python3
"""The errors of other engines on the clamped beams of docs/measured/beams.md.

    pip install mujoco newton warp-lang pybullet scipy
    python3 benches/beams.py [docs/measured/beams.md]

Prints the tables, with the rows of msd from that page, or puts them into the page. Those of the
docs are of MuJoCo 4.0.0, Newton 1.8.0 (Warp 1.19.0) and PyBullet 3.2.7, on a CPU, in a minute.

Central differences of an engine's own forces about rest make the stiffness matrix. scipy solves for
the deflection and the lowest frequency, with the engine's masses, scaled to the weight of the beam.
Cells have edges of 1 m, exact in f32; relative errors do not depend on the size. Each number must
repeat within 0.001 points at half of the step. All materials have the same E and a Poisson's ratio
of 1/4 near rest: for that, PyBullet needs 4/3 mu and lambda + 5/6 mu (Smith et al., 2018).
"""

import itertools
import sys
import tempfile

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import eigsh, splu

YOUNG, POISSON, DENSITY = 1e5, 0.25, 1000.0
MU, LAMBDA = YOUNG / (2 * (1 + POISSON)), YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
CELLS = (1, 2, 4, 6)
STEP = 1e-3  # of PyBullet, seconds
PAGE = "docs/measured/beams.md"


def timoshenko(cells):
    """Deflection under 1 N and first frequency, as in xtask/src/beam_table.rs."""
    area, length = cells**2, 10 * cells
    bending, shear = YOUNG * area**2 / 12, 5 / 6 * MU * area
    mass, inertia = DENSITY * area, DENSITY * area**2 / 12

    def residual(w):
        # Of deflection, turn, moment and force.
        slope = np.array([[0, 1, 0, 1 / shear], [0, 0, 1 / bending, 0],
                          [0, -inertia * w * w, 0, -1], [-mass * w * w, 0, 0, 0]])
        return np.linalg.det(expm(slope * length)[2:, 2:])

    slender = 3.516 * np.sqrt(bending / (mass * length**4))
    deflection = length**3 / (3 * bending) + length / shear
    return deflection, brentq(residual, 0.8 * slender, 1.01 * slender, xtol=1e-14, rtol=1e-12)


def mujoco_beam(cells, kind):
    """A flexcomp of MuJoCo: positions, masses, and a function of a step to the stiffness."""
    import mujoco

    mujoco.set_mju_user_warning(lambda _: None)  # else it writes a log file here
    long, across = (10 * cells, cells) if kind != "quadratic" else (5 * cells, cells // 2)
    count = "" if kind == "full" else f'cellcount="{long} {across} {across}"'
    model = mujoco.MjModel.from_xml_string(f"""
      <mujoco><option gravity="0 0 0"/><size memory="200M"/><worldbody>
      <flexcomp name="beam" type="grid" dim="3" count="{10 * cells + 1} {cells + 1} {cells + 1}"
        spacing="1 1 1" mass="{DENSITY * 10 * cells**3}" radius="0.001" dof="{kind}" {count}>
        <contact selfcollide="none"/><elasticity young="{YOUNG}" poisson="{POISSON}"/>
      </flexcomp></worldbody></mujoco>""")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    bodies = model.flex_vertbodyid if kind == "full" else model.flex_nodebodyid
    points, dofs = data.xpos[bodies].copy(), model.body_dofadr[bodies][:, None] + range(3)

    def force(moved):
        data.qpos[dofs] = moved
        mujoco.mj_forward(model, data)
        return data.qfrc_passive[dofs].copy()

    reach = 1 + (kind == "quadratic")
    return points, model.body_mass[bodies], lambda step: stiffness(points, force, step, reach)


def newton_grid(cells):
    """A soft grid of Newton, five tetrahedra per cell: the model, positions and corners."""
    import newton
    import warp as wp

    builder = newton.ModelBuilder()
    builder.add_soft_grid(pos=wp.vec3(), rot=wp.quat_identity(), vel=wp.vec3(), dim_x=10 * cells,
                          dim_y=cells, dim_z=cells, cell_x=1.0, cell_y=1.0, cell_z=1.0,
                          density=DENSITY, k_mu=MU, k_lambda=LAMBDA, k_damp=0.0)
    model = builder.finalize(device="cpu")
    return model, model.particle_q.numpy().astype(float), model.tet_indices.numpy().reshape(-1, 4)


def newton_beam(cells, _):
    """The forces of SolverVBD, one tetrahedron at a time: their sum in f32 would be too coarse."""
    import warp as wp
    from newton._src.solvers.vbd import particle_vbd_kernels as vbd
    evaluate = vbd.evaluate_volumetric_neo_hookean_force_and_hessian

    @wp.kernel
    def pull(x: wp.array(dtype=wp.vec3), tets: wp.array2d(dtype=wp.int32),
             poses: wp.array(dtype=wp.mat33), f: wp.array(dtype=wp.vec3)):
        t = wp.tid()
        for corner in range(4):
            force, _hessian = evaluate(t, corner, x, x, tets, poses[t], MU, LAMBDA, 0.0, 1.0)
            f[tets[t, corner]] = force

    model, points, tets = newton_grid(cells)
    corners = points[tets]
    dofs = (3 * tets[:, :, None] + range(3)).reshape(-1, 12)
    own = wp.array(np.arange(tets.size, dtype=np.int32).reshape(-1, 4), device="cpu")

    def force(moved):
        x = wp.array((corners + moved).reshape(-1, 3), dtype=wp.vec3, device="cpu")
        f = wp.zeros(tets.size, dtype=wp.vec3, device="cpu")
        wp.launch(pull, len(tets), [x, own, model.tet_poses], [f], device="cpu")
        return f.numpy().astype(float).reshape(-1, 12)

    def matrix(step):
        moves = step * np.eye(12).reshape(12, 4, 3)
        parts = np.stack([(force(-move) - force(move)) / (2 * step) for move in moves], axis=2)
        # Rounding in f32, 1e-7 of the forces, would resist rigid motions, which cost nothing.
        rigid = [np.cross(axis, corners).reshape(-1, 12) for axis in np.eye(3)]
        rigid += [np.tile(axis, (len(tets), 4)) for axis in np.eye(3)]
        rigid = np.linalg.qr(np.stack(rigid, axis=2))[0]
        others = np.eye(12) - rigid @ rigid.transpose(0, 2, 1)
        cleaned = others @ parts @ others
        assert np.abs(cleaned - parts).max() < 1e-6 * np.abs(parts).max()
        places = np.repeat(dofs, 12, axis=1).ravel(), np.tile(dofs, 12).ravel()
        return coo_matrix((cleaned.ravel(), places), shape=(points.size, points.size)).tocsc()

    return points, model.particle_mass.numpy().astype(float), matrix


def pybullet_beam(cells, _):
    """A soft body of PyBullet on the tetrahedra of Newton: it has no grids of its own."""
    import pybullet

    _, points, tets = newton_grid(cells)
    if not pybullet.isConnected():
        pybullet.connect(pybullet.DIRECT)
    pybullet.resetSimulation(pybullet.RESET_USE_DEFORMABLE_WORLD)
    pybullet.setTimeStep(STEP)
    pybullet.setPhysicsEngineParameter(numSubSteps=1)
    with tempfile.NamedTemporaryFile("w", suffix=".vtk") as file:
        file.write("# vtk DataFile Version 2.0\nbeam\nASCII\nDATASET UNSTRUCTURED_GRID\n")
        np.savetxt(file, points, "%g", header=f"POINTS {len(points)} double", comments="")
        head = f"\nCELLS {len(tets)} {5 * len(tets)}"
        np.savetxt(file, tets, "4 %d %d %d %d", header=head, comments="")
        file.write(f"\nCELL_TYPES {len(tets)}\n" + "10\n" * len(tets))
        file.flush()
        lame = {"NeoHookeanMu": 4 / 3 * MU, "NeoHookeanLambda": LAMBDA + 5 / 6 * MU}
        # A mass of 1 kg for each node.
        body = pybullet.loadSoftBody(file.name, simFileName=file.name, mass=len(points), **lame,
                                     useNeoHookean=1, NeoHookeanDamping=0, collisionMargin=0.001)
    before = np.zeros_like(points)

    def force(moved):
        nonlocal before  # the velocity, which lasts between calls
        pybullet.resetMeshData(body, (points + moved).tolist())
        pybullet.stepSimulation()
        _, after = pybullet.getMeshData(body, -1, flags=pybullet.MESH_DATA_SIMULATION_MESH)
        velocity = (np.array(after) - points - moved) / STEP
        change, before = velocity - before, velocity
        return change / STEP

    return points, np.ones(len(points)), lambda step: stiffness(points, force, step, 1)


def stiffness(points, force, step, reach):
    """By central differences, of all nodes at once with no neighbour in common."""
    place = np.rint(points - points.min(axis=0)).astype(int)
    width = 2 * reach + 1
    node = np.full(place.max(axis=0) + width, -1)
    node[tuple(place.T + reach)] = np.arange(len(points))
    entries = []
    for colour in itertools.product(range(width), repeat=3):
        moved = np.flatnonzero((place % width == colour).all(axis=1))
        for axis in range(3):
            x = np.zeros_like(points)
            x[moved, axis] = step
            slope = (force(-x) - force(x)) / (2 * step)
            for offset in itertools.product(range(width), repeat=3):
                beside = node[tuple((place[moved] + offset).T)]
                column, beside = 3 * moved[beside >= 0] + axis, beside[beside >= 0]
                entries += [(slope[beside, i], 3 * beside + i, column) for i in range(3)]
    entries, *at = (np.concatenate(part) for part in zip(*entries))
    matrix = coo_matrix((entries, at), shape=(points.size, points.size)).tocsc()
    # Equal masses in PyBullet and missed neighbours would show as a lack of symmetry.
    assert abs(matrix - matrix.T).max() < 1e-6 * abs(matrix).max()
    return 0.5 * (matrix + matrix.T)


def errors(cells, beam, step):
    """The errors of the deflection and of the first frequency, per cent."""
    points, mass, matrix = beam
    low, high = points.min(axis=0), points.max(axis=0)
    free = np.flatnonzero(np.repeat(points[:, 0] > low[0] + 0.5, 3))
    at_edge = (np.abs(points - low) < 0.5) | (np.abs(points - high) < 0.5)
    share = (points[:, 0] > high[0] - 0.5) * 0.5 ** at_edge[:, 1:].sum(axis=1)
    load = np.outer(share / share.sum(), [0, 1, 0]).ravel()[free]
    matrix = matrix(step)[free][:, free].tocsc()
    mass = np.repeat(mass * (DENSITY * 10 * cells**3 / mass.sum()), 3)[free]
    square = eigsh(matrix, k=1, M=diags(mass).tocsc(), sigma=0, return_eigenvectors=False)[0]
    values = load @ splu(matrix).solve(load), np.sqrt(square)
    return np.array([100 * (v / exact - 1) for v, exact in zip(values, timoshenko(cells))])


def row(make, kind, step):
    """The errors at each number of cells; a quadratic cell spans two."""
    columns = []
    for cells in CELLS:
        if kind == "quadratic" and cells % 2:
            columns.append("--")
            continue
        beam = make(cells, kind)
        found = errors(cells, beam, step)
        apart = np.abs(found - errors(cells, beam, step / 2)).max()
        print(f"{make.__name__} {kind} {cells}: {found}, {apart:.1e} apart", file=sys.stderr)
        assert apart < 0.001, "the step is too large or too small"
        columns.append(f"{error:+.1f} %" for error in found)
    return list(zip(*columns))


def row_of_msd():
    table = open(PAGE).read().split("<!-- begin beam -->")[1].split("<!-- end beam -->")[0]
    rows = [line.strip("| ").split(" | ") for line in table.split("\n")[3:-1]]
    return list(zip(*(cells for cells in rows if int(cells[0]) in CELLS)))[1:3]


def main(page=None):
    rows = {
        "msd, springs": row_of_msd(),
        "MuJoCo, quadratic hexahedra": row(mujoco_beam, "quadratic", 2**-14),
        "MuJoCo, trilinear hexahedra": row(mujoco_beam, "trilinear", 2**-14),
        "MuJoCo, tetrahedra": row(mujoco_beam, "full", 2**-14),
        "Newton, tetrahedra": row(newton_beam, None, 2**-6),
        "PyBullet, tetrahedra": row(pybullet_beam, None, 2**-12),
    }
    tables = []
    for part, what in enumerate(["deflection", "first frequency"]):
        lines = [f"| {what}, by cells across | {' | '.join(map(str, CELLS))} |\n|{'---|' * 5}"]
        lines += [f"| {name} | {' | '.join(found[part])} |" for name, found in rows.items()]
        tables.append("\n".join(lines) + "\n")
    if page is None:
        return print("\n".join(tables))
    with open(page) as file:
        before, mark, rest = file.read().partition("<!-- begin engines -->\n")
    with open(page, "w") as file:
        file.write(before + mark + "\n".join(tables) + rest[rest.index("<!-- end engines -->"):])


main(*sys.argv[1:])
