#!/usr/bin/env python3
"""Replays the round trips of real telerobots (../shared/data/teleop_round_trips) between slave and master, with one row
per link.

  recorded_links.py [--seconds 60] [--parts 2] [--only TEXT]

The simulated operator presses the block every 4 s, once with the local contact model and once with the newest received
force. Columns: rendered force minus true force at the same commanded position while FOLLOWING, in percent of the press'
largest force, rms and largest; share of the engaged time in HOLD; contacts without any force on the operator, of all
contacts of the tool, beside the number of press cycles; energy that the operator received beyond the energy put in.

The true force at a position is that of the simulated object in a slow press (`process`), so that neither the delay nor
the lag of the tool behind its commands counts.
Exit code 1: energy was created, or the error with the local model exceeds 1 %; 77: no recordings, or no network
namespaces.
"""
import argparse
import bisect
import csv
import pathlib
import sys
import tempfile
from math import dist, hypot, sqrt

from impaired_link import ImpairedLink, can_impair_links, recorded_delay
from impairment import MIN_NOISE_ENERGY, run_session
from programs import BLOCK, ROOT, SLAVE, run

DATA = ROOT.parent / "shared/data/teleop_round_trips"
LINKS = {"local": None, "building Wi-Fi": "wifi_building", "repeater": "wifi_repeater", "4G": "mobile_4g"}
RENDERS = {"local": "patch model", "hold": "newest force"}
MAX_ERROR = 0.01  # rms error, relative to the peak force
PRESS_FORCE, CYCLE = 2.4, 4  # largest force [N] and period of the presses [s] of the simulated operator on the block
MIN_CONTACT_FORCE = 0.05  # relative to the peak force
MIN_TICKS_APART = 300  # between two contacts
ASSUMED_ROUND_TRIP = 0.3  # [s] determines how long `connect` waits


def size(row, name):
    return hypot(*(float(row[f"{name}_{axis}"] or 0) for axis in "xyz"))


def contacts(rows, peak):
    """Returns the number of contacts of the tool, and the number of those that rendered no force to the operator."""
    touched = [k for k, row in enumerate(rows) if size(row, "true") > MIN_CONTACT_FORCE * peak]
    begins = [k for last, k in zip([-MIN_TICKS_APART, *touched], touched) if k - last >= MIN_TICKS_APART]
    spans = list(zip(begins, [*begins[1:], len(rows)]))
    return len(spans), sum(all(size(row, "sent") < MIN_CONTACT_FORCE * peak for row in rows[a:b]) for a, b in spans)


class Truth:
    """Force of the simulated block as a function of the height of the tip, from a press of 8.4 mm."""

    def __init__(self):
        with tempfile.TemporaryDirectory() as folder:
            run(SLAVE, "process", BLOCK, "--override", "operator.press.depth=8.4 mm", "--out", folder, timeout=600)
            with open(f"{folder}/states.csv", encoding="ascii") as states:
                curve = sorted((float(row["tip_y"]), float(row["true_fy"])) for row in csv.DictReader(states) if row["tip_y"])
        self.heights, self.forces = zip(*curve)

    def at(self, height):
        after = min(max(bisect.bisect(self.heights, height), 1), len(self.heights) - 1)
        (low, high), (begin, end) = (values[after - 1:after + 1] for values in (self.heights, self.forces))
        share = min(max((height - low) / (high - low), 0), 1) if high > low else 0
        return (0, begin + share * (end - begin), 0)


class Sum:
    """Totals of the sessions over one link with one rendering."""

    def __init__(self, truth):
        self.truth, self.squares, self.ticks, self.most = truth, 0.0, 0, 0.0
        self.seconds, self.contacts, self.missed, self.energy = {}, 0, 0, 0.0

    def add(self, report, rows):
        for row in rows:
            if row["state"] != "FOLLOWING":
                continue
            rendered, truth = [float(row[f"local_{axis}"]) for axis in "xyz"], self.truth.at(float(row["p_S_y"]))
            if max(hypot(*rendered), truth[1]) > 0.01 * PRESS_FORCE:
                error = dist(rendered, truth) / PRESS_FORCE
                self.squares, self.ticks, self.most = self.squares + error**2, self.ticks + 1, max(self.most, error)
        for state, seconds in report["seconds_in"].items():
            self.seconds[state] = self.seconds.get(state, 0) + seconds
        found, missed = contacts(rows, report["force_peak_N"])
        self.contacts, self.missed = self.contacts + found, self.missed + missed
        self.energy = min(self.energy, report["energy_min_J"])

    def error(self):
        return sqrt(self.squares / max(self.ticks, 1))

    def hold_share(self):
        held = self.seconds.get("HOLD", 0)
        return held / max(held + self.seconds.get("FOLLOWING", 0), 1e-9)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--parts", type=int, default=2, help="sessions per row, from as many places of the recording")
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    if not DATA.exists() or not can_impair_links():
        print("skipped: no ../shared/data/teleop_round_trips, or no network namespaces and TUN device")
        return 77
    holds, truth = True, Truth()
    print("| link | rendering | error: rms, largest | time in HOLD | missed contacts | largest energy to the operator |\n"
          + "|---" * 6 + "|")
    for link, file in LINKS.items():
        if options.only not in link:
            continue
        for render, name in RENDERS.items():
            total = Sum(truth)
            for part in range(options.parts):
                delay = recorded_delay(DATA / f"{file}.csv", part / options.parts) if file else None
                with tempfile.TemporaryDirectory() as folder:
                    report, rows = run_session(ImpairedLink(delay=delay), "stiff", render, options.seconds, ASSUMED_ROUND_TRIP, pathlib.Path(folder), True)
                if report is None:
                    raise RuntimeError(f"{link}: no session")
                total.add(report, rows)
            print(f"| {link} | {name} | {100 * total.error():.2f} %, {100 * total.most:.2f} % | "
                  f"{100 * total.hold_share():.1f} % | {total.missed} of {total.contacts}, {options.parts * options.seconds / CYCLE:.0f} cycles | {-1e3 * total.energy:.2f} mJ |", flush=True)
            holds = holds and total.energy >= MIN_NOISE_ENERGY and (render != "local" or total.error() <= MAX_ERROR)
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
