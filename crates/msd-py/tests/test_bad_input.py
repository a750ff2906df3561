"""What is refused: one line each, with the error and a part of its sentence."""

import pickle

import numpy as np
import pytest

import msd

X, S = np.zeros((2, 3)), [[0, 1]]
X[1, 1] = -1
N = 5  # the particles of the scene `chain`


def run():
    return msd.Simulation(msd.open("chain"))


def net(positions=X, springs=S, **keys):
    return msd.network(positions, springs, **keys)


def read_only():
    out = np.empty((N, 3))
    out.flags.writeable = False
    return out


BAD = [
    (lambda: net(np.zeros((2, 2))), msd.SceneError, "positions has the shape (2, 2); it must be (n, 3)"),
    (lambda: net(np.zeros(6)), msd.SceneError, "positions has the shape (6,); it must be (n, 3)"),
    (lambda: net("abc"), msd.SceneError, "positions must hold real numbers"),
    (lambda: net(X.astype(complex)), msd.SceneError, "positions must hold real numbers"),
    (lambda: net([[0, 0, 0], [1, 2]]), msd.SceneError, "positions must be an array of numbers"),
    (lambda: net(np.full((2, 3), np.nan)), msd.SceneError, "position of particle 0 is NaN"),
    (lambda: net(springs=[[0, 2]]), msd.SceneError, "springs names particle 2, but there are only 2"),
    (lambda: net(springs=[[0, -1]]), msd.SceneError, "springs holds -1; indexes are counted from 0"),
    (lambda: net(springs=[[0, 0.5]]), msd.SceneError, "springs must hold whole numbers"),
    (lambda: net(springs=[[1, 1]]), msd.SceneError, "joins particle 1 to itself"),
    (lambda: net(springs=[0, 1]), msd.SceneError, "springs has the shape (2,)"),
    (lambda: net(mass=[1, 2, 3]), msd.SceneError, "mass has the shape (3,); it must be a number or (2,)"),
    (lambda: net(mass=-1), msd.SceneError, "mass of particle 0 is -1; it must be"),
    (lambda: net(stiffness=np.inf), msd.SceneError, "stiffness of spring 0 is inf; it must be"),
    (lambda: net(pins=[7]), msd.SceneError, "pins names particle 7"),
    (lambda: net(pins=np.array([True])), msd.SceneError, "pins has the shape (1,); it must be (2,)"),
    (lambda: net(pins=[True]), msd.SceneError, "pins has the shape (1,); it must be (2,)"),
    (lambda: net().with_keys({"bodies[0].mass": 1}), msd.SceneError, "a network has the keys"),
    (lambda: net([], np.empty((0, 2), int)), msd.SceneError, "the scene has no particles"),
    (lambda: msd.mesh(X, [[0, 1, 9]]), msd.SceneError, "faces names particle 9"),
    (lambda: msd.mesh(X * np.nan, [[0, 1, 1]]), msd.SceneError, "not finite"),
    (lambda: msd.open("cloht"), msd.SceneError, "did you mean `cloth`?"),
    (lambda: msd.open("#scene=cloth"), msd.SceneError, "does not open links"),
    (lambda: msd.open("cloth", {"bodies[0].stifness": 3}), msd.SceneError, "stiffness"),
    (lambda: msd.open("cloth", {"world.gravity": 3}), msd.SceneError, "world.gravity: "),
    (lambda: net().with_keys({"world.gravity": None}), msd.SceneError, "world.gravity is None; to"),
    (lambda: msd.open("cloth", {3: 3}), msd.SceneError, "the key 3 must be a text"),
    (lambda: msd.open("cloth", {"": 3}), msd.SceneError, "must begin with a key of a scene"),
    (lambda: msd.open("cloth", {"world.drag": np.nan}), msd.SceneError, "it must be finite"),
    (lambda: msd.open("cloth", {"world.drag": object()}), msd.SceneError, "of type object"),
    (lambda: msd.scene({"bodies": 3}), msd.SceneError, "bodies"),
    (lambda: msd.scene("version = 2"), msd.SceneError, "version"),
    (lambda: msd.scene(3), msd.SceneError, "a scene is a text or a dict"),
    (lambda: msd.Simulation(msd.open("chain"), substep=3), TypeError, "did you mean `substeps`?"),
    (lambda: msd.Simulation(msd.open("chain"), integrator="rk5"), msd.SceneError, "rk5"),
    (lambda: msd.Simulation(msd.open("chain"), precision="f16"), msd.SceneError, "f32 or f64"),
    (lambda: msd.Simulation(msd.open("chain"), substeps=0), msd.SceneError, "substeps"),
    (lambda: msd.Simulation(msd.open("chain"), substeps=-1), msd.SceneError, "substeps is -1"),
    (lambda: msd.Simulation(msd.open("chain"), step=np.nan), msd.SceneError, "NaN"),
    (lambda: msd.Simulation(msd.open("chain"), threads=0), msd.SceneError, "threads is 0"),
    (lambda: msd.Simulation(msd.open("chain"), newton=2), msd.SceneError, "does not use newton"),
    (lambda: run().step(-1), msd.SceneError, "n is -1; it must be a whole number from 0"),
    (lambda: run().step(10**30), msd.SceneError, f"n is {10**30}; it must be a whole number from 0"),
    (lambda: run().step(1.5), TypeError, "n is of type float; it must be a whole number"),
    (lambda: run().trajectory(1, every=-1), msd.SceneError, "every is -1; it must be"),
    (lambda: run().cut(-1), msd.SceneError, "spring is -1; it must be"),
    (lambda: run().set_mass(1, of=-1), msd.SceneError, "of is -1; it must be"),
    (lambda: run().set_mass(1, of=range(-1, 2)), msd.SceneError, "the start of the range is -1"),
    (lambda: run().set_mass(1, of=[0, 1]), TypeError, "it must be the name of a body, a whole number"),
    (lambda: run().set_stiffness(1, of=range(5)), msd.SceneError, "of names spring 4, but there are only 4"),
    (lambda: run().set_mass(1, of=range(9, 9)), msd.SceneError, f"of names particle 9, but there are only {N}"),
    (lambda: run().run(-1), msd.SceneError, "seconds is -1; it must be"),
    (lambda: run().run(np.nan), msd.SceneError, "seconds is NaN"),
    (lambda: run().trajectory(10**15), MemoryError, "GB; ask for less"),
    (lambda: msd.Simulation(msd.open("cloth")).trajectory(10**9), MemoryError, "GB; ask for less"),
    (lambda: run().trajectory(2**64 - 1), MemoryError, "GB; ask for less"),
    (lambda: run().trajectory(1, points=[N]), msd.SceneError, f"points names particle {N}"),
    (lambda: run().push(10**9, [0, 0, 0]), msd.SceneError, "names particle 1000000000"),
    (lambda: run().push(0, [0, 0]), msd.SceneError, "[0, 0] is not a vector"),
    (lambda: run().push(0, [0, np.nan, 0]), msd.SceneError, "NaN"),
    (lambda: run().set_stiffness(-1), msd.SceneError, "stiffness"),
    (lambda: run().set_stiffness(1, of="chian"), msd.SceneError, "did you mean"),
    (lambda: run().set_stiffness(1, of=range(0, 4, 2)), msd.SceneError, "the step"),
    (lambda: run().set_look(0, color=1), msd.SceneError, "unknown keyword `color`"),
    (lambda: run().pin_force(99), msd.SceneError, "but there are"),
    (lambda: run().copy_positions(np.empty((N, 2))), msd.SceneError, "out has the shape"),
    (lambda: run().copy_positions(np.empty((3, N)).T), msd.SceneError, "contiguous"),
    (lambda: run().copy_positions(np.empty((N, 3), int)), msd.SceneError, "float32 or float64"),
    (lambda: run().copy_positions(read_only()), msd.SceneError, "out cannot be written"),
    (lambda: run().set_state(np.zeros((3, 3)), np.zeros((N, 3))), msd.SceneError, f"({N}, 3)"),
    (lambda: run().set_state(np.full((N, 3), np.nan), np.zeros((N, 3))), msd.SceneError, "NaN"),
    (lambda: run().add_force(3), msd.SceneError, "a force is a callable"),
    (lambda: msd.Simulation.from_bytes(b"msd"), msd.SceneError, "not a saved run"),
    (lambda: msd.Simulation.from_bytes(b"msd saved run, format 3\n"), msd.SceneError, "format 3"),
    (lambda: msd.Simulation.from_bytes(run().to_bytes()[:-1]), msd.SceneError, "the bytes"),
    (lambda: msd.Scene._from_bytes(run().to_bytes()), msd.SceneError, "is a saved run"),
    (lambda: msd.Scene._from_bytes(b"msd pickled scene, format 9\n"), msd.SceneError, "format 9"),
    (lambda: msd.tune(msd.open("chain")), TypeError, "give one of max_error"),
    (lambda: msd.tune(msd.open("chain"), max_error=-1), msd.SceneError, "max_error is -1"),
    (lambda: msd.tune(msd.open("chain"), np.inf, max_error=1), msd.SceneError, "duration is inf"),
    (lambda: msd.sweep("missing.toml"), msd.SceneError, "missing.toml"),
    (lambda: msd.run_cell({}), msd.SceneError, "the cell lacks `values`"),
]


@pytest.mark.parametrize("bad", BAD, ids=[str(row) for row in range(len(BAD))])
def test_bad_input_is_refused_in_a_sentence(bad):
    call, error, words = bad
    with pytest.raises(error) as raised:
        call()
    message = str(raised.value)
    assert words in message
    assert "panicked" not in message


def bad_at(particle, number):
    force = np.zeros((N, 3))
    force[particle, 1] = number
    return force


FORCES = [
    (lambda t, x, v: None, "the force returned None"),
    (lambda t, x, v: x[:1], "what the force returned has the shape (1, 3)"),
    (lambda t, x, v: "abc", "what the force returned must hold real numbers"),
    (lambda t, x, v: bad_at(2, np.nan), "the force returned NaN for particle 2 at t = 0.000000 s"),
    (lambda t, x, v: bad_at(0, -np.inf).tolist(), "the force returned -inf for particle 0 at t"),
]


@pytest.mark.parametrize("force, words", FORCES)
def test_a_force_that_returns_no_forces_is_refused(force, words):
    one = run()
    one.add_force(force)
    with pytest.raises(msd.SceneError) as raised:
        one.step()
    assert words in str(raised.value) and one.steps == 0


def test_a_run_with_a_callable_is_not_saved():
    one = run()
    one.add_force(lambda t, x, v: 0 * x)
    one.copy().step()
    with pytest.raises(msd.Error, match="has 1 force of your own, which"):
        pickle.dumps(one)


def test_a_failed_step_says_where_and_keeps_the_state():
    one = msd.Simulation(msd.open("cloth", {"bodies[0].stiffness": 1e6}), substeps=4)
    with pytest.raises(msd.StepError) as raised:
        one.step(1000)
    error = raised.value
    assert isinstance(error, ArithmeticError) and isinstance(error, msd.Error)
    assert error.step == one.steps + 1 and error.time == one.time
    assert 0 <= error.particle < 961
    assert 0 < error.stable_substep < one.settings["step"] / 4
    assert np.isfinite(one.positions).all()


def test_a_run_that_leaves_the_world_is_not_blamed_on_its_force():
    one = msd.Simulation(msd.open("cloth", {"bodies[0].stiffness": 1e9}), substeps=8)
    one.add_force(lambda t, x, v: 1e-9 * x)
    with pytest.raises(msd.StepError, match="diverged: particle"):
        one.step(1000)


def test_an_error_made_by_hand_has_none_of_what_it_cannot_know():
    error = msd.StepError("mine")
    assert (error.step, error.time, error.particle, error.stable_substep) == (None,) * 4


def test_classes_of_errors_pickle():
    with pytest.raises(msd.SceneError) as raised:
        msd.open("cloht")
    back = pickle.loads(pickle.dumps(raised.value))
    assert type(back) is msd.SceneError and str(back) == str(raised.value)
