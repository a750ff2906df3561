"""Measures the binding: what calls, arrays and steps cost. Run it on a quiet machine."""

import os
import signal
import threading
import time

start = time.perf_counter()
import numpy as np

ready = time.perf_counter()
import msd

print(f"| import after numpy | {1e3 * (time.perf_counter() - ready):.1f} ms |")


def best(call, count, rounds=9):
    """Seconds of processor time of a call, the least of several rounds."""
    least = np.inf
    for _ in range(rounds):
        start = time.process_time()
        for _ in range(count):
            call()
        least = min(least, (time.process_time() - start) / count)
    return least


tiny = msd.network([[0, 0, 0], [0, -1, 0]], [[0, 1]], pins=[0])
run = msd.Simulation(tiny, substeps=1)
one, many = best(run.step, 20_000), best(lambda: run.step(20_000), 3) / 20_000
print(f"| binding and release of the GIL, per call | {1e6 * (one - many):.3f} µs |")

for name in ("cloth", "jelly"):
    for precision in ("f32", "f64"):
        run = msd.Simulation(msd.open(name), precision=precision)
        step, positions = best(run.step, 30), best(lambda: run.positions, 1000)
        array = run.positions
        copy = best(array.copy, 1000)
        print(f"| {name} {precision}: a step | {1e6 * step:.0f} µs |")
        print(f"| {name} {precision}: `positions` | {1e6 * positions:.2f} µs |")
        print(f"| {name} {precision}: numpy's copy of it | {1e6 * copy:.2f} µs |")
        pickled = best(lambda: msd.Simulation.from_bytes(run.to_bytes()), 3)
        print(f"| {name} {precision}: a pickle and back, in steps | {pickled / step:.1f} |")

frames = 600
run = msd.Simulation(msd.open("cloth"))
steps = best(lambda: run.copy().step(frames), 1, 3)
whole = best(lambda: run.copy().trajectory(frames), 1, 3)
copies = frames * best(lambda: run.positions, 1000)
print(f"| trajectory(600) beside step(600) and copies | {whole / (steps + copies):.3f} |")

scene = msd.open("cloth")
plain, forced = (msd.Simulation(scene, integrator="symplectic-euler", substeps=16) for _ in range(2))
zero = np.zeros_like(forced.positions, dtype=float)
forced.add_force(lambda time, positions, velocities: zero)
force = (best(forced.step, 30) - best(plain.step, 30)) / 16
print(f"| a callable force, per evaluation of 961 particles | {1e6 * force:.1f} µs |")
rate = len(scene.springs) * 16 / best(plain.step, 100)
print(f"| cloth, symplectic Euler, f32 | {rate / 1e9:.2f} G springs/s |")



def interrupt(threads):
    """Seconds from Ctrl-C to the end of `step`."""
    run, sent = msd.Simulation(msd.open("jelly"), threads=threads), []
    send = lambda: (sent.append(time.perf_counter()), os.kill(os.getpid(), signal.SIGINT))
    threading.Timer(0.2, send).start()
    try:
        run.step(10**12)
    except KeyboardInterrupt:
        return time.perf_counter() - sent[0]


for threads in (1, 2):
    waits = sorted(interrupt(threads) for _ in range(9))
    print(f"| Ctrl-C, threads={threads}: median, longest of 9 | "
          f"{1e3 * waits[4]:.0f}, {1e3 * waits[-1]:.0f} ms |")

try:
    forced.picture()
    print(f"| a second picture of 640 x 480 | {1e3 * best(forced.picture, 1):.0f} ms |")
except msd.Error as error:
    print(f"SKIPPED pictures: {error}")
