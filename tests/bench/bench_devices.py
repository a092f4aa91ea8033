#!/usr/bin/env python3
"""Measures haptic devices with force feedback in real time, each with a fake of its vendor's software:
  1. The demo's press with each: missed ticks and the largest force beside sim-hand's of the same round.
  2. `palpate-master devices` without any device.
Exit code 1: more missed ticks than 1.2 times those of sim-hand plus 5, a force that differs by more than 1 %, or a
driver that does not report its reason within 2 s.

tests/bench/bench_devices.py [--rounds N] [--seconds S]      needs build/release with its tests
"""
import argparse
import contextlib
import csv
import os
import pathlib
import re
import socket
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/e2e"))
from programs import BARE, BIN, MASTER, Slave, read_json, read_rows, wait_until  # noqa: E402

FAKES = ROOT / "tests/master/device/fakes"
LEAD = 1.0  # [s] time that the device runs before and after the motion
PRIORITY = 40  # real-time priority of the service
LIMITS = {"ratio": 1.2, "more": 5, "force": 0.01, "list": 2.0}
FOLLOWS = ("ALIGNING", "FOLLOWING")


class Control:
    """Sends commands to a fake, see tests/master/device/fakes/fakes.h."""

    def __init__(self, path):
        wait_until(lambda: pathlib.Path(path).exists())
        self.line = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.line.connect(str(path))
        self.answers = self.line.makefile()

    def ask(self, text):
        self.line.sendall(f"{text}\n".encode())
        answer = self.answers.readline().strip()
        assert not answer.startswith("error"), f"{text}: {answer}"
        return answer


class Library:
    """A device whose vendor's library the master loads."""

    def __init__(self, device, folder, to_device):
        self.device, self.name, self.folder, self.to_device = device, device, folder, to_device

    def start(self, place):
        self.path = place / "control"
        return {"LD_LIBRARY_PATH": str(BIN.parent / "fakes" / self.folder),
                f"PALPATE_FAKE_{self.folder.upper()}_CONTROL": str(self.path)}

    def control(self):
        return Control(self.path)

    def stop(self):
        pass


class Service:
    """The Haply service as a separate process."""

    def __init__(self, api):
        self.api, self.name = api, f"haply {api}"

    def to_device(self, p):
        return p[0], -p[2], p[1]

    def start(self, place):
        self.path = place / "control"
        self.process = subprocess.Popen(["/usr/bin/python3", FAKES / "haply_service.py", "--api", self.api, "--control", self.path],
                                        stdout=subprocess.PIPE, text=True)
        with contextlib.suppress(PermissionError):  # the same policy as the master's threads, since Python is slow
            os.sched_setscheduler(self.process.pid, os.SCHED_FIFO, os.sched_param(PRIORITY))
        port = re.match(r"listening on (\d+)", self.process.stdout.readline())[1]
        self.device = f"haply:{port}"
        self.control().ask("set gain 1")
        return {}

    def control(self):
        return Control(self.path)

    def stop(self):
        self.process.terminate()
        self.process.wait()


DEVICES = (Library("touch", "hd", lambda p: p), Library("dhd", "dhd", lambda p: (p[2], p[0], p[1])), Service("3.1"), Service("3.5"))


def session(place, device, seconds, environment=None, meanwhile=lambda: None):
    """Runs a session with a new slave and writes the log into `place`. Returns the report."""
    with Slave() as slave:
        process = subprocess.Popen([MASTER, "connect", slave.address, "--device", device, "--duration", str(seconds),
                                    "--report", place / "report.json", "--log", place / "log.csv"],
                                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, env=BARE | (environment or {}))
        meanwhile()
        assert process.wait() == 0, "the session failed"
    return read_json(place / "report.json")


def recorded_motion(file):
    """Returns (t, p_M, engaged) of each tick in a log."""
    return [(float(row["t"]), [float(row[f"p_M_{axis}"]) for axis in "xyz"], row["state"] in FOLLOWS) for row in read_rows(file)]


def replay(device, motion, place):
    """Runs a session in which the fake device repeats `motion`. Returns the report."""
    path = place / "motion.csv"
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["time_s", "x", "y", "z"])
        writer.writerows([t, *device.to_device(p)] for t, p, _ in motion)

    def operate():
        control = device.control()
        time.sleep(LEAD)
        control.ask(f"follow {path}")
        closed = False
        for t, _, wanted in motion:
            if wanted != closed:
                control.ask(f"press 0 {int(wanted)} {t}")
                closed = wanted

    environment = device.start(place)
    try:
        return session(place, device.device, motion[-1][0] + 2 * LEAD, environment, operate)
    finally:
        device.stop()


def press_with_each(rounds, seconds):
    runs = {}
    for _ in range(rounds):
        with tempfile.TemporaryDirectory() as folder:
            reference = session(pathlib.Path(folder), "sim-hand", seconds)
            motion = recorded_motion(pathlib.Path(folder, "log.csv"))
        reports = {"sim-hand": reference}
        for device in DEVICES:
            with tempfile.TemporaryDirectory() as folder:
                reports[device.name] = replay(device, motion, pathlib.Path(folder))
        for name, report in reports.items():
            share = report["force_sent_peak_N"] / reference["force_sent_peak_N"]
            runs.setdefault(name, []).append((report["missed"], reference["missed"], report["force_sent_peak_N"], share))
    print(f"{'device':10} {'missed':>7} {'sim-hand':>8} {'at most':>8}   {'each round: missed/sim-hand':30} {'force [N]':>10} {'of sim-hand':>12}  {'worst':>8}")
    held = True
    for name, rows in runs.items():
        missed, others = (statistics.mean(row[i] for row in rows) for i in (0, 1))
        force, share = (statistics.median(row[i] for row in rows) for i in (2, 3))
        most = LIMITS["ratio"] * others + LIMITS["more"]
        worst = max((share for *_, share in rows), key=lambda share: abs(share - 1))
        fine = missed <= most and abs(share - 1) <= LIMITS["force"]
        held = held and fine
        print(f"{name:10} {missed:7.1f} {others:8.1f} {most:8.1f}   {' '.join(f'{row[0]}/{row[1]}' for row in rows):30} {force:10.3f} "
              f"{100 * share:10.2f} %  {100 * worst:6.1f} %{'' if fine else '  NOT HELD'}", flush=True)
    print("missed: means of the rounds; force: medians")
    return held


def list_without_devices():
    begin = time.monotonic()
    answer = subprocess.run([MASTER, "devices"], stdin=subprocess.DEVNULL, capture_output=True, text=True, env=BARE)
    took = time.monotonic() - begin
    drivers = [entry for entry in re.split(r"\n(?=\S)", answer.stdout) if re.match(r"\w+ +(not )?ready", entry)]
    reasons = {entry.split()[0]: re.search(r"missing +(.{1,100})", entry) for entry in drivers}
    for name, reason in reasons.items():
        print(f"{name:10} {reason[1] if reason else '-'}")
    held = answer.returncode == 0 and took < LIMITS["list"] and len(reasons) == 6 and all(reasons.values())
    print(f"exit code {answer.returncode}, {took:.2f} s, at most {LIMITS['list']:g} s{'' if held else ': NOT HELD'}")
    return held


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=8, help="of each press session")
    chosen = parser.parse_args()
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}\n\nThe demo's press, {chosen.rounds} rounds of {chosen.seconds:g} s")
    held = press_with_each(chosen.rounds, chosen.seconds)
    print("\npalpate-master devices, without a device")
    held = list_without_devices() and held
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
