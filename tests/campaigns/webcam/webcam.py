#!/usr/bin/env python3
"""Runs ten kinds of webcam set-ups through the modules of the web page and the slave. References are independent finite
elements and images.

usage: webcam.py [--count N] [--first N] [--only KIND] [--browser] [--faults] [--bin FOLDER] [--keep FOLDER]   (30 set-ups)

Each set-up is rendered, set up by a simulated person with inexact clicks, and processed. Where the page asks for a
strip of tape or another height of the camera, the person follows it once. Prints a line for each set-up, then the
totals. Needs NumPy, SciPy, Gmsh, Pillow and Node.js.
"""
import argparse
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import bodies  # noqa: F401 (limits the threads before NumPy is loaded)
import numpy as np
from PIL import Image

from render import Stage
from setups import KINDS, RATE, Setup

HERE = pathlib.Path(__file__).resolve().parent
MIN_CONTACT_FORCE, MAX_VALID_ERROR = 0.02, 0.10  # relative to the peak: smallest force of a state in contact; largest error of a valid force


def rendered(setup, number, folder):
    """Writes images, true forces and the person's input of a set-up to `folder`."""
    if (folder / "setup.json").exists():
        known = json.loads((folder / "setup.json").read_text())
        (folder / "setup.json").write_text(json.dumps({**known, **setup.clicks(number)}))
        return
    frames = folder / "frames"
    frames.mkdir(parents=True, exist_ok=True)
    tips, press = setup.press()
    stage = Stage(setup, np.random.default_rng(number))
    with open(folder / "truth.csv", "w") as file:
        file.write("force\n" + "".join(f"{force:.9g}\n" for force, _ in press))
    for i, (tip, (_, outline), gain) in enumerate(zip(tips, press, setup.gains(len(tips)))):
        (frames / f"{i:06d}.jpg").write_bytes(stage.image(tip, outline, gain))
    first = Image.open(frames / "000000.jpg").convert("RGBA")
    (folder / "frozen.rgba").write_bytes(first.tobytes())
    known = {**setup.clicks(number), "size": first.size, "first": "frames/000000.jpg", "remedies": setup.remedies}
    (folder / "setup.json").write_text(json.dumps(known))


class Program:
    """A program in the background that prints `words` before its address."""

    def __init__(self, words, *command):
        self.process = subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        for line in self.process.stdout:
            if words in line:
                self.address = line.split(words)[1].split()[0]
                return
        raise RuntimeError(f"{command[0]} ended")

    def end(self):
        self.process.terminate()
        self.process.wait()
        self.process.stdout.close()


def set_up_in_modules(programs, folder):
    """Runs the page's modules on the set-up in `folder`. Returns their result."""
    images = folder / "frames/%06d.jpg"
    width, height = json.loads((folder / "setup.json").read_text())["size"]
    slave = Program("listening on ", programs / "palpate-slave", "serve", "--setup", folder / "kept", "--camera", images,
                    "--camera-rate", RATE, "--listen", "127.0.0.1:0")
    try:
        master = Program("view at ", programs / "palpate-master", "connect", slave.address, "--device", "pointer", "--view", "127.0.0.1:0")
        try:
            lines = f'file: "{images}"\nrate: {RATE} Hz\nsize: [{width}, {height}]\n'
            run = subprocess.run(["node", HERE / "set_up.mjs", folder, master.address.rstrip("/"), lines], capture_output=True, text=True)
            if run.stderr: print(run.stderr)
            if run.returncode != 0 or not run.stdout:
                raise RuntimeError(run.stderr)
            return json.loads(run.stdout)
        finally:
            master.end()
    finally:
        slave.end()


def set_up_in_browser(programs, folder):
    """Does the same with the page in Chromium, with the packages of tests/page/run.sh."""
    scratch = HERE.parents[2] / "build/page"
    shutil.rmtree(folder / "browser", ignore_errors=True)
    environment = {**os.environ, "PALPATE_BIN": str(programs.resolve()), "PALPATE_SCRATCH": str(scratch)}
    run = subprocess.run(["node", HERE / "browser.mjs", folder], capture_output=True, text=True, env=environment)
    if run.returncode != 0 or not run.stdout:
        raise RuntimeError(run.stderr)
    return {"edgePx": float("nan"), "tipPx": float("nan"), **json.loads(run.stdout.splitlines()[-1])}


def processed(programs, folder, scene):
    """Processes the images of a set-up. Returns forces, sigmas and validities."""
    out = folder / "out"
    subprocess.run([programs / "palpate-slave", "process", folder / scene, "--out", out], check=True, capture_output=True)
    with open(out / "states.csv") as file:
        return list(csv.DictReader(file))


def compared(states, truth):
    """Evaluates the states in contact: returns which are valid, their errors relative to the peak, and how many are
    within one and two sigma."""
    force = np.array([np.sqrt(sum(float(row["f" + a] or "nan") ** 2 for a in "xyz")) for row in states])
    sigma = np.array([float(row["sigma"] or "nan") for row in states])
    valid = np.array([row["validity"] == "valid" for row in states])
    truth = truth[:len(force)]
    peak, touched = truth.max(), truth > MIN_CONTACT_FORCE * truth.max()
    used = valid & touched
    error = (force - truth) / peak
    within = [np.abs(error[used]) * peak <= count * sigma[used] for count in (1, 2)]
    free = valid & (truth == 0)
    return {
        "peak": peak, "touched": int(touched.sum()), "valid": int(used.sum()), "silent": int((np.abs(error[used]) > MAX_VALID_ERROR).sum()),
        "rms": float(np.sqrt((error[used] ** 2).mean())) if used.any() else float("nan"),
        "worst": float(error[used][np.abs(error[used]).argmax()]) if used.any() else float("nan"),
        "one": int(within[0].sum()), "two": int(within[1].sum()), "free_sigma_0": int((free & (sigma == 0)).sum()),
        "flags": sorted({(row["validity"], row.get("check", "")) for row, t in zip(states, touched) if t and row["validity"] != "valid"}),
    }


def line_of(result):
    if "silent" not in result:
        return f"stopped at {result.get('step')}: {' '.join(result.get('words', []))}"
    share = [100 * result[key] / max(1, result["valid"]) for key in ("one", "two")]
    return (f"peak {result['peak']:.3g} N, {result['valid']} of {result['touched']} valid, {result['silent']} silent, rms "
            f"{100 * result['rms']:.1f} %, worst {100 * result['worst']:+.1f} %, within one and two sigma {share[0]:.0f}, {share[1]:.0f} %, "
            f"edge {result['edgePx']:.2f} px, tip {result['tipPx']:.2f} px{', after ' + result['followed'] if result['followed'] else ''} "
            f"{result['flags'] or ''}")


def remedy_of(words):
    """Returns the remedy that a message of the page requests."""
    text = " ".join(words)
    return "tape" if "strip of tape" in text else "sheet" if "plain sheet" in text else \
        "height" if "height of the" in text else "middle" if "in the middle of the image" in text else \
        "near" if "mm above the object" in text else None


def tried(programs, number, scratch, set_up=set_up_in_modules):
    """Runs a set-up, and again each time the page's advice is followed."""
    remedies, advice = [], []
    while True:
        folder = scratch / "-".join([str(number), *remedies])
        rendered(Setup(number, remedies), number, folder)
        result = set_up(programs, folder)
        remedy = remedy_of(result.get("words", []))
        result["followed"], result["advice"] = ", ".join(remedies), advice
        if "done" in result:
            truth = np.loadtxt(folder / "truth.csv", skiprows=1)
            scene = "saved/scene.yaml" if set_up is set_up_in_modules else "browser/scene.yaml"
            result.update(compared(processed(programs, folder, scene), truth))
        if remedy is None or remedy in remedies:
            return result
        advice = advice + result["words"]
        remedies.append(remedy)


def damaged(count, rng):
    """Returns damaged sequences by name: for each image the number of the true image that it shows, and the gain of its
    exposure."""
    whole, plain = np.arange(count), np.ones(count)
    kept = np.sort(rng.choice(whole[1:], int(0.8 * count), replace=False))
    doubled, late = whole.copy(), whole.copy()
    doubled[5::5] = doubled[4:-1:5][:len(doubled[5::5])]
    for start in rng.choice(np.arange(3, count - 3), 6, replace=False):
        late[start:start + 2] = late[start - 1]
    step = np.arange(count) > count // 3
    return {"dropped": (np.concatenate([[0], kept]), plain[:len(kept) + 1]), "doubled": (doubled, plain), "late": (late, plain),
            "exposure x 0.7": (whole, np.where(step, 0.7, 1.0)), "exposure x 1.4": (whole, np.where(step, 1.4, 1.0)),
            "exposure x 0.4": (whole, np.where(step, 0.4, 1.0))}


def run_faults(programs, scratch):
    """Processes damaged sequences of one set-up at 1280 x 720. Compares each image with the true force at its time."""
    folder, silent = scratch / "faults", 0
    rendered(Setup(0, size=(1280, 720)), 0, folder)
    result = set_up_in_modules(programs, folder)
    if "done" not in result:
        print(line_of(result))
        return 1
    truth = np.loadtxt(folder / "truth.csv", skiprows=1)
    scene = (folder / "saved/scene.yaml").read_text()
    for name, (shown, gains) in damaged(len(truth), np.random.default_rng(1)).items():
        images = folder / name.replace(" ", "-")
        images.mkdir(exist_ok=True)
        for i, (number, gain) in enumerate(zip(shown, gains)):
            image = Image.open(folder / f"frames/{number:06d}.jpg").point(lambda level, gain=gain: min(255, gain * level))
            image.save(images / f"{i:06d}.jpg", quality=95)
        (folder / "saved/damaged.yaml").write_text(scene.replace(str(folder / "frames"), str(images)))
        # A dropped image leaves a gap. A late or doubled one is replaced by the previous image.
        at_time = truth[shown] if name == "dropped" else truth
        found = compared(processed(programs, folder, "saved/damaged.yaml"), at_time)
        silent += found["silent"]
        print(f"{name}: {line_of({**result, **found, 'followed': ''})}", flush=True)
    return silent


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=30)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--only", choices=KINDS)
    parser.add_argument("--browser", action="store_true", help="through the page in Chromium, where tests/page/run.sh has run")
    parser.add_argument("--bin", type=pathlib.Path, default=HERE.parents[2] / "build/release/bin")
    parser.add_argument("--keep", type=pathlib.Path, help="folder of the images; they are made again where it is empty")
    parser.add_argument("--faults", action="store_true", help="damaged sequences of one set-up in place of all set-ups")
    options = parser.parse_args()
    if options.faults:
        with tempfile.TemporaryDirectory() as scratch:
            return 1 if run_faults(options.bin, options.keep or pathlib.Path(scratch)) else 0
    total = dict.fromkeys(("touched", "valid", "silent", "one", "two", "free_sigma_0"), 0)
    reached, squares, count = 0, [], 0
    with tempfile.TemporaryDirectory() as scratch:
        for number in range(options.first, options.first + options.count):
            if options.only and KINDS[number % len(KINDS)] != options.only:
                continue
            count += 1
            result = tried(options.bin, number, options.keep or pathlib.Path(scratch), set_up_in_browser if options.browser else set_up_in_modules)
            if result.get("valid"):
                reached += 1
                squares.append(result["rms"])
                for key in total:
                    total[key] += result[key]
            print(f"{number} {KINDS[number % len(KINDS)]}: {line_of(result)}", flush=True)
    valid = max(1, total["valid"])
    print(f"{reached} of {count} reached a force; {total['silent']} of {total['valid']} valid contact states are off by more than 10 % of "
          f"the peak; rms {100 * np.sqrt(np.mean(np.square(squares))):.1f} %; within one and two sigma {100 * total['one'] / valid:.0f}, "
          f"{100 * total['two'] / valid:.0f} %; {total['free_sigma_0']} valid states without contact have a sigma of 0")
    return 0 if total["silent"] <= 0.01 * valid else 1


if __name__ == "__main__":
    sys.exit(main())
