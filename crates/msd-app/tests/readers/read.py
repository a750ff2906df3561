"""Reads back what msd exported, with numpy, Arrow, VTK and Blender, and compares it.

usage: read.py FOLDER, with the files of tests/readers/main.rs in it. Ends with a line per format.
"""

import csv
import pathlib
import sys
import xml.etree.ElementTree as tree

import numpy as np

folder = pathlib.Path(sys.argv[1])
# By numpy, against the state file of another run, to the last bit.
run = np.load(folder / "run.npz")
times, positions, velocities = run["times"], run["positions"], run["velocities"]
springs, rest = run["springs"], run["rest_lengths"]
assert positions.dtype == np.float32 and positions.shape == velocities.shape
assert positions.shape == (len(times), len(run["masses"]), 3)
with open(folder / "state.csv") as rows:
    state = list(csv.DictReader(rows))
for axis, name in enumerate("xyz"):
    column = np.array([row[name] for row in state], np.float32)
    speeds = np.array([row["v" + name] for row in state], np.float32)
    assert (positions[-1, :, axis] == column).all() and (velocities[-1, :, axis] == speeds).all()
assert np.allclose(times, np.arange(len(times)) / 30, atol=1e-12)
assert np.abs(positions[-1] - positions[0]).max() > 0.1, "nothing moves"
one = np.load(folder / "state.npz")
assert (one["positions"][0] == positions[-1]).all() and one["times"].shape == (1,)
print("npz")

if (folder / "run.parquet").exists():
    import pyarrow.parquet as parquet

    table = parquet.read_table(folder / "run.parquet").to_pydict()
    assert len(table["time"]) == positions.shape[0] * positions.shape[1]
    for axis, name in enumerate("xyz"):
        assert (np.float32(table[name]).reshape(positions.shape[:2]) == positions[..., axis]).all()
    assert (np.array(table["particle"]) == np.tile(np.arange(positions.shape[1]), len(times))).all()
    print("parquet")

import vtk  # noqa: E402
from vtk.util.numpy_support import vtk_to_numpy  # noqa: E402


def grid(path):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    failures = []
    reader.AddObserver("ErrorEvent", lambda *_: failures.append(path))
    reader.Update()
    assert not failures, failures
    return reader.GetOutput()


def column(data, name):
    return vtk_to_numpy(data.GetArray(name))


collection = tree.parse(folder / "run.pvd").getroot().findall("./Collection/DataSet")
assert np.allclose([float(entry.get("timestep")) for entry in collection], times)
for moment, entry in enumerate(collection):
    found = grid(folder / entry.get("file"))
    assert (vtk_to_numpy(found.GetPoints().GetData()) == positions[moment]).all()
    assert (column(found.GetPointData(), "velocity") == velocities[moment]).all()
    cells, count = found.GetCellData(), len(springs)
    assert [found.GetCellType(cell) for cell in (0, count)] == [vtk.VTK_LINE, vtk.VTK_TRIANGLE]
    across = np.diff(positions[moment][springs].astype(float), axis=1)[:, 0]
    apart = np.diff(velocities[moment][springs].astype(float), axis=1)[:, 0]
    length = np.linalg.norm(across, axis=1)
    strain = length / rest - 1
    assert np.allclose(column(cells, "strain")[:count], strain, atol=1e-9)
    # Hooke's law and the damper, with the numbers of the scene: k = 500 N/m, b = 2 N s/m.
    force = 500 * (length - rest) + 2 * (apart * across).sum(axis=1) / length
    assert np.allclose(column(cells, "force")[:count], force, atol=1e-6)
    assert np.isnan(column(cells, "force")[count:]).all()
last = grid(folder / "state.vtu")
assert (vtk_to_numpy(last.GetPoints().GetData()) == positions[-1]).all()
print("vtu, pvd")

# The particles of surfaces and lines are all but those inside the block.
# VTK's reader of OBJ knows no lines, and so not the four of the rope; Blender's does, below.
for reader, name, unseen in [
    (vtk.vtkOBJReader(), "state.obj", 1 + 4),
    (vtk.vtkPLYReader(), "state.ply", 1),
]:
    reader.SetFileName(str(folder / name))
    reader.Update()
    mesh = reader.GetOutput()
    # Text that is read as double, of numbers in single precision.
    points = vtk_to_numpy(mesh.GetPoints().GetData()).astype(np.float32)
    triangles = mesh.GetNumberOfPolys()
    seen = np.unique(points, axis=0)
    every = np.unique(positions[-1], axis=0)
    assert len(every) - len(seen) == unseen, (name, len(every), len(seen))
    assert np.isin(seen, every).all(), name
    # Two triangles for each square of the cloth and of the six sides of the block.
    assert triangles == 2 * (3 * 2 + 6 * 4), (name, triangles)
print("obj, ply")

import bpy  # noqa: E402


def vertices(thing, frame):
    bpy.context.scene.frame_set(frame)
    found = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array([vertex.co for vertex in found.data.vertices])


for ending in ["pc2", "mdd"]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = 30
    bpy.ops.wm.obj_import(filepath=str(folder / f"{ending}-cache.obj"))
    [thing] = bpy.context.scene.objects
    cache = thing.modifiers.new("run", "MESH_CACHE")
    cache.cache_format = ending.upper()
    cache.filepath = str(folder / f"{ending}-cache.{ending}")
    cache.frame_start = 0
    start = positions[0].astype(float)
    here = np.array([vertex.co for vertex in thing.data.vertices])
    assert len(here) == len(start) - 1
    particle = np.array([np.linalg.norm(start - place, axis=1).argmin() for place in here])
    assert len(set(particle)) == len(here)
    for moment in range(len(times)):
        apart = np.abs(vertices(thing, moment) - positions[moment][particle]).max()
        assert apart < 1e-5, f"{ending}: {apart} m off in frame {moment}"
print("pc2, mdd")

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.context.scene.render.fps = 30
bpy.ops.import_scene.gltf(filepath=str(folder / "run.glb"))
meshes = [thing for thing in bpy.context.scene.objects if thing.type == "MESH"]
assert sorted(thing.name for thing in meshes) == ["block", "links", "rope", "sheet"], meshes
for thing in meshes:
    # Blender's z is up, and so are its meshes. A rope is a tube, a ring of eight for a particle.
    def turned(frame):
        x, y, z = vertices(thing, frame).T
        places = np.stack([x, z, -y], axis=1)
        return places.reshape(-1, 8, 3).mean(axis=1) if thing.name == "rope" else places

    # Blender counts the frames of an animation from its start.
    first = bpy.context.scene.frame_start
    start = positions[0].astype(float)
    particle = [np.linalg.norm(start - place, axis=1).argmin() for place in turned(0)]
    for moment in range(len(times)):
        apart = np.abs(turned(moment) - positions[moment][particle]).max()
        assert apart < 1e-5, f"glb: {thing.name} is {apart} m off in frame {moment}"
print("glb")
