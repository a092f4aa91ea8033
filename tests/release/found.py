"""What the present programs find in recordings."""
import csv
import math
import pathlib
import tempfile

from programs import MASTER, SLAVE, run


def summary(file):
    """Number of states, and the largest force with its sigma, of a table states.csv."""
    with open(file, newline="") as table:
        rows = list(csv.DictReader(table))
    forces = [(math.hypot(*(float(row[axis]) for axis in ("fx", "fy", "fz"))), float(row["sigma"])) for row in rows if row["fx"]]
    peak, sigma = max(forces)
    return {"states": len(rows), "with_force": len(forces), "peak_N": peak, "sigma_N": sigma}


def made_by(*command):
    done = run(*command)
    if done.returncode != 0:
        raise AssertionError(f"{command}: exit {done.returncode}\n{done.stderr}")


def in_slave(recording):
    """By `palpate-slave process`, which computes every state again."""
    with tempfile.TemporaryDirectory() as out:
        made_by(SLAVE, "process", recording, "--out", out)
        return summary(pathlib.Path(out, "states.csv"))


def in_session(recording):
    """By `palpate-master export`."""
    with tempfile.TemporaryDirectory() as out:
        made_by(MASTER, "export", recording, "--out", out)
        return summary(pathlib.Path(out, "states.csv"))
