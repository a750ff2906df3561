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

Sweep a stiffness, and read the error of a setting, metres:

>>> def after_a_second(stiffness, substeps):
...     run = msd.Simulation(msd.network([[0, 0, 0], [1, 0, 0]], [[0, 1]], pins=[0],
...                                      stiffness=stiffness), substeps=substeps, precision="f64")
...     run.run(1.0)
...     return run.positions
>>> for stiffness in (100, 200, 400):
...     error = abs(after_a_second(stiffness, 16) - after_a_second(stiffness, 1024)).max()
...     print(stiffness, error < 0.02)
100 True
200 True
400 True

`tune` does that for you: it finds the cheapest setting within an error. `study` compares methods and
settings with a reference. `sweep` and `run_cell` run a scene over a grid of its keys, on any engine.

`open`, `scene`, `network` and `mesh` make scenes. `inspect` measures bodies as materials, `report`
writes the page of a study, and `film` draws a run. `help(msd.Simulation)` lists what a run can do.
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
    study,
    sweep,
    tune,
)

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
    "study",
    "sweep",
    "tune",
]

if hasattr(_os, "register_at_fork"):
    _os.register_at_fork(after_in_child=_msd.note_fork)
