#!/usr/bin/env python3
"""Switches each check off in turn and prints what changes, as Markdown for tests/RESULTS.md.

ablation.py PROGRAM --out DIR [--mixed N] [--seed S] [--only SENSE]

PROGRAM is `robustness`. Each run plays N pairs of alterations per sense, drawn with the seed; the quick rows too. Results
of a run stay in DIR, so that an interrupted study goes on where it stopped.
"""
import argparse
import csv
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
SENSES = {"camera": "camera", "points": "pairs", "load": "pairs", "fingertips": "fingertips"}  # folder of checks: sense of the suite


def checks():
    """(sense, name) of every check that a pipeline adds to its lists."""
    found = {(SENSES[path.parent.name], name): None for path in sorted((ROOT / "slave/checks").rglob("*.cpp"))
             for name in re.findall(r'\.Add\("(\w+)"', path.read_text(encoding="utf-8"))}
    return list(found)


def run(program, out, sense, rows, without):
    """Rows of one run: {row: (samples, valid, undetected)}. A run that has ended is not repeated."""
    folder = out / f"{sense}-{'without-' + without if without else 'all'}-{'-'.join(rows).strip('-')}"
    done = folder / "done"
    if not done.exists():
        command = [program, "--only", f"^{sense} ", "--out", folder, *rows]
        said = subprocess.run(command + (["--without", without] if without else []), capture_output=True, text=True)
        if said.returncode not in (0, 1):
            sys.exit(said.stderr or said.stdout)
        done.touch()
    with open(folder / "table.csv", newline="", encoding="utf-8") as file:
        return {(row["stage"], row["case"]): (int(row["samples"]), int(row["valid"]), int(row["silent"]))
                for row in csv.DictReader(file)}


def study(program, out, sense, sets, without=""):
    rows = {}
    for number, one in enumerate(sets):
        rows |= {(number, *key): value for key, value in run(program, out, sense, one, without).items()}
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--mixed", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    sets = [["--quick"], ["--mixed", str(options.mixed), "--seed", str(options.seed)]]
    print("| sense | check left out | rows that change | undetected errors | valid samples |\n|---|---|---|---|---|")
    with_all = {}
    for sense, name in checks():
        if options.only not in ("", sense):
            continue
        if sense not in with_all:
            with_all[sense] = study(options.program, options.out, sense, sets)
        before, after = with_all[sense], study(options.program, options.out, sense, sets, name)
        changed = sum(before[key] != after[key] for key in before)
        silent = [sum(value[2] for value in rows.values()) for rows in (before, after)]
        valid = [sum(value[1] for value in rows.values()) for rows in (before, after)]
        print(f"| {sense} | {name} | {changed} of {len(before)} | {silent[0]} to {silent[1]} | {valid[0]} to {valid[1]} |",
              flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
