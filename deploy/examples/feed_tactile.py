#!/usr/bin/python3
"""Sends tactile samples to a slave at the rate of a recording: a fingertip driver.

usage: feed_tactile.py HOST:PORT [RECORDING.csv] [--finger NAME ...] [--hurry] [--check] [--tls DIR]

The recording has a header with a time in seconds (rel_time_s, time_s, t or timestamp) and NAME_E1 to
NAME_E19, NAME_pdc, NAME_pac0 for each finger (without NAME_ for a single finger). Without a
recording every finger rests for half a second. Fingers: by default all fingers of the scene.
--hurry: as fast as possible. --check: also send a sample with 18 electrodes, which must be rejected with an explanation.

Prints the number of accepted samples. Exit code 0: all; 1: not all; 2: unusable arguments.
"""
import argparse
import csv
import sys
from typing import Iterator

import palpate

ELECTRODES = 19
CLOCKS = ("rel_time_s", "time_s", "t", "timestamp")


def read(path: str, fingers: list[str]) -> Iterator[palpate.TactileSample]:
    """The samples of a recording."""
    with open(path, newline="", encoding="ascii") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        header = rows.fieldnames or []
        clock = next((name for name in CLOCKS if name in header), None)
        if clock is None:
            sys.exit(f"the recording has no time: expected one of {', '.join(CLOCKS)}")
        prefixes = {finger: f"{finger}_" if f"{finger}_E1" in header else "" for finger in fingers}
        for prefix in prefixes.values():
            for name in (f"{prefix}E{i}" for i in range(1, ELECTRODES + 1)):
                if name not in header:
                    sys.exit(f"the recording has no {name}: expected {prefix}E1 to {prefix}E{ELECTRODES}")
        for row in rows:
            for finger, prefix in prefixes.items():
                pressures = [float(row[prefix + name]) for name in ("pdc", "pac0") if prefix + name in row]
                electrodes = [float(row[f"{prefix}E{i}"]) for i in range(1, ELECTRODES + 1)]
                yield palpate.TactileSample(finger, electrodes, pressures, float(row[clock]))


def rest(fingers: list[str]) -> Iterator[palpate.TactileSample]:
    """Half a second without contact."""
    for i in range(50):
        for finger in fingers:
            yield palpate.TactileSample(finger, [3000.0 + k for k in range(ELECTRODES)], [2000.0, 1800.0], 0.01 * i)


def is_rejected_with_an_explanation(slave: palpate.Slave, finger: str) -> bool:
    try:
        slave.feed_fingertips([palpate.TactileSample(finger, [0.0] * (ELECTRODES - 1))])
    except palpate.Error as error:
        print(f"18 electrodes: {error.details}")
        return error.code == "INVALID_ARGUMENT" and "expected" in error.details
    return False


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("recording", nargs="?")
    parser.add_argument("--finger", action="append", dest="fingers")
    parser.add_argument("--hurry", action="store_true")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--tls", metavar="DIR", help="folder with ca.pem, cert.pem and key.pem")
    arguments = parser.parse_args()
    with palpate.connect(arguments.target, arguments.tls) as slave:
        scene = slave.scene()
        fingers = arguments.fingers or [fingertip.name for fingertip in scene.fingertips]
        if not fingers:
            sys.exit(f"{scene.name} has no fingertips")
        samples = list(read(arguments.recording, fingers) if arguments.recording else rest(fingers))
        accepted = slave.feed_fingertips(palpate.replayed(samples, arguments.hurry))
        print(f"{scene.name}: {accepted} of {len(samples)} samples of {', '.join(fingers)} accepted")
        explained = not arguments.check or is_rejected_with_an_explanation(slave, fingers[0])
    return 0 if explained and accepted == len(samples) > 0 else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except palpate.Error as error:
        sys.exit(f"error: {error}")
