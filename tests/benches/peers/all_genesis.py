"""All three scenes in genesis-world on the CPU: `genesis.py THREADS SECONDS block|dam|sheet`."""

import os
import sys
import tempfile
import time

os.environ["QD_NUM_THREADS"] = sys.argv[1]
import genesis as gs  # noqa: E402  (it reads the number of threads when it is loaded)
import numpy as np  # noqa: E402

SECONDS, SCENE = float(sys.argv[2]), sys.argv[3]
# Seconds of a substep: below what Courant's condition of the block allows; its own figures for water and cloth.
STEP = {"block": 2e-4, "dam": 4e-4, "sheet": 4e-4}[SCENE]
gs.init(backend=gs.cpu, precision="32", logging_level="error")
options = {"sim_options": gs.options.SimOptions(dt=10 * STEP, substeps=10, gravity=(0, 0, -9.81)), "show_viewer": False}
if SCENE == "block":
    options["mpm_options"] = gs.options.MPMOptions(
        particle_size=1 / 128, grid_density=64, lower_bound=(0, 0, 0), upper_bound=(1, 1, 1)
    )
    scene = gs.Scene(**options)
    material = gs.materials.MPM.Elastic(E=1e5, nu=0.3, rho=1000, model="neohooken", sampler="regular")
    body = scene.add_entity(material=material, morph=gs.morphs.Box(pos=(0.5,) * 3, size=(46 / 128,) * 3))
elif SCENE == "dam":
    options["sph_options"] = gs.options.SPHOptions(
        particle_size=0.01, lower_bound=(0, 0, 0), upper_bound=(0.8, 0.4, 1.0), pressure_solver="DFSPH"
    )
    scene = gs.Scene(**options)
    material = gs.materials.SPH.Liquid(sampler="regular")
    body = scene.add_entity(material=material, morph=gs.morphs.Box(pos=(0.2,) * 3, size=(0.4,) * 3))
else:
    row, side = 100, 1.5
    line = np.linspace(-0.5 * side, 0.5 * side, row)
    path = os.path.join(tempfile.mkdtemp(), "sheet.obj")
    with open(path, "w") as file:
        file.writelines(f"v {x} {y} 0\n" for x in line for y in line)
        for q in (i * row + j + 1 for i in range(row - 1) for j in range(row - 1)):
            file.write(f"f {q} {q + row} {q + 1}\nf {q + 1} {q + row} {q + row + 1}\n")
    options["pbd_options"] = gs.options.PBDOptions(particle_size=side / (row - 1))
    scene = gs.Scene(**options)
    scene.add_entity(gs.morphs.Plane())
    body = scene.add_entity(material=gs.materials.PBD.Cloth(), morph=gs.morphs.Mesh(file=path, pos=(0, 0, 1.0)))
scene.build()
if SCENE == "sheet":
    body.fix_particles(particles_idx_local=[0, 9999])


def places():
    return np.array(body.get_particles_pos().cpu()).reshape(-1, 3)


scene.step()
count, steps = len(places()), round(SECONDS / (10 * STEP))
begun = time.perf_counter()
for _ in range(steps - 1):
    scene.step()
x = places()
taken = time.perf_counter() - begun
print("RESULT", count, 10 * (steps - 1), taken, float(x[:, 0].max() if SCENE == "dam" else x[:, 2].mean()))
