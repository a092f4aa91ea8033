"""Runs the built programs on the files of a case."""
import csv
import json
import os
import pathlib
import subprocess
import sys

from campaign import Refused

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("PALPATE_BIN", ROOT / "build/release/bin")).resolve()
PACKAGE = BIN.parent / "python"  # the Python package palpate
PYTHON = "/usr/bin/python3"  # with NumPy and PyTorch
SLAVE, MASTER = BIN / "palpate-slave", BIN / "palpate-master"
DATA = ROOT.parent / "shared/data"  # recordings of others
sys.path += [str(ROOT / folder) for folder in ("tests", "tests/e2e", "deploy/examples")]


def run(*command, codes=(0,), **options):
    """Runs a program to its end. Raises Refused with its output for other exit codes than `codes`."""
    done = subprocess.run([str(word) for word in command], stdin=subprocess.DEVNULL, capture_output=True, text=True, **options)
    if done.returncode not in codes:
        raise Refused((done.stdout + done.stderr).strip())
    return done


def run_python(module, *arguments, **options):
    """Runs a module of the Python package palpate."""
    return run(PYTHON, "-m", module, *arguments, env={**os.environ, "PYTHONPATH": str(PACKAGE)}, **options)


def shell(command, folder, **places):
    """Runs a command line in `folder` with its {PLACES} filled in. Returns the exit code and the output."""
    for key, value in {"BIN": BIN, "REPO": ROOT, "PYTHON": PYTHON, "PY": PACKAGE, **places}.items():
        command = command.replace("{%s}" % key, str(value))
    done = subprocess.run(["bash", "-c", command], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, timeout=300)
    return done.returncode, (done.stdout + done.stderr).decode(errors="replace")


def rows_of(text):
    return list(csv.DictReader(text.splitlines()))


def table(file):
    return rows_of(file.read_text(encoding="utf-8"))


def write_table(file, names, rows):
    with open(file, "w", newline="", encoding="utf-8") as lines:
        csv.writer(lines).writerows([names, *rows])
    return file


def report(folder, command, *words, codes=(0,)):
    """Runs a command of the slave that writes FOLDER/report.json."""
    run(SLAVE, command, *words, "--out", folder, codes=codes)
    return json.loads((folder / "report.json").read_text())


def process(scene, out, *options, overrides=()):
    """Returns the rows of states.csv."""
    run(SLAVE, "process", scene, "--out", out, *options, *(word for one in overrides for word in ("--override", one)))
    return table(out / "states.csv")


def solve(scene, contacts, answers):
    """Returns the rows of the answers, and the remarks of the program."""
    remarks = run(SLAVE, "solve", scene, "--contacts", contacts, "--out", answers).stderr
    return table(answers), remarks


def study(scene, out, budget):
    """Returns the rows of study.csv."""
    run(SLAVE, "study", scene, "--out", out, "--budget", budget)
    return table(out / "study.csv")


def vector(row, prefix="f"):
    return tuple(float(row[prefix + axis] or "nan") for axis in "xyz")


class Serving:
    """A program in the background that prints `words` before its address."""

    def __init__(self, words, *command):
        self.process = subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        for line in self.process.stdout:
            if words in line:
                self.address = line.split(words)[1].split()[0]
                return
        raise Refused(f"{command[0]} ended")

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.process.terminate()
        self.process.wait()
        self.process.stdout.close()
