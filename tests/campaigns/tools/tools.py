#!/usr/bin/env python3
"""Measures force errors for a tool that differs from its scene, or that is tilted, in simulated presses through
`process`.

usage: tools.py [anchors] [leaning] [--bin FOLDER] [--only WORD] [--seed N]   (both; FOLDER build/release/bin)

  anchors   The template is cut from the first image of the shipped block, with an error of its anchor of -3 to +5 px
            along the tool.
  leaning   Tools of radius 0 (flat) to 10 mm press a block and a disc, with a constant tilt of 0 to 20 degrees, or in
            a hand that rotates them by as much.

Prints a line for each press. An error is the distance of the estimated from the true force, relative to the largest
true force of the press. Contact states are those whose true force is more than a hundredth of it.
Exit code 1: a valid contact state has an error of more than a tenth; or, of a tilted tool, fewer than 80 % of the
contact states are valid.
"""
import argparse
import csv
import math
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/e2e"))
from programs import png  # noqa: E402
from setups import BOX, TIP, decoded  # noqa: E402

SCENE = ROOT / "deploy/scenes/silicone-block.yaml"
MAX_ERROR, MIN_VALID, TOUCHES = 0.1, 0.8, 0.01
DISC = ["object.geometry={disc: {radius: 40 mm, thickness: 9 mm}}",
        "object.fixed={arc: {centre: -90 deg, half_angle: 40 deg}}", "manipulator.home=[0, 46 mm, 0]",
        "sense.camera.pose={translation: [0, 6 mm, 0]}"]


def process(slave, overrides, out, *options):
    arguments = [str(slave), "process", str(SCENE), "--out", str(out), *options]
    for one in overrides:
        arguments += ["--override", one]
    run = subprocess.run(arguments, capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(f"{' '.join(arguments)}\n{run.stdout}{run.stderr}")
    with open(out / "states.csv", newline="") as file:
        return list(csv.DictReader(file))


def report(name, rows, min_valid):
    def vector(row, prefix):
        return [float(row[prefix + axis] or "nan") for axis in ("fx", "fy", "fz")]

    peak = max(math.hypot(*vector(row, "true_")) for row in rows)
    touching = [row for row in rows if math.hypot(*vector(row, "true_")) > TOUCHES * peak]
    errors = [(math.dist(vector(row, ""), vector(row, "true_")) / peak, row) for row in touching]
    known = [error for error, _ in errors if not math.isnan(error)]
    valid = [error for error, row in errors if row["validity"] == "valid"]
    worst = max(valid, default=0)
    rms = math.sqrt(sum(error**2 for error in known) / max(1, len(known)))
    checks = {}
    for _, row in errors:
        if row["validity"] != "valid":
            checks[row["check"]] = checks.get(row["check"], 0) + 1
    holds = worst <= MAX_ERROR and len(valid) >= min_valid * len(touching)
    print(f"{'holds' if holds else 'FAILS'}  {name:48} error {100 * rms:5.1f} % rms, worst valid {100 * worst:5.1f} %, "
          f"valid {len(valid)} of {len(touching)}  {checks or ''}", flush=True)
    return holds


def anchors(slave, folder, only, seed):
    undisturbed = [f"site.seed={seed}"]
    first = folder / "first"
    process(slave, [*undisturbed, "operator.press.depth=1 mm"], first, "--frames")
    left, top, right, bottom = BOX
    rows = decoded(sorted((first / "frames").iterdir())[0].read_bytes())
    template = folder / "tip.png"
    template.write_bytes(png(right - left, bottom - top, 8, [row[left:right] for row in rows[top:bottom]]))
    holds = True
    for off in (0, -3, -2, -1, 1, 2, 3, 4, 5):
        name = f"anchor {off:+d} px"
        if only not in name:
            continue
        tip = f"sense.tip={{track: template, template: {template}, anchor: [{TIP[0] - left}, {TIP[1] - top + off}]}}"
        rows = process(slave, [*undisturbed, tip], folder / f"anchor{off}")
        holds &= report(name, rows, MIN_VALID if off == 0 else 0)
    return holds


def leaning(slave, folder, only, seed):
    holds = True
    for body, place in (("block", []), ("disc", DISC)):
        for radius in (0, 3, 5, 10):
            tool = "shape: round, radius: {0} mm, width: {1} mm".format(radius, 2 * radius) if radius else "shape: flat, width: 5.87 mm"
            for angle in (0, 8, 15, 20):
                for way in ("direction", "hand") if angle else ("direction",):
                    name = f"{body}, radius {radius} mm, {way} {angle} deg"
                    if only not in name:
                        continue
                    lean = math.radians(angle) if way == "direction" else 0
                    overrides = [*place, f"site.seed={seed}", "sense.camera.rate=20 Hz", "sense.camera.pixel=0.25 mm", "model.elements=360",
                                 f"tool={{{tool}, depth: whole, direction: [{math.sin(lean):.6f}, {-math.cos(lean):.6f}]}}"]
                    if way == "hand":
                        overrides.append(f"site.hand={{tilt: {angle} deg}}")
                    holds &= report(name, process(slave, overrides, folder / name.replace(" ", "")), MIN_VALID)
    return holds


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*")
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin")
    parser.add_argument("--only", default="")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    parts = {"anchors": anchors, "leaning": leaning}
    holds = True
    with tempfile.TemporaryDirectory() as folder:
        for name in options.parts or parts:
            holds &= parts[name](options.bin.resolve() / "palpate-slave", pathlib.Path(folder), options.only, options.seed)
    sys.exit(0 if holds else 1)


if __name__ == "__main__":
    main()
