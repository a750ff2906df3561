"""Prints how the force at the held end of a rope grows as its other end is pulled away."""

import numpy as np

import msd

count, spacing = 20, 0.05
positions = np.zeros((count, 3))
positions[:, 0] = spacing * np.arange(count)
springs = np.column_stack([np.arange(count - 1), np.arange(1, count)])

rope = msd.network(positions, springs, mass=0.01, stiffness=2000, damping=2, pins=[0, count - 1])
run = msd.Simulation(rope.with_keys({"world.gravity": [0, 0, 0]}), substeps=32)
run.pin(count - 1, velocity=(0.01, 0, 0))

print("stretch, m  force, N")
for _ in range(5):
    run.run(1.0)
    stretch = run.positions[-1, 0] - positions[-1, 0]
    print(f"{stretch:10.4f} {-run.pin_force(0)[0]:9.3f}")
print(f"stiffness of {count - 1} springs in a row: {2000 / (count - 1):.1f} N/m")
