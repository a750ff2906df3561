"""Elastic things as particles joined by springs and dampers, and what accuracy costs.

>>> import msd
>>> cloth = msd.open("cloth", {"bodies[0].stiffness": 300})
>>> run = msd.Simulation(cloth, integrator="rk4", substeps=16)
>>> run.step(60)
>>> run.positions.shape
(961, 3)

Make a Scene with `open`, `scene`, `network` or `mesh`, and run it with `Simulation`. `tune` finds
the cheapest setting within an error, `study` what accuracy costs, and `inspect` what bodies amount
to as materials; `report` writes the page of a study. `film` draws a run. `sweep` and `run_cell` run a scene over a grid of its keys.

Units are SI, y is up, and arrays are copies: they are yours to keep and change.
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
