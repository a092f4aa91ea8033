#!/usr/bin/env python3
"""Replays the round trips of real telerobots (../shared/data/teleop_round_trips) between slave and master, one row per link.

  recorded_links.py [--seconds 60] [--parts 2] [--only WORDS]

The simulated operator presses the block every 4 s, once with the local contact model and once with the newest received
force. Columns: the rendered force minus the true force at the same commanded position, without HOLD, in percent of the
largest true force (rms of the later contacts, of the first one); share of the engaged time in HOLD; contacts of the tool
of which no force reached the operator; energy that the operator got beyond what was put in.
Exit code 1: energy was created, or the error with the local model exceeds 1 %; 77: no recordings, or no network namespaces.
"""
import argparse
import math
import pathlib
import sys
import tempfile

from bad_line import BadLine, permitted, recorded_delay
from impairment import NOISE_ENERGY, session
from programs import ROOT

DATA = ROOT.parent / "shared/data/teleop_round_trips"
LINKS = {"local": None, "building Wi-Fi": "wifi_building", "repeater": "wifi_repeater", "4G": "mobile_4g"}
RENDERS = {"local": "patch model", "hold": "newest force"}
MOST_ERROR = 0.01  # of the peak
TOUCH, APART, WAIT = 0.05, 300, 0.3  # of the peak; ticks between two contacts; round trip that `connect` waits for [s]


def size(row, name):
    return math.hypot(*(float(row[f"{name}_{axis}"] or 0) for axis in "xyz"))


def contacts(rows, peak):
    """(contacts of the tool, those of which no force reached the operator)."""
    touched = [k for k, row in enumerate(rows) if size(row, "true") > TOUCH * peak]
    begins = [k for last, k in zip([-APART, *touched], touched) if k - last >= APART]
    spans = list(zip(begins, [*begins[1:], len(rows)]))
    return len(spans), sum(all(size(row, "sent") < TOUCH * peak for row in rows[a:b]) for a, b in spans)


class Sum:
    """What the sessions over one link with one rendering add up to."""

    def __init__(self):
        self.squares, self.ticks = {"later": 0.0, "first": 0.0}, {"later": 0, "first": 0}
        self.seconds, self.contacts, self.missed, self.energy = {}, 0, 0, 0.0

    def add(self, report, rows):
        peak = report["force_peak_N"]
        error = report["force_error_delay_compensated"] or {}
        for name, part in (("later", error), ("first", error.get("first_contact", {}))):
            if part.get("contact_ticks"):
                self.ticks[name] += part["contact_ticks"]
                self.squares[name] += part["contact_ticks"] * (part["rms_N"] / peak) ** 2
        for state, seconds in report["seconds_in"].items():
            self.seconds[state] = self.seconds.get(state, 0) + seconds
        found, missed = contacts(rows, peak)
        self.contacts, self.missed = self.contacts + found, self.missed + missed
        self.energy = min(self.energy, report["energy_min_J"])

    def error(self, name):
        return math.sqrt(self.squares[name] / self.ticks[name]) if self.ticks[name] else math.nan

    def hold_share(self):
        held = self.seconds.get("HOLD", 0)
        return held / max(held + self.seconds.get("FOLLOWING", 0), 1e-9)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--parts", type=int, default=2, help="sessions per row, from as many places of the recording")
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    if not DATA.exists() or not permitted():
        print("skipped: no ../shared/data/teleop_round_trips, or no network namespaces and TUN device")
        return 77
    holds = True
    print("| link | rendering | error: later, first contact | time in HOLD | missed contacts | largest energy to the operator |\n"
          + "|---" * 6 + "|")
    for link, file in LINKS.items():
        if options.only not in link:
            continue
        for render, name in RENDERS.items():
            total = Sum()
            for part in range(options.parts):
                delay = recorded_delay(DATA / f"{file}.csv", part / options.parts) if file else None
                with tempfile.TemporaryDirectory() as folder:
                    report, rows = session(BadLine(delay=delay), "stiff", render, options.seconds, WAIT, pathlib.Path(folder), True)
                if report is None:
                    raise RuntimeError(f"{link}: no session")
                total.add(report, rows)
            print(f"| {link} | {name} | {100 * total.error('later'):.2f} %, {100 * total.error('first'):.2f} % | "
                  f"{100 * total.hold_share():.1f} % | {total.missed} of {total.contacts} | {-1e3 * total.energy:.2f} mJ |", flush=True)
            holds = holds and total.energy >= NOISE_ENERGY and (render != "local" or total.error("later") <= MOST_ERROR)
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
