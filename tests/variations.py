#!/usr/bin/env python3
"""Makes input files as other people would bring them, from known values, runs the programs on them and judges the
output.

  variations.py [-v] [NAME...]   runs all, or those whose name begins with NAME; -v: also prints the output

A variation is right if its numbers are the known ones or a remark names the mistake; refused if the message names the
cause; unhelpful if the message names another cause or none; silent if wrong numbers come without a remark. The kinds
differ from those of ../shared/cases and ../shared/cases-2.
Programs: PALPATE_BIN, default build/release/bin. Exit code 1: a silent variation, or too many unhelpful ones.
"""
import csv
import gzip
import json
import math
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import time
import zipfile
import zlib

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[1]
BIN = pathlib.Path(os.environ.get("PALPATE_BIN", ROOT / "build/release/bin")).resolve()
PACKAGE = BIN.parent / "python"
MAX_UNHELPFUL = 5  # largest number of unhelpful messages

VARIATIONS = []


def variation(command, refuse, truth=None, remark=None):
    """`make(folder)` writes the input. `refuse`, `remark`: patterns that a rejection or a remark must match, joined by
    ` & `. `truth(output, folder)` returns whether the numbers are right."""
    def add(make):
        VARIATIONS.append((make.__name__, make, command, refuse, truth, remark))
        return make
    return add


def write(file, text):
    file.write_bytes(text if isinstance(text, bytes) else text.encode())


# ---- tables of test machines: a neo-Hookean gel of E = 81 kPa, compressed to 30 %, cylinder of 50 mm x 30 mm

E = 81e3
HEIGHT, AREA = 0.03, math.pi / 4 * 0.05**2
STRAIN = np.linspace(0, 0.3, 61)
STRESS = -E / 3 * ((1 - STRAIN) - (1 - STRAIN)**-2)  # nominal, positive
LOAD = AREA * STRESS  # [N]
TRAVEL = HEIGHT * STRAIN  # [m]
SIZED = "{BIN}/palpate-slave identify compression={F}/test.csv --diameter 50mm --height 30mm --ends free --out {F}/out"
STRESSES = "{BIN}/palpate-slave identify compression={F}/test.csv --ends free --out {F}/out"


def modulus(expected, relative=0.02):
    def is_right(output, _):
        found = re.search(r"(?:at rest|fem-green:) E (\S+)", output)
        return bool(found) and abs(float(found[1]) / expected - 1) <= relative
    return is_right


def table(header, *columns, separator=",", form="%.6g"):
    rows = [separator.join(header)] + [separator.join(form % x for x in row) for row in zip(*columns)]
    return "\n".join(rows) + "\n"


@variation(SIZED, "column|displacement|Weg", modulus(E))
def identify_german_names_tabs_and_decimal_commas(f):
    write(f / "test.csv", table(["Standardweg [mm]", "Kraft [N]"], 1e3 * TRAVEL, LOAD, separator="\t").replace(".", ","))


@variation(SIZED, "unit|force", modulus(E))
def identify_inches_and_ounces_of_force(f):
    write(f / "test.csv", table(["Displacement (in)", "Load (ozf)"], TRAVEL / 0.0254, LOAD / 0.2780139))


@variation(STRESSES, "stress", modulus(E))
def identify_kilograms_of_force_per_square_centimetre(f):
    write(f / "test.csv", table(["Strain (%)", "Stress (kgf/cm2)"], 100 * STRAIN, STRESS / 98066.5))


@variation(STRESSES, "stress", modulus(E))
def identify_newtons_per_square_millimetre_in_latin_1(f):
    write(f / "test.csv", table(["Strain (%)", "Stress (N/mm\u00b2)"], 100 * STRAIN, STRESS / 1e6).encode("latin-1"))


@variation(STRESSES, "stress", modulus(E))
def identify_dynes_per_square_centimetre(f):
    write(f / "test.csv", table(["Strain (%)", "Stress (dyn/cm2)"], 100 * STRAIN, STRESS / 0.1))


@variation(STRESSES, "stress", modulus(E))
def identify_millimetres_of_mercury(f):
    write(f / "test.csv", table(["Strain (%)", "Stress (mmHg)"], 100 * STRAIN, STRESS / 133.322))


@variation(STRESSES, "strain|unit|number", modulus(E))
def identify_microstrain(f):
    write(f / "test.csv", table(["Strain (\u00b5\u03b5)", "Stress (kPa)"], 1e6 * STRAIN, STRESS / 1e3))


@variation(SIZED, "number|comma", modulus(E))
def identify_thousands_separators(f):
    rows = ["Displacement (um),Load (mN)"]
    rows += ['"%s","%s"' % (format(1e6 * x, ",.1f"), format(1e3 * y, ",.1f")) for x, y in zip(TRAVEL, LOAD)]
    write(f / "test.csv", "\n".join(rows) + "\n")


@variation(SIZED, "travel|begin|rest", modulus(E), "travel|begin")
def identify_travel_and_load_with_offsets(f):
    write(f / "test.csv", table(["Displacement (mm)", "Load (N)"], 1e3 * TRAVEL + 2.05, LOAD + 0.3))


@variation(SIZED, "decreas|travel|displacement|gap|stretch", modulus(E), "gap|decreas|travel")
def identify_a_gap_that_closes(f):
    write(f / "test.csv", table(["Displacement (mm)", "Load (N)"], 1e3 * (HEIGHT - TRAVEL), LOAD))


@variation(SIZED, "deformation|column|gap", modulus(E))
def identify_a_column_gap(f):
    write(f / "test.csv", table(["Gap (mm)", "Normal force (N)"], 1e3 * (HEIGHT - TRAVEL), LOAD))


@variation(SIZED, "cycle|unloading|differ", modulus(E), "cycle|loading")
def identify_three_cycles_that_soften(f):
    up = np.arange(61)
    down = up[::-1]
    path = np.concatenate([up, down] * 3)
    soft = np.repeat([1, 0.8, 0.75, 0.65, 0.7, 0.6], 61)
    write(f / "test.csv", table(["Displacement (mm)", "Load (N)"], 1e3 * TRAVEL[path], soft * LOAD[path]))


@variation(SIZED, ":63: & Maximum", modulus(E))
def identify_statistics_below_the_rows(f):
    text = table(["Displacement (mm)", "Load (N)"], 1e3 * TRAVEL, LOAD)
    write(f / "test.csv", text + "Maximum,%g\nMean,%g\nStd. dev.,%g\n" % (LOAD.max(), LOAD.mean(), LOAD.std()))


@variation(SIZED, "second|two", modulus(E))
def identify_two_tables_in_one_file(f):
    text = table(["Displacement (mm)", "Load (N)"], 1e3 * TRAVEL, LOAD)
    write(f / "test.csv", text + "\n" + table(["Displacement (mm)", "Load (N)"], 1e3 * TRAVEL, 2 * LOAD))


@variation(SIZED, ":32: & Load", modulus(E))
def identify_dashes_for_a_lost_reading(f):
    rows = table(["Displacement (mm)", "Load (N)"], 1e3 * TRAVEL, LOAD).splitlines()
    rows[31] = rows[31].split(",")[0] + ",--"
    write(f / "test.csv", "\n".join(rows) + "\n")


@variation(SIZED, "unit|lb", modulus(E))
def identify_pounds(f):
    write(f / "test.csv", table(["Displacement (mm)", "Load (lb)"], 1e3 * TRAVEL, LOAD / 4.4482216))


@variation(SIZED, "units?|size|modul|Check", modulus(E), "If that is not so")
def identify_newtons_that_are_millinewtons(f):
    write(f / "test.csv", table(["Displacement (mm)", "Load (N)"], 1e3 * TRAVEL, 1e3 * LOAD))


@variation(SIZED, "gzip")
def identify_a_compressed_table(f):
    write(f / "test.csv", gzip.compress(table(["Displacement (mm)", "Load (N)"], 1e3 * TRAVEL, LOAD).encode()))


@variation(SIZED, "JSON")
def identify_a_table_in_json(f):
    write(f / "test.csv", json.dumps({"Displacement (mm)": list(1e3 * TRAVEL), "Load (N)": list(LOAD)}, indent=1))


@variation(SIZED, "HDF5")
def identify_an_hdf5_file(f):
    write(f / "test.csv", b"\x89HDF\r\n\x1a\n" + bytes(600))


@variation(SIZED, "LabVIEW|TDMS")
def identify_a_labview_file(f):
    write(f / "test.csv", b"TDSm\x0e\0\0\0\x69\x12\0\0" + bytes(500))


def relaxes(output, _):
    """Relaxes from 18 kPa to 10.8 kPa with two minutes, the weighted mean of the time constants."""
    found = re.search(r"young_modulus (\S+) \+- .*, (\S+) Pa for quick", output)
    terms = [(float(a), float(b)) for a, b in re.findall(r"share: ([\d.]+), time: (\S+) s", output)]
    mean = sum(a * b for a, b in terms) / max(sum(a for a, _ in terms), 1e-9)
    return bool(found) and abs(float(found[1]) / 10.8e3 - 1) < 0.03 and abs(float(found[2]) / 18e3 - 1) < 0.03 and 100 < mean < 140


@variation("{BIN}/palpate-slave identify relaxation={F}/test.csv --out {F}/out", "time|min", relaxes)
def identify_relaxation_in_minutes(f):
    t = np.linspace(0, 12, 145)
    stress = 0.1 * 6e3 * (0.6 + 0.4 * np.exp(-t / 2))
    write(f / "test.csv", table(["Time (min)", "Shear strain (%)", "Stress (Pa)"], t, 0 * t + 10, stress))


# ---- presses and loads on a gel of 40 mm x 40 mm x 20 mm

GEL = """name: gel
object:
  geometry: {GEOMETRY}
  material: {young_modulus: 20 kPa, poisson_ratio: 0.4}
  fixed: {plane: {axis: z, at: 0 mm}}
tool: {shape: flat, width: 12 mm}
model: {kind: fem-green}
"""
BOX = "{box: {size: [40 mm, 40 mm, 20 mm], cells: [8, 8, 4]}}"
PLACES = np.array([[0.02, 0.02, 0.02, 0, 0, -0.001], [0.02, 0.02, 0.02, 0, 0, -0.002], [0.015, 0.02, 0.02, 0, 0, -0.001]])
COLUMNS = ["x", "y", "z", "dx", "dy", "dz"]
PRESS = "{BIN}/palpate-slave identify press={F}/press.csv --scene {F}/scene.yaml --out {F}/out"
SOLVE = "{BIN}/palpate-slave solve {F}/scene.yaml --contacts {F}/press.csv --out {F}/answers.csv"
_plain = {}  # cached results of inputs in their plain form


def scene(f, geometry=BOX, **changes):
    text = GEL.replace("{GEOMETRY}", geometry)
    for old, new in changes.items():
        text = re.sub(rf"{old}: [^,\n}}]+", f"{old}: {new}", text)
    write(f / "scene.yaml", text)


def run(command, f):
    for key, value in (("BIN", BIN), ("REPO", ROOT), ("F", f), ("PYTHON", f"PYTHONPATH={PACKAGE} /usr/bin/python3")):
        command = command.replace("{%s}" % key, str(value))
    done = subprocess.run(["bash", "-c", command], cwd=f, stdin=subprocess.DEVNULL, capture_output=True, timeout=300)
    return done.returncode, (done.stdout + done.stderr).decode(errors="replace")


def forces(file):
    return np.array([[float(row[a] or "nan") for a in ("fx", "fy", "fz")] for row in csv.DictReader(open(file))])


def plain_forces():
    """Returns the forces of the presses on the box that `solve` computes for the plain table."""
    if "solved" not in _plain:
        with tempfile.TemporaryDirectory() as folder:
            f = pathlib.Path(folder)
            scene(f)
            write(f / "press.csv", table(["case"] + COLUMNS, range(len(PLACES)), *PLACES.T))
            status, output = run(SOLVE, f)
            assert status == 0, output
            _plain["solved"] = forces(f / "answers.csv")
    return _plain["solved"]


def same_forces(_, f):
    answers = forces(f / "answers.csv")
    return answers.shape == plain_forces().shape and np.allclose(answers, plain_forces(), rtol=1e-5, atol=1e-9)


def pressed(f, titles, by, separator=",", force_by=1.0, extra=None, force_titles=("fx", "fy", "fz")):
    """Writes a table of presses with the forces that `solve` computes for 20 kPa."""
    columns = [c for c in (PLACES * by).T] + [c for c in (plain_forces() * force_by).T]
    titles = list(titles) + list(force_titles)
    for title, column in (extra or {}).items():
        titles.append(title)
        columns.append(np.full(len(PLACES), column))
    return table(["case"] + titles, range(len(PLACES)), *columns, separator=separator)


@variation(PRESS, "unit|mm", modulus(20e3))
def press_in_millimetres_with_titles(f):
    scene(f, young_modulus="5 kPa")
    write(f / "press.csv", pressed(f, [c + " (mm)" for c in COLUMNS], 1e3))


@variation(PRESS, "unit|force", modulus(20e3))
def press_in_grams_of_force_with_titles(f):
    scene(f)
    write(f / "press.csv", pressed(f, COLUMNS, 1, force_by=1 / 9.80665e-3, force_titles=("fx (gf)", "fy (gf)", "fz (gf)")))


@variation(PRESS, "force.*(away|reaction|tool on the object)")
def press_with_the_reaction(f):
    scene(f)
    write(f / "press.csv", pressed(f, COLUMNS, 1, force_by=-1))


@variation(PRESS, "width|unit", modulus(20e3))
def press_with_its_width_in_millimetres(f):
    scene(f)
    write(f / "press.csv", pressed(f, COLUMNS, 1, extra={"width (mm)": 12}))


@variation(PRESS, "surface & 0\\.02\\) m")
def press_5_mm_above_the_surface(f):
    scene(f)
    write(f / "press.csv", pressed(f, COLUMNS, 1).replace("0.02,0.02,0.02,", "0.02,0.02,0.025,"))


@variation(PRESS, "column|torque|tx")
def press_with_a_column_that_is_unknown(f):
    scene(f)
    write(f / "press.csv", pressed(f, COLUMNS, 1, extra={"tx": 0}))


@variation(PRESS, "column|case", modulus(20e3))
def press_without_names_of_cases(f):
    scene(f)
    write(f / "press.csv", "\n".join(row.partition(",")[2] for row in pressed(f, COLUMNS, 1).splitlines()) + "\n")


@variation(SOLVE, "column|separat|comma", same_forces)
def solve_semicolons_decimal_commas_and_millimetres(f):
    scene(f)
    text = table(["case"] + [c + " [mm]" for c in COLUMNS], range(3), *(1e3 * PLACES).T, separator=";")
    write(f / "press.csv", text.replace(".", ","))


@variation(SOLVE, "unit|cm", same_forces)
def solve_in_centimetres(f):
    scene(f)
    write(f / "press.csv", table(["case"] + [c + " (cm)" for c in COLUMNS], range(3), *(1e2 * PLACES).T))


@variation(SOLVE, "surface & reaches")
def solve_micrometres_without_a_unit(f):
    scene(f)
    write(f / "press.csv", table(["case"] + COLUMNS, range(3), *(1e6 * PLACES).T))


@variation(PRESS, "surface", None, "off the surface.*0.005 m")
def press_5_mm_above_a_coarse_surface(f):
    scene(f, geometry=BOX.replace("[8, 8, 4]", "[2, 2, 1]"))
    write(f / "press.csv", pressed(f, COLUMNS, 1).replace("0.02,0.02,0.02,", "0.02,0.02,0.025,"))


@variation(PRESS, "modul|times")
def press_in_grams_without_a_unit(f):
    scene(f)
    write(f / "press.csv", pressed(f, COLUMNS, 1, force_by=1 / 9.80665e-3))


@variation(SOLVE, "column", same_forces)
def solve_with_capital_titles(f):
    scene(f)
    write(f / "press.csv", table(["Case"] + [c.upper() for c in COLUMNS], range(3), *PLACES.T))


@variation(SOLVE, "nearest")
def solve_a_plane_that_misses_by_half_a_millimetre(f):
    scene(f, at="0.5 mm")
    write(f / "press.csv", table(["case"] + COLUMNS, range(3), *PLACES.T))


@variation(SOLVE, "poisson_ratio & 0\\.5")
def scene_poisson_in_percent(f):
    scene(f, poisson_ratio="40")
    write(f / "press.csv", table(["case"] + COLUMNS, range(3), *PLACES.T))


@variation(SOLVE, "young_modulus|unit", same_forces)
def scene_newtons_per_square_millimetre(f):
    scene(f, young_modulus="0.02 N/mm2")
    write(f / "press.csv", table(["case"] + COLUMNS, range(3), *PLACES.T))


@variation(SOLVE, "young_modulus & [kM]Pa", None, "young_modulus & MPa")
def scene_megapascals_without_a_unit(f):
    scene(f, young_modulus="0.02")
    write(f / "press.csv", table(["case"] + COLUMNS, range(3), *PLACES.T))


@variation(SOLVE, "gravity", None, "gravity & mm")
def scene_gravity_in_millimetres(f):
    scene(f, young_modulus="20 MPa")
    text = (f / "scene.yaml").read_text().replace("{kind: fem-green}", "{kind: fem, gravity: [0, 0, -9810]}")
    write(f / "scene.yaml", text.replace("poisson_ratio: 0.4", "poisson_ratio: 0.4, density: 1000"))
    write(f / "press.csv", table(["case"] + COLUMNS, range(3), *PLACES.T))


@variation(SOLVE, "density", None, "density & (t/mm3|g/cm3)")
def scene_tonnes_per_cubic_millimetre(f):
    scene(f)
    text = (f / "scene.yaml").read_text().replace("{kind: fem-green}", "{kind: fem, gravity: [0, 0, -9.81]}")
    write(f / "scene.yaml", text.replace("poisson_ratio: 0.4", "poisson_ratio: 0.4, density: 1.07e-9"))
    write(f / "press.csv", table(["case"] + COLUMNS, range(3), *PLACES.T))


@variation(SOLVE, "XML")
def scene_of_sofa(f):
    write(f / "scene.yaml", '<?xml version="1.0"?>\n<Node name="root" dt="0.02" gravity="0 0 -9.81">\n</Node>\n')
    write(f / "press.csv", table(["case"] + COLUMNS, range(3), *PLACES.T))


@variation(SOLVE, "XML")
def scene_of_mujoco_without_a_prolog(f):
    write(f / "scene.yaml", '<mujoco model="gel">\n  <worldbody>\n    <geom type="box" size="1 1 1"/>\n  </worldbody>\n</mujoco>\n')
    write(f / "press.csv", table(["case"] + COLUMNS, range(3), *PLACES.T))


# ---- meshes of the same box

def box_mesh():
    n = np.array([9, 9, 5])
    grid = np.stack(np.meshgrid(*(np.arange(k) for k in n), indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(grid)).reshape(n)
    elements = []
    for i, j, k in np.ndindex(8, 8, 4):
        for order in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
            corner, path = [i, j, k], [(i, j, k)]
            for axis in order:
                corner[axis] += 1
                path.append(tuple(corner))
            elements.append([number[place] for place in path])
    elements = np.array(elements)
    nodes = 0.005 * grid
    a, b, c, d = (nodes[elements[:, i]] for i in range(4))
    turned = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) < 0
    elements[turned] = elements[turned][:, [0, 1, 3, 2]]
    return nodes, elements


def meshed(f, name, text, unit=""):
    scene(f, geometry="{mesh: %s%s}" % (name, unit))
    write(f / name, text)
    write(f / "press.csv", table(["case"] + COLUMNS, range(3), *PLACES.T))


def gmsh_2(nodes, elements, binary=False):
    if binary:
        text = b"$MeshFormat\n2.2 1 8\n" + struct.pack("<i", 1) + b"\n$EndMeshFormat\n$Nodes\n%d\n" % len(nodes)
        text += b"".join(struct.pack("<iddd", i + 1, *p) for i, p in enumerate(nodes))
        text += b"\n$EndNodes\n$Elements\n%d\n" % len(elements) + struct.pack("<iii", 4, len(elements), 2)
        text += b"".join(struct.pack("<iii4i", i + 1, 1, 1, *(e + 1)) for i, e in enumerate(elements))
        return text + b"\n$EndElements\n"
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(nodes))]
    lines += [f"{i + 1} %.9g %.9g %.9g" % tuple(p) for i, p in enumerate(nodes)]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    lines += [f"{i + 1} 4 2 1 1 " + " ".join(map(str, e + 1)) for i, e in enumerate(elements)]
    return "\n".join(lines + ["$EndElements", ""])


@variation(SOLVE, "binary & gmsh", same_forces)
def mesh_gmsh_2_binary(f):
    meshed(f, "box.msh", gmsh_2(*box_mesh(), binary=True))


@variation(SOLVE, "tet|inverted|turned|volume", same_forces)
def mesh_of_tetrahedra_that_turn_the_other_way(f):
    nodes, elements = box_mesh()
    meshed(f, "box.msh", gmsh_2(nodes, elements[:, [0, 1, 3, 2]]))


@variation(SOLVE, "mm|millimetre|surface", same_forces, "millimetre|mm")
def mesh_in_millimetres_without_a_unit(f):
    nodes, elements = box_mesh()
    meshed(f, "box.msh", gmsh_2(1e3 * nodes, elements))


@variation(SOLVE, "Abaqus")
def mesh_of_abaqus(f):
    nodes, elements = box_mesh()
    text = "*HEADING\n*NODE\n" + "".join(f"{i + 1}, %.9g, %.9g, %.9g\n" % tuple(p) for i, p in enumerate(nodes))
    meshed(f, "box.inp", text + "*ELEMENT, TYPE=C3D4\n" + "".join(f"{i + 1}, " + ", ".join(map(str, e + 1)) + "\n"
                                                               for i, e in enumerate(elements)))


@variation(SOLVE, "Abaqus")
def mesh_of_abaqus_with_a_comment_first(f):
    nodes, _ = box_mesh()
    meshed(f, "box.inp", "** Job name: Job-1\n*Heading\n*Node\n" + "".join(f"{i + 1}, %.9g, %.9g, %.9g\n" % tuple(p)
                                                                        for i, p in enumerate(nodes)))


@variation(SOLVE, "Wavefront")
def mesh_of_wavefront(f):
    meshed(f, "box.obj", "# Blender v3\no Cube\nv 0 0 0\nv 0.04 0 0\nv 0 0.04 0\nv 0 0 0.02\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")


@variation(SOLVE, "Geomview")
def mesh_of_geomview(f):
    meshed(f, "box.off", "OFF\n4 4 6\n0 0 0\n0.04 0 0\n0 0.04 0\n0 0 0.02\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n")


@variation(SOLVE, "STEP & gmsh")
def mesh_of_cad(f):
    meshed(f, "box.step", "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n")


@variation(SOLVE, "glTF")
def mesh_of_a_browser(f):
    meshed(f, "box.glb", b"glTF\x02\0\0\0" + bytes(200))


@variation(SOLVE, "Nastran")
def mesh_of_nastran(f):
    meshed(f, "box.bdf", "$ Nastran input\nSOL 101\nCEND\nBEGIN BULK\nGRID    1       0       0.      0.      0.\nENDDATA\n")


@variation(SOLVE, "VTK")
def mesh_of_paraview(f):
    meshed(f, "box.vtk", "# vtk DataFile Version 3.0\nbox\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n")


@variation(SOLVE, "FEBio|XML")
def mesh_of_febio(f):
    meshed(f, "box.feb", '<?xml version="1.0" encoding="ISO-8859-1"?>\n<febio_spec version="4.0">\n<Mesh></Mesh>\n</febio_spec>\n')


def surface_of(nodes, elements):
    """Returns the triangles that belong to one tetrahedron only, outward."""
    found = {}
    for a, b, c, d in elements:
        for face in ((b, c, d), (a, d, c), (a, b, d), (a, c, b)):
            key = tuple(sorted(face))
            found[key] = None if key in found else face
    return [face for face in found.values() if face]


def stl(nodes, faces):
    text = b"binary".ljust(80) + struct.pack("<I", len(faces))
    for a, b, c in faces:
        text += struct.pack("<12fH", 0, 0, 0, *nodes[a], *nodes[b], *nodes[c], 0)
    return text


TETRAHEDRON = np.array([[0, 0, 0], [0.04, 0, 0], [0, 0.04, 0], [0, 0, 0.02]])


def near_forces(_, f):
    """Expects forces within a third: a surface is filled with other tetrahedra, of 5 mm under a tool of 12 mm."""
    answers = forces(f / "answers.csv")
    return np.allclose(answers[:, 2], plain_forces()[:, 2], rtol=0.33)


@variation(SOLVE, "inside|outward|turned|inverted", near_forces)
def mesh_whose_surface_is_inside_out(f):
    nodes, elements = box_mesh()
    meshed(f, "box.stl", stl(nodes, [face[::-1] for face in surface_of(nodes, elements)]), ", resolution: 3 mm")


@variation(SOLVE, "open|hole|closed")
def mesh_whose_surface_has_a_hole(f):
    nodes, elements = box_mesh()
    meshed(f, "box.stl", stl(nodes, surface_of(nodes, elements)[3:]), ", resolution: 3 mm")


@variation(SOLVE, "parts|bodies|components|pieces|connected", None, "parts|bodies|components|pieces|connected")
def mesh_of_two_bodies(f):
    nodes, elements = box_mesh()
    meshed(f, "box.msh", gmsh_2(np.vstack([nodes, nodes + [0, 0, 0.03]]), np.vstack([elements, elements + len(nodes)])))


@variation(SOLVE, "hexahedr|type 5|element")
def mesh_of_hexahedra(f):
    nodes, _ = box_mesh()
    text = gmsh_2(nodes, np.zeros((0, 4), dtype=int)).replace("$Elements\n0\n", "$Elements\n1\n1 5 2 1 1 1 2 7 6 46 47 52 51\n")
    meshed(f, "box.msh", text)


@variation(SOLVE, "twice|nodes|numbers", same_forces)
def mesh_of_tetgen_from_zero_with_attributes(f):
    nodes, elements = box_mesh()
    scene(f, geometry="{mesh: box.node}")
    write(f / "box.node", f"{len(nodes)} 3 1 1\n" + "".join(f"{i} %.9g %.9g %.9g 7 0\n" % tuple(p) for i, p in enumerate(nodes)))
    write(f / "box.ele", f"{len(elements)} 4 1\n" + "".join(f"{i} {' '.join(map(str, e))} 3\n" for i, e in enumerate(elements)))
    write(f / "press.csv", table(["case"] + COLUMNS, range(3), *PLACES.T))


# ---- outlines of a plane body of 50 mm x 30 mm, pressed at the middle of its top

PLANE = """name: plane
object:
  geometry: {contour: outline.csv, thickness: 8 mm}
  material: {young_modulus: 30 kPa, poisson_ratio: 0.48}
  fixed: {side: bottom}
tool: {shape: flat, width: 6 mm, depth: whole}
model: {kind: bem2d, plane: stress, elements: 160}
"""
OUTLINE = np.array([[0, 0], [0.05, 0], [0.05, 0.03], [0, 0.03]])


def outlined(f, text):
    write(f / "scene.yaml", PLANE)
    write(f / "outline.csv", text)
    write(f / "press.csv", table(["case", "x", "y", "dx", "dy"], ["1"], ["0.025"], ["0.03"], ["0"], ["-0.001"], form="%s"))


def same_plane_force(_, f):
    if "plane" not in _plain:
        with tempfile.TemporaryDirectory() as folder:
            own = pathlib.Path(folder)
            outlined(own, table(["x", "y"], *OUTLINE.T))
            status, output = run(SOLVE, own)
            assert status == 0, output
            _plain["plane"] = forces(own / "answers.csv")
    return np.allclose(forces(f / "answers.csv"), _plain["plane"], rtol=1e-5, atol=1e-9)


@variation(SOLVE, "clockwise|order", same_plane_force)
def outline_clockwise(f):
    outlined(f, table(["x", "y"], *OUTLINE[::-1].T))


@variation(SOLVE, "twice|equal|edge|point", same_plane_force)
def outline_whose_first_point_is_repeated(f):
    outlined(f, table(["x", "y"], *OUTLINE[[0, 1, 2, 3, 0]].T))


@variation(SOLVE, "column|separat", same_plane_force)
def outline_in_columns_y_and_x_with_semicolons(f):
    outlined(f, table(["Y [mm]", "X [mm]"], 1e3 * OUTLINE[:, 1], 1e3 * OUTLINE[:, 0], separator=";"))


@variation(SOLVE, "surface|boundary|metres|pixel|unit", None, "metres|unit")
def outline_in_pixels(f):
    outlined(f, table(["x", "y"], *(1e4 * OUTLINE).T))


@variation(SOLVE, "cross|area")
def outline_that_crosses_itself(f):
    outlined(f, table(["x", "y"], *OUTLINE[[0, 2, 1, 3]].T))


@variation(SOLVE, "each key once")
def scene_with_a_key_twice(f):
    scene(f)
    text = (f / "scene.yaml").read_text()
    write(f / "scene.yaml", text.replace("  fixed:", "  material: {young_modulus: 80 kPa, poisson_ratio: 0.4}\n  fixed:"))
    write(f / "press.csv", table(["case"] + COLUMNS, range(3), *PLACES.T))


@variation(SOLVE, "young_modulus", same_forces)
def scene_kilopascals_in_capitals(f):
    scene(f, young_modulus="20 KPA")
    write(f / "press.csv", table(["case"] + COLUMNS, range(3), *PLACES.T))


@variation(SOLVE, "never", same_forces)
def scene_in_json(f):
    write(f / "scene.yaml", json.dumps({
        "name": "gel", "tool": {"shape": "flat", "width": 0.012}, "model": {"kind": "fem-green"},
        "object": {"geometry": {"box": {"size": [0.04, 0.04, 0.02], "cells": [8, 8, 4]}},
                   "material": {"young_modulus": 20e3, "poisson_ratio": 0.4}, "fixed": {"plane": {"axis": "z", "at": 0}}}}))
    write(f / "press.csv", table(["case"] + COLUMNS, range(3), *PLACES.T))


# ---- depth cameras: a box of 60 mm on a table, 250 mm below the camera

DEPTH = """name: depth-box
object:
  geometry:
    box: {size: [60 mm, 60 mm, 60 mm], cells: [6, 6, 6]}
  material: {young_modulus: 3.8 kPa, poisson_ratio: 0.15}
  fixed: {plane: {axis: z, at: 0 mm}}
tool: {shape: flat, width: 20 mm}
sense:
  camera:
    depth: "d/*.png"
    rate: 30 Hz
    unit: 0.1 mm
    fx: 390 px
    fy: 390 px
    cx: 159.5 px
    cy: 119.5 px
    sigma: 0.5 mm
    pose: {translation: [30 mm, 30 mm, 310 mm], rotation: [180 deg, 0 deg, 0 deg]}
  points: {track: surface}
model: {kind: fem-green, rate: 30 Hz}
"""
PROCESS = "{BIN}/palpate-slave process {F}/scene.yaml --out {F}/out"


def png(pixels):
    """Returns a PNG: grey with 8 or 16 bits, or three channels of 8 bits."""
    depth, colour = 8 * pixels.dtype.itemsize, 2 if pixels.ndim == 3 else 0
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + row.astype(row.dtype.newbyteorder(">")).tobytes() for row in pixels)
    head = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], depth, colour, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def depth_image(rng, width=320, height=240, focal=390.0, cx=159.5, cy=119.5, tilt=0.0, above=0.25):
    """Returns the depths [m] of a camera that looks down, rotated by `tilt` about its y axis [rad]."""
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    ray = np.stack([(u - cx) / focal, (v - cy) / focal, np.ones(u.shape)], axis=-1)
    c, s = math.cos(tilt), math.sin(tilt)
    down = np.stack([c * ray[..., 0] + s * ray[..., 2], ray[..., 1], -s * ray[..., 0] + c * ray[..., 2]], axis=-1)
    z = above / down[..., 2]
    on = (abs(down[..., 0] * z) < 0.03) & (abs(down[..., 1] * z) < 0.03)
    z = np.where(on, z, (above + 0.06) / down[..., 2])
    return z + rng.normal(0, 2e-4, z.shape)


def filmed(f, change=lambda z: z, scene_changes=(), count=30, unit=1e-4, name="%03d.png", encode=png, **camera):
    rng = np.random.default_rng(3)
    (f / "d").mkdir()
    for i in range(count):
        pixels = np.clip(np.round(change(depth_image(rng, **camera)) / unit), 0, 65535).astype(np.uint16)
        write(f / "d" / (name % i), encode(pixels))
    text = DEPTH
    for old, new in scene_changes:
        assert old in text, old
        text = text.replace(old, new)
    write(f / "scene.yaml", text)


def states(f):
    return list(csv.DictReader(open(f / "out/states.csv")))


def all_valid_without_force(_, f):
    rows = states(f)
    return len(rows) >= 10 and all(row["validity"] == "valid" and abs(float(row["fz"] or "nan")) < 0.02 for row in rows[-5:])


def no_state_is_valid(output, f):
    """Expects that no state is valid, and that the message names the surface at rest."""
    rows = states(f)
    named = [row for row in rows if "rest" in (row.get("check") or "")]
    return len(named) >= 10 and "the surface at rest" in output and not any(row["validity"] == "valid" for row in rows)


@variation(PROCESS, "never", all_valid_without_force)
def depth_as_the_scene_has_it(f):
    filmed(f)


@variation(PROCESS, "never", all_valid_without_force)
def depth_with_holes(f):
    filmed(f, lambda z: np.where(np.random.default_rng(5).random(z.shape) < 0.1, 0, z))


@variation(PROCESS, "rest|unit|farther", no_state_is_valid)
def depth_in_millimetres_read_as_tenths(f):
    filmed(f, unit=1e-3)


@variation(PROCESS, "rest", no_state_is_valid)
def depth_10_percent_too_long(f):
    filmed(f, lambda z: 1.1 * z)


@variation(PROCESS, "rest|size|principal", no_state_is_valid)
def depth_halved_with_the_intrinsics_of_the_whole(f):
    filmed(f, lambda z: z[::2, ::2])


@variation(PROCESS, "rest|cx|principal", no_state_is_valid)
def depth_with_the_principal_point_at_the_corner(f):
    filmed(f, scene_changes=[("cx: 159.5 px", "cx: 0 px"), ("cy: 119.5 px", "cy: 0 px")])


@variation(PROCESS, "rest", no_state_is_valid)
def depth_of_a_camera_20_mm_too_high(f):
    filmed(f, above=0.27)


@variation(PROCESS, "rest", no_state_is_valid)
def depth_of_a_tilted_camera(f):
    filmed(f, tilt=0.1)


@variation(PROCESS, "rest|fy|square", no_state_is_valid)
def depth_with_half_of_fy(f):
    filmed(f, scene_changes=[("fy: 390 px", "fy: 195 px")])


@variation(PROCESS, "rest|distance|depth", all_valid_without_force)
def depth_along_the_ray(f):
    """Displacements are differences of two depths, so they are at most 1.5 % too large at the edge of the body."""
    def along(z):
        u, v = np.meshgrid(np.arange(z.shape[1]), np.arange(z.shape[0]))
        return z * np.sqrt(1 + ((u - 159.5) / 390)**2 + ((v - 119.5) / 390)**2)
    filmed(f, along)


@variation(PROCESS, "size|image", all_valid_without_force)
def depth_of_another_size_in_the_middle(f):
    filmed(f)
    write(f / "d/015.png", png(np.full((120, 160), 2500, dtype=np.uint16)))


@variation(PROCESS, "16.bit")
def depth_in_8_bits(f):
    filmed(f, encode=lambda p: png((p // 16).astype(np.uint8)))


@variation(PROCESS, "16.bit|colour|channel")
def depth_as_a_coloured_map(f):
    filmed(f, encode=lambda p: png(np.repeat((p // 16).astype(np.uint8)[..., None], 3, axis=2)))


@variation(PROCESS, "EXR")
def depth_in_openexr(f):
    filmed(f, name="%03d.exr", encode=lambda p: b"v/1\x01\x02\0\0\0" + bytes(64), scene_changes=[("*.png", "*.exr")])


@variation(PROCESS, "NumPy & PNG")
def depth_in_numpy_arrays(f):
    filmed(f, name="%03d.npy", scene_changes=[("*.png", "*.npy")],
           encode=lambda p: b"\x93NUMPY\x01\0v\0{'descr': '<u2'}" + p.tobytes())


@variation(PROCESS, "PGM|P5|byte|image|16.bit", all_valid_without_force)
def depth_in_pgm(f):
    filmed(f, name="%03d.pgm", scene_changes=[("*.png", "*.pgm")],
           encode=lambda p: b"P5\n%d %d\n65535\n" % (p.shape[1], p.shape[0]) + p.astype(">u2").tobytes())


# ---- lenses of other programs, to register a camera of 640 x 480, fx 812

LENS = np.array([[812.0, 0, 318.5], [0, 806.0, 243.25], [0, 0, 1]])
# Rotation about x [rad], and position of the camera [m].
POSE_ANGLE, POSE_AT = math.radians(150), np.array([0.04, 0.2, 0.3])
REGISTER = "{BIN}/palpate-slave calibrate --register {F}/tips.csv --rig {F}/lens.yaml"


def tips(f, change=lambda uv: uv, lens=LENS):
    rng = np.random.default_rng(8)
    c, s = math.cos(POSE_ANGLE), math.sin(POSE_ANGLE)
    rotation = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    places = rng.uniform([-0.02, -0.02, 0], [0.1, 0.1, 0.05], (14, 3))
    seen = (places - POSE_AT) @ rotation
    uv = change((seen / seen[:, 2:]) @ lens.T[:, :2] + rng.normal(0, 0.05, (14, 2)))
    write(f / "tips.csv", table(["x", "y", "z", "u", "v"], *places.T, *uv.T, form="%.6f"))


def pose_is_right(output, _):
    found = re.search(r"translation: \[([^\]]+)\]", output)
    if not found:
        return False
    at = [float(re.sub(r"[^-+.\de]", "", part.replace("mm", "e-3").replace(" m", ""))) for part in found[1].split(",")]
    return np.allclose(at, POSE_AT, atol=2e-3)


NUMBERS = ", ".join("%g" % x for x in LENS.ravel())


@variation(REGISTER, "never", pose_is_right)
def lens_of_ros(f):
    tips(f)
    write(f / "lens.yaml", f"""image_width: 640
image_height: 480
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: [{NUMBERS}]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0, 0, 0, 0, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [812, 0, 318.5, 0, 0, 806, 243.25, 0, 0, 0, 1, 0]
""")


@variation(REGISTER, "camera_matrix|image_width|K", pose_is_right)
def lens_of_a_ros_topic(f):
    tips(f)
    write(f / "lens.yaml", f"""header:
  stamp: {{sec: 1, nanosec: 2}}
  frame_id: camera
height: 480
width: 640
distortion_model: plumb_bob
d: [0.0, 0.0, 0.0, 0.0, 0.0]
k: [{NUMBERS}]
r: [1, 0, 0, 0, 1, 0, 0, 0, 1]
p: [812, 0, 318.5, 0, 0, 806, 243.25, 0, 0, 0, 1, 0]
""")


@variation(REGISTER, "equidistant|plumb_bob|fisheye")
def lens_of_a_fisheye(f):
    tips(f)
    write(f / "lens.yaml", f"""image_width: 640
image_height: 480
camera_matrix: {{rows: 3, cols: 3, data: [{NUMBERS}]}}
distortion_model: equidistant
distortion_coefficients: {{rows: 1, cols: 4, data: [0.1, 0.01, 0, 0]}}
""")


@variation(REGISTER, "XML|camera_matrix", pose_is_right)
def lens_of_opencv_in_xml(f):
    tips(f)
    write(f / "lens.yaml", f"""<?xml version="1.0"?>
<opencv_storage>
<image_width>640</image_width>
<image_height>480</image_height>
<camera_matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
  <data>{NUMBERS.replace(",", "")}</data></camera_matrix>
<distortion_coefficients type_id="opencv-matrix"><rows>5</rows><cols>1</cols><dt>d</dt>
  <data>0. 0. 0. 0. 0.</data></distortion_coefficients>
</opencv_storage>
""")


@variation(REGISTER, "cam0 & camera_matrix")
def lens_of_kalibr(f):
    tips(f)
    write(f / "lens.yaml", "cam0:\n  camera_model: pinhole\n  intrinsics: [812, 806, 318.5, 243.25]\n  distortion_model: radtan\n"
                           "  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [640, 480]\n")


@variation(REGISTER, "camera_matrix|image_width")
def lens_of_colmap(f):
    tips(f)
    write(f / "lens.yaml", "# Camera list with one line of data per camera:\n1 PINHOLE 640 480 812 806 318.5 243.25\n")


@variation(REGISTER, "MATLAB")
def lens_of_matlab(f):
    tips(f)
    write(f / "lens.yaml", b"MATLAB 5.0 MAT-file, Platform: GLNXA64" + bytes(500))


@variation(REGISTER, "residual|contradict|reject|mirror|pose|fit")
def register_pixels_from_the_bottom(f):
    tips(f, lambda uv: np.column_stack([uv[:, 0], 480 - uv[:, 1]]))
    lens_file(f)


@variation(REGISTER, "outside|image")
def register_pixels_of_a_larger_image(f):
    tips(f, lambda uv: 2 * uv)
    lens_file(f)


@variation(REGISTER, "residual|contradict|reject|mirror|pose|fit|outside")
def register_u_and_v_exchanged(f):
    tips(f, lambda uv: uv[:, ::-1])
    lens_file(f)


def lens_file(f):
    write(f / "lens.yaml", f"image_width: 640\nimage_height: 480\ncamera_matrix: {{rows: 3, cols: 3, data: [{NUMBERS}]}}\n"
                           "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n")


# ---- tactile tables: four channels that are shares of a normal force, quadratic in one

TRAIN = "{PYTHON} -m palpate.train {F}/data --unit kPa --out {F}/net"
REST = np.array([12.0, -3.0, 40.0, 7.5])


def touches(seed, contacts=6, shift=0.0):
    rng = np.random.default_rng(seed)
    t = np.arange(0, 3.0 * contacts, 0.01)
    phase = t % 3.0
    force = np.where(phase > 1, np.sin(math.pi * (phase - 1) / 2)**2, 0) * rng.uniform(0.5, 2, contacts)[(t // 3).astype(int)]
    late = np.interp(t - shift, t, force)
    values = REST + force[:, None] * np.array([1.0, 1.4, -0.8, 2.0]) + rng.normal(0, 0.02, (len(t), 4))
    return t, values, np.column_stack([0 * late, 0 * late, -late])


def data(f, change=lambda t, c, w: (t, c, w), titles="t c1 c2 c3 c4 fx fy fz", shift=0.0, form="%.9g"):
    (f / "data").mkdir()
    for k in range(4):
        t, c, w = change(*touches(k, shift=shift))
        write(f / "data" / f"p{k}.csv", table(titles.split(), t, *c.T, *w.T, form=form))


def learnt(output, f):
    network = json.loads((f / "net/network.json").read_text())
    return network["architecture"] == "qnn_4" and abs(network["learnt_force"] / 1.9 - 1) < 0.3 and network["sigma"][2] < 0.1


@variation(TRAIN, "never", learnt)
def train_as_documented(f):
    data(f)


@variation(TRAIN, "column|c1", learnt)
def train_channels_with_other_names(f):
    data(f, titles="t ch0 ch1 ch2 ch3 fx fy fz")


@variation(TRAIN, "nanoseconds", learnt)
def train_times_in_nanoseconds(f):
    data(f, lambda t, c, w: (1.7e18 + 1e9 * t, c, w), form="%.19g")


@variation(TRAIN, "nothing|follow|correlat|constant|c3", learnt)
def train_with_a_dead_channel(f):
    def dead(t, c, w):
        c = c.copy()
        c[:, 2] = 40
        return t, c, w
    data(f, dead)


@variation(TRAIN, "fz|normal|axis|contact", learnt)
def train_with_the_normal_along_x(f):
    data(f, lambda t, c, w: (t, c, w[:, [2, 0, 1]]))


def honest(output, f):
    """Expects that the sigma of the network covers its errors, because the forces cannot be right."""
    return json.loads((f / "net/network.json").read_text())["sigma"][2] > 0.3


@variation(TRAIN, "delay|late|shift|time|follow", honest)
def train_with_a_wrench_that_is_half_a_second_late(f):
    data(f, shift=0.5)


def trained(f):
    if "net" not in _plain:
        with tempfile.TemporaryDirectory() as folder:
            own = pathlib.Path(folder)
            data(own)
            status, output = run(TRAIN, own)
            assert status == 0, output
            _plain["net"] = (own / "net/network.json").read_bytes()
    (f / "net").mkdir()
    write(f / "net/network.json", _plain["net"])


PAD = """name: pad
object:
  geometry:
    box: {size: [40 mm, 40 mm, 20 mm], cells: [4, 4, 2]}
  material: {young_modulus: 20 kPa, poisson_ratio: 0.3}
  fixed: {plane: {axis: z, at: 0 mm}}
sense:
  tactile: {source: touch.csv, finger: pad, channels: 4, unit: kPa, network: net, rest: first 50}
model: {kind: fem}
"""


def touched(f, change=lambda t, c: (t, c), titles="t,c1,c2,c3,c4"):
    trained(f)
    write(f / "scene.yaml", PAD)
    t, c, _ = touches(11, 3)
    t, c = change(t, c)
    write(f / "touch.csv", table(titles.split(","), t, *c.T, form="%.12g"))


def tactile_force_is_right(_, f):
    rows = [row for row in states(f) if row["validity"] == "valid"]
    _, _, w = touches(11, 3)
    force = np.array([float(row["fz"]) for row in rows])
    # The state has the force of the object on the tool, opposite to that of the sensor on the object.
    return len(rows) > 100 and abs(np.abs(force).max() / np.abs(w).max() - 1) < 0.1


def no_large_force_is_valid(_, f):
    rows = states(f)
    size = [math.hypot(*(float(row[a] or "nan") for a in ("fx", "fy", "fz"))) for row in rows]
    return bool(rows) and not any(row["validity"] == "valid" and x > 0.3 for row, x in zip(rows, size))


@variation(PROCESS, "never", tactile_force_is_right)
def tactile_as_documented(f):
    touched(f)


@variation(PROCESS, "unit|Pa")
def tactile_in_pascals_with_a_title(f):
    touched(f, lambda t, c: (t, 1e3 * c), "t,c1 [Pa],c2 [Pa],c3 [Pa],c4 [Pa]")


@variation(PROCESS, "unit|range|expected", no_large_force_is_valid)
def tactile_in_pascals_without_a_title(f):
    touched(f, lambda t, c: (t, 1e3 * c))


@variation(PROCESS, "rest|touch", no_large_force_is_valid)
def tactile_touched_at_the_start(f):
    """Begins the recording within the first contact."""
    touched(f, lambda t, c: (t[:-190], c[190:]))


@variation(PROCESS, "unit", tactile_force_is_right)
def tactile_times_in_milliseconds_with_a_title(f):
    touched(f, lambda t, c: (1e3 * t, c), "t [ms],c1,c2,c3,c4")


@variation(PROCESS, "nanoseconds|time", tactile_force_is_right)
def tactile_times_in_nanoseconds(f):
    touched(f, lambda t, c: (1.7e18 + 1e9 * t, c))


@variation(PROCESS, "time & (back|increase|decrease)", no_large_force_is_valid)
def tactile_of_two_runs_joined(f):
    touched(f, lambda t, c: (np.concatenate([t, t]), np.vstack([c, c])))


@variation(PROCESS, "channel|constant|pattern", no_large_force_is_valid)
def tactile_with_a_channel_that_is_dead(f):
    touched(f, lambda t, c: (t, np.column_stack([c[:, :3], 0 * t + 7.5])))


@variation(PROCESS, "channel|pattern|order", no_large_force_is_valid)
def tactile_with_channels_exchanged(f):
    touched(f, lambda t, c: (t, c[:, [3, 1, 2, 0]]))


@variation(PROCESS, "column|c1|channels")
def tactile_with_three_of_four_channels(f):
    touched(f, lambda t, c: (t, c[:, :3]), "t,c1,c2,c3")


@variation(PROCESS, "JSON|column|CSV")
def tactile_lines_of_json(f):
    touched(f)
    t, c, _ = touches(11, 3)
    write(f / "touch.csv", "".join(json.dumps({"t": x, "c1": a, "c2": b, "c3": y, "c4": z}) + "\n" for x, (a, b, y, z) in zip(t, c)))


# ---- recordings

@variation("{BIN}/palpate-slave process {F}/x.mcap --out {F}/out", "zstd")
def recording_compressed_as_a_whole(f):
    write(f / "x.mcap", b"\x28\xb5\x2f\xfd\x04\x00" + bytes(300))


@variation("{BIN}/palpate-slave process {F}/x.mcap --out {F}/out", "ROS 1 & MCAP")
def recording_of_ros_1(f):
    write(f / "x.mcap", b"#ROSBAG V2.0\n" + bytes(300))


@variation("{BIN}/palpate-slave process {F}/x.mcap --out {F}/out", "cut|damaged|MCAP|no ")
def recording_of_a_header_alone(f):
    write(f / "x.mcap", b"\x89MCAP0\r\n\x01" + struct.pack("<Q", 8) + bytes(8))


@variation("{PYTHON} -m palpate.export {F}/x.mcap {F}/out", "MCAP|rosbag2|SQLite")
def export_of_a_database(f):
    write(f / "x.mcap", b"SQLite format 3\0" + bytes(500))


# ---- forces of other sources

def forces_table(n=1500):
    rng = np.random.default_rng(2)
    t = np.arange(n) * 0.02
    measured = np.column_stack([np.sin(0.7 * t), 0.5 * np.cos(1.1 * t), -2 * np.sin(0.4 * t)**2])
    return t, measured, measured + rng.normal(0, 0.02, measured.shape)


NAMES = ["t"] + [f"{w}_f{a}" for w in ("measured", "estimated") for a in "xyz"]
FORCES = "{BIN}/palpate-slave verify --forces {F}/f.csv --out {F}/out"


def passes(output, _):
    return bool(re.search(r"\bpasses\b|all right", output)) and not re.search(r"\bwrong\b", output)


@variation(FORCES, "never", passes)
def forces_as_documented(f):
    t, m, e = forces_table()
    write(f / "f.csv", table(NAMES, t, *m.T, *e.T))


@variation(FORCES, "unit|g", passes)
def forces_measured_by_a_scale(f):
    t, m, e = forces_table()
    write(f / "f.csv", table(["t"] + [f"measured_f{a} (gf)" for a in "xyz"] + NAMES[4:], t, *(m / 9.80665e-3).T, *e.T))


@variation(FORCES, "measured_fx|column")
def forces_of_a_ros_table(f):
    t, m, _ = forces_table()
    header = ["header.stamp.sec", "header.stamp.nanosec", "wrench.force.x", "wrench.force.y", "wrench.force.z"]
    write(f / "f.csv", table(header, t // 1, 1e9 * (t % 1), *m.T))


@variation(FORCES, "Parquet")
def forces_in_parquet(f):
    write(f / "f.csv", b"PAR1" + bytes(400) + b"PAR1")


@variation(FORCES, "magnitude & wrong", None, "magnitude")
def forces_in_millinewtons_without_a_unit(f):
    t, m, e = forces_table()
    write(f / "f.csv", table(NAMES, t, *m.T, *(1e3 * e).T))


@variation(FORCES, "time|back|decrease", None, "back|decrease|time")
def forces_of_two_runs_joined(f):
    t, m, e = forces_table()
    write(f / "f.csv", table(NAMES, np.concatenate([t, t]), *np.vstack([m, m]).T, *np.vstack([e, e]).T))


# ---- networks

CONVERT = "{PYTHON} -m palpate.convert_network {F}/net.pt --window 20 --out {F}/net"


@variation(CONVERT, "HDF5")
def network_of_keras(f):
    write(f / "net.pt", b"\x89HDF\r\n\x1a\n" + bytes(500))


def archive(file, **members):
    with zipfile.ZipFile(file, "w") as zipped:
        for name, text in members.items():
            zipped.writestr(name.replace("__", "/").replace("_dot_", "."), text)


@variation(CONVERT, "Keras")
def network_of_keras_3(f):
    archive(f / "net.pt", metadata_dot_json="{}", config_dot_json='{"class_name": "Sequential"}', model_dot_weights_dot_h5=b"\x89HDF")


@variation(CONVERT, "TorchScript")
def network_in_torchscript(f):
    script = ("import torch; torch.jit.script(torch.nn.Sequential(torch.nn.Linear(19, 8), torch.nn.Tanh(), torch.nn.Linear(8, 3)))"
              f".save('{f / 'net.pt'}')")
    subprocess.run(["/usr/bin/python3", "-c", script], check=True, capture_output=True)


@variation(CONVERT, "ONNX")
def network_in_onnx(f):
    write(f / "net.pt", b"\x08\x07\x12\x07pytorch\x1a\x051.9.1:\x80\x01" + bytes(200))


@variation(CONVERT, "pickle|scikit|PyTorch")
def network_of_scikit_learn(f):
    import pickle
    write(f / "net.pt", pickle.dumps({"coefs_": [[1.0]], "intercepts_": [[0.0]]}, protocol=4))


@variation(CONVERT, "text|weights|PyTorch")
def network_in_text(f):
    write(f / "net.pt", "0.1 0.2 0.3\n0.4 0.5 0.6\n")


# ---- clouds and motions

CLOUD = "{BIN}/palpate-slave evaluate {F}/scene.yaml --cloud {F}/cloud.pcd --segment no --out {F}/out"
CLOUD_SCENE = GEL.replace("{GEOMETRY}", BOX).replace("model:", """sense:
  tactile: {source: simulated}
  depth_camera: {pose: {translation: [20 mm, 20 mm, 300 mm], rotation: [180 deg, 0, 0]}}
model:""").replace("tool: {shape: flat, width: 12 mm}\n", "").replace("fem-green", "fem")


@variation(CLOUD, "LAS")
def cloud_in_las(f):
    write(f / "scene.yaml", CLOUD_SCENE)
    write(f / "cloud.pcd", b"LASF" + bytes(400))


@variation(CLOUD, "metres|mm|far|no point|unit", None, "millimetre|mm|no point|beyond")
def cloud_in_millimetres(f):
    write(f / "scene.yaml", CLOUD_SCENE)
    x, y = np.meshgrid(np.linspace(-20, 20, 41), np.linspace(-20, 20, 41))
    rows = "".join("%.4g %.4g 280\n" % (a, b) for a, b in zip(x.ravel(), y.ravel()))
    write(f / "cloud.pcd", "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1681\nHEIGHT 1\n"
                           "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1681\nDATA ascii\n" + rows)


@variation(CLOUD, "PLY.*PCD|PCD.*PLY")
def cloud_in_ply(f):
    write(f / "scene.yaml", CLOUD_SCENE)
    write(f / "cloud.pcd", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                           "end_header\n0 0 0.28\n")


PLAYBACK = "{BIN}/palpate-master connect 127.0.0.1:1 --wait 0.2 --device playback:{F}/p.csv"


@variation(PLAYBACK, "ft & unit")
def playback_in_feet(f):
    t = np.linspace(0, 2, 40)
    write(f / "p.csv", table(["time_s", "x (ft)", "y (ft)", "z (ft)"], t, 0 * t, 0 * t, 0 * t))


@variation(PLAYBACK, ":42: time_s.*(more than the row before|increase|back)")
def playback_whose_time_runs_back(f):
    t = np.concatenate([np.linspace(0, 2, 40), np.linspace(0, 2, 40)])
    write(f / "p.csv", table(["time_s", "x", "y", "z"], t, 0 * t, 0 * t, -0.001 * t))


def has_all(text, patterns):
    return all(re.search(p, text, re.I) for p in (patterns or "never").split(" & "))


def verdict_of(make, command, refuse, truth, remark):
    """Returns (right, refused, unhelpful or silent; output)."""
    with tempfile.TemporaryDirectory() as folder:
        f = pathlib.Path(folder)
        make(f)
        status, output = run(command, f)
        if "Traceback" in output or not 0 <= status <= 2:  # a crash
            return "unhelpful", output
        words = output.replace(str(f), "")
        if truth and status == 0 and truth(output, f):
            return "right", output
        if remark and has_all(words, remark):
            return "right", output
        if status != 0:
            return ("refused" if has_all(words, refuse) else "unhelpful"), output
        return "silent", output


def main():
    counts = dict.fromkeys(("right", "refused", "unhelpful", "silent"), 0)
    began = time.monotonic()
    wanted, shows_all = tuple(word for word in sys.argv[1:] if word != "-v"), "-v" in sys.argv
    for name, *one in VARIATIONS:
        if wanted and not name.startswith(wanted):
            continue
        verdict, output = verdict_of(*one)
        counts[verdict] += 1
        shown = output if shows_all or verdict in ("unhelpful", "silent") else ""
        print(f"{verdict:10}{name}" + "".join("\n      " + line for line in shown.splitlines()[-12:]), flush=True)
    print(", ".join(f"{count} {verdict}" for verdict, count in counts.items()) + f" of {sum(counts.values())}, "
          f"{time.monotonic() - began:.0f} s")
    return 1 if counts["silent"] or counts["unhelpful"] > MAX_UNHELPFUL or not sum(counts.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
