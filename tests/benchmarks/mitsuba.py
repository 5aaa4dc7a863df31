"""Time to a colour error beside Mitsuba 3: ``python -m tests.benchmarks.mitsuba [--plot error.png]``.

Six matte balls on a matte floor with measured reflectances, a fluorescent point light and a sun, direct light only:
both renderers can express all of it exactly, from the same triangles, normals and spectra. Each is compared with its
own converged picture (mean CIE Delta E 2000, box filter), and the two converged pictures with each other. The times are
processor time of one thread: here from the scene to X, Y, Z, with everything that is built on the way; of Mitsuba the
rendering alone, its scene loaded and its kernels compiled before.

Mitsuba samples wavelengths, four a ray, so that its pictures have colour noise until many samples are taken; here
colour is integrated at 1 nm whatever the samples, and what is left is the smoothness of edges. Of Mitsuba's samplers
the one with the least noise for its time is used. Variant llvm_ad_spectral needs a libLLVM (19 works, 15 does not;
DRJIT_LIBLLVM_PATH names one); where it does not run scalar_spectral does the work, on a smaller picture. Without
Mitsuba (``pip install mitsuba``) the benchmark says so and ends.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import importlib.util
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from spectral_core.colorimetry import observer
from spectral_core.estimate import colour_error
from spectral_core.library import illuminant, reflectance
from spectral_core.lights import PointLight, SunLight
from spectral_core.reflection.materials import TypeI
from spectral_core.renderer import render
from spectral_core.scene import RenderSettings, Scene, World
from tests.render.render_scenes import ball, floor, look_at, placed

ROOT = Path(__file__).parents[2]
ASPECT = 9 / 16
OBSERVER = "cie_1931_2"
BALLS = {
    "light skin": (-2.2, 0.0, 0.7),
    "foliage": (-0.7, -0.4, 0.7),
    "blue flower": (0.8, 0.2, 0.7),
    "orange yellow": (2.3, -0.2, 0.7),
    "purplish blue": (-1.4, 1.6, 0.7),
    "moderate red": (1.5, 1.8, 0.7),
}
EYE, TARGET, HALF_WIDTH = (0.0, -7.5, 3.6), (0.0, 0.3, 0.5), 0.36
LAMP, SUN = ("FL11", (3.0, -4.0, 5.0), 700.0), ("D65", (-0.5, -0.6, 1.2), 1.2)

OUR_SAMPLES, OUR_CONVERGED = (1, 2, 4), 64
SAMPLER, THEIR_SAMPLES = "orthogonal", (4, 9, 25, 49, 121)  # squares of primes, as the sampler wants them
THEIR_PASSES = (1, 2, 4)  # of the largest number
REFERENCE_PASSES = 16
WIDTHS = {"llvm_ad_spectral": 640, "scalar_spectral": 160}  # of the picture, by variant; the fastest first
CIE_Y = 106.7502593994140625  # Mitsuba's own integral of its y function, by which it divides


def our_scene():
    materials = [TypeI(reflectance(name), 0.0) for name in (*BALLS, "neutral 8")]
    instances = [placed(ball(5, number), place, 0.7) for number, place in enumerate(BALLS.values())]
    lights = [
        PointLight(LAMP[1], LAMP[2], illuminant(LAMP[0]), "lamp"),
        SunLight(SUN[1], SUN[2], illuminant(SUN[0]), "sun"),
    ]
    camera = look_at(EYE, TARGET, HALF_WIDTH, HALF_WIDTH * ASPECT)
    return Scene([*instances, placed(floor(20.0, len(BALLS)))], materials, lights, camera, World(illuminant("D65"), 0))


def timed(call, repeats=1):
    """Median processor time of a call, and its last result."""
    taken = []
    for _ in range(repeats):
        start = time.process_time()
        result = call()
        taken.append(time.process_time() - start)
    return float(np.median(taken)), result


def ours(width):
    """Rows (samples, seconds, X, Y, Z) of this renderer."""
    scene = our_scene()
    for samples in (*OUR_SAMPLES, OUR_CONVERGED):
        settings = RenderSettings(width, int(width * ASPECT), samples=samples, pixel_filter="box")
        repeats = 5 if samples in OUR_SAMPLES else 1
        yield (samples, *timed(lambda settings=settings: render(scene, settings).tristimulus(), repeats))


# --- the other side, in a process of its own: a library that does not fit can end it -------------------------------


def spectrum(values, scale=1.0):
    return {
        "type": "regular",
        "wavelength_min": 360.0,
        "wavelength_max": 830.0,
        "values": ", ".join(f"{value:.9g}" for value in values * scale),
    }


def lamp_spectrum(name, scale):
    """Of luminance 1 in Mitsuba's units: that is how lamps are scaled here."""
    sees = observer(OBSERVER)
    nm = np.arange(360.0, 831.0)
    values = illuminant(name).at(nm)
    luminance = values @ np.interp(nm, sees.wavelengths_nm, sees.matching_functions[:, 1])
    return spectrum(values, scale * CIE_Y / luminance)


def their_mesh(mi, instance, material):
    mesh = instance.mesh
    properties = mi.Properties()
    values = material.body_reflectance.at(np.arange(360.0, 831.0))
    properties["bsdf"] = mi.load_dict({"type": "diffuse", "reflectance": spectrum(values)})
    is_smooth = mesh.corner_normals is not None
    made = mi.Mesh(mesh.name, len(mesh.vertices), len(mesh.triangles), has_vertex_normals=is_smooth, props=properties)
    parameters = mi.traverse(made)
    world = mesh.vertices @ instance.matrix[:3, :3].T + instance.matrix[:3, 3]
    parameters["vertex_positions"] = world.astype(np.float32).ravel()
    parameters["faces"] = mesh.triangles.astype(np.uint32).ravel()
    if is_smooth:
        normals = np.zeros_like(mesh.vertices)
        normals[mesh.triangles] = mesh.corner_normals  # a ball: one normal a vertex, and its matrix only scales
        parameters["vertex_normals"] = normals.astype(np.float32).ravel()
    parameters.update()
    return made


def their_scene(mi, width):
    scene = our_scene()
    parts = {
        f"object {k}": their_mesh(mi, instance, material)
        for k, (instance, material) in enumerate(zip(scene.instances, scene.materials, strict=True))
    }
    parts["lamp"] = {
        "type": "point",
        "position": list(LAMP[1]),
        "intensity": lamp_spectrum(LAMP[0], LAMP[2] / (4 * math.pi)),
    }
    parts["sun"] = {
        "type": "directional",
        "direction": [-x for x in SUN[1]],
        "irradiance": lamp_spectrum(SUN[0], SUN[2]),
    }
    film = {"type": "hdrfilm", "width": width, "height": int(width * ASPECT), "rfilter": {"type": "box"}}
    parts["camera"] = {
        "type": "perspective",
        "fov": 2 * math.degrees(math.atan(HALF_WIDTH)),
        "fov_axis": "x",
        "to_world": mi.ScalarTransform4f().look_at(list(EYE), list(TARGET), [0, 0, 1]),
        "film": {**film, "pixel_format": "xyz", "component_format": "float32"},
        "sampler": {"type": SAMPLER},
    }
    parts["integrator"] = {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0, "hide_emitters": True}
    return mi.load_dict({"type": "scene", **parts})


def run_mitsuba(variant, path):
    """Render with Mitsuba, and write rows and the converged picture to a file."""
    import drjit
    import mitsuba as mi

    mi.set_variant(variant)
    mi.set_log_level(mi.LogLevel.Error)
    drjit.set_thread_count(1)
    scene = their_scene(mi, WIDTHS[variant])

    def picture(samples, seed):
        return np.array(mi.render(scene, spp=samples, seed=seed))[..., :3]

    rows = []
    for samples in THEIR_SAMPLES:
        picture(samples, 0)  # compiles
        rows.append((samples, *timed(lambda samples=samples: picture(samples, 1), 3)))
    most, seconds, _ = rows[-1]
    several = [picture(most, 1 + k) for k in range(THEIR_PASSES[-1])]
    rows += [(most * n, seconds * n, np.mean(several[:n], axis=0)) for n in THEIR_PASSES[1:]]
    converged = np.mean([picture(most, 1000 + k) for k in range(REFERENCE_PASSES)], axis=0)
    np.savez(
        path,
        samples=[row[0] for row in rows],
        seconds=[row[1] for row in rows],
        pictures=[row[2] for row in rows],
        converged=converged,
        version=mi.__version__,
        taken=most * REFERENCE_PASSES,
    )


def from_mitsuba():
    """What :func:`run_mitsuba` wrote with the fastest variant that runs, and the name of it; None if none does."""
    for variant in WIDTHS:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "mitsuba.npz"
            command = [sys.executable, "-m", "tests.benchmarks.mitsuba", "--run", variant, str(path)]
            done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
            if done.returncode == 0:
                with np.load(path) as found:
                    return dict(found), variant
            reason = (done.stderr.strip().splitlines() or ["no message"])[-1]
            print(f"variant {variant} does not run here (exit code {done.returncode}): {reason}")
    return None


def seconds_within(errors, seconds, limit=1.0):
    """When the error first is at most the limit, between the measured rows along a straight line in logarithms."""
    below = np.flatnonzero(np.array(errors) <= limit)
    if not len(below):
        return math.inf
    k = int(below[0])
    if k == 0:
        return seconds[0]
    share = math.log(errors[k - 1] / limit) / math.log(errors[k - 1] / errors[k])
    return math.exp((1 - share) * math.log(seconds[k - 1]) + share * math.log(seconds[k]))


def draw(curves, file):
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6, 4), layout="constrained")
    axes = figure.subplots()
    for name, seconds, errors in curves:
        axes.loglog(seconds, errors, "o-", label=name)
    axes.axhline(1.0, color="grey", linestyle=":")
    axes.set(xlabel="processor time, s", ylabel="mean Delta E 2000 from the converged picture")
    axes.legend()
    figure.savefig(file)


def table(name, rows, converged):
    """Print the rows of one renderer; returns its seconds and errors."""
    seconds = [row[1] for row in rows]
    errors = [colour_error(row[2], converged, OBSERVER).mean for row in rows]
    for (samples, taken, _), error in zip(rows, errors, strict=True):
        print(f"| {name} | {samples} | {taken:.3f} | {error:.2f} |", flush=True)
    return seconds, errors


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.mitsuba")
    parser.add_argument("--plot", help="file to draw the errors into")
    parser.add_argument("--run", nargs=2, metavar=("VARIANT", "FILE"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.run:
        run_mitsuba(*options.run)
        return
    if importlib.util.find_spec("mitsuba") is None:
        print("Mitsuba is not installed (pip install mitsuba): skipped")
        return
    found = from_mitsuba()
    if found is None:
        print("no spectral variant of Mitsuba runs here: skipped")
        return
    theirs, variant = found
    name = f"Mitsuba {theirs['version']}, {variant}"
    *our_rows, (_, _, our_converged) = ours(WIDTHS[variant])
    width = WIDTHS[variant]
    print(f"{width} x {int(width * ASPECT)}, one thread; mean Delta E 2000 from each one's own converged picture")
    print("| renderer | samples | seconds | Delta E |\n| --- | --- | --- | --- |")
    our_curve = table("Dichromatic", our_rows, our_converged)
    their_rows = list(zip(theirs["samples"], theirs["seconds"], theirs["pictures"], strict=True))
    their_curve = table(name, their_rows, theirs["converged"])
    ours_within, theirs_within = (seconds_within(errors, seconds) for seconds, errors in (our_curve, their_curve))
    ratio = theirs_within / ours_within
    print(f"within 1: Dichromatic {ours_within:.2f} s, Mitsuba {theirs_within:.2f} s ({ratio:.0f} times as long)")
    apart = colour_error(our_converged, theirs["converged"], OBSERVER)
    print(f"converged pictures ({OUR_CONVERGED} and {theirs['taken']} samples): mean {apart.mean:.2f} from each other")
    if options.plot:
        draw([("Dichromatic", *our_curve), (name, *their_curve)], options.plot)


if __name__ == "__main__":
    main()
