#!/usr/bin/env python3
"""Runs the cases of ../shared/cases and compares what the programs say with the README of each case.

cases.py [NAME...]   runs all cases, or those whose names begin with NAME; exit 1: one is not as expected; 77: no cases

A refusal must have an exit status other than 0 and name the cause. A force must be that of the same input in its plain
form, an elastic modulus and a state within half a unit of the last digit that the README gives. Programs: PALPATE_BIN,
default build/release/bin.
"""
import csv
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parents[1]
BIN = pathlib.Path(os.environ.get("PALPATE_BIN", ROOT / "build/release/bin")).resolve()
CASES = ROOT.parent / "shared/cases"


class Result(NamedTuple):
    status: int
    text: str
    out: pathlib.Path
    case: pathlib.Path


def execute(command, case, out):
    for key, value in (("BIN", BIN), ("REPO", ROOT), ("OUT", out)):
        command = command.replace("{%s}" % key, str(value))
    done = subprocess.run(["bash", "-c", command], cwd=case, capture_output=True, timeout=300)
    return Result(done.returncode, (done.stdout + done.stderr).decode(errors="replace"), out, case)


# ---- expectations: each returns the reason why a result is not as expected, or nothing

def says(*patterns):
    """Accepted, with remarks that match all patterns."""
    def check(result):
        missing = [p for p in patterns if not re.search(p, result.text, re.I)]
        return (result.status and f"status {result.status}") or (missing and f"no text like {missing[0]!r}")
    return check


def refuses(*patterns, status=None):
    """Refused, with a message that matches all patterns."""
    def check(result):
        missing = [p for p in patterns if not re.search(p, result.text, re.I)]
        wrong = result.status == 0 if status is None else result.status != status
        return (wrong and f"status {result.status}") or (missing and f"no text like {missing[0]!r}")
    return check


def either(*checks):
    def check(result):
        reasons = [c(result) for c in checks]
        return all(reasons) and "; ".join(map(str, reasons))
    return check


def modulus(pascal, relative=0.006):
    """`E at rest 81.0 kPa`: three digits."""
    def check(result):
        if result.status:
            return f"status {result.status}"
        found = re.search(r"at rest E (\S+)", result.text)
        return (not found and "no modulus") or (abs(float(found[1]) / pascal - 1) > relative and f"E {found[1]}")
    return check


def state(*force, count=None):
    """The last row of states.csv; five decimals."""
    def check(result):
        if result.status:
            return f"status {result.status}"
        rows = list(csv.DictReader(open(result.out / "states.csv")))
        last = [float(rows[-1][key] or "nan") for key in ("fx", "fy", "fz")]
        near = all(abs(a - b) <= 2e-5 for a, b in zip(last, force))
        return (not near and f"state {last}") or (count and len(rows) != count and f"{len(rows)} samples")
    return check


def forces_of(answers):
    return [[float(row[key] or "nan") for key in ("fx", "fy", "fz")] for row in csv.DictReader(open(answers))]


def force(plain):
    """The forces of the same command where plain(folder) has written the input in its plain form."""
    def check(result):
        if result.status:
            return f"status {result.status}: {result.text[:200]}"
        with tempfile.TemporaryDirectory() as folder:
            case, out = pathlib.Path(folder) / "case", pathlib.Path(folder) / "out"
            shutil.copytree(result.case, case)
            out.mkdir()
            plain(case)
            reference = execute(command_of(case), case, out)
            if reference.status:
                return f"the plain form is refused: {reference.text}"
            pairs = zip(forces_of(result.out / "answers.csv"), forces_of(out / "answers.csv"))
            # The same numbers in another file: at most the order of nodes, and the rounding of floats, differ.
            same = all(abs(a - b) <= 1e-6 * max(map(abs, two)) for one, two in pairs for a, b in zip(one, two))
        return not same and "another force than of the plain form"
    return check


# ---- plain forms

def rewrite(name, change, target=None):
    def plain(case):
        text = change((case / name).read_bytes())
        (case / name).unlink()
        (case / (target or name)).write_bytes(text)
        if target:
            scene = (case / "scene.yaml").read_text().replace(name, target)
            (case / "scene.yaml").write_text(scene)
    return plain


def without_parameters(text):
    begin, end = text.index(b"$ParametricNodes"), text.index(b"$EndParametricNodes")
    rows = text[begin:end].splitlines()
    rows = rows[:2] + [b" ".join(row.split()[:4]) for row in rows[2:]]
    text = text[:begin] + b"\n".join(rows) + b"\n" + text[end:]
    return text.replace(b"ParametricNodes", b"Nodes")


def without_tail(text):
    header = b"binary" + text[6:80]
    return header + text[80:84] + text[84:84 + 50 * int.from_bytes(text[80:84], "little")]


def plain_veg(case):
    for ending in ("node", "ele"):
        (case / f"cube gel.{ending}").rename(case / f"cube.{ending}")
    rewrite("cube.veg", lambda text: text.replace(b"cube gel.", b"cube."))(case)


def plain_tetgen(case):
    for name in ("cube.node", "cube.ele"):
        rewrite(name, lambda text: text.removeprefix(b"\xef\xbb\xbf"))(case)


def plain_rows(change):
    return rewrite("press.csv", lambda text: "\n".join(map(change, text.decode().splitlines())).encode())


# ---- cases with commands of their own

def full_disk(case, out):
    result = execute("{BIN}/palpate-slave check scene.yaml >/dev/full", case, out)
    return (result.status == 0 and "status 0") or ("cannot be written" not in result.text and result.text)


def rig_in_millimetres(case, out):
    """Its images are not included: the remark must not need them."""
    copy = out / "case"
    shutil.copytree(case, copy)
    scene = ROOT / "deploy/scenes/rubber-membrane.yaml"
    made = execute(f"{{BIN}}/palpate-slave process {scene} --frames --out {copy}", case, out)
    for side in ("left", "right"):
        if (copy / "frames" / side).is_dir():
            (copy / "frames" / side).rename(copy / side)
    if not (copy / "left").is_dir():
        return f"no images: {made.text}"
    return either(says("baseline", "60 m"), refuses("baseline", "60 m"))(
        execute("{BIN}/palpate-slave check scene.yaml", copy, out))


def single_presses(result):
    """One row per case has 0.146 N in the middle; rows that act together must state it."""
    together = says("act together")(result)
    if together:
        return together
    apart = execute(command_of(result.case) + " --independent", result.case, result.out)
    if apart.status:
        return f"--independent: {apart.text}"
    middle = forces_of(result.out / "answers.csv")
    middle = abs(middle[1][1])  # at x = 18 mm, which the README means
    return abs(middle - 0.146) > 0.0005 and f"{middle} N"


def with_present_kind(case, out):
    """Closed surfaces were answered by `bem3d`, which is removed: `fem-green` answers for them."""
    scene = case / "scene.yaml"
    if not scene.is_file() or b"kind: bem3d" not in scene.read_bytes():
        return case
    shutil.copytree(case, out / "case")
    (out / "case/scene.yaml").write_bytes(scene.read_bytes().replace(b"kind: bem3d", b"kind: fem-green"))
    return out / "case"


OWN = {"X01": full_disk, "R01": rig_in_millimetres}
EXPECTED = {
    "C01": either(says(r"at \(\S+( mm)?, 18 mm, 0\)"), refuses("three columns|columns? .*(,|without a name)")),
    "C04": either(says("60 m x", "millimetres|unit"), says(r"at \(\S+( mm)?, 18 mm, 0\)")),
    "D01": refuses("boundary"),
    "G01": says("pixel of 350 mm|pixel.*larger", "350"),
    "I01": either(modulus(81e3), refuses("row of units")),
    "I02b": either(modulus(81e3), refuses("quote")),
    "I03": either(modulus(81e3), refuses("semicolon|decimal comma")),
    "I04": either(modulus(3e6), refuses("unit")),
    "I05-": either(modulus(300e3), refuses("unit|force in")),
    "I05c": either(modulus(81e3), refuses("unit", "lbf")),
    "I06": either(modulus(12e6), refuses("unit", "psi")),
    "I07": either(modulus(9e6), refuses("Standardkraft")),
    "I08": either(modulus(81e3), says("toe|slack|contact begins")),
    "I10": either(modulus(81e3), refuses("UTF-16")),
    "I11": either(modulus(81e3), refuses("unit")),
    "I12": either(modulus(81e3), refuses("true strain")),
    "I17": either(says("percent|%.*unit|800 %"), refuses("percent")),
    "M01": force(rewrite("CUBE.STL", bytes, "cube.stl")),
    "M02": force(rewrite("cube.stl", bytes.lower)),
    "M03b": either(force(rewrite("cube.stl", without_tail)), refuses("length|bytes behind")),
    "M05": either(force(rewrite("cube.msh", without_parameters)), refuses(r"\$ParametricNodes")),
    "M08": says("millimetres"),
    "M09": says("physical|groups", "not used|not read"),
    "M14b": either(force(plain_veg), refuses("blank|space")),
    "M15": either(force(plain_tetgen), refuses("byte order mark")),
    "M16": force(rewrite("cube.stl", bytes.lstrip)),
    "M18": either(force(rewrite("cube.ply", lambda text: text.replace(b"\r", b"\n"))), refuses("line end")),
    "M20": says("duplicate nodes"),
    "N04": either(says("ticks"), refuses("lz4")),
    "N06": either(refuses("UTF-8"), says("rc 0")),
    "N08": refuses(r"\[::1\]", r"10\.0\.0\.300.*expected|expected.*10\.0\.0\.300", r"10\.0\.0\.5:50051", "rc 1", status=0),
    "N09": refuses("name", "expected", "rc [12]", "A-Z|letters", status=0),
    **dict.fromkeys(("O01-", "O01c", "O04c", "O05", "O30", "O43", "O45", "O53", "O55"),
                    refuses("onnx", "palpate.convert_network")),
    "P03": None,
    "S01": either(force(plain_rows(lambda row: row.partition(",")[2])), refuses("without a name")),
    "S02": force(plain_rows(lambda row: row.rstrip(","))),
    "S03b": single_presses,
    "S05": either(says("wider than the object"), refuses("width", "object")),
    "T01": refuses("time", "increase"),
    "T02": either(state(1.06429, 0.75475, -0.45276, count=40), refuses("time", "increase|equal"), says("equal times?", "dropped|averaged")),
    "Y01": either(force(rewrite("scene.yaml", lambda text: text.replace("\u00a0".encode(), b" "))), refuses(r"U\+00A0")),
    "Y02": either(says("valid"), refuses("UTF-16")),
    "Y06": refuses("decimal comma"),
    "Y07": refuses("rotation", "rad|deg"),
    "Y12": refuses("tab"),
    "Y14": says("50 m", "millimetres|unit"),
}


def three_valid_states(result):
    if result.status:
        return f"status {result.status}: {result.text[-200:]}"
    rows = list(csv.DictReader(open(result.out / "states.csv")))
    wrong = [row for row in rows if row["validity"] != "valid" or abs(float(row["fy"] or "nan")) > 0.005]
    return (len(rows) != 3 and f"{len(rows)} states") or (wrong and f"{wrong[0]}")


EXPECTED["P03"] = three_valid_states


def command_of(case):
    return re.search(r"^Command: (.*)$", (case / "README").read_text(), re.M)[1]


def reason_against(case):
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder)
        own = [run for key, run in OWN.items() if case.name.startswith(key)]
        if own:
            return own[0](case, out)
        expected = [check for key, check in EXPECTED.items() if (case.name + "-").startswith(key.rstrip("-") + "-")]
        if len(expected) != 1:
            return "no expectation in tests/cases.py"
        case = with_present_kind(case, out)
        result = execute(command_of(case), case, out)
        reason = expected[0](result)
        return reason and f"{reason}\n    " + "\n    ".join(result.text.splitlines()[-8:])


def main():
    if not CASES.is_dir():
        print(f"skipped: {CASES} is absent")
        return 77
    chosen = [case for case in sorted(CASES.iterdir()) if case.is_dir()]
    if sys.argv[1:]:
        chosen = [case for case in chosen if case.name.startswith(tuple(sys.argv[1:]))]
    failed = 0
    for case in chosen:
        reason = reason_against(case)
        print(f"{'FAILED' if reason else 'ok':7}{case.name}" + (f": {reason}" if reason else ""), flush=True)
        failed += bool(reason)
    print(f"{len(chosen) - failed} of {len(chosen)} as expected")
    return 1 if failed or not chosen else 0


if __name__ == "__main__":
    sys.exit(main())
