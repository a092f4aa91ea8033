"""The cases of ../shared/cases and ../shared/cases-2: the output of each command against the README of the case.

A rejection must have an exit status other than 0 and name the cause. A force must be that of the same input in its plain form, an
elastic modulus and a state within half a unit of the last digit in the README.
"""
import functools
import pathlib
import re
import shutil
import tempfile
from typing import NamedTuple

import runners
from campaign import Case, Skipped, verdict
from runners import ROOT

import programs

CASES = ROOT.parent / "shared/cases"
MORE_CASES = ROOT.parent / "shared/cases-2"


class Result(NamedTuple):
    status: int
    text: str
    out: pathlib.Path
    case: pathlib.Path


def execute(command, case, out):
    places = {"MCAP": recording_in(out)} if "{MCAP}" in command else {}
    return Result(*runners.shell(command, case, OUT=out, **places), out, case)


def recording_in(out):
    """Records a simulated press of a few hundred samples by a slave."""
    file = out / "recorded.mcap"
    with programs.Slave(programs.BLOCK, "--record", file):
        if not programs.wait_until(lambda: file.exists() and file.stat().st_size > 200_000):
            raise AssertionError("the slave recorded nothing")
    return file


# ---- expectations: each returns the reason why a result is not as expected, or nothing

def says(*patterns):
    """Expects that the input is accepted with remarks that match all patterns."""
    def check(result):
        missing = [p for p in patterns if not re.search(p, result.text, re.I)]
        return (result.status and f"status {result.status}") or (missing and f"no text like {missing[0]!r}")
    return check


def refuses(*patterns, status=None):
    """Expects that the input is rejected with a message that matches all patterns."""
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


def all_of(*checks):
    def check(result):
        return next((reason for reason in (c(result) for c in checks) if reason), None)
    return check


def modulus(pascal, relative=0.006):
    """Expects a modulus, as in `E at rest 81.0 kPa`, to three digits."""
    def check(result):
        if result.status:
            return f"status {result.status}"
        found = re.search(r"at rest E (\S+)", result.text)
        return (not found and "no modulus") or (abs(float(found[1]) / pascal - 1) > relative and f"E {found[1]}")
    return check


def state(*force, count=None):
    """Expects the last row of states.csv to five decimals."""
    def check(result):
        if result.status:
            return f"status {result.status}"
        rows = runners.table(result.out / "states.csv")
        last = [float(rows[-1][key] or "nan") for key in ("fx", "fy", "fz")]
        near = all(abs(a - b) <= 2e-5 for a, b in zip(last, force))
        return (not near and f"state {last}") or (count and len(rows) != count and f"{len(rows)} samples")
    return check


def not_valid(check, but_below=0.0):
    """Expects that all valid states have a force below `but_below` [N], and that some states name this check."""
    def check_states(result):
        if result.status:
            return f"status {result.status}"
        rows = runners.table(result.out / "states.csv")
        size = [sum(float(row[key] or "nan")**2 for key in ("fx", "fy", "fz"))**0.5 for row in rows]
        valid = sum(row["validity"] == "valid" and not force < but_below for row, force in zip(rows, size))
        named = re.search(check, result.text) or any(re.search(check, row.get("check") or "") for row in rows)
        return (not rows and "no state") or (valid and f"{valid} of {len(rows)} valid") or (not named and f"no {check}")
    return check_states


def faded(at_once, held, relative=0.03):
    """Expects the moduli of a relaxation test [Pa]."""
    def check(result):
        found = re.search(r"young_modulus (\S+) \+- .* is for contacts held for .*, (\S+) Pa for quick", result.text)
        if result.status or not found:
            return f"status {result.status}, no relaxation"
        wrong = abs(float(found[2]) / at_once - 1) > relative or abs(float(found[1]) / held - 1) > relative
        return wrong and f"{found[2]} and {found[1]} Pa"
    return check


def round_contact(result):
    """Expects that the contact of a sphere grows with the depth: the force of twice the depth is 2^1.5 times as large
    (Hertz), on a bonded layer of 20 mm 3.07 times (Dimitriadis et al., Biophys J 82, 2002); the mesh is coarse under
    the tool."""
    if result.status:
        return f"status {result.status}"
    one, two = (abs(force[2]) for force in forces_of(result.out / "answers.csv"))
    return abs(two / one / 3.07 - 1) > 0.1 and f"force ratio {two / one:.3f}"


def forces_of(answers):
    return [runners.vector(row) for row in runners.table(answers)]


def force(plain):
    """Expects the forces of the same command with the input in its plain form, which plain(folder) writes."""
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
            # The numbers are the same except for the order of nodes and the rounding of floats.
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
    """The case has no images, so the remark must not need them."""
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
    """With one row per case the middle contact has 0.146 N by whole elements, as in the README, and 0.1485 N by the tool's
    width. If rows act together, the output must state it."""
    together = says("act together")(result)
    if together:
        return together
    apart = execute(command_of(result.case) + " --independent", result.case, result.out)
    if apart.status:
        return f"--independent: {apart.text}"
    middle = forces_of(result.out / "answers.csv")
    middle = abs(middle[1][1])  # at x = 18 mm, as in the README
    return abs(middle - 0.1485) > 0.0005 and f"{middle} N"


def with_present_kind(case, out):
    """The README names `bem3d` for closed surfaces; `fem-green` has replaced it."""
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
    "M14b": refuses(r"expected a file that can be read: \.node"),  # Vega
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


# Expectations of the READMEs of the second set.
MORE_EXPECTED = {
    "A02": either(all_of(modulus(81e3, 0.02), says("loading and unloading|hysteresis")), refuses("hysteresis|unloading")),
    "A06": either(faded(18e3, 10.8e3), refuses("shear")),
    "A08": refuses("workbook", "CSV"),
    "A14": either(modulus(85e3, 0.02), refuses("twice|two columns|occurs? .*times"), says("twice|two columns|occurs? .*times")),
    "B13": either(says("nanoseconds"), refuses("nanoseconds")),
    "B17": either(refuses("time", "falls|back|decreases"), says("time", "falls|back|decreases")),
    "C20": either(refuses("outside"), says("outside|shift")),
    "E01": either(refuses("rest"), not_valid("rest")),
    "E04": refuses("TIFF", "16.bit.*PNG|PNG.*16.bit"),
    "E05": either(refuses("rest"), not_valid("rest")),
    "F09": refuses("Gmsh.*format 1", "convert|gmsh .*-save|-format"),
    "F17": either(force(rewrite("scene.yaml", lambda text: text.replace(b"at: 0 mm", b"at: 0.001 mm"))),
                  refuses("no node", "nearest")),
    # While the contact lasts it cannot be detected: relative to the baseline the force is zero.
    # Its network is older than the checks of channels.
    "G10": either(refuses("rest|channels is missing"), not_valid("rest_drift", but_below=0.3)),
    "G21": either(refuses("fz > 0|sign"), says("fz > 0|sign")),
    "G22": refuses("c0"),
    "G26": either(refuses("mN"), says("mN")),
    "H07": refuses("rosbag2|SQLite", "MCAP"),
    "H12": either(refuses("second|another|follow"), says("second|another|follow")),
    "J10": refuses("web server|HTTP|no palpate"),
    "J21": either(refuses("metres|mm"), says("millimetres")),
    "K03": refuses("PCD", "text|x y z"),
    "L01": either(round_contact, says("flat")),
    "L06": either(refuses("density", "1070|g/cm"), says("density", "1070|g/cm")),
    "L17": refuses("modul", "scene|times"),
    "N01": refuses("--state", "state_dict"),
    "N16": refuses("forward pass"),
    "N17": refuses("--sensor"),
}


def three_valid_states(result):
    if result.status:
        return f"status {result.status}: {result.text[-200:]}"
    rows = runners.table(result.out / "states.csv")
    wrong = [row for row in rows if row["validity"] != "valid" or abs(float(row["fy"] or "nan")) > 0.005]
    return (len(rows) != 3 and f"{len(rows)} states") or (wrong and f"{wrong[0]}")


EXPECTED["P03"] = three_valid_states


def command_of(case):
    readme = next(file for file in (case / "README", case / "README.md") if file.is_file())
    return re.search(r"^(?:- )?Command: (.*)$", readme.read_text(), re.M)[1].strip("`")


def judged(case, expectations, out):
    own = [run for key, run in OWN.items() if expectations is EXPECTED and case.name.startswith(key)]
    if own:
        reason = own[0](case, out)
        return verdict("silent" if reason else "right", reason or "")
    expected = [check for key, check in expectations.items() if (case.name + "-").startswith(key.rstrip("-") + "-")]
    if len(expected) != 1:
        return verdict("silent", "no expectation in tests/campaigns/cases.py")
    case = with_present_kind(case, out)
    result = execute(command_of(case), case, out)
    reason = expected[0](result)
    if reason:
        return verdict("unhelpful" if result.status else "silent", "\n      ".join([str(reason), *result.text.splitlines()[-8:]]))
    return verdict("refused" if result.status else "right")


def cases(options):
    sets = [(folder, expectations) for folder, expectations in ((CASES, EXPECTED), (MORE_CASES, MORE_EXPECTED)) if folder.is_dir()]
    if not sets:
        raise Skipped(f"{CASES} and {MORE_CASES} are absent")
    return [Case(f"{folder.name}/{case.name}", functools.partial(judged, case, expectations), folder.name)
            for folder, expectations in sets for case in sorted(folder.iterdir()) if case.is_dir()]
