"""Random calls with strange arguments: an answer or an exception of Python, and never a panic.

MSD_MUTATIONS sets how many calls are made. No target of fuzz/ does this, as libFuzzer would need an
interpreter of Python inside; what reads bytes is fuzzed there already, in msd-scene.
"""

import math
import os
import random

import numpy as np

import msd

CALLS = int(os.environ.get("MSD_MUTATIONS", 4000))
# Calls that wait, or take as long as their numbers say.
LONG = {"step", "run", "trajectory", "tune", "study", "film", "save", "report"}


def strange():
    """Values of all kinds; some of them are right somewhere."""
    array = np.linspace(-1, 1, 15).reshape(5, 3)
    loop = []
    loop.append(loop)
    yield from (0, 1, 2, 4, -1, 2**31, 2**63, 2**64, -(2**63), 10**30, True, None)
    yield from (0.0, 0.5, -1.0, 1e308, 5e-324, math.nan, math.inf, 1j)
    yield from ("", "cloth", "rk4", "auto", "f32", "young", "\0", "\ud800", "a" * 999, b"msd", "é")
    yield from ([], [0], [0, 1, 0], [[0, 1]], [[]], [None], loop, (1, 2, 3), {}, {"a": 1}, {1: 2})
    yield from (array, array.T, array[::-2], np.asfortranarray(array), array.astype(">f4"))
    yield from (array * np.nan, array.astype(int), array > 0, array.astype(object), array[:0])
    yield from (np.array("text"), np.float32(1), np.int8(-3), np.zeros((5, 3)), np.zeros((2, 2, 2)))
    yield from (object(), range(3), range(0, 9, 2), slice(1, None), slice(2), int, len)
    yield from (lambda *some: 0, lambda *some: 1 / 0, msd.open("chain"), run(), set(), {"x": loop})


def run():
    return msd.Simulation(msd.open("chain"))


def callables(one, scene):
    for owner in (msd, one, scene):
        names = msd.__all__ if owner is msd else [name for name in dir(owner) if name[0] != "_"]
        for name in names:
            call = getattr(owner, name)
            if callable(call) and name not in LONG and not isinstance(call, type(msd.Error)):
                yield name, call
    yield "Simulation", msd.Simulation
    yield "_from_bytes", msd.Scene._from_bytes


def test_random_calls_end_in_an_answer_or_an_exception():
    chance, known = random.Random(7), list(strange())
    keywords = ["of", "keys", "pins", "mass", "rest", "step", "substeps", "camera", "width", "x"]
    one, scene = run(), msd.open("chain")
    table = list(callables(one, scene))
    raised = 0
    for _ in range(CALLS):
        name, call = chance.choice(table)
        some = [chance.choice(known) for _ in range(chance.randrange(4))]
        few = chance.sample(keywords, chance.choice([0, 0, 1, 2]))
        try:
            call(*some, **{key: chance.choice(known) for key in few})
        except Exception as error:  # A panic is a BaseException alone.
            assert str(error), (name, some)
            raised += 1
        if chance.random() < 0.02:
            try:
                one.step()
            except Exception:
                one = run()
                table = list(callables(one, scene))
    assert 0 < raised < CALLS
