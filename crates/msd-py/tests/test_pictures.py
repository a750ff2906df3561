"""Pictures and films: those of the command line, and what is refused.

Without any graphics driver each test says that it skips, unless MSD_REQUIRE_ADAPTER is set.
"""

import os
import signal
import struct
import subprocess
import threading
import zlib

import numpy as np
import pytest

import msd

MSD = os.environ.get("MSD")


def run_of(name="chain", steps=0):
    run = msd.Simulation(msd.open(name))
    run.step(steps)
    return run


def draws():
    """Whether a picture can be drawn; nothing will not do where CI has a driver."""
    try:
        run_of().picture(8, 8)
    except msd.Error as error:
        assert "MSD_REQUIRE_ADAPTER" not in os.environ, error
        print(f"SKIPPED: {error}")
        return False
    return True


drawn = pytest.mark.skipif(not draws(), reason="no graphics driver, or a build without pictures")


def read_png(data):
    """The pixels of a PNG of 8 bits with opacity, (h, w, 4)."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    width, height, depth, colours = struct.unpack(">IIBB", data[16:26])
    assert (depth, colours) == (8, 6)
    at, packed = 8, b""
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        if data[at + 4 : at + 8] == b"IDAT":
            packed += data[at + 8 : at + 8 + length]
        at += 12 + length
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 4 * width)
    pixels = np.zeros((height + 1, width + 1, 4), np.int64)
    for y, row in enumerate(rows):
        filtered = row[1:].reshape(width, 4).astype(np.int64)
        line, above = pixels[y + 1], pixels[y]
        for x in range(width):
            left, up, corner = line[x], above[x + 1], above[x]
            if row[0] == 4:
                distance = np.abs([up - corner, left - corner, left + up - 2 * corner])
                near = np.where(distance[1] <= distance[2], up, corner)
                is_left = (distance[0] <= distance[1]) & (distance[0] <= distance[2])
                guess = np.where(is_left, left, near)
            else:
                guess = [0 * left, left, up, (left + up) // 2][row[0]]
            line[x + 1] = (filtered[x] + guess) % 256
    return pixels[1:, 1:].astype(np.uint8)


@drawn
def test_a_picture_has_its_shape_and_shows_something():
    image = run_of().picture(64, 48)
    assert image.shape == (48, 64, 4) and image.dtype == np.uint8
    assert (image[..., 3] > 0).all() and len(np.unique(image[..., 0])) > 3
    assert run_of().picture().shape == (480, 640, 4)


@drawn
@pytest.mark.skipif(MSD is None, reason="MSD names no `msd` program")
@pytest.mark.parametrize("name, options, keywords", [
    ("cloth", [], {}),
    ("square", ["--camera", "top"], {"camera": "top"}),
    ("jelly", ["--yaw-deg", "30", "--pitch-deg", "10"], {"camera": (30, 10)}),
    ("cloth", ["--colour-by", "speed", "--background", "none"],
     {"colour": "speed", "background": False}),
])  # fmt: skip
def test_a_picture_is_that_of_the_command_line(tmp_path, name, options, keywords):
    out = tmp_path / "a.png"
    command = [MSD, "render", name, "--time", "0.25", "--size", "96x72", "--out", out, "-q"]
    subprocess.run(command + options, check=True, capture_output=True)
    run = run_of(name)
    run.run(0.25)
    assert np.array_equal(run.picture(96, 72, **keywords), read_png(out.read_bytes()))


@drawn
def test_sides_colours_and_an_open_background_differ():
    run = run_of("cloth", 10)
    images = [run.picture(64, 48, **keywords) for keywords in (
        {}, {"camera": "top"}, {"camera": (90, 5)}, {"colour": "speed"}, {"background": False},
    )]  # fmt: skip
    assert len({image.tobytes() for image in images}) == len(images)
    assert (images[4][..., 3] == 0).any()


@drawn
def test_a_scene_and_a_run_show_themselves_in_a_notebook():
    scene = msd.open("chain")
    image = read_png(scene._repr_png_())
    assert np.array_equal(image, msd.Simulation(scene).picture())
    assert msd.Simulation(scene)._repr_png_() == scene._repr_png_()
    assert scene._repr_html_() is None


def test_without_pictures_a_scene_shows_a_table():
    table = msd.open("chain")._repr_html_()
    assert draws() or table.startswith("<table><caption>")


@drawn
def test_more_sizes_than_are_kept_are_drawn():
    run = run_of()
    first = run.picture(16, 16)
    for side in range(17, 24):
        run.picture(side, side)
    assert np.array_equal(run.picture(16, 16), first)


@drawn
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_forked_child_draws():
    run = run_of()
    expected = run.picture(32, 24)
    child = os.fork()
    if child == 0:
        os._exit(0 if np.array_equal(run.picture(32, 24), expected) else 1)
    _, status = os.waitpid(child, 0)
    assert status == 0


@drawn
@pytest.mark.parametrize("ending, head", [("webp", b"RIFF"), ("gif", b"GIF89a")])
def test_a_film_takes_the_steps_of_its_frames(tmp_path, ending, head):
    run, other = run_of(), run_of()
    path = tmp_path / f"film.{ending}"
    msd.film(run, 3, path, every=2, width=64, height=48)
    other.step(6)
    assert run.hash() == other.hash() and path.read_bytes().startswith(head)


@drawn
@pytest.mark.skipif(MSD is None, reason="MSD names no `msd` program")
def test_a_film_is_that_of_the_command_line(tmp_path):
    ours, theirs = tmp_path / "a.webp", tmp_path / "b.webp"
    msd.film(run_of(), 4, ours, every=2, width=64, height=48, camera="orbit")
    command = [MSD, "render", "chain", "--frames", f"0:{8 / 60!r}:1/30", "--size", "64x48"]
    command += ["--camera", "orbit", "--out", theirs, "-q"]
    subprocess.run(command, check=True, capture_output=True)
    assert ours.read_bytes() == theirs.read_bytes()


@drawn
def test_the_frames_before_a_failed_step_are_kept(tmp_path):
    run = msd.Simulation(msd.open("cloth", {"bodies[0].stiffness": 1e6}), substeps=4)
    with pytest.raises(msd.StepError):
        msd.film(run, 1000, tmp_path / "%d.png", width=8, height=8)
    assert len(list(tmp_path.iterdir())) == run.steps + 1


@drawn
@pytest.mark.parametrize("threads", [1, 2])
def test_ctrl_c_ends_a_film_as_it_looks_ahead(tmp_path, threads):
    run = msd.Simulation(msd.open("jelly"), threads=threads)
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        msd.film(run, 100_000, tmp_path / "%d.png", every=1000, width=8, height=8)  # hours
    assert run.steps == 0 and not list(tmp_path.iterdir())


@drawn
def test_an_exception_of_a_force_ends_a_film(tmp_path):
    run = run_of()

    def force(t, x, v):
        raise KeyError("mine")

    run.add_force(force)
    with pytest.raises(KeyError, match="mine"):
        msd.film(run, 3, tmp_path / "a.webp", width=8, height=8)


BAD = [
    (lambda: run_of().picture(0, 8), msd.Error, "picture size is 0x8; each side must be from 1"),
    (lambda: run_of().picture(10**9, 8), msd.Error, "each side must be from 1"),
    (lambda: run_of().picture(-1, 8), msd.SceneError, "width is -1; it must be a whole number"),
    (lambda: run_of().picture(camera="behind"), msd.SceneError, "camera must be front, back"),
    (lambda: run_of().picture(camera=(1, 2, 3)), msd.SceneError, "camera is (1, 2, 3); it must"),
    (lambda: run_of().picture(colour="heat"), msd.SceneError, "colour is heat; it must be one"),
    (lambda: msd.film(run_of(), 3, "a.xyz"), msd.SceneError, "unknown extension"),
    (lambda: msd.film(run_of(), 3, "a.png"), msd.SceneError, "needs its number in the name"),
    (lambda: msd.film(run_of(), 3, "no/such/a.webp"), msd.SceneError, "no/such/a.webp"),
    (lambda: msd.film(run_of(), 10**9, "a.webp"), msd.SceneError, "frames is 1000000000; it must"),
    (lambda: msd.film(run_of(), 3, "a.webp", every=0), msd.SceneError, "every is 0; it must be"),
]


@drawn
@pytest.mark.parametrize("bad", BAD, ids=[str(row) for row in range(len(BAD))])
def test_bad_pictures_are_refused_in_a_sentence(bad):
    call, error, words = bad
    with pytest.raises(error) as raised:
        call()
    assert words in str(raised.value)
