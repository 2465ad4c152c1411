#!/usr/bin/env python3
"""Runs the three scenes of this folder in Cosplat and in the peers that install here, and prints one table.

    python3 tests/benches/peers/compare.py [--threads N] [--cosplat PROGRAM] [--without PEER] [FOLDER]

FOLDER keeps what pip installs, so that a second run is short. See README.md for what is compared.
"""

import argparse
import json
import os
import subprocess
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
# Seconds that are simulated, and the probe of what Cosplat found.
SCENES = {"block": (0.1, "z"), "dam": (0.1, None), "sheet": (0.2, "z")}
# Scene, name, what pip installs, script and its further arguments, and the figure [M particle-substeps/s] where it is
# absent: measured before, on two cores of such a machine.
PEERS = [
    ("block", "taichi", "taichi==1.7.4 numpy<3", ["block_taichi.py"], "4.2 to 4.8"),
    ("block", "genesis-world", "torch genesis-world", ["all_genesis.py", "block"], "4.0"),
    ("dam", "SPlisHSPlasH", "pysplishsplash==2.19.0", ["dam_splish.py"], "0.6 to 0.7"),
    ("dam", "genesis-world", "torch genesis-world", ["all_genesis.py", "dam"], "0.62 (weakly compressible)"),
    ("sheet", "newton, 1 thread", "newton==1.8.0 warp-lang==1.19.0", ["sheet_newton.py"], "0.16"),
    ("sheet", "genesis-world", "torch genesis-world", ["all_genesis.py", "sheet"], "0.31"),
]
PATIENCE_S = {"install": 240, "run": 150}
# What Cosplat runs, with further arguments: genesis's liquid is weakly compressible.
OWN = [
    ("block", "Cosplat", []),
    ("dam", "Cosplat", []),
    ("dam", "Cosplat, weakly compressible", ["--set", "solver.sph.params.pressure=wcsph"]),
    ("sheet", "Cosplat", []),
]


def python(folder, packages):
    """The interpreter of an environment with these packages, or None and why there is none."""
    place = folder / packages.split()[0].split("=")[0]
    found = place / "bin" / "python"
    try:
        if (place / "failed").exists():
            return None, "does not install here"
        if not (place / "complete").exists():
            subprocess.run(["python3", "-m", "venv", place], check=True, capture_output=True)
            command = [found, "-m", "pip", "install", "-q", *packages.split()]
            subprocess.run(command, check=True, capture_output=True, timeout=PATIENCE_S["install"])
            own_libraries(place)
            (place / "complete").touch()
    except (OSError, subprocess.SubprocessError):
        place.mkdir(exist_ok=True)
        (place / "failed").touch()
        return None, "does not install here"
    return found, ""


def own_libraries(place):
    """Lets SPlisHSPlasH, whose wheel brings its own parts of OpenGL and crashes beside others, use those of the system."""
    for bundled in place.glob("lib/*/site-packages/pysplishsplash.libs/lib*-*.so*"):
        system = sorted(Path("/usr/lib/x86_64-linux-gnu").glob(bundled.name.split("-")[0] + ".so.?"))
        if system and "GL" in bundled.name:
            bundled.unlink()
            bundled.symlink_to(system[0])


def peer(folder, threads, scene, packages, script):
    """Particles, substeps, seconds and result of a peer, or why there are none."""
    interpreter, why = python(folder, packages)
    if interpreter is None:
        return why
    command = [interpreter, HERE / script[0], str(threads), str(SCENES[scene][0]), *script[1:]]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S["run"])
    except subprocess.TimeoutExpired:
        return f"takes more than {PATIENCE_S['run']} s"
    line = [line for line in done.stdout.splitlines() if line.startswith("RESULT")]
    if not line:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        return f"ends with {done.returncode}: {last[:80]}"
    particles, steps, seconds, result = line[0].split()[1:]
    return int(particles), int(steps), float(seconds), float(result)


def own(cosplat, threads, scene, further):
    """The same of Cosplat: seconds are those of the run without its beginning."""
    with tempfile.TemporaryDirectory() as place:
        out = Path(place) / "out"
        command = [cosplat, "run", HERE / f"{scene}.toml", "--threads", str(threads), "--out", out, *further]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            return f"ends with {done.returncode}, see `cosplat run {scene}.toml`"
        summary = json.loads((out / "summary.json").read_text())
        rows = (out / "probes.csv").read_text().splitlines()
    last = dict(zip(rows[0].split(","), rows[-1].split(",")))
    axis = SCENES[scene][1]
    column = [name for name in last if name.startswith("result") and (axis is None or name.endswith(axis))][0]
    particles = {"block": 46**3, "dam": 40**3, "sheet": 100**2}[scene]
    process = summary["processes"][0]
    return particles, process["substeps"], process["compute_s"], float(last[column])


def row(scene, name, found, known):
    """A row of the table."""
    if isinstance(found, str):
        absent = f"({known})" if known else ""
        return f"| {scene} | {name} | {found} | | | {absent} | | |"
    particles, steps, seconds, result = found
    rate = particles * steps / seconds / 1e6
    return f"| {scene} | {name} | {particles} | {steps} | {seconds:.2f} | {rate:.2f} | {seconds / SCENES[scene][0]:.0f} | {result:.4f} |"


def main():
    """Prints the table."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--threads", type=int, default=2)
    built = Path(os.environ.get("CARGO_TARGET_DIR", "target")) / "release" / "cosplat"
    arguments.add_argument("--cosplat", default=built, type=Path)
    arguments.add_argument("--without", action="append", default=[], help="name of a peer to leave out")
    arguments.add_argument("folder", nargs="?", default="out/peers", type=Path)
    given = arguments.parse_args()
    if not given.cosplat.is_file():
        arguments.error(f"there is no program {given.cosplat}: build it with `cargo build --release`, or name it with --cosplat")
    given.folder.mkdir(parents=True, exist_ok=True)
    print("| scene | program | particles | substeps | s | M particle-substeps/s | s per simulated s | result |")
    print("|---|---|---|---|---|---|---|---|")
    for scene in SCENES:
        for _, name, further in (o for o in OWN if o[0] == scene):
            print(row(scene, name, own(given.cosplat, given.threads, scene, further), ""), flush=True)
        for _, name, packages, script, known in (p for p in PEERS if p[0] == scene):
            left_out = "left out" if name.split(",")[0] in given.without else ""
            found = left_out or peer(given.folder.resolve(), given.threads, scene, packages, script)
            print(row(scene, name, found, known), flush=True)


main()
