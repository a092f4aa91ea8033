#!/usr/bin/env python3
"""Faults of single channels and of the driver of a tactile sensor: recordings of a simulated pad, altered, through `process`.

usage: channels.py [--count N] [--seed N] [--taxels 16|60] [--bin FOLDER] [--keep FOLDER]   (100 trials; FOLDER build/release/bin)

The pad and the training are those of deploy/guides/own-tactile-sensor.md. Each trial is a recording of three presses that the
training did not contain, with one fault that begins at a random time of the first or second press:

dead       the channel reads 0
stuck      it keeps its last value
jump       it reads 2 to 20 kPa more or less
saturated  it reads at most a tenth to a half of its largest change above its reading at rest
swapped    it changes places with another channel
drift      it rises or falls by 0.5 to 5 kPa/s
frozen     the driver repeats its last sample
touched    the recording begins in a press

The channel is one of those that this press changes by more than a fifth of the largest change. Prints a line for each trial.
An undetected error is a `valid` state off by more than three sigma and more than 5 % of the largest force. The first 0.1 s
after the begin of a fault do not count: the checks need ten samples.
Exit code 1: a trial has an undetected error, or more than 10 % of the contact states of ten unaltered recordings are
flagged.
"""
import argparse
import csv
import math
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "deploy/examples"), str(ROOT / "tests/e2e")]
from programs import PACKAGE  # noqa: E402
from taxel_sensor import RATE, REST, Pad, record, samples  # noqa: E402

KINDS = ["dead", "stuck", "jump", "saturated", "swapped", "drift", "frozen", "touched"]
SETTLED = 0.1  # [s]
TOUCHES = 0.05  # of the largest force
UNALTERED = 10  # recordings
MAX_FLAGGED = 0.1  # of their contact states: 2 % with 16 taxels, 7 % with 60
SCENE = """name: taxel-pad
object:
  geometry: {{box: {{size: [60 mm, 60 mm, 60 mm], cells: [6, 6, 6]}}}}
  material: {{young_modulus: 3.8 kPa, poisson_ratio: 0.15}}
  fixed: {{plane: {{axis: z, at: 0 mm}}}}
sense:
  tactile: {{source: altered.csv, finger: pad, channels: {taxels}, unit: kPa, network: network, rest: first 50}}
model: {{kind: fem}}
"""


def train(folder, taxels):
    record(folder / "presses", taxels, 60, 1)
    subprocess.run([sys.executable, "-m", "palpate.train", folder / "presses", "--unit", "kPa", "--out", folder / "network"],
                   check=True, stdout=subprocess.DEVNULL, env=os.environ | {"PYTHONPATH": str(PACKAGE)})


def press(taxels, seed):
    """Readings [kPa], n x taxels, and forces of the pad on the object [N], n x 3."""
    readings, forces = zip(*samples(Pad(taxels, seed), 3))
    return np.array(readings), np.array(forces)


def begin_of_fault(forces, random):
    """A sample at which a press has reached half its largest force, of the first or second press."""
    size = np.linalg.norm(forces, axis=1)
    starts = [k for k in range(1, len(size)) if size[k] > 0 and size[k - 1] == 0]
    first = starts[random.integers(2)]
    length = next(k for k in range(first, len(size)) if size[k] == 0) - first
    return first + int(random.uniform(0.1, 0.6) * length)


def altered(kind, values, forces, random):
    """Altered readings, the forces that belong to them, the first sample of the fault, and what happened in words."""
    rest = values[:round(REST * RATE)].mean(axis=0)
    change = np.abs(values - rest).max(axis=0)
    at = begin_of_fault(forces, random)
    channel = random.choice(np.flatnonzero(np.abs(values[at:] - rest).max(axis=0) > 0.2 * change.max()))
    out = values.copy()
    text = f"c{channel + 1}"
    if kind == "dead":
        out[at:, channel] = 0
    elif kind == "stuck":
        out[at:, channel] = values[at - 1, channel]
    elif kind == "jump":
        size = random.choice([-1, 1]) * random.uniform(2, 20)
        out[at:, channel] += size
        text += f" {size:+.1f} kPa"
    elif kind == "saturated":
        limit = rest[channel] + random.uniform(0.1, 0.5) * change[channel]
        out[:, channel] = np.minimum(values[:, channel], limit)
        at = int(np.argmax(values[:, channel] > limit))
        text += f" at {limit - rest[channel]:.1f} kPa"
    elif kind == "swapped":
        other = random.choice([k for k in range(values.shape[1]) if k != channel])
        out[at:, [channel, other]] = values[at:, [other, channel]]
        text += f" and c{other + 1}"
    elif kind == "drift":
        rate = random.choice([-1, 1]) * random.uniform(0.5, 5)
        out[at:, channel] += rate * np.arange(len(values) - at) / RATE
        text += f" {rate:+.1f} kPa/s"
    elif kind == "frozen":
        out[at:] = values[at - 1]
        text = "all"
    else:
        return values[at:], forces[at:], 0, "all"
    return out, forces, at, text


def states(slave, folder, values):
    with open(folder / "altered.csv", "w", newline="", encoding="ascii") as file:
        rows = csv.writer(file)
        rows.writerow(["t", *(f"c{k + 1} [kPa]" for k in range(values.shape[1]))])
        rows.writerows([f"{k / RATE:.2f}", *(f"{x:.4f}" for x in row)] for k, row in enumerate(values))
    run = subprocess.run([slave, "process", folder / "pad.yaml", "--out", folder / "out"], capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(run.stdout + run.stderr)
    with open(folder / "out/states.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def judged(rows, forces, at):
    """(contact states, flagged ones, undetected errors, the worst valid error [parts of the peak])."""
    peak = np.linalg.norm(forces, axis=1).max()
    touching = flagged = undetected = 0
    worst = 0.0
    for row in rows:
        k = round(float(row["t"]) * RATE)
        if k < at + SETTLED * RATE or np.linalg.norm(forces[k]) < TOUCHES * peak:
            continue
        touching += 1
        if row["validity"] != "valid":
            flagged += 1
            continue
        error = math.dist([float(row[f"f{axis}"]) for axis in "xyz"], -forces[k])
        worst = max(worst, error / peak)
        undetected += error > 3 * float(row["sigma"]) and error > 0.05 * peak
    return touching, flagged, undetected, worst


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--taxels", type=int, choices=(16, 60), default=16)
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin")
    parser.add_argument("--keep", type=pathlib.Path)
    a = parser.parse_args()
    random = np.random.default_rng(a.seed)
    silent = 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = a.keep or pathlib.Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "pad.yaml").write_text(SCENE.format(taxels=a.taxels), encoding="ascii")
        if not (folder / "network").exists():
            train(folder, a.taxels)
        flags = contacts = 0
        for k in range(UNALTERED):
            values, forces = press(a.taxels, 5000 + 100 * a.seed + k)
            touching, flagged, undetected, worst = judged(states(a.bin / "palpate-slave", folder, values), forces, 0)
            flags, contacts = flags + flagged, contacts + touching
            print(f"unaltered                        {flagged:4} of {touching:4} flagged, worst valid {100 * worst:5.1f} %, "
                  f"{undetected} undetected errors", flush=True)
        for k in range(a.count):
            kind = KINDS[k % len(KINDS)]
            values, forces, at, text = altered(kind, *press(a.taxels, 6000 + 1000 * a.seed + k), random)
            touching, flagged, undetected, worst = judged(states(a.bin / "palpate-slave", folder, values), forces, at)
            silent += undetected > 0
            print(f"{kind:9} {text:22} {flagged:4} of {touching:4} flagged, worst valid {100 * worst:5.1f} %, "
                  f"{undetected} undetected errors", flush=True)
    print(f"{flags} of {contacts} contact states flagged without a fault")
    print(f"{silent} of {a.count} trials with undetected errors; seed {a.seed}, {a.taxels} taxels")
    return 1 if silent or flags > MAX_FLAGGED * contacts else 0


if __name__ == "__main__":
    sys.exit(main())
