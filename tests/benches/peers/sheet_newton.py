"""The silk of `sheet.toml` in newton's XPBD on the CPU, where warp computes on one thread; without self-collision."""

import sys
import time

import newton
import numpy as np
import warp as wp

SECONDS, STEP, ROW, SIDE = float(sys.argv[2]), 4e-4, 100, 1.5
STEPS = round(SECONDS / STEP)
wp.config.quiet = True
wp.set_device("cpu")
cell = SIDE / (ROW - 1)
# Springs without damping: at this step and mass its damping throws the sheet to 170 m.
builder = newton.ModelBuilder()
builder.add_ground_plane()
builder.add_cloth_grid(
    pos=wp.vec3(-0.5 * SIDE, -0.5 * SIDE, 1.0), rot=wp.quat_identity(), vel=wp.vec3(0.0, 0.0, 0.0),
    dim_x=ROW - 1, dim_y=ROW - 1, cell_x=cell, cell_y=cell, mass=4.0 * cell * cell,
    add_springs=True, spring_ke=1e3, spring_kd=0.0, edge_ke=10.0, edge_kd=0.0, particle_radius=0.005,
)
for corner in (0, ROW * ROW - 1):
    builder.particle_mass[corner] = 0.0
model = builder.finalize()
solver = newton.solvers.SolverXPBD(model=model, iterations=10)
collide = newton.CollisionPipeline(model)
contacts = collide.contacts()
now, then, control = model.state(), model.state(), model.control()


def run(steps):
    global now, then
    for _ in range(steps):
        now.clear_forces()
        collide.collide(now, contacts)
        solver.step(now, then, control, contacts, STEP)
        now, then = then, now
    wp.synchronize()


run(2)
begun = time.perf_counter()
run(STEPS)
taken = time.perf_counter() - begun
print("RESULT", ROW * ROW, STEPS, taken, float(np.mean(now.particle_q.numpy()[:, 2])))
