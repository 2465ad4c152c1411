"""The block of `block.toml` in taichi: quadratic B-splines, affine transfers, neo-Hookean, single precision, dense grid."""

import sys
import time

import numpy as np
import taichi as ti

THREADS, SECONDS = int(sys.argv[1]), float(sys.argv[2])
CELLS, EDGE, DENSITY, YOUNG, POISSON = 64, 46, 1000.0, 1.0e5, 0.3
H = 1.0 / CELLS
VOLUME = (0.5 * H) ** 3
MASS = DENSITY * VOLUME
MU = YOUNG / (2.0 * (1.0 + POISSON))
LAMBDA = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
# Half of what Courant's condition allows, as in Cosplat.
STEPS = int(np.ceil(SECONDS / (0.5 * H / np.sqrt((LAMBDA + 2.0 * MU) / DENSITY))))
DT = SECONDS / STEPS

ti.init(arch=ti.cpu, default_fp=ti.f32, cpu_max_num_threads=THREADS, log_level=ti.ERROR, offline_cache=False)
COUNT = EDGE**3
place = ti.Vector.field(3, ti.f32, COUNT)
speed = ti.Vector.field(3, ti.f32, COUNT)
affine = ti.Matrix.field(3, 3, ti.f32, COUNT)
strain = ti.Matrix.field(3, 3, ti.f32, COUNT)
momentum = ti.Vector.field(3, ti.f32, (CELLS,) * 3)
mass = ti.field(ti.f32, (CELLS,) * 3)


@ti.func
def spline(f):
    return ti.Matrix.rows([0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2])


@ti.kernel
def empty():
    for node in ti.grouped(mass):
        mass[node] = 0.0
        momentum[node] = ti.Vector.zero(ti.f32, 3)


@ti.kernel
def scatter():
    for p in place:
        at = place[p] / H
        first = int(at - 0.5)
        f = at - first
        w = spline(f)
        g = strain[p] + DT * affine[p] @ strain[p]
        strain[p] = g
        stress = MU * (g @ g.transpose()) + (LAMBDA * ti.log(g.determinant()) - MU) * ti.Matrix.identity(ti.f32, 3)
        moment = MASS * affine[p] - (4.0 * DT * VOLUME / H**2) * stress
        for i, j, k in ti.static(ti.ndrange(3, 3, 3)):
            node = ti.Vector([i, j, k])
            weight = w[i, 0] * w[j, 1] * w[k, 2]
            momentum[first + node] += weight * (MASS * speed[p] + moment @ ((node - f) * H))
            mass[first + node] += weight * MASS


@ti.kernel
def push():
    for node in ti.grouped(mass):
        if mass[node] > 0.0:
            momentum[node] = momentum[node] / mass[node] - ti.Vector([0.0, 0.0, 9.81 * DT])


@ti.kernel
def gather():
    for p in place:
        at = place[p] / H
        first = int(at - 0.5)
        f = at - first
        w = spline(f)
        v = ti.Vector.zero(ti.f32, 3)
        b = ti.Matrix.zero(ti.f32, 3, 3)
        for i, j, k in ti.static(ti.ndrange(3, 3, 3)):
            node = ti.Vector([i, j, k])
            part = w[i, 0] * w[j, 1] * w[k, 2] * momentum[first + node]
            v += part
            b += part.outer_product(node - f)
        speed[p] = v
        affine[p] = (4.0 / H) * b
        place[p] += DT * v


def start():
    line = 0.5 + ((np.arange(EDGE) + 0.5) / EDGE - 0.5) * EDGE * 0.5 * H
    place.from_numpy(np.stack(np.meshgrid(line, line, line, indexing="ij"), -1).reshape(-1, 3).astype(np.float32))
    speed.fill(0.0)
    affine.fill(0.0)
    strain.from_numpy(np.tile(np.eye(3, dtype=np.float32), (COUNT, 1, 1)))


def run(steps):
    for _ in range(steps):
        empty()
        scatter()
        push()
        gather()
    ti.sync()


start()
run(2)
start()
begun = time.perf_counter()
run(STEPS)
taken = time.perf_counter() - begun
print("RESULT", COUNT, STEPS, taken, float(place.to_numpy()[:, 2].astype(np.float64).mean()))
