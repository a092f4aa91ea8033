#!/usr/bin/env python3
"""Runs `palpate-slave identify` on the published material tests and prints each fit beside what was published.

Three tables: fitted modulus, its 95 % interval, the published value and its source; the interval of
specimen A1 against specimen B1 of each silicone; wrong units, which must be rejected. Every run must
print the lines of a scene. Exit code 1 if one of these demands fails, 77 without the data.

    python3 tests/identify_published.py [palpate-slave]
"""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
DATA = ROOT.parent / "shared" / "data"
SLAVE = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "build/release/bin/palpate-slave")
LEAST_COVERED, MOST_WIDE = 11, 0.15  # of 13 silicones, half-width by the modulus
NOT_GIVEN = "none in the data's source"


def identify(*arguments):
    """Exit code, report (None where rejected), all that was printed."""
    with tempfile.TemporaryDirectory() as out:
        done = subprocess.run([SLAVE, "identify", *arguments, "--out", out], capture_output=True, text=True)
        report = pathlib.Path(out) / "report.json"
        found = json.loads(report.read_text()) if done.returncode == 0 else None
    return done.returncode, found, done.stdout + done.stderr


def has_scene_lines(printed):
    lines = [line.strip() for line in printed.splitlines()]
    return any(line.startswith("object.material: {") for line in lines) and any(
        line.startswith("model: {") for line in lines)


def modulus_of(report):
    """What it is, value and half-width [Pa]."""
    if report.get("relaxation"):
        held = report["relaxation"]
        return "held", held["young_modulus_held_Pa"], held["half_width_Pa"]
    if report["moduli"] and report["moduli"][0]["end_factor"] > 1:
        chord = report["moduli"][0]
        return "chord, bonded ends", chord["modulus_Pa"], chord["half_width_Pa"]
    law = next(law for law in report["laws"] if law["law"] == (report["scene_law"] or report["best"]))
    return "at rest, " + law["law"], law["young_modulus_Pa"], law["half_width_Pa"]


def runs():
    """Name, arguments, published value and source."""
    silicone = DATA / "silicone_compression"
    with open(silicone / "elastic_modulus_kPa.csv", encoding="utf-8") as table:
        published = {row["material"]: row for row in csv.DictReader(table)}
    for file in sorted(silicone.glob("*_A1.csv")):
        row = published.get(file.stem[:-3])
        value = (f"{row['elastic_modulus_mean_kPa']} +- {row['elastic_modulus_std_kPa']} kPa, Dawood et al. 2026"
                 if row else NOT_GIVEN)
        yield file.stem, silicone_run(file), value
    curves = DATA / "hyperelastic_curves"
    for name, unit, tests in (
            ("Treloar_1944", "MPa", ("uniaxial=UT", "equibiaxial=ET", "planar=PS")),
            ("Kawabata_1981", "MPa", ("uniaxial=UT", "equibiaxial=ET", "planar=PS")),
            ("Meunier_2008", "MPa", ("uniaxial=UT", "equibiaxial=ET", "planar=PS")),
            ("Katashima_2012", "kPa", ("equibiaxial=ET", "planar=PS")),
            ("Budday_2017 cortex", "kPa",
             ("tension=UT_T_cortex", "compression=UT_C_cortex", "shear=SS_cortex")),
            ("Budday_2017 corona_radiata", "kPa",
             ("tension=UT_T_corona_radiata", "compression=UT_C_corona_radiata", "shear=SS_corona_radiata"))):
        yield name, tables(curves / name.split()[0], tests) + ["--stress-unit", unit], NOT_GIVEN
    yield ("foam_leap", tables(DATA / "foam_curves/foam_leap", ("tension=UT", "compression=UC", "shear=SS")),
           NOT_GIVEN)
    for file in ("shear_relaxation", "shear_relaxation_1", "loading_2d0_unloading_0d03"):
        yield ("adhesive " + file, tables(DATA / "viscoelastic_adhesive", ("relaxation=" + file,)), NOT_GIVEN)


def tables(folder, tests):
    return [f"{kind}={folder / file}.csv" for kind, file in (test.split("=") for test in tests)]


def silicone_run(file, diameter="50mm", height="30mm"):
    return [f"compression={file}", "--diameter", diameter, "--height", height, "--ends", "bonded"]


def print_fits():
    print(f"{'run':<38}{'modulus':<26}{'fitted, 95 %':<24}{'scene lines':<13}published")
    complete = True
    for name, arguments, published in runs():
        code, report, printed = identify(*arguments)
        if code != 0:
            print(f"{name:<38}failed: {printed.strip().splitlines()[-1]}")
            complete = False
            continue
        kind, value, half = modulus_of(report)
        lines = has_scene_lines(printed)
        complete = complete and lines
        fitted = f"{value / 1e3:.4g} +- {half / 1e3:.2g} kPa"
        print(f"{name:<38}{kind:<26}{fitted:<24}{'yes' if lines else 'NO':<13}{published}")
    return complete


def print_specimens():
    covered = count = 0
    narrow = True
    print(f"\n{'silicone':<14}{'A1':<22}{'half-width':<12}{'B1':<12}covered")
    for file in sorted((DATA / "silicone_compression").glob("*_A1.csv")):
        _, own, _ = identify(*silicone_run(file))
        _, other, _ = identify(*silicone_run(str(file).replace("_A1", "_B1")))
        _, value, half = modulus_of(own)
        _, against, _ = modulus_of(other)
        is_in = abs(against - value) <= half
        covered, count = covered + is_in, count + 1
        narrow = narrow and half <= MOST_WIDE * value
        print(f"{file.stem[:-3]:<14}{f'{value / 1e3:.4g} +- {half / 1e3:.2g} kPa':<22}{f'{100 * half / value:.1f} %':<12}"
              f"{f'{against / 1e3:.4g} kPa':<12}{'yes' if is_in else 'no'}")
    print(f"intervals of A1 that hold B1: {covered} of {count}; each at most 15 % to a side: {'yes' if narrow else 'NO'}")
    return covered >= LEAST_COVERED and narrow


def changed(folder, file, before, after, name="wrong"):
    copy = pathlib.Path(folder) / f"{file.stem}_{name}.csv"
    text = file.read_text(encoding="utf-8-sig")
    assert before in text, f"{file}: no {before}"
    copy.write_text(text.replace(before, after), encoding="utf-8")
    return copy


def print_wrong_units():
    silicone = DATA / "silicone_compression/EF50_0T_A1.csv"
    curves = DATA / "hyperelastic_curves"
    foam = DATA / "foam_curves/foam_leap/UC.csv"
    with tempfile.TemporaryDirectory() as folder:
        tries = (
            ("silicone, diameter and height in mm read as m", silicone_run(silicone, "50", "30")),
            ("silicone, diameter in mm read as m", silicone_run(silicone, "50", "30mm")),
            ("silicone, height in mm read as m", silicone_run(silicone, "50mm", "30")),
            ("silicone, N labelled mN", silicone_run(changed(folder, silicone, "Load (N)", "Load (mN)"))),
            ("silicone, kPa labelled Pa",
             [f"compression={changed(folder, DATA / 'silicone_compression/EF10_0T_A1.csv', 'Stress (kPa)', 'Stress (Pa)')}"]),
            ("rubber, MPa read as Pa", [f"uniaxial={curves / 'Treloar_1944/UT.csv'}"]),
            ("brain, kPa read as Pa", [f"uniaxial={curves / 'Budday_2017/UT_T_corona_radiata.csv'}"]),
            ("brain, kPa read as GPa",
             [f"uniaxial={curves / 'Budday_2017/UT_T_corona_radiata.csv'}", "--stress-unit", "GPa"]),
            ("foam, MPa labelled Pa", [f"compression={changed(folder, foam, 'P_MPa', 'P_Pa')}"]),
            ("silicone, N labelled kN", silicone_run(changed(folder, silicone, "Load (N)", "Load (kN)", "kN"))),
            ("silicone, N labelled kgf", silicone_run(changed(folder, silicone, "Load (N)", "Load (kgf)", "kgf"))),
            ("silicone, N labelled lbf", silicone_run(changed(folder, silicone, "Load (N)", "Load (lbf)", "lbf"))),
            ("silicone, kPa labelled psi", silicone_run(changed(folder, silicone, "Stress (kPa)", "Stress (psi)", "psi"))),
            ("silicone, mm labelled m",
             silicone_run(changed(folder, silicone, "Compression (mm)", "Compression (m)", "m"))),
            ("silicone, mm labelled in",
             silicone_run(changed(folder, silicone, "Compression (mm)", "Compression (in)", "in"))),
            ("silicone, mm labelled um",
             silicone_run(changed(folder, silicone, "Compression (mm)", "Compression (um)", "um"))),
            ("silicone, kPa labelled MPa",
             [f"compression={changed(folder, silicone, 'Stress (kPa)', 'Stress (MPa)', 'MPa')}"]),
            ("silicone, fractions labelled %",
             [f"compression={changed(folder, silicone, 'Engineering Strain [-]', 'Engineering Strain [%]', 'percent')}"]),
            ("foam, MPa labelled GPa",
             [f"tension={changed(folder, DATA / 'foam_curves/foam_leap/UT.csv', 'P_MPa', 'P_GPa', 'GPa')}"]),
            ("rubber, MPa read as GPa", [f"uniaxial={curves / 'Treloar_1944/UT.csv'}", "--stress-unit", "GPa"]),
            ("rubber, MPa read as kPa, scene in MPa",
             [f"uniaxial={curves / 'Treloar_1944/UT.csv'}", "--stress-unit", "kPa", "--scene",
              str(ROOT / "deploy/scenes/foam-cube.yaml"), "--override", "object.material.young_modulus=1.2 MPa"]))
        print()
        rejected = 0
        for name, arguments in tries:
            code, _, printed = identify(*arguments)
            reasons = [line for line in printed.splitlines() if "expected" in line or "Check the units" in line]
            rejected += code != 0 and bool(reasons)
            print(f"{name:<50}{'rejected: ' + reasons[-1].removeprefix('palpate-slave: ') if code != 0 and reasons else 'NOT REJECTED'}")
    print(f"wrong units that are rejected: {rejected} of {len(tries)}")
    return rejected == len(tries)


def main():
    if not DATA.exists():
        print(f"{DATA} is absent")
        return 77
    holds = [print_fits(), print_specimens(), print_wrong_units()]
    return 0 if all(holds) else 1


if __name__ == "__main__":
    sys.exit(main())
