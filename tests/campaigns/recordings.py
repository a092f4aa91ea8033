"""Recordings of other laboratories (../shared/data), run through the programs as a user would.

Each case is a set, with a line for each quantity: published figure, ours, and whether our 95 % interval covers the published one.
It is right if it does and silent if it does not. "by the data's README" marks figures that the README of the set states, where
its authors published none. Sets without a force, a shape or a material that a command estimates are in ELSEWHERE.
"""
import collections
import functools
import math
import os
import re
from typing import NamedTuple

import numpy as np

import runners
from campaign import Case, Outcome, Refused, Skipped, verdict
from runners import DATA

PYTHON = {**os.environ, "PYTHONPATH": str(runners.PACKAGE), "OMP_NUM_THREADS": "1"}
NONE = "none"
GRAM = 9.80665e-3  # weight of a gram [N]


class Row(NamedTuple):
    quantity: str
    published: str
    ours: str
    covers: str = "-"


def run(*words, accept=(0,)):
    done = runners.run(*words, codes=accept, env=PYTHON)
    return done.stdout + done.stderr


def slave(command, *words, accept=(0,)):
    return run(runners.SLAVE, command, *words, accept=accept)


def rounded(value):
    """Formats to three digits without an exponent."""
    return f"{value:.{max(0, 2 - math.floor(math.log10(abs(value))))}f}"


def within(value, half):
    """Formats a value and half of its interval [kPa]."""
    digits = max(0, 1 - math.floor(math.log10(half)))
    return f"{value:.{digits}f} ± {half:.{digits}f} kPa"


def covers(low, value, high):
    return "yes" if low <= value <= high else "no"


# ---- materials

def modulus_of(report):
    """Returns the kind of modulus, its value and half of the 95 % interval [kPa]."""
    if report.get("relaxation"):
        held = report["relaxation"]
        return "modulus of a held contact", held["young_modulus_held_Pa"] / 1e3, held["half_width_Pa"] / 1e3
    if report["moduli"] and report["moduli"][0]["end_factor"] > 1:
        chord = report["moduli"][0]
        return "chord modulus", chord["modulus_Pa"] / 1e3, chord["half_width_Pa"] / 1e3
    best = report.get("scene_law") or report["best"]
    law = next(law for law in report["laws"] if law["law"] == best)
    return f"modulus at rest, {law['law']}", law["young_modulus_Pa"] / 1e3, law["half_width_Pa"] / 1e3


def identified(folder, name, *words):
    what, value, half = modulus_of(runners.report(folder, "identify", *words))
    return Row(f"{name}: {what}", NONE, within(value, half))


def silicone_compression(folder):
    """Compares each interval of specimen A1 also with specimen B1."""
    def modulus(file):
        return modulus_of(runners.report(folder, "identify", f"compression={file}", "--diameter", "50mm", "--height", "30mm", "--ends",
                                    "bonded"))
    published = {row["material"]: float(row["elastic_modulus_mean_kPa"])
                 for row in runners.table(DATA / "silicone_compression/elastic_modulus_kPa.csv")}
    held = count = 0
    for file in sorted((DATA / "silicone_compression").glob("*_A1.csv")):
        name = file.stem[:-3]
        what, value, half = modulus(file)
        other = modulus(file.with_name(f"{name}_B1.csv"))[1]
        held, count = held + (abs(other - value) <= half), count + 1
        known = published.get(name)
        yield Row(f"{name}: {what}, bonded ends", f"{known:.4g} kPa" if known else NONE,
                  f"{within(value, half)}; B1 {rounded(other)}", covers(value - half, known, value + half) if known else "-")
    yield Row("intervals of A1 that hold the modulus of B1", NONE, f"{held} of {count}")


def hyperelastic_curves(folder):
    for name, unit, tests in (
            ("Treloar_1944", "MPa", "uniaxial=UT equibiaxial=ET planar=PS"), ("Kawabata_1981", "MPa", "uniaxial=UT equibiaxial=ET planar=PS"),
            ("Meunier_2008", "MPa", "uniaxial=UT equibiaxial=ET planar=PS"), ("Katashima_2012", "kPa", "equibiaxial=ET planar=PS"),
            ("Budday_2017", "kPa", "tension=UT_T_cortex compression=UT_C_cortex shear=SS_cortex"),
            ("Budday_2017", "kPa", "tension=UT_T_corona_radiata compression=UT_C_corona_radiata shear=SS_corona_radiata")):
        part = " corona radiata" if "corona" in tests else " cortex" if "cortex" in tests else ""
        yield identified(folder, name.replace("_", " ") + part, *tables(DATA / "hyperelastic_curves" / name, tests), "--stress-unit", unit)


def foam_curves(folder):
    """No incompressible law fits a foam: `identify` rejects them and states chord moduli."""
    report = runners.report(folder, "identify", *tables(DATA / "foam_curves/foam_leap", "tension=UT compression=UC shear=SS"))
    laws = report.get("best", "no law")
    for chord in report["moduli"]:
        yield Row(f"midsole, {chord['test']}: chord modulus; {laws} fits at rest", NONE,
                  within(chord["modulus_Pa"] / 1e3, chord["half_width_Pa"] / 1e3))


def viscoelastic_adhesive(folder):
    for file in ("shear_relaxation", "shear_relaxation_1", "loading_2d0_unloading_0d03"):
        yield identified(folder, file, *tables(DATA / "viscoelastic_adhesive", f"relaxation={file}"))


def tables(folder, tests):
    return [f"{kind}={folder / file}.csv" for kind, file in (test.split("=") for test in tests.split())]


BEAM = """name: silicone-beam
object:
  geometry: {box: {size: [100 mm, 30 mm, 30 mm], cells: [16, 5, 5]}}
  material: {young_modulus: 100 kPa, poisson_ratio: 0.499, density: 1.07 g/cm3}
  fixed: {plane: {axis: x, at: 0 m}}
model: {kind: fem, element: tet10, gravity: [0, 0, -9.81]}
"""
# Positions of the three markers at the tip in the beam's frame [m]: one on its top, two on its sides.
MARKERS = ((0.1, 0.015, 0.03), (0.1, 0.03, 0.0244), (0.1, 0.0, 0.0068))
WEIGHT = 0.51  # [N]


def sag(take):
    """Returns how far each of the three markers moves down from start to end [m]. The recording's x points up."""
    rows = runners.table(DATA / "silicone_beam" / f"{take}.csv")
    return [np.mean([float(row[f"x{k}_m"]) for row in rows[-50:] if row[f"x{k}_m"]]) - float(rows[0][f"x{k}_m"]) for k in (1, 2, 3)]


def silicone_beam(folder):
    scene = folder / "beam.yaml"
    scene.write_text(BEAM)
    rows = [[take, *at, "", "", "", "", "", f"{dz:.6f}"] for take in ("gravity_a", "gravity_b") for at, dz in zip(MARKERS, sag(take))]
    loads = runners.write_table(folder / "sag.csv", "case x y z fx fy fz dx dy dz".split(), rows)
    fit = runners.report(folder, "identify", f"loads={loads}", "--scene", scene)["loads"]
    value, half = fit["young_modulus_Pa"] / 1e3, 1.96 * fit["sigma_Pa"] / 1e3
    alone = " and ".join(f"{E / 1e3:.4g}" for E in dict(fit["alone_Pa"]).values())
    yield Row("modulus from its own weight", "263.8 kPa, fit of the authors' simulator",
              f"{within(value, half)}; takes alone {alone}", covers(value - half, 263.8, value + half))
    # The load is where the authors' code has it.
    edge = [["tip", 0.1, 0.006 * k, 0.03, 0, 0, -WEIGHT / 6] for k in range(6)]
    hung = runners.write_table(folder / "weight.csv", "case x y z fx fy fz".split(), edge + [["tip", *at, 0, 0, 0] for at in MARKERS])
    slave("solve", scene, "--override", f"object.material.young_modulus={1e3 * value} Pa", "--loads", hung, "--out", folder / "tip.csv")
    solved = np.array([float(row["dz"]) for row in runners.table(folder / "tip.csv")[len(edge):]])
    for take in ("load52_a", "load52_b"):
        measured = np.array(sag(take))
        yield Row(f"{take}: tip under 0.51 N; markers on top, left, right", ", ".join(f"{-1e3 * dz:.1f}" for dz in measured) + " mm, measured",
                  ", ".join(f"{-1e3 * dz:.1f}" for dz in solved) + " mm: " +
                  ", ".join(f"{error:+.1f} %" for error in 100 * (solved / measured - 1)))


# ---- fingertips and other sources of forces

def judged(folder, name, names, rows):
    """Runs `verify --forces` and returns its card."""
    file = runners.write_table(folder / f"{name}.csv", names, rows)
    return runners.report(folder, "verify", "--forces", file, codes=(0, 1))["cards"][0]


def interval(card, key):
    return card["lines"][key]["low_value_high"]


def findings(card):
    return ", ".join(sorted(key for key, line in card["lines"].items() if line["verdict"] == "wrong")) or "nothing"


FORCES = [f"{kind}_f{axis}" for kind in ("measured", "estimated") for axis in "xyz"]


def tactile_9dtact(folder):
    rows = [[row[f"{kind}_f{axis}_N"] for kind in ("true", "predicted") for axis in "xyz"] for row in runners.table(DATA / "tactile_9dtact/pairs.csv")]
    card = judged(folder, "pairs", FORCES, rows)
    error = np.array(rows, float)[:, 5] - np.array(rows, float)[:, 2]
    low, value, high = interval(card, "magnitude")
    yield Row("mean error of fz", "0.278 N of all objects, by the data's README",
              f"{np.mean(np.abs(error)):.3f} N of the even ones; `verify` finds wrong: {findings(card)}")
    yield Row("estimated / measured", "1", f"{value:.3f} ({low:.3f} to {high:.3f})", covers(low, 1, high))


def tactile_eflesh(folder):
    trials = [DATA / f"tactile_eflesh/normal_trial{k}.csv" for k in (1, 2)]
    for data, test in (trials, trials[::-1]):
        printed = run(runners.PYTHON, "-m", "palpate.train", data, "--test", test, "--unit", "uT", "--channels", "m", "--sample-rate", "14",
                      "--normal", f"scale_g={-GRAM:g}", "--out", folder / "network", accept=(0, 2))
        error = re.search(r"rms error ([\d.]+) mN", printed)
        yield Row(f"error of the normal force, rms, {data.stem} on {test.stem}",
                  "0.27 N within a trial; 0.76 and 0.93 N across by a linear fit, by the data's README",
                  f"{float(error.group(1)) / 1e3:.2f} N" if error else "not trained: " + printed.strip().splitlines()[-1])


FINGER = """name: finger
object:
  geometry: {{box: {{size: [200 mm, 40 mm, 40 mm], cells: [20, 4, 4]}}}}
  material: {{young_modulus: 3.8 kPa, poisson_ratio: 0.15, density: 45 kg/m3}}
  fixed: {{plane: {{axis: z, at: 0}}}}
sense: {{tactile: {{{tactile}}}}}
model: {{kind: fem}}
"""


def seed001_rf_foam_bar(folder):
    """Applies the network of paper B's authors to their recording. The sensor's mean before the contact is its
    offset."""
    recording = DATA / "seed001_rf_foam_bar"
    run(runners.PYTHON, "-m", "palpate.convert_network", DATA / "seed001_biotac_lstm/biotac_rnn21", "--out", folder / "network")
    (folder / "finger.yaml").write_text(FINGER.format(
        tactile=f"source: {recording / 'rh_tactile.csv'}, finger: rf, rest: first 50, network: network"))
    slave("process", folder / "finger.yaml", "--out", folder)
    states = {round(float(row["t"]), 4): row for row in runners.table(folder / "states.csv") if row["fz"]}
    expected = runners.table(recording / "lstm_expected_rf.csv")
    rest = [np.mean([float(row[f"meas_f{axis}_N"]) for row in expected[:50]]) for axis in "xyz"]
    pairs, worst = [], 0.0
    for row in expected:
        # Force of the fingertip on the object.
        ours = [-float(states[round(float(row["rel_time_s"]), 4)][f"f{axis}"]) for axis in "xyz"]
        worst = max(worst, *(abs(one - float(row[f"y{k}"])) for k, one in enumerate(ours)))
        pairs.append([row["rel_time_s"], *(float(row[f"meas_f{axis}_N"]) - zero for axis, zero in zip("xyz", rest)), *ours])
    yield Row("force of the authors' network, largest difference", "0 N, evaluated in float64", f"{worst:.1g} N", "yes" if worst < 1e-5 else "no")
    card = judged(folder, "foam", ["t", *FORCES], pairs)
    low, value, high = interval(card, "magnitude")
    yield Row("estimated / measured", "0.68 of fz (slope 1.47), by the data's README",
              f"{value:.2f} ({low:.2f} to {high:.2f}); `verify` finds wrong: {findings(card)}", covers(low, 1 / 1.47, high))


# ---- cameras

DOME = """name: punyo
object:
  geometry: {membrane: {semi_axes: [70 mm, 49.6 mm, 71 mm], inflation: 42.4 mm, thickness: 0.5 mm, air: 0.6 l}}
  pose: {translation: [29.7 mm, 0.1 mm, 58 mm]}
  material: {young_modulus: %s, poisson_ratio: 0.5}
tool: {shape: flat, width: 14 mm}
sense:
  camera: {depth: "DATA/depth_*.png", unit: 0.1 mm, fx: 434.34, fy: 433.36, cx: 313.71, cy: 247.54, sigma: 0.08 mm,
           rate: 30 Hz, pose: {translation: [0, 0, 0]}}
model: {kind: membrane, prestress: %s}
"""
STATED = ("2.424 MPa", "295 N/m")  # 1212 N/m with the thickness of 0.5 mm
LAST_FITTED = 65                   # number of an image


def wrench():
    """Returns the magnitude of the force per image [N], minus its mean over images 40 to 58."""
    force = np.array([[float(row[name]) for name in ("fx_N", "fy_N", "fz_N")]
                      for row in runners.table(DATA / "membrane_press_rgbd/robot_pressure_wrench.csv")])
    return np.linalg.norm(force - force[40:59].mean(axis=0), axis=1)


def press_error(folder, name, constants, offset=0.0):
    """Returns the rms error on the images after the fitted ones, relative to the peak, and the share of forces within
    two sigma."""
    scene = folder / f"{name}.yaml"
    scene.write_text((DOME % constants).replace("DATA", str(DATA / "membrane_press_rgbd")))
    slave("process", scene, "--out", folder)
    measured = wrench()
    later = [(number, row) for number, row in zip(image_numbers(), runners.table(folder / "states.csv")) if row["fz"] and number > LAST_FITTED]
    error = np.array([np.linalg.norm([float(row[f"f{axis}"]) for axis in "xyz"]) + offset - measured[number] for number, row in later])
    allowed = [2 * math.hypot(float(row["sigma"]), 0.2) for _, row in later]
    return (f"{100 * np.sqrt(np.mean(error**2)) / max(measured[image_numbers()]):.1f} %; "
            f"{np.sum(np.abs(error) < allowed)} of {len(later)} within 2 sigma and the wrench's noise")


def image_numbers():
    return [int(file.stem[-3:]) for file in sorted((DATA / "membrane_press_rgbd").glob("depth_*.png"))]


def membrane_press_rgbd(folder):
    measured = wrench()
    table = runners.write_table(folder / "wrench.csv", ["sequence", "force"],
                  [[i, f"{measured[number]:.4f}"] for i, number in enumerate(image_numbers(), 1) if number <= LAST_FITTED])
    published = "6.8 to 7.9 % of the peak"
    yield Row("force on later images, rms, with 1212 and 295 N/m", published, press_error(folder, "stated", STATED))
    fit = runners.report(folder, "identify", f"images={table}", "--scene", folder / "stated.yaml")["images"]
    fitted = f"{fit['young_modulus_Pa']:.6g} Pa", f"{fit['prestress_N_per_m']:.6g} N/m"
    yield Row(f"the same, `identify images` on images up to {LAST_FITTED}, with its offset of {fit['offset_N']:.2f} N", published,
              press_error(folder, "fitted", fitted, fit["offset_N"]))


def stereo_chessboard_opencv(folder):
    chess = DATA / "stereo_chessboard_opencv"
    printed = slave("calibrate", "--left", chess / "left*.jpg", "--right", chess / "right*.jpg", "--board", "9x6", "--square", "25mm",
                    "--out", folder / "rig.yaml")
    baseline = float(re.search(r"baseline ([\d.]+) mm", printed).group(1))
    yield Row("baseline", "83.2 mm, by the data's README", f"{baseline:.1f} mm")


def stereo_endoscope_dvrk(folder):
    chess = DATA / "stereo_endoscope_dvrk"
    printed = slave("calibrate", "--left", chess / "chess_left*.png", "--right", chess / "chess_right*.png", "--board", "6x9",
                    "--square", "11.66mm", "--out", folder / "endoscope.yaml", accept=(1,))
    yield Row("calibration", "not credible, by the data's README", "rejected: " + re.search(r"the baseline has a sigma[^,]*", printed).group(0), "yes")


SETS = (silicone_compression, hyperelastic_curves, foam_curves, viscoelastic_adhesive, silicone_beam, tactile_9dtact, tactile_eflesh,
        seed001_rf_foam_bar, membrane_press_rgbd, stereo_chessboard_opencv, stereo_endoscope_dvrk)
ELSEWHERE = {
    "teleop_round_trips": "replayed by tests/e2e/recorded_links.py",
    "biotac_contact_direction": "test_localise", "teleop_1dof_2khz": "test_teleop_recording", "dot_patterns": "test_dots", "stereo_disparity": "test_texture",
    "pointclouds": "test_shape", "zebrafish_injection": "test_zebrafish", "biotac_slide": "test_capture, no true force",
    "seed001_biotac_lstm": "the network of seed001_rf_foam_bar", "seed001_meshes": "meshes of the scenes foam-*",
    "biotac_skin_mesh": "no measurement", "endoscope_sinus": "no force and no scale", "gripper_squeeze": "no size of the objects",
    "robot_palpation": "no modulus and no shape", "liver_registration": "point clouds, which no command takes",
}


def compared(rows, folder):
    """Runs the comparisons of a set. A published figure is no truth, so an interval beside it fails nothing."""
    try:
        lines = list(rows(folder))
    except (Refused, OSError, KeyError, AttributeError) as error:
        return verdict("refused", repr(error), holds=False)
    counts = collections.Counter({"yes": "right", "no": "silent"}[row.covers] for row in lines if row.covers != "-")
    return Outcome(counts, "".join(f"\n      {row.quantity} | {row.published} | {row.ours} | {row.covers}" for row in lines))


def is_named(name, _):
    return verdict("right", ELSEWHERE[name]) if name in ELSEWHERE else verdict("silent", "no row in tests/campaigns/recordings.py")


def cases(options):
    if not DATA.exists():
        raise Skipped(f"no {DATA}")
    compares = [Case(rows.__name__, functools.partial(compared, rows), "compared") for rows in SETS]
    names = sorted({folder.name for folder in DATA.iterdir() if folder.is_dir()} - {rows.__name__ for rows in SETS})
    return compares + [Case(name, functools.partial(is_named, name), "elsewhere") for name in names]
