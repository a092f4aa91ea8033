#!/usr/bin/python3
"""Runs the conditions of a table in random order: sets the parameters of the slave, then a session of the master.

usage: trials.py HOST:PORT TABLE.csv OUT [--seed N] [--master PROGRAM] [--tls DIR] [-- MASTER_OPTIONS ...]

Columns of the table: label, seconds; if wanted repeats, render, position_scale, force_scale, young_modulus. Writes
OUT/marks.csv (number, label, begin_s, end_s since 1970), and OUT/NUMBER-LABEL.csv and .mcap for each trial. Exit code
0: all trials ran.
"""
import argparse
import csv
import pathlib
import random
import subprocess
import sys
import time

import palpate
from palpate.v1 import teleoperation_pb2

SETTINGS = ("position_scale", "force_scale", "young_modulus")
COLUMNS = ("label", "seconds", "repeats", "render", *SETTINGS)


def read_table(path: pathlib.Path) -> list[dict[str, str]]:
    with open(path, newline="", encoding="utf-8-sig") as file:
        rows = list(csv.DictReader(file))
    for line, row in enumerate(rows, 2):
        for column, text in row.items():
            if column not in COLUMNS:
                sys.exit(f"{path}:1: column {column}: expected {', '.join(COLUMNS)}")
            if column in ("seconds", "repeats", *SETTINGS) and text:
                try:
                    float(text)
                except ValueError:
                    sys.exit(f"{path}:{line}: {column} = {text}: expected a number")
        if not row.get("label") or not row.get("seconds"):
            sys.exit(f"{path}:{line}: expected a row with label and seconds")
    return [row for row in rows for _ in range(int(row.get("repeats") or 1))]


def apply(slave: palpate.Slave, row: dict[str, str]) -> None:
    request = teleoperation_pb2.SetParametersRequest()
    for name in SETTINGS:
        if row.get(name):
            setattr(request, name, float(row[name]))
    slave.stub.SetParameters(request, timeout=60)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("table", type=pathlib.Path, help="TABLE.csv")
    parser.add_argument("out", type=pathlib.Path, help="folder")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--master", default="palpate-master", metavar="PROGRAM")
    parser.add_argument("--tls", metavar="DIR", help="folder with ca.pem, cert.pem and key.pem")
    own, rest = sys.argv[1:], []
    if "--" in own:
        rest = own[own.index("--") + 1:]
        own = own[:own.index("--")]
    arguments = parser.parse_args(own)
    trials = read_table(arguments.table)
    random.Random(arguments.seed).shuffle(trials)
    arguments.out.mkdir(parents=True, exist_ok=True)
    marks = []
    for number, row in enumerate(trials, 1):
        with palpate.connect(arguments.target, arguments.tls) as slave:
            apply(slave, row)
        name = arguments.out / f"{number:02}-{row['label']}"
        command = [arguments.master, "connect", arguments.target, "--duration", row["seconds"], "--render",
                   row.get("render") or "local", "--log", f"{name}.csv", "--record", f"{name}.mcap", *rest]
        if arguments.tls:
            command += ["--tls", arguments.tls]
        begin = time.time()
        done = subprocess.run(command, stdout=subprocess.DEVNULL)
        marks.append((number, row["label"], f"{begin:.3f}", f"{time.time():.3f}"))
        print(f"trial {number}: {row['label']}", flush=True)
        if done.returncode != 0:
            return 1
    with open(arguments.out / "marks.csv", "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([("number", "label", "begin_s", "end_s"), *marks])
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except palpate.Error as error:
        sys.exit(f"error: {error}")
