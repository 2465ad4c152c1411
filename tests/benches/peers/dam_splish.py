"""The water of `dam.toml` in SPlisHSPlasH's DFSPH with its own choice of steps and boundary particles."""

import json
import os
import sys
import tempfile
import time

SECONDS, D = float(sys.argv[2]), 0.01
os.environ["OMP_NUM_THREADS"] = sys.argv[1]
import pysplishsplash as sph  # noqa: E402  (it reads the number of threads when it is loaded)

folder = tempfile.mkdtemp()
box = os.path.join(folder, "box.obj")
corners = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
faces = ["1 2 4", "1 4 3", "5 7 8", "5 8 6", "1 5 6", "1 6 2", "3 4 8", "3 8 7", "1 3 7", "1 7 5", "2 6 8", "2 8 4"]
with open(box, "w") as file:
    file.writelines("v {} {} {}\n".format(*corner) for corner in corners)
    file.writelines(f"f {face}\n" for face in faces)
tank = {
    "geometryFile": box, "translation": [0.4, 0.5, 0.2], "scale": [0.8 + D, 1.0 + D, 0.4 + D], "isDynamic": False,
    "isWall": True, "mapInvert": True, "mapThickness": 0.0, "mapResolution": [40, 50, 20],
}
scene = {
    "Configuration": {
        "particleRadius": 0.5 * D, "simulationMethod": 4, "gravitation": [0, -9.81, 0], "timeStepSize": 1e-3,
        "cflMethod": 1, "cflFactor": 0.5, "cflMaxTimeStepSize": 2e-3, "boundaryHandlingMethod": 0, "stopAt": 1e9,
        "enablePartioExport": False, "enableVTKExport": False, "sim2D": False,
        "DFSPH": {"maxIterations": 100, "maxError": 0.01, "enableDivergenceSolver": True},
    },
    "Materials": [{"id": "Fluid", "density0": 1000, "viscosityMethod": 0}],
    "RigidBodies": [tank],
    # A block is filled between its ends less a spacing.
    "FluidBlocks": [{"denseMode": 0, "start": [-0.5 * D] * 3, "end": [0.4 + 0.5 * D] * 3}],
}
path = os.path.join(folder, "scene.json")
with open(path, "w") as file:
    json.dump(scene, file)
base = sph.Exec.SimulatorBase()
base.init(sceneFile=path, useGui=False, useCache=False, outputDir=folder, initialPause=False)
base.setValueFloat(base.STOP_AT, 1e9)
steps, begun = 0, 0.0


def stepped():
    """After each step; the first one, which pays for the beginning, is not counted."""
    global steps, begun
    if begun == 0.0:
        begun = time.perf_counter()
        return
    steps += 1
    fluid = sph.Simulation.getCurrent().getFluidModel(0)
    count = fluid.numActiveParticles()
    if sph.TimeManager.getCurrent().getTime() >= SECONDS:
        taken = time.perf_counter() - begun
        print("RESULT", count, steps, taken, max(fluid.getPosition(i)[0] for i in range(count)), flush=True)
        base.setValueFloat(base.STOP_AT, 0.5 * SECONDS)


base.setTimeStepCB(stepped)
base.run()
