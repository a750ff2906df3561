"""Tuning, studies, inspection and sweeps."""

import os
import pathlib
import pickle
import signal
import sys
import tempfile
import threading
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

import msd

CHAIN = msd.open("chain")
SWEEP = """
version = 1
scene = "chain"
duration = 0.1
error = true
[grid]
"bodies[0].stiffness" = [1000, 2000]
solver.integrator = ["velocity-verlet", "rk4"]
solver.substeps = [16, 32]
"""


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("MSD_CACHE", str(tmp_path / "cache"))


def test_tuning_meets_what_is_asked_and_reports_progress():
    heard = []
    found = msd.tune(CHAIN, 0.1, max_error=0.01, progress=heard.append)
    assert found["met"] and found["verified_error"] <= 0.01
    assert heard and all(isinstance(words, str) for words in heard)


# By its substeps, its tolerance, its Newton iterations; the scene says otherwise.
@pytest.mark.parametrize("goal", [{"max_error": 1e-2}, {"max_error": 1e-5}, {"budget": 1e-4}])
def test_the_settings_of_tuning_have_the_error_that_was_promised(goal):
    scene = CHAIN.with_keys({"solver.step": 1 / 200, "solver.substeps": 3, "solver.newton": 4})
    found = msd.tune(scene, 0.5, **goal)
    assert found["met"] or "budget" in goal
    assert "step" not in found
    run = msd.Simulation(scene, **found["settings"])
    now = run.settings
    assert now["step"] == 1 / 60
    assert found["substeps"] is None or now["step"] / now["substeps"] == found["substep"]
    exact = msd.Simulation(scene, integrator="rk4", substeps=4096, precision="f64")
    off = run.trajectory(30) - exact.trajectory(30)
    error = (off**2).sum(axis=2).mean(axis=1).max() ** 0.5
    uncertainty = found["reference_uncertainty"] + 1e-9
    assert error <= found["verified_error"] + uncertainty
    assert error <= goal.get("max_error", np.inf) + uncertainty
    other = found["runner_up"]
    if other is not None:
        run = msd.Simulation(scene, **other["settings"]).settings
        assert (run["integrator"], run["precision"]) == (other["integrator"], other["precision"])
        assert other["substeps"] in (None, run["substeps"]) and "substep" in other


def test_a_callable_that_raises_ends_a_search():
    def progress(words):
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        msd.tune(CHAIN, 0.1, max_error=0.01, progress=progress)


def test_a_study_has_the_names_and_arrays_of_its_json():
    study = msd.study(CHAIN, 0.1, time=1, fresh=True)
    assert study["scene"] == "chain" and study["trials"]
    assert isinstance(study["times"], np.ndarray)
    assert "error" in study["words"]


def test_the_report_of_a_study_is_a_page(tmp_path):
    study, path = msd.study(CHAIN, 0.1, time=1, fresh=True), tmp_path / "report.html"
    try:
        msd.report(study, path)
    except msd.Error as error:
        assert "this build of msd writes no reports" in str(error)
        return
    page = path.read_text()
    assert page.startswith("<!DOCTYPE html>") and "Error against cost" in page
    with pytest.raises(msd.SceneError, match="this is not a dict of msd.study: "):
        msd.report({}, path)
    with pytest.raises(msd.SceneError, match="no/such"):
        msd.report(study, tmp_path / "no/such/a.html")


def run_a_long_cell(cloth):
    with tempfile.TemporaryDirectory() as folder:
        text = 'version = 1\nscene = "cloth"\nduration = 1e6\n[grid]\nsolver.substeps = [4]'
        msd.run_cell(msd.sweep(write(folder, text))[0])


LONG = [
    lambda cloth: msd.study(cloth, 100, time=10_000, fresh=True),
    lambda cloth: msd.tune(cloth, 100, max_error=1e-9),
    run_a_long_cell,
]


@pytest.mark.parametrize("work", LONG)
def test_ctrl_c_ends_long_work(work):
    cloth = msd.open("cloth")
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        work(cloth)  # minutes to hours


def test_inspection_knows_the_mass():
    body = msd.inspect(CHAIN)["bodies"][0]
    assert body["mass"] == pytest.approx(CHAIN.masses.sum())


def write(folder, text=SWEEP):
    path = pathlib.Path(folder) / "s.toml"
    path.write_text(text)
    return path


def test_cells_are_small_dicts_that_pickle(tmp_path):
    cells = msd.sweep(write(tmp_path))
    assert len(cells) == len(list(cells)) == 8
    assert cells[-1] == cells[7] == pickle.loads(pickle.dumps(cells[7]))
    assert len({cell["hash"] for cell in cells}) == 8
    assert cells[7]["values"]["solver.integrator"] == "rk4"
    with pytest.raises(IndexError, match="there is no cell 8 of 8"):
        cells[8]


def test_a_row_has_the_bits_of_a_run_and_touches_no_folder(tmp_path):
    cells = msd.sweep(write(tmp_path))
    rows = [msd.run_cell(cell) for cell in cells]
    for cell, row in zip(cells, rows):
        run = msd.Simulation(msd.open("chain", cell["values"]))
        run.run(0.1)
        assert row["state_hash"] == run.hash()
        assert row["hash"] == cell["hash"] and row["outcome"] == "finished"
        assert row["rms_error"] > 0
    assert not (tmp_path / "s").exists() and not (tmp_path / "s.csv").exists()


def test_the_errors_of_a_row_are_the_largest_over_time(tmp_path):
    exact = dict(integrator="rk4", substeps=4096, precision="f64")
    for cell in msd.sweep(write(tmp_path)):
        row, scene = msd.run_cell(cell), msd.open("chain", cell["values"])
        off = msd.Simulation(scene).trajectory(6) - msd.Simulation(scene, **exact).trajectory(6)
        squares = (off**2).sum(axis=2)
        # Both references are off by as much as theirs claims, at most; f32 rounds positions here.
        near = dict(rel=1e-3, abs=10 * row["reference_uncertainty"] + 1e-7)
        assert row["rms_error"] == pytest.approx(squares.mean(axis=1).max() ** 0.5, **near)
        assert row["max_error"] == pytest.approx(squares.max() ** 0.5, **near)
        assert row["compared_until"] == row["duration"] == pytest.approx(0.1)


def test_rows_of_a_chaotic_motion_are_compared_for_a_part_of_it(tmp_path):
    # Three particles thrown about by two springs, and less predictable the stiffer they are.
    (tmp_path / "double.toml").write_text("""
version = 1
[[bodies]]
kind = "explicit"
particles = [{position = [0, 0, 0]}, {position = [0.3, 1, 0]}, {position = [0.1, 2, 0]}]
springs = [{ends = [0, 1], stiffness = 200}, {ends = [1, 2], stiffness = 200}]
[[pins]]
particle = 0
""")
    grid = '[grid]\n"bodies[0].springs[0].stiffness" = [200, 1000]\nsolver.substeps = [64, 128]'
    text = 'version = 1\nscene = "double.toml"\nduration = 20\nerror = true\n' + grid
    until = [msd.run_cell(cell)["compared_until"] for cell in msd.sweep(write(tmp_path, text))]
    assert until[0] == until[1] < 20 and until[2] == until[3] < 20
    assert until[0] != until[2]


def test_a_row_is_that_of_the_command_line(tmp_path):
    import csv
    import subprocess

    if (program := os.environ.get("MSD")) is None:
        pytest.skip("MSD names no `msd` program")
    path = write(tmp_path)
    subprocess.run([program, "sweep", path], check=True, capture_output=True)
    with (tmp_path / "s.csv").open() as file:
        table = list(csv.DictReader(file))
    for theirs, cell in zip(table, msd.sweep(path)):
        ours = msd.run_cell(cell)
        assert list(ours) == list(theirs)
        for key, value in ours.items():
            if key in ("cpu_seconds", "cpu_per_second", "wall_seconds") or "updates" in key:
                continue
            assert theirs[key] == ("" if value is None else str(value)) or float(
                theirs[key]
            ) == float(value), key


def test_processes_make_the_rows_of_a_plain_loop(tmp_path):
    cells = list(msd.sweep(write(tmp_path)))
    expected = [msd.run_cell(cell)["state_hash"] for cell in cells]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        assert [row["state_hash"] for row in pool.map(msd.run_cell, cells)] == expected


def needed(module):
    """An engine, or a loud skip."""
    return pytest.importorskip(module, reason=f"SKIPPED {module}: pip install {module}")


def test_joblib_makes_the_rows_of_a_plain_loop(tmp_path):
    joblib = needed("joblib")
    cells = list(msd.sweep(write(tmp_path)))
    expected = [msd.run_cell(cell)["state_hash"] for cell in cells]
    rows = joblib.Parallel(2)(joblib.delayed(msd.run_cell)(cell) for cell in cells)
    assert [row["state_hash"] for row in rows] == expected


GRID = f"""
version = 1
scene = "chain"
duration = 0.05
[grid]
"bodies[0].stiffness" = {[1000 + row for row in range(1000)]}
"""


def thousand(folder):
    cells = list(msd.sweep(write(folder, GRID)))
    assert len(cells) == 1000
    return cells, {cell["hash"]: msd.run_cell(cell)["state_hash"] for cell in cells}


def run_or_die(cell, folder):
    """A row; the process that first comes to cell 300 dies of it."""
    if cell["cell"] == 300:
        try:
            (pathlib.Path(folder) / "died").touch(exist_ok=False)
        except FileExistsError:
            return msd.run_cell(cell)
        os.kill(os.getpid(), signal.SIGKILL)
    return msd.run_cell(cell)


def hashes(rows):
    return {row["hash"]: row["state_hash"] for row in rows}


def test_dask_makes_a_thousand_rows_though_a_worker_dies(tmp_path):
    distributed = needed("distributed")
    cells, expected = thousand(tmp_path)
    with distributed.Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
        futures = client.map(run_or_die, cells, folder=tmp_path)
        rows = client.gather(futures)
        # A second call of the same cells takes the rows that are there.
        again = client.map(run_or_die, cells, folder=tmp_path)
        assert all(future.done() for future in again)
        assert [future.key for future in again] == [future.key for future in futures]
    assert (tmp_path / "died").exists()
    assert len(rows) == 1000 and hashes(rows) == expected


def test_ray_makes_a_thousand_rows_though_a_worker_dies(tmp_path, monkeypatch):
    ray = needed("ray")
    # Its workers cannot import the tests; and they need no token on their own machine.
    ray.cloudpickle.register_pickle_by_value(sys.modules[__name__])
    monkeypatch.setenv("RAY_AUTH_MODE", "disabled")
    cells, expected = thousand(tmp_path)
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        run_cell = ray.remote(max_retries=3)(run_or_die)
        rows = ray.get([run_cell.remote(cell, tmp_path) for cell in cells])
    finally:
        ray.shutdown()
    assert (tmp_path / "died").exists()
    assert len(rows) == 1000 and hashes(rows) == expected
