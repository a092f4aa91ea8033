#!/usr/bin/python3
"""A simulated tactile pad of 16 or 60 taxels: writes recordings for training, or drives a running slave.

usage: taxel_sensor.py record DIR [--taxels 16|60] [--presses N] [--seed N]
       taxel_sensor.py feed HOST:PORT [--taxels 16|60] [--presses N] [--seed N] [--tls DIR]

The pad is an elastic layer on a stiff dome: a round object (4 to 12 mm) that enters it is pushed back by a pressure in
proportion to its depth, along the dome's normal. The force is the sum of that pressure over 2,500 points. A taxel
measures the pressure around it, with its own gain, saturation, creep, noise and drifting baseline.

record: writes DIR/000.csv and so on, ten presses each, with t, c1 to cN [kPa] and the force of the pad on the object fx, fy,
fz [N]; also DIR/layout.txt. feed: presses against the pad of the scene's first finger in real time, and prints the rms error
of the slave's force in percent of the peak. Exit code 0: all samples accepted and at most 5 %; 1: not so.
"""
import argparse
import pathlib
import sys
import threading
import time
from typing import Iterator

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

RATE = 100.0  # [Hz]
GRIDS = {16: (4, 4), 60: (10, 6)}  # taxels along x and y
SIDE_X, SIDE_Y, DOME = 0.020, 0.016, 0.025  # pad and radius of its dome [m]
STIFFNESS = 60e6  # pressure per depth of the layer, 120 kPa and 2 mm thick [Pa/m]
BLUR = 0.0018  # width of the region that a taxel averages over [m]
SATURATION = 150.0  # [kPa]
CREEP, CREEP_TIME = 0.04, 1.5  # share and time of the delayed part [s]
NOISE, DRIFT = 0.05, 0.02  # [kPa], [kPa per sqrt(s)]
REST = 1.5  # seconds without contact at the start
LIMIT = 5.0  # [% of the peak]


def dome(x: Array, y: Array) -> tuple[Array, Array]:
    """Returns points of the surface [m] and outward normals in frame F of the pad. Outwards is -z."""
    n = np.stack([x / DOME, y / DOME, -np.sqrt(1 - (x**2 + y**2) / DOME**2)], axis=-1)
    return n * DOME + np.array([0, 0, DOME]), n


class Pad:
    def __init__(self, taxels: int, seed: int) -> None:
        rows, columns = GRIDS[taxels]
        u, v = np.meshgrid((np.arange(50) + 0.5) / 50 - 0.5, (np.arange(50) + 0.5) / 50 - 0.5)
        self.points, self.normals = dome(SIDE_X * u.ravel(), SIDE_Y * v.ravel())
        self.areas = SIDE_X * SIDE_Y / 2500 / -self.normals[:, 2]
        a, b = np.meshgrid((np.arange(rows) + 0.5) / rows - 0.5, (np.arange(columns) + 0.5) / columns - 0.5)
        self.places, self.directions = dome(SIDE_X * a.ravel(), SIDE_Y * b.ravel())
        weights = np.exp(-((self.places[:, None] - self.points)**2).sum(axis=2) / (2 * BLUR**2)) * self.areas
        random = np.random.default_rng(5)  # the same pad in every recording
        self.weights = weights / weights.sum(axis=1, keepdims=True) * random.uniform(0.8, 1.2, (taxels, 1))
        self.random = np.random.default_rng(seed)
        self.rest = random.uniform(5, 20, taxels)
        self.creep = np.zeros(taxels)
        self.drift = np.zeros(taxels)

    def press(self, centre: Array, radius: float) -> tuple[Array, Array]:
        """Returns the readings [kPa] and the force of the pad on a ball [N]."""
        depth = np.maximum(radius - np.linalg.norm(self.points - centre, axis=1), 0)
        pressure = STIFFNESS * depth
        force = ((pressure * self.areas)[:, None] * self.normals).sum(axis=0)
        seen = self.weights @ pressure / 1e3
        seen = seen / (1 + seen / SATURATION)
        self.creep += (seen - self.creep) / (CREEP_TIME * RATE)
        self.drift += DRIFT / np.sqrt(RATE) * self.random.normal(size=len(seen))
        noise = NOISE * self.random.normal(size=len(seen))
        return self.rest + self.drift + seen + CREEP * self.creep + noise, force


def samples(pad: Pad, presses: int) -> Iterator[tuple[Array, Array]]:
    """Yields readings and forces at RATE: first without contact, then presses that slide."""
    for _ in range(round(REST * RATE)):
        yield pad.press(np.array([0, 0, -1.0]), 0.01)
    for _ in range(presses):
        radius = pad.random.uniform(0.004, 0.012)
        begin, end = (pad.random.uniform(-0.35, 0.35, 2) * (SIDE_X, SIDE_Y) for _ in range(2))
        deepest, steps = pad.random.uniform(0.0003, 0.0012), round(pad.random.uniform(0.8, 2.0) * RATE)
        for k in range(steps):
            share = k / steps
            place, normal = dome(*(begin + share * (end - begin)))
            depth = deepest * np.sin(np.pi * share)**2
            yield pad.press(place + (radius - depth) * normal, radius)
        for _ in range(round(0.6 * RATE)):
            yield pad.press(np.array([0, 0, -1.0]), 0.01)


def record(folder: pathlib.Path, taxels: int, presses: int, seed: int) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    names = ["t", *(f"c{i} [kPa]" for i in range(1, taxels + 1)), "fx", "fy", "fz"]
    pad = Pad(taxels, seed)
    layout = [f"c{i + 1}," + ",".join(f"{x:.5f}" for x in (*(1e3 * pad.places[i]), *pad.directions[i])) for i in range(taxels)]
    (folder / "layout.txt").write_text("\n".join(layout) + "\n", encoding="ascii")
    for file in range((presses + 9) // 10):
        rows = [",".join(names)]
        for k, (values, force) in enumerate(samples(Pad(taxels, seed + file), min(10, presses - 10 * file))):
            rows.append(f"{k / RATE:.2f}," + ",".join(f"{x:.4f}" for x in values) + "," + ",".join(f"{x:.6f}" for x in force))
        (folder / f"{file:03}.csv").write_text("\n".join(rows) + "\n", encoding="ascii")


def feed(target: str, taxels: int, presses: int, seed: int, tls: str | None) -> int:
    import palpate
    with palpate.connect(target, tls) as slave:
        finger = slave.scene().fingertips[0].name
        truth: list[tuple[float, Array]] = []
        states: list[palpate.State] = []
        readings = list(samples(Pad(taxels, seed), presses))
        ready, seconds = threading.Event(), len(readings) / RATE

        def watch() -> None:
            with palpate.connect(target, tls) as observer:
                ready.set()
                states.extend(observer.states(seconds=seconds + 1))

        watcher = threading.Thread(target=watch)
        watcher.start()
        ready.wait()
        time.sleep(0.5)
        start = time.time()

        def live() -> Iterator[palpate.TactileSample]:
            for k, (values, force) in enumerate(readings):
                t = start + k / RATE
                time.sleep(max(0.0, t - time.time()))
                truth.append((t, force))
                yield palpate.TactileSample(finger, values, t=t, unit="kPa")

        accepted = slave.feed_fingertips(live())
        watcher.join()
    times, forces = np.array([t for t, _ in truth]), np.array([f for _, f in truth])
    known = {round(s.t, 4): s for s in states if s.known}
    pairs = []
    for t, state in known.items():
        k = int(np.argmin(np.abs(times - t)))
        if abs(times[k] - t) < 0.5 / RATE:
            pairs.append((state.force, -forces[k], state.sigma))  # of the object on the finger
    if not pairs:
        print("no state with a force: the slave needs a network for these channels")
        return 1
    estimated, measured = (np.array([pair[k] for pair in pairs]) for k in (0, 1))
    error = np.linalg.norm(estimated - measured, axis=1)
    sigma = np.array([pair[2] for pair in pairs])
    peak = np.linalg.norm(measured, axis=1).max()
    percent = 100 * float(np.sqrt((error**2).mean())) / peak
    print(f"{accepted} of {len(readings)} samples of {taxels} taxels accepted, {len(pairs)} states: rms error {percent:.2f} % of the "
          f"peak of {peak:.2f} N, {100 * (error < sigma).mean():.0f} % within one sigma, {100 * (error < 2 * sigma).mean():.0f} % "
          "within two")
    return 0 if accepted == len(readings) and percent <= LIMIT else 1


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("action", choices=("record", "feed"))
    parser.add_argument("target", help="folder, or HOST:PORT")
    parser.add_argument("--taxels", type=int, choices=sorted(GRIDS), default=16)
    parser.add_argument("--presses", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tls", metavar="DIR", help="folder with ca.pem, cert.pem and key.pem")
    arguments = parser.parse_args()
    if arguments.action == "record":
        record(pathlib.Path(arguments.target), arguments.taxels, arguments.presses, arguments.seed)
        return 0
    return feed(arguments.target, arguments.taxels, arguments.presses, arguments.seed, arguments.tls)


if __name__ == "__main__":
    sys.exit(main())
