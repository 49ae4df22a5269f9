#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# Renders the same volumes with this project, with Blender's Cycles and with VTK, and prints a
# Markdown table; docs/independent_truth.md keeps one. Optional: nothing in the build or the tests
# needs it.
#   apt-get install blender python3-vtk9 python3-openimageio python3-numpy
#   tests/truth/compare_truth.py --volume-gi build/bin/volume_gi --data $OCKHAM_DATA_DIR
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
WINDOW = 32  # central pixels of 64 x 64
VIEW = ["--camera", "0,0,2 0,0,0 57.29577951", "--width", "64", "--height", "64"]

# (extinction, albedo, g, sun, volume of the data folder or None: the homogeneous unit cube)
MEDIA = [(4, 1, 0, 0, None), (4, .8, 0, 0, None), (4, .5, 0, 0, None), (4, .8, .6, 0, None),
         (4, 0, 0, 0, None), (2, .8, 0, 0, None),
         (20, 0, 0, 0, "bump64"), (20, .8, 0, 0, "bump64"), (20, .8, 0, math.pi, "bump64")]
SURFACES = [("engine", 110.5), ("brainweb_t1", 60.5), ("bi2o3_c0", 0.3)]


def run(command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def result_of(text):
    lines = [line for line in text.splitlines() if line.startswith("RESULT ")]
    return json.loads(lines[-1][len("RESULT "):])


def window_mean(path):
    """Mean of red over the central window, and the spread of its pixels over their root."""
    import OpenImageIO
    picture = OpenImageIO.ImageInput.open(str(path)).read_image("float")
    first = (picture.shape[0] - WINDOW) // 2
    red = picture[first:first + WINDOW, first:first + WINDOW, 0]
    return float(red.mean()), float(red.std(ddof=1) / WINDOW)


def transfer_file(folder, lowest, highest):
    """Opacity in proportion to the value, so that --density-scale is the extinction at `highest`."""
    path = folder / "transfer.json"
    path.write_text(json.dumps({"points": [
        {"value": lowest, "opacity": 0, "color": [1, 1, 1]},
        {"value": highest, "opacity": 1, "color": [1, 1, 1]}]}))
    return path


def render_medium(arguments, folder, mode, medium, seed):
    extinction, albedo, g, sun, name = medium
    volume = arguments.data / "volumes" / f"{name}.json" if name else "builtin:constant"
    output = folder / "ours.exr"
    run([arguments.volume_gi, volume, "--mode", mode, *VIEW, "--sampler", "independent",
         "--transfer", transfer_file(folder, 0, 1), "--density-scale", extinction,
         "--albedo", albedo, "--phase-g", g, "--steps", arguments.steps, "--quiet",
         "--seed", seed,
         "--environment", "0,0,0" if sun else "1,1,1",
         "--light", f"0,0,-1 {sun},{sun},{sun}", "-o", output])
    return window_mean(output)


def render_cycles(arguments, folder, medium):
    extinction, albedo, g, sun, name = medium
    job = {"extinction": extinction, "albedo": albedo, "g": g, "sun": sun,
           "samples": arguments.samples, "output": str(folder / "cycles.exr")}
    if name:
        job["vdb"] = str(arguments.data / "volumes" / f"{name}.vdb")
    return result_of(run(["blender", "-b", "--factory-startup", "-P", HERE / "cycles_volume.py",
                          "--", json.dumps(job)]))


def compare_media(arguments, folder):
    modes = arguments.modes.split(",")
    print(f"| medium | extinction | albedo | g | light | Cycles | {' | '.join(modes)} |")
    print("| --- " * (6 + len(modes)) + "|")
    for row, medium in enumerate(MEDIA):
        extinction, albedo, g, sun, name = medium
        if name and not arguments.data:
            continue
        cycles = render_cycles(arguments, folder, medium)
        ours = [render_medium(arguments, folder, mode, medium, 100 * row + i)
                for i, mode in enumerate(modes)]
        cells = [f"{mean:.5f} ± {error:.5f}" for mean, error in
                 [(cycles["mean"], cycles["spread_of_mean"]), *ours]]
        print(f"| {name or 'cube'} | {extinction} | {albedo} | {g} | "
              f"{'sun' if sun else 'white'} | {' | '.join(cells)} |", flush=True)


def compare_surfaces(arguments, folder):
    print("| volume | isovalue | pixels | hits | agreement | mean, voxels | p99 | largest |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for name, isovalue in SURFACES:
        sidecar = arguments.data / "volumes" / f"{name}.json"
        about = json.loads(sidecar.read_text())
        x, y, z = about["dims"]
        sizes = [d * s for d, s in zip(about["dims"], about["spacing_mm"])]
        height = sizes[1] / max(sizes)
        depth = folder / "depth.exr"
        # Along +z, a pixel per voxel of x and y, through their centres.
        run([arguments.volume_gi, sidecar, "--mode", "noncaching", "--iso", isovalue,
             "--camera", "0,0,-2 0,0,0 40", "--orthographic", height, "--width", x, "--height", y,
             "--steps", 1, "--quiet", "--capture", f"surface_depth={depth}",
             "-o", folder / "surface.exr"])
        row = result_of(run([sys.executable, HERE / "vtk_surface.py", sidecar, isovalue, depth]))
        print(f"| {name} | {isovalue} | {row['pixels']} | {row['hits']} | "
              f"{100 * row['agreement']:.3f} % | {row['mean']:.2e} | {row['p99']:.2e} | "
              f"{row['max']:.2e} |", flush=True)


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--volume-gi", type=pathlib.Path, required=True)
parser.add_argument("--data", type=pathlib.Path, help="folder of external scenes and volumes")
parser.add_argument("--modes", default="path", help="of volume_gi, by commas")
parser.add_argument("--steps", type=int, default=512, help="samples per pixel of this project")
parser.add_argument("--samples", type=int, default=1024, help="samples per pixel of Cycles")
arguments = parser.parse_args()
with tempfile.TemporaryDirectory() as name:
    compare_media(arguments, pathlib.Path(name))
    if arguments.data:
        print()
        compare_surfaces(arguments, pathlib.Path(name))
