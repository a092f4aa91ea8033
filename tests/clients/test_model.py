"""palpate.solve, Model, verify_forces and identify return the same digits as the programs, and raise exceptions that
name invalid input.

The programs are in PALPATE_BIN. Needs the built package with its module (PYTHONPATH).
"""
import csv
import json
import math
import os
import pathlib
import pickle
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import types
import unittest
import warnings
from concurrent import futures

import numpy as np

try:
    import palpate
    from palpate import _core
except ImportError as missing:
    print(f"skipped: {missing}: deploy/install.sh tests")
    sys.exit(77)

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(os.environ.get("PALPATE_BIN", ROOT / "build/release/bin"))
SANITIZED = bool(os.environ.get("PALPATE_SANITIZED"))  # the interpreter runs under the address sanitizer

NEEDS_TOOLS = unittest.skipIf(SANITIZED or not (BIN / "palpate-tools").exists() or not (BIN / "palpate-verify").exists(),
                              "palpate-tools and palpate-verify of the release are compared: deploy/build.sh release -- all")

BOX = {"box": {"size": [0.06, 0.06, 0.03], "cells": [6, 6, 3]}}
ON_GROUND = {"plane": {"axis": "z", "at": 0}}
RECTANGLE = {"rectangle": {"width": 0.088, "height": 0.088, "thickness": 0.009}}
DISC = {"disc": {"radius": 0.0006, "thickness": 0.0004}}
ARC = {"arc": {"centre": "180 deg", "half_angle": "20 deg"}}
EXTRUDED = {"rectangle": {"width": 0.06, "height": 0.04, "thickness": 0.03}}
POLYGON = {"polygon": {"points": [[0, 0], [0.08, 0], [0.06, 0.05], [0.01, 0.05]], "thickness": 0.01}}
MEMBRANE = {"membrane": {"radius": 0.038, "thickness": 0.001}}
FLAT, BALL = {"shape": "flat", "width": 0.02}, {"shape": "round", "radius": 0.01}
PLANE_TOOL = {"shape": "flat", "width": 0.006, "depth": "whole"}
TOP = [[0.03, 0.03, 0.03, 0, 0, -0.001], [0.02, 0.03, 0.03, 0.0002, 0, -0.002], [0.03, 0.03, 0.03, 0, 0, -0.004]]
SIDE = [[0.044, 0.088, 0, 0, -0.001, 0], [0.03, 0.088, 0, 0.0003, -0.005, 0]]
CENTRE = [[0, 0, 0, 0, 0, -0.0002], [0.01, 0.005, 0, 0, 0, -0.0012]]
PULL = [[0.03, 0.03, 0.03, 0, 0, -0.05], [0.03, 0.02, 0.03, 0.01, 0, 0]]

# name, geometry, young_modulus, poisson_ratio, contacts, arguments of palpate.solve
SCENES = [
    ("rectangle, point", RECTANGLE, 127e3, 0.49, SIDE, {"kind": "bem2d", "fixed": {"side": "bottom"}}),
    ("rectangle, flat tool", RECTANGLE, 127e3, 0.49, SIDE, {"kind": "bem2d", "fixed": {"side": "bottom"}, "tool": PLANE_TOOL}),
    ("rectangle, coarse, strain", RECTANGLE, 127e3, 0.4, SIDE,
     {"kind": "bem2d", "fixed": {"side": "bottom"}, "tool": PLANE_TOOL, "model": {"elements": 60, "plane": "strain"}}),
    ("rectangle, frictionless", RECTANGLE, 127e3, 0.49, SIDE,
     {"kind": "bem2d", "fixed": {"side": "bottom"}, "tool": PLANE_TOOL, "model": {"contact": "frictionless", "order": "linear"}}),
    ("rectangle, ball", RECTANGLE, 127e3, 0.49, SIDE,
     {"fixed": {"side": "bottom"}, "tool": {"shape": "round", "radius": 0.004, "depth": "whole"}}),
    ("disc, arc", DISC, 15e3, 0.45, [[6e-4, 0, 0, -5e-5, 0, 0]], {"kind": "bem2d", "fixed": ARC, "model": {"order": "quadratic"}}),
    ("polygon", POLYGON, 50e3, 0.3, [[0.04, 0, 0, 0, 0.002, 0]],
     {"kind": "auto", "fixed": {"side": "top"}, "tool": PLANE_TOOL}),
    ("plate, flat tool", MEMBRANE, 0.9e6, 0.49, CENTRE, {"kind": "plate", "tool": {"shape": "flat", "width": 0.002}}),
    ("plate, ball", MEMBRANE, 0.9e6, 0.49, CENTRE, {"kind": "plate", "tool": {"shape": "round", "radius": 0.003}}),
    ("plate-large", MEMBRANE, 0.9e6, 0.49, CENTRE, {"kind": "plate-large", "tool": {"shape": "flat", "width": 0.004}}),
    ("plate-large, load", MEMBRANE, 0.9e6, 0.49, [[0, 0, 0, 0, 0, -0.1]], {"kind": "plate-large", "loads": True}),
    ("fem, co-rotational", BOX, 20e3, 0.45, TOP, {"fixed": ON_GROUND, "kind": "fem", "tool": FLAT}),
    ("fem, linear, point", BOX, 20e3, 0.3, TOP, {"fixed": ON_GROUND, "kind": "fem", "model": {"law": "linear"}}),
    ("fem, neo-Hookean, ball", BOX, 20e3, 0.3, TOP,
     {"fixed": ON_GROUND, "kind": "fem", "tool": BALL, "model": {"law": "neo-hookean"}}),
    ("fem, ten nodes", BOX, 20e3, 0.49, TOP, {"fixed": ON_GROUND, "kind": "fem", "tool": FLAT, "model": {"element": "tet10"}}),
    ("fem, neo-Hookean, loads", BOX, 20e3, 0.3, PULL,
     {"fixed": ON_GROUND, "kind": "fem", "tool": FLAT, "loads": True, "model": {"law": "neo-hookean"}}),
    ("fem-green", BOX, 20e3, 0.45, TOP, {"fixed": ON_GROUND, "kind": "fem-green", "tool": FLAT}),
    ("fem-green, frictionless, ball", BOX, 20e3, 0.45, TOP,
     {"fixed": ON_GROUND, "kind": "fem-green", "tool": BALL, "model": {"contact": "frictionless"}}),
    ("fem, neo-Hookean, friction", BOX, 20e3, 0.45, TOP,
     {"fixed": ON_GROUND, "kind": "fem", "tool": FLAT, "model": {"law": "neo-hookean", "contact": "friction", "friction": 0.3}}),
    ("fem, neo-Hookean, frictionless ball", BOX, 20e3, 0.45, TOP,
     {"fixed": ON_GROUND, "kind": "fem", "tool": BALL, "model": {"law": "neo-hookean", "contact": "frictionless"}}),
    ("extruded", EXTRUDED, 20e3, 0.45, [[0.03, 0.04, 0, 0, -0.001, 0], [0.02, 0.04, 0, 0.0002, -0.003, 0]],
     {"fixed": {"side": "bottom"}, "kind": "extruded", "tool": {"shape": "flat", "width": 0.01, "depth": 0.012}}),
]


def digits(value):
    return "%.17g" % value


def scene_of(geometry, young_modulus, poisson_ratio, options):
    scene = {"name": "x", "object": {"geometry": geometry,
                                     "material": {"young_modulus": young_modulus, "poisson_ratio": poisson_ratio}},
             "model": {**options.get("model", {}), "kind": options.get("kind", "auto")}}
    if "fixed" in options:
        scene["object"]["fixed"] = options["fixed"]
    if "tool" in options:
        scene["tool"] = options["tool"]
    return scene


def quiet_model(*arguments, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", palpate.ForceWarning)
        return palpate.Model(*arguments, **options)


def tetrahedra(cells=(6, 6, 3), size=(0.06, 0.06, 0.03)):
    """Returns a block of tetrahedra, six in each cell."""
    n = np.array(cells) + 1
    grid = np.stack(np.meshgrid(*(np.arange(k) for k in n), indexing="ij"), axis=-1).reshape(-1, 3)
    nodes = grid / np.array(cells) * np.array(size)
    number = np.arange(len(grid)).reshape(n)
    elements = []
    for i, j, k in np.ndindex(*cells):
        for first, second, third in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
            corner = np.array([i, j, k])
            path = [tuple(corner)]
            for axis in (first, second, third):
                corner = corner + np.eye(3, dtype=int)[axis]
                path.append(tuple(corner))
            elements.append([number[place] for place in path])
    return nodes, np.array(elements)


def cube_surface():
    """Returns the triangles of a cube of 40 mm."""
    nodes = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * 0.04
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return nodes, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


class SlaveSolve(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.addCleanup(self.scratch.cleanup)
        self.folder = pathlib.Path(self.scratch.name)

    def solved(self, scene, rows, loads=False, path=False):
        """Returns the rows of `palpate-slave solve`, one per case."""
        (self.folder / "scene.yaml").write_text(json.dumps(scene))
        axes = "fx,fy,fz" if loads else "dx,dy,dz"
        lines = [f"case,x,y,z,{axes}"] + [f"{i}," + ",".join(map(digits, row)) for i, row in enumerate(rows)]
        (self.folder / "rows.csv").write_text("\n".join(lines) + "\n")
        done = subprocess.run([BIN / "palpate-slave", "solve", self.folder / "scene.yaml", "--loads" if loads else "--contacts",
                               self.folder / "rows.csv", "--out", self.folder / "out.csv"] + ["--path"] * path,
                              capture_output=True, text=True)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        with open(self.folder / "out.csv", encoding="utf-8") as table:
            return list(csv.DictReader(table))


@unittest.skipIf(SANITIZED, "the programs of the release are compared")
class SameDigitsTest(SlaveSolve):
    def test_scenes_of_all_kinds(self):
        self.assertGreaterEqual(len(SCENES), 20)
        compared, kinds = 0, set()
        for name, geometry, young_modulus, poisson_ratio, rows, options in SCENES:
            with self.subTest(name):
                options = dict(options)
                expected = self.solved(scene_of(geometry, young_modulus, poisson_ratio, options), rows, "loads" in options)
                given = {"loads": rows} if options.pop("loads", False) else {"contacts": rows}
                model = quiet_model(geometry, young_modulus, poisson_ratio, **options)
                kinds.add(model.info["kind"])
                answer = model.solve(**given)
                for i, row in enumerate(expected):
                    force, moved = answer.force[i], answer.displacement[i]
                    self.assertEqual([digits(x) for x in (*moved, *force)],
                                     [row[c] or "nan" for c in ("dx", "dy", "dz", "fx", "fy", "fz")])
                    self.assertEqual(str(answer.validity[i]), row["validity"])
                    error = row.get("error") or "0"
                    self.assertEqual(digits(0 if math.isnan(answer.error[i]) else answer.error[i]), error)
                    self.assertEqual(bool(answer.why[i]), row["validity"] != "valid")
                    compared += 1
        self.assertGreater(compared, 40)
        # All kinds except `membrane`, which has another interface.
        self.assertEqual(kinds, {"bem2d", "extruded", "plate", "plate-large", "fem", "fem-green"})

    def test_contacts_together_and_a_scene_file(self):
        scene = scene_of(BOX, 20e3, 0.45, {"kind": "fem-green", "fixed": ON_GROUND, "tool": FLAT})
        pair = [[0.015, 0.03, 0.03, 0, 0, -0.001], [0.045, 0.03, 0.03, 0, 0, -0.002]]
        (self.folder / "scene.yaml").write_text(json.dumps(scene))
        (self.folder / "rows.csv").write_text("case,x,y,z,dx,dy,dz\n" + "".join("a," + ",".join(map(digits, r)) + "\n" for r in pair))
        subprocess.run([BIN / "palpate-slave", "solve", self.folder / "scene.yaml", "--contacts", self.folder / "rows.csv",
                        "--out", self.folder / "out.csv"], check=True, capture_output=True)
        with open(self.folder / "out.csv", encoding="utf-8") as table:
            expected = [[row[c] for c in ("fx", "fy", "fz")] for row in csv.DictReader(table)]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", palpate.ForceWarning)
            model = palpate.Model.from_scene(self.folder / "scene.yaml")
        answer = model.solve([pair, pair], together=True)
        self.assertEqual(answer.force.shape, (2, 2, 3))
        for case in answer.force:
            self.assertEqual([[digits(x) for x in force] for force in case], expected)
        alone = model.solve(pair)
        self.assertNotEqual(digits(alone.force[0, 2]), expected[0][2])


    def test_a_path_of_press_drag_return_and_lift(self):
        # Law: Coulomb's. A straight way from rest has no friction where the drag has returned.
        options = {"fixed": ON_GROUND, "kind": "fem", "tool": FLAT,
                   "model": {"law": "neo-hookean", "contact": "friction", "friction": 0.3}}
        place = [0.03, 0.03, 0.03]
        rows = [place + moved for moved in ([0, 0, -0.002], [0.002, 0, -0.002], [0, 0, -0.002], [0, 0, 0.001])]
        expected = self.solved(scene_of(BOX, 20e3, 0.3, options), rows, path=True)
        model = quiet_model(BOX, 20e3, 0.3, **options)
        path, alone = model.solve(rows, path=True), model.solve(rows)
        for i, row in enumerate(expected):
            self.assertEqual([digits(x) for x in path.force[i]], [row[c] for c in ("fx", "fy", "fz")])
        normal = -path.force[:, 2]
        self.assertTrue(np.all(np.hypot(path.force[:, 0], path.force[:, 1]) <= (0.3 + 1e-6) * normal))
        self.assertGreater(path.force[1, 0], 0.9 * 0.3 * normal[1])
        self.assertLess(path.force[2, 0], -0.5 * 0.3 * normal[2])
        self.assertGreater(alone.force[2, 0], -0.1 * 0.3 * normal[2])
        np.testing.assert_array_equal(path.force[3], 0)
        together = model.solve([[row] for row in rows], together=True, path=True)
        np.testing.assert_array_equal(together.force[:, 0], path.force)
        broken = model.solve([rows[0], place + [0, 0, -0.05], rows[1]], path=True)  # deeper than thick
        self.assertEqual(broken.validity.tolist(), [path.validity[0], "failed", "failed"])
        self.assertEqual(broken.why[2], "an earlier case of the path has no solution")


# Presses of one millimetre at a place, inward.
PRESSES = [
    ("fem-green", {"box": {"size": [0.06, 0.06, 0.03], "cells": [8, 8, 4]}}, 20e3, 0.3, [0.03, 0.03, 0.03],
     {"fixed": ON_GROUND, "kind": "fem-green", "tool": FLAT}),
    ("neo-Hookean", {"box": {"size": [0.06, 0.06, 0.03], "cells": [8, 8, 4]}}, 20e3, 0.3, [0.03, 0.03, 0.03],
     {"fixed": ON_GROUND, "kind": "fem", "tool": FLAT, "model": {"law": "neo-hookean"}}),
    ("outline", RECTANGLE, 127e3, 0.49, [0.04, 0.088, 0], {"fixed": {"side": "bottom"}, "kind": "bem2d", "tool": PLANE_TOOL}),
    ("extruded", EXTRUDED, 20e3, 0.45, [0.03, 0.04, 0],
     {"fixed": {"side": "bottom"}, "kind": "extruded", "tool": {"shape": "flat", "width": 0.01, "depth": 0.012}}),
    ("plate", MEMBRANE, 0.9e6, 0.49, [0, 0, 0], {"kind": "plate-large", "tool": {"shape": "flat", "width": 0.004}}),
]
CAMERA = {"camera": {"source": "simulated", "rate": "60 Hz", "size": [640, 480], "pixel": 0.25e-3,
                     "pose": {"translation": [0.044, 0.044, 0]}},
          "tip": {"track": "template", "roi": "80 px"}, "contour": {"track": "snake"}}


@unittest.skipIf(SANITIZED or not (BIN / "palpate-tools").exists(), "palpate-tools of the release is compared")
class SamePressTest(SlaveSolve):
    """A press has one force, whatever command or call computes it."""

    def run_slave(self, *arguments):
        done = subprocess.run([BIN / "palpate-slave", *arguments], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def press(self, geometry, young_modulus, poisson_ratio, place, options):
        """Returns a scene with this press, and its row."""
        axis = 1 if "rectangle" in geometry else 2
        moved = [0, 0, 0]
        moved[axis] = -0.001
        scene = scene_of(geometry, young_modulus, poisson_ratio, options)
        scene |= {"study": {"contacts": [place]}, "operator": {"press": {"depth": 0.001, "speed": 0.01}, "force_limit": 3.3}}
        return scene, [*place, *moved]

    def test_commands_and_python_give_one_force(self):
        for name, geometry, young_modulus, poisson_ratio, place, options in PRESSES:
            for sense in [None, CAMERA] if "rectangle" in geometry and options["kind"] == "bem2d" else [None]:
                with self.subTest(name, sense=sense):
                    scene, row = self.press(geometry, young_modulus, poisson_ratio, place, options)
                    if sense:
                        scene["sense"] = sense
                    solved = self.solved(scene, [row])[0]
                    force = max(abs(float(solved[c])) for c in ("fx", "fy", "fz"))
                    called = quiet_model(geometry, young_modulus, poisson_ratio, **options).solve(row)
                    self.assertEqual([digits(x) for x in called.force], [solved[c] for c in ("fx", "fy", "fz")])
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore", palpate.ForceWarning)
                        once = palpate.solve(geometry, young_modulus, poisson_ratio, row, **options)
                    np.testing.assert_array_equal(once.force, called.force)
                    checked = self.run_slave("check", self.folder / "scene.yaml")
                    printed = re.search(r"contact +(\S+) N for an indentation of 1 mm", checked)
                    self.assertEqual(float(printed[1]), float("%.4g" % force), checked)
                    self.assertEqual("extrapolated:" in checked, solved["validity"] == "extrapolated")
                    self.run_slave("study", self.folder / "scene.yaml", "--out", self.folder / "study", "--budget", "1")
                    rows = json.loads((self.folder / "study/study.json").read_text())["rows"]
                    full = next(r for r in rows if r["own"])["answers"][0]["full"]
                    # The study presses in steps: the law's iterations end at a residual of 1e-6.
                    self.assertAlmostEqual(full["value"] / force, 1, delta=1e-6 if "law" in options.get("model", {}) else 1e-12)
                    self.assertEqual(full["validity"], solved["validity"])

    def test_a_tracked_press_has_the_force_of_its_indentation(self):
        _, geometry, young_modulus, poisson_ratio, place, options = PRESSES[2]
        scene, _ = self.press(geometry, young_modulus, poisson_ratio, place, options)
        scene["sense"] = CAMERA
        (self.folder / "scene.yaml").write_text(json.dumps(scene))
        self.run_slave("process", self.folder / "scene.yaml", "--out", self.folder / "press")
        with open(self.folder / "press/states.csv", encoding="utf-8") as table:
            states = [state for state in csv.DictReader(table) if state["validity"] == "valid" and float(state["fy"]) > 0.1]
        self.assertGreater(len(states), 20)
        tip, contact, force = (np.array([[float(state[prefix + axis]) for axis in "xyz"] for state in states])
                               for prefix in ("tip_", "contact_", "f"))
        moved = tip - contact
        contact[:, 1] = 0.088  # of the object at rest, which the camera sees a micrometre away
        expected = self.solved(scene, np.hstack([contact, moved]))
        # The force is that of the object on the tool. The table has nine digits of metres.
        np.testing.assert_allclose(-force[:, 1], [float(row["fy"]) for row in expected], rtol=1e-6)


class MeshTest(SlaveSolve):
    CONTACT = [0.03, 0.03, 0.03, 0, 0, -0.001]

    def force(self, mesh, fixed=ON_GROUND, **options):
        answer = quiet_model(mesh, 20e3, 0.45, tool=FLAT, fixed=fixed, kind="fem-green", **options).solve(self.CONTACT)
        self.assertEqual(answer.force.shape, (3,))
        self.assertLess(answer.force[2], 0)  # force of the tool on the body
        return answer.force[2]

    def test_every_way_to_give_a_mesh(self):
        nodes, elements = tetrahedra()
        expected = self.force((nodes, elements))
        self.assertAlmostEqual(expected / self.force(BOX), 1, delta=0.05)  # the diagonals of its cells differ
        self.assertEqual(self.force([nodes.tolist(), elements.tolist()]), expected)
        self.assertEqual(self.force(types.SimpleNamespace(points=nodes, cells_dict={"tetra": elements, "line": [[0, 1]]})), expected)
        self.assertAlmostEqual(self.force((1e3 * nodes, elements), unit="mm") / expected, 1, delta=1e-9)
        lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(nodes))]
        lines += [f"{i + 1} " + " ".join(map(digits, p)) for i, p in enumerate(nodes)] + ["$EndNodes", "$Elements", str(len(elements))]
        lines += [f"{i + 1} 4 2 1 1 " + " ".join(str(c + 1) for c in e) for i, e in enumerate(elements)] + ["$EndElements"]
        (self.folder / "block.msh").write_text("\n".join(lines) + "\n")
        self.assertEqual(self.force(self.folder / "block.msh"), expected)

    def test_every_way_to_fix_nodes(self):
        mesh = tetrahedra()
        expected = self.force(mesh)
        on_ground = np.flatnonzero(mesh[0][:, 2] < 1e-9)
        for fixed in ([ON_GROUND], on_ground, on_ground.tolist(), mesh[0][:, 2] < 1e-9, lambda p: p[:, 2] < 1e-9):
            self.assertEqual(self.force(mesh, fixed), expected)

    def test_a_closed_surface_is_filled(self):
        nodes, triangles = cube_surface()
        surface = types.SimpleNamespace(vertices=nodes, faces=triangles)  # as trimesh has it
        try:
            model = quiet_model(surface, 20e3, 0.3, tool={"shape": "flat", "width": 0.02}, fixed=lambda p: p[:, 2] < 1e-6,
                                resolution=0.008)
        except RuntimeError as error:
            self.assertRegex(str(error), "(?i)tetgen|gmsh")
            self.skipTest(str(error))
        answer = model.solve([0.02, 0.02, 0.04, 0, 0, -0.002])
        self.assertLess(answer.force[2], 0)
        self.assertGreater(len(model.nodes), 100)

    def test_an_outline_is_a_polygon(self):
        outline = POLYGON["polygon"]["points"]
        options = {"fixed": {"side": "top"}, "tool": PLANE_TOOL}
        contact = [0.04, 0, 0, 0, 0.002, 0]
        same = quiet_model(POLYGON, 50e3, 0.3, **options).solve(contact)
        given = quiet_model(np.array(outline), 50e3, 0.3, thickness=0.01, **options).solve(contact)
        np.testing.assert_array_equal(same.force, given.force)
        for unit in ("mm", 0.001):
            given = quiet_model(1e3 * np.array(outline), 50e3, 0.3, thickness=0.01, unit=unit, **options).solve(contact)
            np.testing.assert_allclose(given.force, same.force, rtol=1e-9)  # the lengths differ by rounding

    def test_the_force_of_a_plate_is_that_of_its_closed_form(self):
        # w = F a^2 / (16 pi D) at the centre of a clamped plate under a point load (Timoshenko)
        a, t, E, nu, w = 0.038, 0.001, 0.9e6, 0.49, 1e-5
        force = 16 * math.pi * E * t**3 / (12 * (1 - nu**2)) * w / a**2
        answer = quiet_model(MEMBRANE, E, nu, kind="plate").solve([0, 0, 0, 0, 0, -w])
        self.assertAlmostEqual(answer.force[2] / -force, 1, delta=1e-6)

    def test_shapes(self):
        model = quiet_model(BOX, 20e3, 0.45, tool=FLAT, fixed=ON_GROUND, kind="fem-green")
        one = model.solve(self.CONTACT)
        self.assertEqual((one.force.shape, one.validity.shape, one.error.shape, one.why.shape), ((3,), (), (), ()))
        grid = np.broadcast_to(self.CONTACT, (4, 5, 6))
        many = model.solve(grid)
        self.assertEqual((many.force.shape, many.valid.shape), ((4, 5, 3), (4, 5)))
        np.testing.assert_array_equal(many.force, np.broadcast_to(one.force, (4, 5, 3)))

    def test_solve_warns_of_an_answer_that_is_not_valid(self):
        with self.assertWarnsRegex(palpate.ForceWarning, "extrapolated"):
            answer = palpate.solve(BOX, 20e3, 0.45, [0.03, 0.03, 0.03, 0, 0, -0.02], tool=FLAT, fixed=ON_GROUND, kind="fem-green")
        self.assertFalse(answer.valid)
        self.assertTrue(answer.why.item())
        with self.assertWarnsRegex(palpate.ForceWarning, r"1 of 2 answers are not valid \(failed\): a fixed point") as warned:
            palpate.solve(BOX, 20e3, 0.45, [[0.03, 0.03, z, 0, 0, -0.001] for z in (0, 0.03)], tool=FLAT, fixed=ON_GROUND,
                          kind="fem-green")
        self.assertEqual(warned.filename, __file__)
        with self.assertWarnsRegex(palpate.ForceWarning, r"tool = \(missing\)") as warned:
            palpate.Model(BOX, 20e3, 0.45, fixed=ON_GROUND, kind="fem-green")
        self.assertEqual(warned.filename, __file__)
        with self.assertWarnsRegex(palpate.ForceWarning, "young_modulus"):
            palpate.Model(BOX, 20, 0.45, tool=FLAT, fixed=ON_GROUND, kind="fem-green")

    def test_other_threads_run_while_a_model_computes(self):
        model = palpate.Model({"box": {"size": [0.06, 0.06, 0.03], "cells": [16, 16, 8]}}, 20e3, 0.3, tool=FLAT, fixed=ON_GROUND, kind="fem",
                              model={"law": "corotational"})
        rows = [[0.03, 0.03, 0.03, 0, 0, -0.001 * i] for i in (1, 2, 3)]
        alone, turns, ends = model.solve(rows), [], threading.Event()
        other = threading.Thread(target=lambda: [turns.append(time.monotonic()) or time.sleep(1e-4) for _ in iter(ends.is_set, True)])
        other.start()
        begin = time.monotonic()
        with futures.ThreadPoolExecutor(2) as pool:
            answers = list(pool.map(model.solve, [rows, rows]))
        end = time.monotonic()
        ends.set()
        other.join()
        self.assertGreater(sum(begin < turn < end for turn in turns), 10)
        for answer in answers:
            np.testing.assert_array_equal(answer.force, alone.force)

    def test_errors_pass_between_processes(self):
        for kind in (palpate.Error, palpate.LeaseHeld, palpate.Interrupted):
            error = pickle.loads(pickle.dumps(kind("ABORTED", "held by Ada", "LEASE_HELD")))
            self.assertEqual((type(error), str(error), error.reason), (kind, "ABORTED: held by Ada", "LEASE_HELD"))

    def test_the_threads_of_openblas_are_left_alone(self):
        code = ("import ctypes, numpy; numpy.ones((9, 9)) @ numpy.ones((9, 9))\n"
                "def threads():\n"
                "    names = {l.split()[-1] for l in open('/proc/self/maps') if 'openblas' in l}\n"
                "    return [getattr(ctypes.CDLL(n), 'openblas_get_num_threads')() for n in sorted(names)\n"
                "            if hasattr(ctypes.CDLL(n), 'openblas_get_num_threads')]\n"
                "import palpate._core; before = threads()\n"
                "import palpate; palpate.Model({'membrane': {'radius': 0.03, 'thickness': 0.001}}, 1e6, 0.4).solve([0]*5 + [-1e-5])\n"
                "assert threads() == before, (threads(), before); assert not before or max(before) == 2, before\n")
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True,
                              env={**os.environ, "OPENBLAS_NUM_THREADS": "2"})
        self.assertEqual(done.returncode, 0, done.stderr)


class BadInputTest(unittest.TestCase):
    """Each case has the text that the message must contain, and the call."""

    def bad(self, pattern, call):
        with self.assertRaises(ValueError) as raised:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", palpate.ForceWarning)
                call()
        self.assertRegex(str(raised.exception), pattern)

    def test_twenty_bad_inputs(self):
        nodes, elements = tetrahedra()
        not_finite, far = nodes.copy(), elements.copy()
        not_finite[7, 1], far[3, 2] = math.nan, 10**6
        surface, triangles = cube_surface()
        fine = {"tool": FLAT, "fixed": ON_GROUND, "kind": "fem-green"}
        model = quiet_model(BOX, 20e3, 0.45, **fine)
        touch = np.array([0.03, 0.03, 0.03, 0, 0, -0.001])
        rows = np.array([touch, touch])
        rows[1, 4] = math.nan
        cases = [
            (r"contacts: shape \(2,\): expected \(6,\)", lambda: model.solve([1, 2])),
            (r"contacts: shape \(6,\): expected \(n, 6\)", lambda: model.solve(touch, together=True)),
            (r"contacts\[1, 0\] = .*nan.*finite", lambda: model.solve(rows)),
            (r"contacts\[0, 0\] = \(0\.03, 0\.03, 0\.09.*from the surface", lambda: model.solve([0.03, 0.03, 0.09, 0, 0, -0.001])),
            (r"contacts\[0, 0\] = \(30, 30, 30.*reaches from \(0, 0, 0\) to \(0\.06, 0\.06, 0\.03\) m", lambda: model.solve([30, 30, 30, 0, 0, -1])),
            (r"contacts: expected numbers", lambda: model.solve(["a"] * 6)),
            (r"expected contacts or loads", lambda: model.solve(touch, loads=touch)),
            (r"nodes\[7\] = .*nan.*finite", lambda: palpate.Model((not_finite, elements), 20e3, 0.45, **fine)),
            (r"elements\[3, 2\] = 1000000: expected .*0 to", lambda: palpate.Model((nodes, far), 20e3, 0.45, **fine)),
            (r"nodes of shape \(196, 2\): expected \(n, 3\)", lambda: palpate.Model((nodes[:, :2], elements), 20e3, 0.45, **fine)),
            (r"elements of shape \(648, 2\): expected \(m, 4\)", lambda: palpate.Model((nodes, elements[:, :2]), 20e3, 0.45, **fine)),
            (r"whole numbers of nodes", lambda: palpate.Model((nodes, elements + 0.5), 20e3, 0.45, **fine)),
            (r"(?i)open", lambda: palpate.Model((surface, triangles[1:]), 20e3, 0.45, tool=FLAT, fixed=lambda p: p[:, 2] < 1e-6)),
            (r"young_modulus = -1.*expected", lambda: palpate.Model(BOX, -1, 0.45, **fine)),
            (r"young_modulus = (?i:nan).*expected", lambda: palpate.Model(BOX, math.nan, 0.45, **fine)),
            (r"young_modulus = 20 mm.*kPa", lambda: palpate.Model(BOX, "20 mm", 0.45, **fine)),
            (r"poisson_ratio = 0\.7.*expected", lambda: palpate.Model(BOX, 20e3, 0.7, **fine)),
            (r"tool\.widht.*width", lambda: palpate.Model(BOX, 20e3, 0.45, **{**fine, "tool": {"shape": "flat", "widht": 0.01}})),
            (r"model\.kind = bem2d.*fem", lambda: palpate.Model(BOX, 20e3, 0.45, **{**fine, "kind": "bem2d"})),
            (r"fixed: no node.*reaches from", lambda: palpate.Model((nodes, elements), 20e3, 0.45, fixed=lambda p: p[:, 2] > 1)),
        ]
        self.assertEqual(len(cases), 20)
        for pattern, call in cases:
            with self.subTest(pattern):
                self.bad(pattern, call)

    def test_more_bad_inputs(self):
        nodes, elements = tetrahedra()
        fine = {"tool": FLAT, "fixed": ON_GROUND, "kind": "fem-green"}
        ball = quiet_model(BOX, 20e3, 0.45, **{**fine, "tool": BALL})
        plate = quiet_model(MEMBRANE, 0.9e6, 0.49, kind="plate")
        touch = [0.03, 0.03, 0.03, 0, 0, -0.001]
        twice = np.vstack([elements, elements[:1]])
        for pattern, call in [
            (r"round tool as a case of its own", lambda: ball.solve([touch, touch], together=True)),
            (r"0 on a membrane", lambda: plate.solve([0, 0, 0, 1e-4, 0, -1e-4])),
            (r"inside the clamped rim", lambda: plate.solve([0.05, 0, 0, 0, 0, -1e-4])),
            (r"one contact or more", lambda: plate.solve(np.empty((0, 6)))),
            (r"object\.fixed.*plane.*contains no node", lambda: palpate.Model(BOX, 20e3, 0.45, fixed={"plane": {"axis": "z", "at": 1}})),
            (r"fixed = \(missing\)", lambda: palpate.Model(BOX, 20e3, 0.45, kind="fem").solve(touch)),
            (r"mask of shape \(3,\)", lambda: palpate.Model((nodes, elements), 20e3, 0.45, fixed=np.array([True, False, True]))),
            (r"nodes = 100000", lambda: palpate.Model((nodes, elements), 20e3, 0.45, fixed=[100000])),
            (r"function of the nodes", lambda: palpate.Model(cube_surface(), 20e3, 0.45, fixed=[0, 1])),
            (r"volume", lambda: palpate.Model(RECTANGLE, 20e3, 0.45, fixed=[0, 1])),
            (r"thickness = \(missing\)", lambda: palpate.Model([[0, 0], [1, 0], [0, 1]], 20e3, 0.45)),
            (r"from_scene", lambda: palpate.Model("scene.yaml", 20e3, 0.45)),
            (r"nowhere\.msh", lambda: palpate.Model("nowhere.msh", 20e3, 0.45, **fine)),
            (r"shape \(3, 4\)", lambda: palpate.Model(np.zeros((3, 4)), 20e3, 0.45)),
            (r"every element once", lambda: palpate.Model((nodes, twice), 20e3, 0.45, **fine)),
            (r"model\.elemets", lambda: palpate.Model(RECTANGLE, 20e3, 0.45, fixed={"side": "bottom"}, model={"elemets": 60})),
            (r"static", lambda: palpate.Model(BOX, 20e3, 0.45, fixed=ON_GROUND, kind="fem", model={"time": "dynamic"})),
            (r"geometry", lambda: palpate.Model({"sphere": {"radius": 1}}, 20e3, 0.45)),
            (r"tool = 0\.01: expected a dict", lambda: palpate.Model(BOX, 20e3, 0.45, tool=0.01)),
            (r"expected a number, a text", lambda: palpate.Model(BOX, 20e3, 0.45, tool={"shape": object()})),
        ]:
            with self.subTest(pattern):
                self.bad(pattern, call)

    def test_mistakes_of_readers(self):
        nodes, elements = tetrahedra()
        surface, triangles = cube_surface()
        quads = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
        soup = surface[triangles].reshape(-1, 3)  # each triangle has its own corners, as in numpy-stl
        outline = np.array(POLYGON["polygon"]["points"])
        on_outline = {"fixed": {"side": "top"}, "tool": PLANE_TOOL, "thickness": 0.01}
        fine = {"tool": FLAT, "fixed": ON_GROUND, "kind": "fem-green"}
        model = quiet_model(BOX, 20e3, 0.45, **fine)
        for pattern, call in [
            (r"without volume: expected tetrahedra", lambda: palpate.Model((surface, quads), 20e3, 0.45, **fine)),
            (r"elements\[642, 3\] = 196: expected .*0 to 195", lambda: palpate.Model((nodes, elements + 1), 20e3, 0.45, **fine)),
            (r"nodes of shape \(3, 196\): expected \(n, 3\)", lambda: palpate.Model((nodes.T, elements), 20e3, 0.45, **fine)),
            (r"elements of shape \(5, 8\): expected \(m, 4\)", lambda: palpate.Model((nodes, np.zeros((5, 8), int)), 20e3, 0.45, **fine)),
            (r"float64: expected whole numbers", lambda: palpate.Model((elements, nodes), 20e3, 0.45, **fine)),
            (r"rows of equal length", lambda: palpate.Model((nodes, [[0, 1, 2, 3], [1, 2, 3]]), 20e3, 0.45, **fine)),
            (r"open at 36 edges.*28 nodes have the position of another",
             lambda: palpate.Model((soup, np.arange(36).reshape(12, 3)), 20e3, 0.45, tool=FLAT, fixed=ON_GROUND)),
            (r"unit = mm: expected with a mesh", lambda: palpate.Model(BOX, 20e3, 0.45, unit="mm", **fine)),
            (r"unit = inch: expected", lambda: palpate.Model((nodes, elements), 20e3, 0.45, unit="inch", **fine)),
            (r"unit = -1: expected", lambda: palpate.Model(outline, 20e3, 0.45, unit=-1, **on_outline)),
            (r"thickness = 0\.01: expected with an outline", lambda: palpate.Model((nodes, elements), 20e3, 0.45, thickness=0.01, **fine)),
            (r"resolution: expected with a surface", lambda: palpate.Model((nodes, elements), 20e3, 0.45, resolution=0.001, **fine)),
            (r"model\.kind = fem: expected kind=\"fem\"", lambda: palpate.Model(BOX, 20e3, 0.45, fixed=ON_GROUND, model={"kind": "fem"})),
            (r"model = fem: expected a dict", lambda: palpate.Model(BOX, 20e3, 0.45, fixed=ON_GROUND, model="fem")),
            (r"tool\.width 0 to 0\.09 m", lambda: palpate.solve(BOX, 20e3, 0.45, [0.03, 0.03, 0.03, 0, 0, -0.001],
                                                           **{**fine, "tool": {"shape": "flat", "width": 20}})),
            (r"a displacement up to the size of the body, 0\.09 m", lambda: model.solve([0.03, 0.03, 0.03, 0, 0, -1])),
            (r"poisson_ratio = 20000.*expected", lambda: palpate.Model(BOX, 0.45, 20e3, **fine)),
            (r"fixed: no node", lambda: palpate.Model((nodes, elements), 20e3, 0.45, fixed=[])),
            (r"a membrane is fixed at its rim", lambda: palpate.Model(MEMBRANE, 1e6, 0.45, fixed=lambda p: p[:, 2] < 1)),
            (r"overrides = .*expected a list", lambda: palpate.Model.from_scene("scene.yaml", "model.kind=fem")),
        ]:
            with self.subTest(pattern):
                self.bad(pattern, call)

    def test_bad_forces_and_tests(self):
        force = np.random.default_rng(1).normal(size=(100, 3))
        for pattern, call in [
            (r"estimated: 99 rows: expected 100", lambda: palpate.verify_forces(force, force[1:])),
            (r"measured: shape \(100, 2\)", lambda: palpate.verify_forces(force[:, :2], force)),
            (r"no axis has both", lambda: palpate.verify_forces(force * math.nan, force)),
            (r"infinite", lambda: palpate.verify_forces(force / 0.0, force)),
            (r"t\[1\] = .* in order of time", lambda: palpate.verify_forces(force, force, np.arange(100)[::-1] * 1.0)),
            (r"t: shape \(99,\)", lambda: palpate.verify_forces(force, force, np.arange(99.0))),
            (r"sigma: a negative", lambda: palpate.verify_forces(force, force, sigma=-np.ones(100))),
            (r"measured: no row", lambda: palpate.verify_forces(force[:0], force[:0])),
            (r"hold", lambda: palpate.verify_forces(force, force, hold=-np.ones(100, dtype=int))),
            (r"hold: expected whole", lambda: palpate.verify_forces(force, force, hold=np.arange(100) / 10)),
            (r"valid: expected whole", lambda: palpate.verify_forces(force, force, valid=np.full(100, math.nan))),
            (r"valid: texts such as valid: expected booleans", lambda: palpate.verify_forces(force, force, valid=["valid"] * 100)),
            (r"t: not a time", lambda: palpate.verify_forces(force, force, np.full(100, "NaT", dtype="datetime64[ns]"))),
            (r"measured = \['Fx'\]: expected a text", lambda: palpate.verify_table("forces.csv", measured=["Fx"])),
            (r"diameter = 0\.05: expected a text, with its unit", lambda: palpate.identify(compression="c.csv", diameter=0.05)),
            (r"smallest = 1 %: expected a number", lambda: palpate.identify(uniaxial=[[0, 0], [1, 1]], smallest="1 %")),
            (r"smallest, largest: expected", lambda: palpate.identify(uniaxial=[[0, 0], [1, 1]], smallest=0.3, largest=0.1)),
            (r"^uniaxial\.csv: .* between smallest and largest", lambda: palpate.identify(uniaxial=[[0, 0], [0.1, 1]])),
            (r"KIND=array", lambda: palpate.identify(np.zeros((5, 2)))),
            (r"KIND=FILE", lambda: palpate.identify()),
            (r"compression: shape", lambda: palpate.identify(compression=[1, 2, 3])),
            (r"nowhere\.csv", lambda: palpate.identify(compression="nowhere.csv")),
            (r"not finite", lambda: palpate.identify(uniaxial=[[0, 0], [math.nan, 1]])),
            (r"palpate-slave identify", lambda: palpate.identify(images="x.csv", scene="y.yaml")),
        ]:
            with self.subTest(pattern), np.errstate(divide="ignore", invalid="ignore"):
                self.bad(pattern, call)


class VerifyAndIdentifyTest(SlaveSolve):
    def pairs(self, factor=1.0):
        rng = np.random.default_rng(7)
        measured = rng.normal(size=(400, 3))
        return measured, factor * measured + 0.02 * rng.normal(size=measured.shape)

    def test_a_scale_and_a_sign_are_named(self):
        measured, estimated = self.pairs()
        right = palpate.verify_forces(measured, estimated)
        self.assertTrue(right.passes, right.text)
        self.assertEqual(right.wrong, [])
        scaled = palpate.verify_forces(measured, 1.4 * estimated)
        self.assertEqual(scaled.wrong, ["magnitude"])
        self.assertAlmostEqual(scaled.report["cards"][0]["lines"]["magnitude"]["low_value_high"][1], 1.4, delta=0.02)
        self.assertEqual(palpate.verify_forces(measured, -estimated).wrong, ["sign"])
        self.assertTrue(palpate.verify_forces(measured[:, 2], estimated[:, 2]).report["cards"][0]["states"] > 300)

    def test_nanoseconds_are_seconds(self):
        t = np.linspace(0, 20, 2000)
        measured = np.column_stack([np.sin(t), np.cos(1.3 * t), np.sin(0.7 * t)])
        late = np.column_stack([np.interp(t - 0.1, t, column) for column in measured.T])
        lines = []
        for times in (t, (1.7e18 + 1e9 * t).astype(np.int64), np.datetime64("2026-01-01") + (1e9 * t).astype("timedelta64[ns]")):
            lines.append(palpate.verify_forces(measured, late, times).report["cards"][0]["lines"]["delay"])
        self.assertEqual(lines[0]["verdict"], "wrong")
        for line in lines:
            self.assertAlmostEqual(line["low_value_high"][1], 0.1, delta=0.01)

    @NEEDS_TOOLS
    def test_the_report_is_that_of_the_program(self):
        measured, estimated = self.pairs(1.2)
        header = ",".join(f"{w}_f{a}" for w in ("measured", "estimated") for a in "xyz")
        np.savetxt(self.folder / "forces.csv", np.hstack([measured, estimated]), fmt="%.17g", delimiter=",", header=header, comments="")
        subprocess.run([BIN / "palpate-slave", "verify", "--forces", self.folder / "forces.csv", "--out", self.folder / "card"],
                       capture_output=True, text=True)
        expected = json.loads((self.folder / "card/report.json").read_text())["cards"]
        self.assertEqual(palpate.verify_table(self.folder / "forces.csv").report["cards"], expected)
        self.assertEqual(palpate.verify_forces(measured, estimated).report["cards"], expected)

    @NEEDS_TOOLS
    def test_identify_gives_the_numbers_of_the_program(self):
        strain = np.linspace(0.01, 0.3, 30)
        stretch, shear = 1 + strain, 20e3
        stress = shear * (stretch - stretch**-2)  # neo-Hookean, uniaxial
        material = palpate.identify(uniaxial=np.column_stack([strain, stress]))
        self.assertAlmostEqual(material.young_modulus / (3 * shear), 1, delta=0.01)
        self.assertIn("neo-hookean", material.text)
        with self.assertWarnsRegex(palpate.ForceWarning, "check the unit"):  # stress in kPa
            palpate.identify(uniaxial=np.column_stack([strain, 1e-3 * stress]))
        np.savetxt(self.folder / "uniaxial.csv", np.column_stack([strain, stress]), fmt="%.17g", delimiter=",",
                   header="strain,stress (Pa)", comments="")
        subprocess.run([BIN / "palpate-slave", "identify", f"uniaxial={self.folder / 'uniaxial.csv'}", "--out", self.folder / "card"],
                       check=True, capture_output=True)
        expected = json.loads((self.folder / "card/report.json").read_text())
        self.assertEqual(palpate.identify(uniaxial=self.folder / "uniaxial.csv").report, expected)

    def test_the_modulus_of_presses_on_a_scene(self):
        scene = {"name": "x", "object": {"geometry": BOX, "material": {"young_modulus": 5e3, "poisson_ratio": 0.45}, "fixed": ON_GROUND},
                 "model": {"kind": "fem-green"}, "tool": FLAT}
        (self.folder / "scene.yaml").write_text(json.dumps(scene))
        rows = np.array([[0.03, 0.03, 0.03, 0, 0, -1e-3 * d] for d in (1, 2, 3)])
        force = quiet_model(BOX, 12e3, 0.45, tool=FLAT, fixed=ON_GROUND, kind="fem-green").solve(rows).force
        np.savetxt(self.folder / "press.csv", np.column_stack([np.arange(3), rows, force]), fmt="%.17g", delimiter=",",
                   header="case,x,y,z,dx,dy,dz,fx,fy,fz", comments="")
        material = palpate.identify(press=self.folder / "press.csv", scene=self.folder / "scene.yaml")
        self.assertAlmostEqual(material.young_modulus / 12e3, 1, delta=1e-6)


@unittest.skipIf(SANITIZED, "a time of the release")
class SpeedTest(unittest.TestCase):
    def test_a_call_takes_at_most_half_more_than_the_model(self):
        # 1,296 tetrahedra; `solve_us` is the time of the same update inside of the library.
        model = quiet_model({"box": {"size": [0.06, 0.06, 0.06], "cells": [6, 6, 6]}}, 20e3, 0.45, tool=FLAT, fixed=ON_GROUND,
                            kind="fem")
        contact = np.array([0.03, 0.03, 0.06, 0, 0, -0.002])
        model.solve(contact)
        ratios = []
        for _ in range(60):
            before = time.perf_counter()
            model.solve(contact)
            spent = time.perf_counter() - before
            ratios.append(1e6 * spent / model.last_update_us)
        self.assertLess(float(np.median(ratios)), 1.5)

    def test_a_call_takes_at_most_half_more_than_the_library_for_a_contact(self):
        # An update of fem-green takes less than a microsecond. For each contact `palpate-slave solve` also finds its
        # position and the nodes under the tool. The test solves 500 contacts in one call, whose arrays cost little.
        model = quiet_model({"box": {"size": [0.06, 0.06, 0.06], "cells": [6, 6, 6]}}, 20e3, 0.45, tool=FLAT, fixed=ON_GROUND,
                            kind="fem-green")
        contact = np.array([0.03, 0.03, 0.06, 0, 0, -0.002])
        many = np.tile(contact, (500, 1))

        def least(contacts, calls):
            times = []
            for _ in range(calls):
                before = time.thread_time()
                model.solve(contacts)
                times.append(time.thread_time() - before)
            return min(times)
        self.assertLess(least(contact, 2000) / (least(many, 20) / len(many)), 1.5)


class LibrariesTest(unittest.TestCase):
    def test_the_module_loads_no_images_clouds_or_network(self):
        code = "import palpate, palpate._core, palpate.model, sys; print(open('/proc/self/maps').read()); assert 'grpc' not in sys.modules"
        loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
        self.assertIn("_core", loaded)
        for name in ("opencv", "libpcl", "grpc", "libprotobuf", "libnats", "libvtk"):
            self.assertNotIn(name, loaded)

    def test_a_package_without_the_module_says_what_is_missing(self):
        with tempfile.TemporaryDirectory() as scratch:
            shutil.copytree(pathlib.Path(palpate.__file__).parent, f"{scratch}/palpate", ignore=shutil.ignore_patterns("_core*.so"))
            for arguments in (["-c", "import palpate; palpate.solve"], ["-m", "palpate.verify", "forces.csv"]):
                done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, env={**os.environ, "PYTHONPATH": scratch})
                self.assertRegex(done.stderr, r"palpate has no module _core of Python 3.*pip or python3-palpate")

    def test_names_of_values_are_those_of_the_protocol(self):
        from palpate.model import VALIDITIES
        from palpate.state import Phase, Validity
        from palpate.v1 import state_pb2
        for declared, prefix, known in ((state_pb2.Validity, "VALIDITY_", Validity), (state_pb2.Phase, "PHASE_", Phase)):
            self.assertEqual({prefix + value.name: value.value for value in known}, dict(declared.items()))
        self.assertEqual(sorted(VALIDITIES), sorted(v.name.lower() for v in Validity if v != Validity.UNSPECIFIED))

    def test_the_stub_has_every_name(self):
        stub = pathlib.Path(palpate.__file__).with_name("_core.pyi").read_text()
        for name in dir(_core):
            if not name.startswith("__"):
                self.assertRegex(stub, rf"\b{name}\b")


if __name__ == "__main__":
    unittest.main(verbosity=2 if "-v" in sys.argv else 1)
