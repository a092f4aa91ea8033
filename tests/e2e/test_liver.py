"""Two fingertips press a soft organ: the scene liver-press on a coarse mesh by the commands check, solve and process."""
import collections
import csv
import importlib.util
import math
import pathlib
import random
import re
import struct
import sys
import tempfile
import unittest

from programs import IS_DEEP, PATIENCE, ROOT, SLAVE, deep, png, read_json, read_rows, run

SCENE = ROOT / "deploy/scenes/liver-press.yaml"
SCRIPT = ROOT / "deploy/scenes/make_liver.py"
LONG = 5 * PATIENCE  # one run prepares several models


def load_script():
    spec = importlib.util.spec_from_file_location("make_liver", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def volume(corners):
    a, b, c = ([p - q for p, q in zip(corner, corners[0])] for corner in corners[1:])
    return (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6


def faces_of(elements):
    """Returns {face: number of tetrahedra that have it}. A face is a sorted tuple of nodes."""
    return collections.Counter(tuple(sorted(face)) for a, b, c, d in elements
                               for face in ((a, b, c), (a, b, d), (a, c, d), (b, c, d)))


class Mesh(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.script = load_script()

    def test_every_tetrahedron_has_a_volume_and_the_surface_is_closed(self):
        for tets in (48, 2000, 20000)[:3 if IS_DEEP else 2]:
            nodes, elements = self.script.body(tets)
            volumes = [volume([nodes[corner] for corner in tet]) for tet in elements]
            self.assertGreater(min(volumes), 0.2 * sum(volumes) / len(volumes), tets)
            self.assertEqual({corner for tet in elements for corner in tet}, set(range(len(nodes))))
            faces = faces_of(elements)
            self.assertEqual(set(faces.values()), {1, 2})
            edges = collections.Counter(edge for face, count in faces.items() if count == 1
                                        for edge in ((face[0], face[1]), (face[0], face[2]), (face[1], face[2])))
            self.assertEqual(set(edges.values()), {2}, "every edge of the surface has two triangles")
            # Euler's formula: a surface without handles has V - E + F = 2.
            outer = [face for face, count in faces.items() if count == 1]
            self.assertEqual(len({node for face in outer for node in face}) - len(edges) + len(outer), 2)

    def test_the_underside_is_flat_and_the_number_of_tetrahedra_is_about_the_wanted_one(self):
        nodes, elements = self.script.body(100_000)
        self.assertAlmostEqual(len(elements) / 100_000, 1, delta=0.05)
        self.assertEqual(min(p[2] for p in nodes), 0)
        self.assertEqual(sum(p[2] == 0 for p in nodes), 37 * 27)
        for axis, size in ((0, 160), (1, 104), (2, 66)):
            extent = max(p[axis] for p in nodes) - min(p[axis] for p in nodes)
            self.assertAlmostEqual(extent / size, 1, delta=0.01)

    def test_the_same_number_gives_the_same_file(self):
        with tempfile.TemporaryDirectory() as folder:
            files = [pathlib.Path(folder) / name for name in ("a.msh", "b.msh")]
            for file in files:
                done = run(sys.executable, SCRIPT, "--tets", "500", "--out", file)
                self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(files[0].read_bytes(), files[1].read_bytes())
        self.assertEqual(run(sys.executable, SCRIPT, "--tets", "7").returncode, 2)


class DepthCamera:
    """A depth camera that looks down on triangles. Images are 16-bit PNG, 0.02 mm per count, with noise of 0.2 mm."""

    SIZE, FOCAL, CENTRE, AWAY, COUNT, NOISE = (320, 240), 280, (159.5, 119.5), 0.4, 2e-5, 2e-4
    KEYS = ("{depth: \"d%03d.png\", rate: 30 Hz, unit: 0.02 mm, sigma: 0.2 mm, fx: 280, fy: 280, cx: 159.5, cy: 119.5, "
            "pose: {translation: [0, 0, 400 mm], rotation: [180 deg, 0, 0]}}")

    def __init__(self, triangles):
        self.triangles, self.random = triangles, random.Random(1)

    def depths(self, nodes):
        width, height = self.SIZE
        depths = [0.0] * (width * height)
        seen = [(self.FOCAL * x / (self.AWAY - z) + self.CENTRE[0], -self.FOCAL * y / (self.AWAY - z) + self.CENTRE[1],
                 1 / (self.AWAY - z)) for x, y, z in nodes]
        for triangle in self.triangles:
            (x0, y0, i0), (x1, y1, i1), (x2, y2, i2) = (seen[node] for node in triangle)
            area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
            if area == 0:
                continue
            for v in range(math.ceil(min(y0, y1, y2)), math.floor(max(y0, y1, y2)) + 1):
                for u in range(math.ceil(min(x0, x1, x2)), math.floor(max(x0, x1, x2)) + 1):
                    a = ((x1 - u) * (y2 - v) - (x2 - u) * (y1 - v)) / area
                    b = ((x2 - u) * (y0 - v) - (x0 - u) * (y2 - v)) / area
                    if min(a, b, 1 - a - b) >= 0:
                        z, pixel = 1 / (a * i0 + b * i1 + (1 - a - b) * i2), v * width + u
                        depths[pixel] = min(depths[pixel] or z, z)
        return depths

    def write(self, file, nodes):
        width, height = self.SIZE
        counts = [round((z + self.random.gauss(0, self.NOISE)) / self.COUNT) if z else 0 for z in self.depths(nodes)]
        rows = (struct.pack(f">{width}H", *counts[v * width:(v + 1) * width]) for v in range(height))
        file.write_bytes(png(width, height, 16, rows))


def displacements(file, name):
    """Returns an array of a VTU file, one vector per node."""
    raw = file.read_bytes()
    begin = raw.index(b"_", raw.index(b"<AppendedData")) + 1
    begin += int(re.search(rb'Name="' + name.encode() + rb'"[^>]*offset="(\d+)"', raw)[1])
    size, = struct.unpack_from("<Q", raw, begin)
    numbers = struct.unpack_from(f"<{size // 8}d", raw, begin + 8)
    return list(zip(numbers[::3], numbers[1::3], numbers[2::3]))


class Programs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.out = pathlib.Path(folder.name)
        mesh = cls.out / "liver.msh"
        done = run(sys.executable, SCRIPT, "--tets", "2000", "--out", mesh)
        assert done.returncode == 0, done.stderr
        cls.scene = (SCENE, "--override", f"object.geometry.mesh={mesh}")

    def test_check_computes_the_press(self):
        done = run(SLAVE, "check", *self.scene, timeout=LONG)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"model +fem:")
        self.assertNotIn("UNGUARDED", done.stdout)

    # Reference: the same mesh solved to six digits. The model with one step per sample is within one percent of it. The
    # scene's friction changes it by less where it sticks.
    def test_solve_gives_the_converged_force(self):
        contacts = self.out / "contacts.csv"
        contacts.write_text("case,x,y,z,dx,dy,dz\n"
                            "1,-0.02813100548,0.01802632260,0.06357817462,0,0.001,-0.004\n"
                            "2,-0.02813100548,0.01802632260,0.06357817462,0,0,-0.003\n"
                            "2,-0.02813100548,-0.02127748995,0.06357817462,0,0,-0.004\n")
        answers = {}
        for name, model in (("scene", ()), ("converged", ("model.residual=1e-6",)),
                            ("rough", ("model.contact=friction", "model.friction=50"))):
            out = self.out / f"{name}.csv"
            overrides = [word for override in model for word in ("--override", override)]
            done = run(SLAVE, "solve", *self.scene, *overrides, "--contacts", contacts, "--out", out, timeout=LONG)
            self.assertEqual(done.returncode, 0, done.stderr)
            with open(out, newline="") as rows:
                answers[name] = [[float(row[key]) for key in ("fx", "fy", "fz")] for row in csv.DictReader(rows)]
        for name, most in (("scene", 0.01), ("rough", 0.02)):
            for found, force in zip(answers[name], answers["converged"], strict=True):
                self.assertLess(math.dist(force, found), most * math.hypot(*force), name)

    # Reference: the known load under which the depth images were made.
    @deep
    def test_depth_images_give_the_force(self):
        nodes, elements = load_script().body(2000)
        nodes = [tuple(1e-3 * x for x in p) for p in nodes]
        place = "-0.02813100548,0.01802632260,0.06357817462"
        forces = (0.2, 0.35, 0.5)
        loads, field, folder = self.out / "loads.csv", self.out / "field.vtu", self.out / "depth"
        folder.mkdir()
        loads.write_text("case,x,y,z,fx,fy,fz\n" + "".join(f"F{i},{place},0,0,{-force}\n" for i, force in enumerate(forces)))
        done = run(SLAVE, "solve", *self.scene, "--override", "model={kind: fem, law: neo-hookean}", "--loads", loads,
                   "--out", self.out / "moved.csv", "--field", field, timeout=LONG)
        self.assertEqual(done.returncode, 0, done.stderr)
        shapes = [nodes] * 6
        for case in (0, 1, 2, 2):
            moved = displacements(field, f"displacement F{case}")
            shapes.append([tuple(map(sum, zip(*pair))) for pair in zip(nodes, moved)])
        camera = DepthCamera([face for face, count in faces_of(elements).items() if count == 1])
        for i, shape in enumerate(shapes):
            camera.write(folder / f"d{i:03}.png", shape)
        text = SCENE.read_text()
        scene = folder / "scene.yaml"
        scene.write_text(text[:text.index("sense:")] + f"sense: {{camera: {camera.KEYS}, points: {{track: surface}}}}\n"
                         "model: {kind: fem, law: neo-hookean, rate: 30 Hz}\n")
        done = run(SLAVE, "process", scene, *self.scene[1:], "--out", folder / "run", timeout=LONG)
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(folder / "run/states.csv", newline="") as states:
            last = list(csv.DictReader(states))[-1]
        force, sigma = math.hypot(*(float(last[key]) for key in ("fx", "fy", "fz"))), float(last["sigma"])
        print(f"depth images: {force} N, sigma {sigma} N, of {forces[-1]} N")
        self.assertEqual(last["validity"], "valid")
        self.assertLess(abs(force - forces[-1]), 3 * sigma)

    # Reference: the simulator's neo-Hookean body. This mesh does not resolve the fingertip, which causes an error of 5 to 6 %. Without the
    # learned correction of the force's direction it is 12 to 14 %.
    def test_two_fingertips_press_it(self):
        done = run(SLAVE, "process", *self.scene, "--out", self.out / "press", timeout=LONG)
        self.assertEqual(done.returncode, 0, done.stderr)
        error, rows = read_json(self.out / "press/summary.json")["force_error"], read_rows(self.out / "press/states.csv")
        print(f"force error of {error['true_peak_N']:.3f} N: {error['rms_N'] / error['true_peak_N']:.1%} rms")
        self.assertGreater(error["contact_samples"], 50)
        self.assertLess(error["rms_N"], 0.08 * error["true_peak_N"])
        for finger in ("ff", "mf"):
            forces = [math.hypot(*(float(row["f" + axis] or 0) for axis in "xyz")) for row in rows if row["finger"] == finger]
            self.assertGreater(max(forces), 0.1, finger)


if __name__ == "__main__":
    unittest.main()
