"""Scenes and runs: the bits of the command line, closed forms, pickles, threads and forks."""

import copy
import gc
import json
import os
import pickle
import signal
import subprocess
import sys
import sysconfig
import threading
import time
import weakref

import numpy as np
import pytest

import msd

MSD = os.environ.get("MSD")


@pytest.mark.skipif(MSD is None, reason="MSD names no `msd` program")
@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("name", msd.scenes)
def test_hashes_are_those_of_the_command_line(name, precision):
    run = msd.Simulation(msd.open(name), precision=precision)
    steps = 3
    duration = repr(steps * run.settings["step"])
    run.step(steps)
    command = [MSD, "run", name, "--duration", duration, "--precision", precision, "--json", "-q"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert run.hash() == json.loads(done.stdout)["state_hash"]


def test_a_pickle_a_copy_and_a_saved_run_go_on_with_the_same_bits(tmp_path):
    run = msd.Simulation(msd.open("jelly"))
    run.step(5)
    run.save(tmp_path / "run.msd")
    others = [
        pickle.loads(pickle.dumps(run)),
        copy.copy(run),
        run.copy(),
        msd.Simulation.load(tmp_path / "run.msd"),
        msd.Simulation(msd.open(tmp_path / "run.msd")),
    ]
    run.step(5)
    for other in others:
        other.step(5)
        assert other.hash() == run.hash()


def test_a_scene_pickles_with_its_notes_and_keys():
    scene = msd.open("cloth", {"bodies[0].stiffness": 300})
    back = pickle.loads(pickle.dumps(scene))
    assert (back.title, back.notes) == (scene.title, scene.notes)
    back = back.with_keys({"solver.substeps": 4})
    assert back.settings["substeps"] == 4
    assert back.notes[0] == "set bodies[0].stiffness = 300"


def pair(**keys):
    net = msd.network([[-0.6, 0, 0], [0.6, 0, 0]], [[0, 1]], rest=1.0, **keys)
    return net.with_keys({"world.gravity": [0, 0, 0]})


def test_two_particles_swing_as_their_closed_form():
    # The distance d from rest obeys d'' = -2 k d / m.
    run = msd.Simulation(pair(mass=2.0, stiffness=50.0), integrator="rk4", step=1e-3, precision="f64")
    run.step(700)
    length = run.positions[1, 0] - run.positions[0, 0]
    expected = 1 + 0.2 * np.cos(np.sqrt(2 * 50 / 2) * run.time)
    # The error of RK4 is below w^5 t h^4 / 120.
    assert abs(length - expected) < 1e-9


def test_a_network_has_the_defaults_that_its_docstring_gives():
    net = msd.network([[0, 0, 0], [0, -3, 0]], [[0, 1]], pins=[True, False])
    run, settings = msd.Simulation(net), net.settings
    assert repr(net) == "<msd.Scene network: 2 particles, 1 spring>"
    assert "1 substep of a step" in repr(run)
    assert net.masses.tolist() == [1, 1] and net.pins.tolist() == [0]
    assert (settings["integrator"], settings["precision"]) == ("velocity-verlet", "f32")
    assert settings["automatic"] and settings["step"] == 1 / 60
    assert run.forces() == pytest.approx(np.array([[0, -9.82, 0]] * 2), rel=1e-6)
    run.set_state([[0, 0, 0], [0, -3.5, 0]], np.zeros((2, 3)))
    assert run.forces()[1, 1] == pytest.approx(100 * 0.5 - 9.82, rel=1e-6)
    run.set_state([[0, 0, 0], [0, -3, 0]], [[0, 0, 0], [0, -3, 0]])
    assert run.forces()[1, 1] == pytest.approx(-9.82, rel=1e-6)


def test_a_network_far_from_the_origin_runs_in_the_precision_of_a_scene_file_there():
    for far, precision in ((0.0, "f32"), (1e5, "f64")):
        places = [[far, 0, 0], [far + 0.01, 0, 0]]
        net = msd.network(places, [[0, 1]])
        rows = dict(particles=[{"position": place} for place in places], springs=[{"ends": [0, 1]}])
        file = msd.scene({"version": 1, "bodies": [{"kind": "explicit", **rows}]})
        assert net.settings["precision"] == file.settings["precision"] == precision
        assert len(net.notes) == len(file.notes) == (precision == "f64")
        for chosen in ("f32", "f64"):
            again = net.with_keys({"solver.precision": chosen})
            assert again.settings["precision"] == chosen


def test_keywords_replace_what_the_scene_says_as_the_docstring_has_it():
    scene = msd.open("chain", {"solver.step": 1 / 200, "solver.substeps": 3})

    def both(**keys):
        settings = msd.Simulation(scene, **keys).settings
        return [settings["step"], settings["substeps"]]

    assert both() == [1 / 200, 3]
    assert both(substeps=5) == [1 / 60, 5]
    assert both(step=1 / 100) == [1 / 100, 1]


def test_a_run_of_no_seconds_takes_no_step_and_one_of_few_takes_one():
    run = msd.Simulation(msd.open("chain"))
    run.run(0)
    assert run.steps == 0
    run.run(1e-9)
    assert run.steps == 1


def test_a_damped_pair_loses_what_its_damper_takes():
    run = msd.Simulation(pair(damping=3.0), integrator="rk4", step=1e-3, precision="f64")
    before = run.energy()
    run.step(500)
    after = run.energy()
    assert after["dissipated"] > 0
    assert after["total"] == pytest.approx(before["total"], abs=1e-8)
    parts = ("kinetic", "elastic", "gravitational", "dissipated")
    assert after["total"] == pytest.approx(sum(map(after.get, parts)) - after["supplied"])
    # w = sqrt(2 k / m), gamma = c / m: x = A exp(-gamma t) cos(wd t + phase) from rest.
    gamma, w = 3.0, np.sqrt(200.0)
    wd = np.sqrt(w * w - gamma * gamma)
    swing = np.cos(wd * run.time) + gamma / wd * np.sin(wd * run.time)
    expected = 1 + 0.2 * np.exp(-gamma * run.time) * swing
    assert run.positions[1, 0] - run.positions[0, 0] == pytest.approx(expected, abs=1e-8)


def test_a_pendulum_has_the_period_of_its_length():
    # T = 2 pi sqrt(l / g) (1 + a^2 / 16) for a small angle a; the stiff rod stretches by g m / k.
    angle, length, stiffness = 0.05, 1.0, 1e6
    bob = [length * np.sin(angle), -length * np.cos(angle), 0]
    net = msd.network([[0, 0, 0], bob], [[0, 1]], stiffness=stiffness, pins=[0])
    run = msd.Simulation(net, integrator="rk4", step=1e-4 * 4, precision="f64")
    x = run.trajectory(10_000, points=[1])[:, 0, 0]
    falling = np.flatnonzero((x[:-1] > 0) & (x[1:] <= 0))
    at = (falling + x[falling] / (x[falling] - x[falling + 1])) * run.settings["step"]
    expected = 2 * np.pi * np.sqrt(length / 9.82) * (1 + angle**2 / 16)
    assert at[1] - at[0] == pytest.approx(expected, rel=2e-5)


def test_a_planet_returns_after_the_period_of_kepler():
    net = msd.network([[1, 0, 0]], np.empty((0, 2), int))
    net = net.with_keys({"world.gravity": [0, 0, 0]})
    run = msd.Simulation(net, integrator="rk4", step=2 * np.pi / 2000, precision="f64")
    run.add_force(lambda t, x, v: -x / np.linalg.norm(x, axis=1, keepdims=True) ** 3)
    run.set_state([[1, 0, 0]], [[0, 1, 0]])
    run.step(2000)
    # On a circle at speed 1 an angle is a time: the error is that of a period of 2 pi.
    x, y, _ = run.positions[0]
    assert abs(np.arctan2(y, x)) < 1e-6 * 2 * np.pi


def test_the_pins_of_a_hanging_weight_carry_it():
    net = msd.network([[0, 0, 0], [0, -1, 0]], [[0, 1]], mass=[0.5, 2.0], damping=20, pins=[0])
    run = msd.Simulation(net, precision="f64")
    run.run(20)
    assert run.pin_force() == pytest.approx([0, 2.5 * 9.82, 0], abs=1e-6)
    assert run.pin_force([1]) == pytest.approx([0, 0, 0])
    assert run.pin_force(0) == pytest.approx(run.pin_force(range(0, 1)))


def test_an_exception_of_a_force_ends_the_step_and_keeps_the_state():
    run = msd.Simulation(msd.open("chain"))
    run.step(3)
    before = run.hash()

    def force(t, x, v):
        raise KeyError("mine")

    run.add_force(force)
    with pytest.raises(KeyError, match="mine"):
        run.step(5)
    assert (run.hash(), run.steps) == (before, 3)


@pytest.mark.parametrize("of", [np.asfortranarray, np.float32, np.ndarray.tolist])
def test_forces_of_any_order_and_type_act_alike(of):
    runs = [msd.Simulation(msd.open("chain"), precision="f64") for _ in range(2)]
    runs[0].add_force(lambda t, x, v: np.float32(-x))
    runs[1].add_force(lambda t, x, v: of(np.float32(-x)))
    for run in runs:
        run.step(3)
    assert runs[0].hash() == runs[1].hash()


def test_a_force_that_uses_its_run_is_refused():
    run = msd.Simulation(msd.open("chain"))
    run.add_force(lambda t, x, v: run.positions)
    with pytest.raises(msd.Error, match="a force cannot use a run that waits for it"):
        run.step()


def test_a_trajectory_is_the_positions_after_each_step():
    run = msd.Simulation(msd.open("chain"))
    other = run.copy()
    frames = run.trajectory(6, every=2)
    for frame in frames:
        assert np.array_equal(frame, other.positions)
        other.step(2)


def test_arrays_are_copies_in_the_precision_of_the_run():
    run = msd.Simulation(msd.open("chain"), precision="f32")
    before = run.positions
    before[:] = 7
    assert run.positions.dtype == np.float32 and not (run.positions == 7).any()
    for dtype in (np.float32, np.float64):
        out = np.empty(before.shape, dtype)
        run.copy_positions(out)
        assert np.array_equal(out, run.positions)


def test_strides_byte_order_and_integers_are_read():
    run = msd.Simulation(msd.open("chain"), precision="f64")
    x, v = run.positions + 0.25, run.velocities
    for given in (x, np.asfortranarray(x), x[::-1][::-1], x.astype(">f8"), x.tolist()):
        run.set_state(given, v)
        assert np.array_equal(run.positions, x)
    run.set_state(np.ones(x.shape, int), v)
    assert (run.positions == 1).all()


def test_other_threads_go_on_while_a_run_steps():
    run = msd.Simulation(msd.open("jelly"))
    worker = threading.Thread(target=run.step, args=(60,))
    worker.start()
    count = 0
    while worker.is_alive():
        count += 1
    assert count > 100


def test_eight_threads_on_one_run_and_on_eight():
    one = msd.Simulation(msd.open("chain"))
    runs = [one.copy() for _ in range(8)]
    workers = [threading.Thread(target=one.step, args=(50,)) for _ in range(8)]
    workers += [threading.Thread(target=run.step, args=(400,)) for run in runs]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert one.steps == 400
    assert {run.hash() for run in runs} == {one.hash()}


@pytest.mark.parametrize("threads, act", [(1, "step"), (2, "step"), (1, "trajectory")])
def test_ctrl_c_ends_steps_in_a_whole_state(threads, act):
    run = msd.Simulation(msd.open("jelly"), threads=threads)
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        run.step(10**12) if act == "step" else run.trajectory(10**6, points=[0])  # hours
    assert 0 < run.steps
    other = msd.Simulation(msd.open("jelly"))
    other.step(run.steps)
    assert run.hash() == other.hash()


@pytest.mark.skipif(
    not sysconfig.get_config_var("Py_GIL_DISABLED"),
    reason="SKIPPED free-threaded: this CPython is not (python3.14t or later)",
)
def test_a_free_threaded_python_stays_so():
    assert not sys._is_gil_enabled()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.parametrize("threads", [1, 2])
def test_a_forked_child_steps_what_its_parent_stepped(threads):
    keys = dict(size=[32, 32, 32], spacing=0.1, mass=0.1, stiffness=100.0, damping=0.1)
    scene = msd.scene({"version": 1, "bodies": [{"kind": "block", **keys}]})
    assert len(scene.springs) > 300_000
    run = msd.Simulation(scene, threads=threads, substeps=1)
    run.step()
    child = os.fork()
    if child == 0:
        run.step()
        os._exit(0)
    ended, deadline = 0, time.monotonic() + 60
    while ended == 0 and time.monotonic() < deadline:
        ended, status = os.waitpid(child, os.WNOHANG)
        time.sleep(0.01)
    if ended == 0:
        os.kill(child, signal.SIGKILL)
    assert ended == child and status == 0


def test_threads_give_the_same_bits():
    scene = msd.open("jelly", {"bodies[0].size": [20, 20, 20]})
    runs = [msd.Simulation(scene, threads=threads) for threads in (1, 2)]
    for run in runs:
        run.step(2)
    assert runs[0].hash() == runs[1].hash()


def test_a_million_calls_leak_nothing():
    run = msd.Simulation(msd.open("chain"))

    def call(count):
        for _ in range(count):
            run.positions, run.time, run.steps

    def resident():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * 4096

    if not os.path.exists("/proc/self/statm"):
        pytest.skip("no /proc here")
    call(10_000)
    gc.collect()
    before = resident()
    call(330_000)
    gc.collect()
    assert resident() - before < 4_000_000


def test_a_run_and_the_force_that_refers_to_it_are_collected():
    class Witness:
        pass

    def make(copies):
        run, witness = msd.Simulation(msd.open("chain")), Witness()
        witness.run = run
        run.add_force(lambda t, x, v, witness=witness: 0 * x)
        runs = [run.copy() for _ in range(copies)]
        gc.collect()
        for one in [run, *runs]:
            one.step()
        return weakref.ref(witness)

    for copies in (0, 2):
        seen = make(copies)
        gc.collect()
        assert seen() is None, copies


def test_a_copy_keeps_its_force_when_the_run_is_collected():
    run = msd.Simulation(msd.open("chain"), precision="f64")
    run.add_force(lambda t, x, v: 0 * x + 1)
    copy, other = run.copy(), run.copy()
    loop = [run]
    loop.append(loop)
    del run, loop
    gc.collect()
    copy.step()
    del other
    gc.collect()
    before = copy.hash()
    copy.step()
    plain = msd.Simulation(msd.open("chain"), precision="f64")
    plain.step(2)
    assert copy.hash() not in (before, plain.hash())


def test_every_interaction_is_queued():
    scene = msd.open("cloth")
    run = msd.Simulation(scene)
    name = scene.bodies[0]["name"]
    run.grab(3, [0, 1, 0])
    run.release(3)
    run.pin(4)
    run.unpin(4)
    run.push(5, (0, 1, 0))
    run.cut(7)
    run.set_stiffness(500, of=name)
    run.set_damping(0.4, of=range(0, 10))
    run.set_mass(0.2, of=2)
    run.set_rest_length(0.1, of=slice(0, 3))
    run.scale_rest_length(1.01)
    run.freeze()
    run.impulse([0, 0.1, 0])
    run.spin([0, 0.1, 0], of=name)
    run.set_gravity([0, -1.62, 0])
    run.set_force([0, 0, 0.001])
    run.set_drag(0.01)
    run.add_plane(offset=-50)
    run.remove_planes()
    run.scale_material("young", 1.1)
    run.set_relaxation_time(0.001, of=name)
    run.set_look(0, colour=[1, 0, 0])
    run.step()
    assert run.steps == 1
