"""Elastic things as particles joined by springs and dampers, and what accuracy costs.

Hang a cloth for a second, and read where its particles are:

>>> import msd
>>> cloth = msd.open("cloth", {"bodies[0].stiffness": 300})
>>> run = msd.Simulation(cloth, integrator="rk4", substeps=16)
>>> run.run(1.0)
>>> run.positions.shape
(961, 3)

`msd.scenes` lists the built-in scenes, and `msd.integrators` the methods. Units are SI, y is up, and
arrays are copies: they are yours to keep and change.

Make a network of springs from arrays, and add a force of your own:

>>> rope = msd.network([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1], [1, 2]], mass=0.1, pins=[0])
>>> run = msd.Simulation(rope)
>>> run.add_force(lambda time, positions, velocities: -0.1 * velocities)
>>> run.run(1.0)
>>> run.energy()["dissipated"] > 0
True

Sweep a stiffness, and read the error of a setting, metres: the largest over time of the root mean
square (rms) over particles.

>>> def second(stiffness, substeps):
...     run = msd.Simulation(msd.network([[0, 0, 0], [1, 0, 0]], [[0, 1]], pins=[0],
...                                      stiffness=stiffness), substeps=substeps, precision="f64")
...     return run.trajectory(60)
>>> for stiffness in (100, 200, 400):
...     off = second(stiffness, 16) - second(stiffness, 1024)
...     error = (off**2).sum(axis=2).mean(axis=1).max() ** 0.5
...     print(stiffness, error < 0.02)
100 True
200 True
400 True

`tune` finds the cheapest setting whose error, the largest over time of the rms over particles, is
within a bound; single particles may be further off. `study` compares methods and settings with a
reference. `sweep` and `run_cell` run a scene over a grid of its keys, on any engine.

`open`, `scene`, `network` and `mesh` make scenes, and `schema` describes their keys. `inspect`
measures bodies as materials, `report` writes the page of a study, and `film` draws a run.
`help(msd.Simulation)` lists what a run can do. `from msd import *` replaces the builtin `open`.
"""

import os as _os

from . import _msd
from ._msd import (
    Error,
    Scene,
    SceneError,
    Simulation,
    StepError,
    Sweep,
    __version__,
    film,
    inspect,
    integrators,
    mesh,
    network,
    open,
    report,
    run_cell,
    scene,
    scenes,
    schema,
    study,
    sweep,
    tune,
)

# `open` as in gzip and io: `help(msd)` shows only names of this list.
__all__ = [
    "Error",
    "Scene",
    "SceneError",
    "Simulation",
    "StepError",
    "Sweep",
    "__version__",
    "film",
    "inspect",
    "integrators",
    "mesh",
    "network",
    "open",
    "report",
    "run_cell",
    "scene",
    "scenes",
    "schema",
    "study",
    "sweep",
    "tune",
]

if hasattr(_os, "register_at_fork"):
    _os.register_at_fork(after_in_child=_msd.note_fork)
