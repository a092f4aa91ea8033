"""A tactile sensor of four taxels, with a network trained by `palpate.train --unit`: faults of its driver and its
baseline are flagged."""
import csv
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time
import unittest

try:
    import numpy as np
    import torch  # noqa: F401
except ImportError as missing:
    print(f"skipped: {missing}: deploy/install.sh training")
    sys.exit(77)

from programs import BARE, PACKAGE, PATIENCE, SLAVE, Slave, load_package, read_rows, run, wait_until

RATE, NOISE, LEVELS = 100, 0.01, np.array([10.0, 12.0, 9.0, 11.0])  # [Hz], [kPa]
REST, PRESS, PAUSE, PEAK = 1.5, 1.0, 1.0, 4.0  # [s], [N]
SCENE = """name: taxels
object:
  geometry: {{box: {{size: [60 mm, 60 mm, 60 mm], cells: [4, 4, 4]}}}}
  material: {{young_modulus: 3.8 kPa, poisson_ratio: 0.15}}
  fixed: {{plane: {{axis: z, at: 0 mm}}}}
sense: {{tactile: {{source: {source}, finger: pad, channels: 4, unit: kPa, network: {network}, rest: first 50}}}}
model: {{kind: fem}}
"""


def truth(presses, peaks):
    """Returns the forces [N] on the pad: rest, then presses with pauses."""
    wave = np.sin(np.pi * np.arange(round(PRESS * RATE)) / (PRESS * RATE))**2
    parts = [np.zeros(round(REST * RATE))]
    for peak in np.broadcast_to(peaks, presses):
        parts += [peak * wave, np.zeros(round(PAUSE * RATE))]
    return np.concatenate(parts)


def readings(force, seed, drift=0.0):
    """Returns n x 4 pressures [kPa]: every taxel rises by 1 kPa per newton and drifts by `drift` [kPa/s]."""
    random = np.random.default_rng(seed)
    level = LEVELS + random.normal(0, 0.03, 4)
    time_s = np.arange(len(force))[:, None] / RATE
    return np.round(level + force[:, None] + drift * time_s + random.normal(0, NOISE, (len(force), 4)), 4)


def write(file, values, force=None):
    with open(file, "w", newline="", encoding="utf-8") as stream:
        rows = csv.writer(stream)
        rows.writerow(["t", *(f"c{i} [kPa]" for i in range(1, 5)), *(("fx", "fy", "fz") if force is not None else ())])
        for k, row in enumerate(values):
            rows.writerow([f"{k / RATE:.2f}", *row, *((0, 0, f"{-force[k]:.6f}") if force is not None else ())])


def train(folder, name, scale=1.0, drift=0.0):
    data = folder / f"{name}-data"
    data.mkdir()
    for seed in range(6):
        force = truth(8, np.random.default_rng(100 + seed).uniform(0.3, 1.1, 8) * PEAK)
        write(data / f"{seed}.csv", readings(force, seed, drift * (-1)**seed), scale * force)
    done = run("/usr/bin/python3", "-m", "palpate.train", data, "--unit", "kPa", "--out", folder / name, timeout=10 * PATIENCE,
               env={**BARE, "PYTHONPATH": str(PACKAGE), "OMP_NUM_THREADS": "1"})
    if done.returncode != 0:
        raise AssertionError(done.stdout + done.stderr)
    return folder / name


def dead(values, force):
    values[220:, 1] = 0


def stuck(values, force):
    values[190:, 1] = values[190, 1]


def jumping(values, force):
    values[230:, 1] += 4


def saturated(values, force):
    values[:, 1] = np.minimum(values[:, 1], LEVELS[1] + 2.5)


def frozen(values, force):
    values[200:] = values[200]


def touched(values, force):
    hold = PEAK * (np.arange(len(force)) < 250)
    values += (hold - np.where(np.arange(len(force)) < 250, force, 0))[:, None]
    force[:250] = PEAK


def touched_and_left(values, force):
    hold = PEAK * (np.arange(len(force)) < 30)
    values += hold[:, None]
    force += hold


FAULTS = (dead, stuck, jumping, saturated, frozen, touched, touched_and_left)


def faulty(fault):
    force = truth(3, PEAK)
    values = readings(force, 50)
    fault(values, force)
    return values, force


class ChannelsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.network = train(cls.folder, "network")

    def processed(self, values, network=None):
        """Runs `process` and returns the rows of states.csv."""
        write(self.folder / "recording.csv", values)
        scene = self.folder / "recorded.yaml"
        scene.write_text(SCENE.format(source="recording.csv", network=network or self.network))
        out = self.folder / "out"
        done = run(SLAVE, "process", scene, "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        return read_rows(out / "states.csv")

    @staticmethod
    def judged(rows, force):
        """Returns the share of valid samples, and how many of these have an error of more than three sigma."""
        valid = [row for row in rows if row["validity"] == "valid"]
        wrong = 0
        for row in valid:
            error = np.linalg.norm([float(row["fx"]), float(row["fy"]), float(row["fz"]) - force[int(row["sequence"]) - 1]])
            wrong += error > 3 * float(row["sigma"])
        return len(valid) / len(rows), wrong

    def test_what_works_is_valid(self):
        force = truth(6, 0.9 * PEAK)
        share, wrong = self.judged(self.processed(readings(force, 51)), force)
        self.assertGreater(share, 0.93, "all but the baseline")
        self.assertLess(wrong, 5)

    def test_no_faulty_recording_is_valid_and_wrong(self):
        for fault in FAULTS:
            with self.subTest(fault.__name__):
                values, force = faulty(fault)
                rows = self.processed(values)
                share, wrong = self.judged(rows, force)
                # By noise alone about one of 450 samples exceeds three sigma.
                self.assertLessEqual(wrong, 2, f"{share:.0%} valid")
                self.assertTrue({row["check"] for row in rows} & {"electrode", "frozen", "rest_drift"})

    # A driver that repeats itself is detected by its missing noise at rest.
    def test_a_frozen_driver_is_flagged_without_a_key(self):
        content = json.loads((self.network / "network.json").read_text())
        del content["longest_constant"]
        (self.folder / "keyless").mkdir()
        (self.folder / "keyless/network.json").write_text(json.dumps(content))
        values, force = faulty(frozen)
        rows = self.processed(values, "keyless")
        self.assertLessEqual(self.judged(rows, force)[1], 2)
        self.assertIn("frozen", {row["check"] for row in rows})

    def test_sigma_grows_as_the_sensor_drifts(self):
        network = train(self.folder, "drifting", drift=0.02)
        force = np.zeros(60 * RATE)
        rows = self.processed(readings(force, 52, drift=0.02), network)
        _, wrong = self.judged(rows, force)
        self.assertLess(wrong, 0.01 * len(rows))
        sigma = [float(row["sigma"]) for row in rows if row["sigma"]]
        self.assertGreater(sigma[-1], 2 * sigma[0])

    def test_a_sensor_of_millinewtons_gives_its_force(self):
        network = train(self.folder, "gentle", scale=1e-3)
        force = truth(2, PEAK)
        rows = self.processed(readings(force, 53), network)
        peak = max(float(row["fz"]) for row in rows if row["fz"])
        self.assertAlmostEqual(peak, 1e-3 * PEAK, delta=0.1e-3 * PEAK)
        with Live(self, network) as live:
            states = live.feed(readings(force, 53))
            peak = max(state.force[2] for state in states if state.valid)
            self.assertAlmostEqual(peak, 1e-3 * PEAK, delta=0.1e-3 * PEAK)

    def test_a_network_without_sigma_is_refused(self):
        for key in ("sigma", "noise"):
            content = json.loads((self.network / "network.json").read_text())
            del content[key]
            (self.folder / "bare").mkdir(exist_ok=True)
            (self.folder / "bare/network.json").write_text(json.dumps(content))
            scene = self.folder / "bare.yaml"
            scene.write_text(SCENE.format(source="stream", network="bare"))
            done = run(SLAVE, "check", scene)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(f"network.json: {key} is missing", done.stderr)
            self.assertIn("palpate.train --unit", done.stderr)

    def test_no_live_state_is_valid_and_wrong(self):
        for fault in FAULTS:
            with self.subTest(fault.__name__):
                values, force = faulty(fault)
                with Live(self, self.network) as live:
                    states = live.feed(values)
                known = [state for state in states if state.validity == live.palpate.Validity.VALID]
                errors = [np.linalg.norm(state.force - [0, 0, force[live.index(state)]]) / state.sigma for state in known]
                self.assertLessEqual(sum(error > 3 for error in errors), 2, f"{len(known)} of {len(states)} valid")
                self.assertTrue(any(state.validity != live.palpate.Validity.VALID for state in states))


class Live:
    """A slave whose fingertip gets its samples by FeedTactile."""

    def __init__(self, test, network):
        self.palpate, _, _ = load_package()
        scene = test.folder / "live.yaml"
        scene.write_text(SCENE.format(source="stream", network=network))
        self.slave = Slave(scene, simulates=False)

    def __enter__(self):
        self.slave.__enter__()
        return self

    def __exit__(self, *error):
        self.slave.__exit__(*error)

    def feed(self, values):
        """Feeds the samples in real time and returns the states."""
        states, ready = [], threading.Event()

        def watch():
            with self.palpate.connect(self.slave.address) as observer:
                for state in observer.states(seconds=len(values) / RATE + 3):
                    ready.set()
                    if state.t >= self.start - 0.5 / RATE and self.index(state) < len(values):
                        states.append(state)

        self.start = time.time() + 1
        watcher = threading.Thread(target=watch)
        watcher.start()

        def samples():
            for k, row in enumerate(values):
                t = self.start + k / RATE
                time.sleep(max(0.0, t - time.time()))
                yield self.palpate.TactileSample("pad", row, t=t, unit="kPa")

        with self.palpate.connect(self.slave.address) as driver:
            driver.feed_fingertips(samples())
        watcher.join()
        return [state for state in states if state.t <= self.start + (len(values) - 0.5) / RATE]

    def index(self, state):
        return round((state.t - self.start) * RATE)


if __name__ == "__main__":
    unittest.main()
