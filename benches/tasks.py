#!/usr/bin/env python3
"""Three tasks in msd, MuJoCo and Newton: lines of code and seconds, as in docs/reference/python.md.

    pip install . mujoco newton warp-lang
    python3 benches/tasks.py

Prints the table. The cloth of all is one network of springs in arrays, hung by two corners for a
second in steps of 1/960 s. A task's lines are those below its `def` line; its seconds are processor
time, the least of three calls, with what the engine builds for a call. Newton has compiled its
kernels before, and computes in f32, the others in f64. Rapier has no package for Python.
"""

import inspect
import time
from importlib.metadata import version

import numpy as np

SIDE, SECONDS, STEP = 31, 1.0, 1 / 960
MASS, STIFFNESS, DAMPING, GRAVITY = 0.1, 1000.0, 1.0, 9.82
NUMBER = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
POINTS = 0.1 * np.array([(i, 0, j) for i in range(SIDE) for j in range(SIDE)])
PAIRS = [(NUMBER[1:], NUMBER[:-1]), (NUMBER[:, 1:], NUMBER[:, :-1]),
         (NUMBER[1:, 1:], NUMBER[:-1, :-1]), (NUMBER[1:, :-1], NUMBER[:-1, 1:])]
SPRINGS = np.concatenate([np.stack([a.ravel(), b.ravel()], axis=1) for a, b in PAIRS])
PINS = [0, SIDE * (SIDE - 1)]
STIFFNESSES = [500.0, 1000.0, 2000.0]


def wind(velocities):
    """The force of the second task, newtons: drag in a wind along x."""
    relative = velocities - [2.0, 0, 0]
    return -0.01 * np.linalg.norm(relative, axis=1, keepdims=True) * relative


def msd_hang(stiffness=STIFFNESS, step=STEP):
    net = msd.network(POINTS, SPRINGS, mass=MASS, stiffness=stiffness, damping=DAMPING, pins=PINS)
    run = msd.Simulation(net, step=step, precision="f64")
    run.run(SECONDS)
    return run.positions


def msd_force():
    net = msd.network(POINTS, SPRINGS, mass=MASS, stiffness=STIFFNESS, damping=DAMPING, pins=PINS)
    run = msd.Simulation(net, step=STEP, precision="f64")
    run.add_force(lambda time, positions, velocities: wind(velocities))
    run.run(SECONDS)
    return run.positions


def mujoco_model(stiffness, step):
    point, element = (" ".join(map(str, rows.ravel())) for rows in (POINTS, SPRINGS))
    return mujoco.MjModel.from_xml_string(f"""
      <mujoco><option gravity="0 -{GRAVITY} 0" timestep="{step}"/><size memory="200M"/><worldbody>
      <flexcomp name="cloth" type="direct" dim="1" radius="0.001" mass="{MASS * len(POINTS)}"
        point="{point}" element="{element}"><edge stiffness="{stiffness}" damping="{DAMPING}"/>
        <contact selfcollide="none" contype="0" conaffinity="0"/><pin id="{PINS[0]} {PINS[1]}"/>
      </flexcomp></worldbody></mujoco>""")


def mujoco_hang(stiffness=STIFFNESS, step=STEP):
    model = mujoco_model(stiffness, step)
    data = mujoco.MjData(model)
    for _ in range(round(SECONDS / step)):
        mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_flex(model, data)
    return data.flexvert_xpos.copy()


def mujoco_force():
    model = mujoco_model(STIFFNESS, STEP)
    data = mujoco.MjData(model)
    free = np.setdiff1d(np.arange(len(POINTS)), PINS)
    dofs = model.body_dofadr[model.flex_vertbodyid[free]][:, None] + range(3)
    for _ in range(round(SECONDS / STEP)):
        data.qfrc_applied[dofs] = wind(data.qvel[dofs])
        mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_flex(model, data)
    return data.flexvert_xpos.copy()


def newton_model(stiffness):
    builder = newton.ModelBuilder(up_axis=newton.Axis.Y, gravity=(0, -GRAVITY, 0))
    for row, position in enumerate(POINTS):
        builder.add_particle(wp.vec3(*position), wp.vec3(), 0.0 if row in PINS else MASS,
                             radius=0.001)
    for a, b in SPRINGS:
        builder.add_spring(int(a), int(b), stiffness, DAMPING, control=0.0)
    return builder.finalize(device="cpu")


def newton_hang(stiffness=STIFFNESS, step=STEP):
    model = newton_model(stiffness)
    solver = newton.solvers.SolverSemiImplicit(model)
    now, after, control = model.state(), model.state(), model.control()
    for _ in range(round(SECONDS / step)):
        now.clear_forces()
        solver.step(now, after, control, None, step)
        now, after = after, now
    return now.particle_q.numpy()


def newton_force():
    model = newton_model(STIFFNESS)
    solver = newton.solvers.SolverSemiImplicit(model)
    now, after, control = model.state(), model.state(), model.control()
    for _ in range(round(SECONDS / STEP)):
        now.clear_forces()
        now.particle_f.assign(wind(now.particle_qd.numpy()))
        solver.step(now, after, control, None, STEP)
        now, after = after, now
    return now.particle_q.numpy()


def sweep(hang):
    """The third task, alike in all: the error of each stiffness by a step of a quarter, metres."""
    return [np.abs(hang(k) - hang(k, STEP / 4)).max() for k in STIFFNESSES]


def lines(*functions):
    return sum(len(inspect.getsource(function).splitlines()) - 1 for function in functions)


def seconds(call):
    least = np.inf
    for _ in range(3):
        start = time.process_time()
        answer = call()
        least = min(least, time.process_time() - start)
    return least, answer


def report(name, hang, force, helpers):
    hung, first = seconds(hang)
    pushed, second = seconds(force)
    swept, errors = seconds(lambda: sweep(hang))
    counts = [lines(hang, *helpers), lines(force, *helpers), lines(hang, *helpers) + 1]
    cells = [f"{count}; {spent:.2f}" for count, spent in zip(counts, (hung, pushed, swept))]
    print(f"| {name} | {' | '.join(cells)} |", flush=True)
    print(f"  lowest point {first[:, 1].min():.4f} m, in wind {second[:, 1].min():.4f} m, "
          f"errors {' '.join(f'{error:.1e}' for error in errors)} m")


if __name__ == "__main__":
    import msd
    report(f"msd {msd.__version__}", msd_hang, msd_force, [])
    try:
        import mujoco
        mujoco.set_mju_user_warning(lambda _: None)  # else it writes a log file here
        report(f"MuJoCo {version('mujoco')}", mujoco_hang, mujoco_force, [mujoco_model])
    except ImportError as error:
        print(f"SKIPPED MuJoCo: {error}")
    try:
        import newton
        import warp as wp
        wp.config.quiet = True
        name = f"Newton {version('newton')}, Warp {version('warp-lang')}"
        report(name, newton_hang, newton_force, [newton_model])
    except ImportError as error:
        print(f"SKIPPED Newton: {error}")
