"""Input files as other people would bring them, written from known values, and what the programs say about them.

A variation is right if its numbers are the known ones or a remark names the mistake; refused if the message names the cause;
unhelpful if the message names another cause or none; silent if wrong numbers come without a remark. The kinds differ from those
of ../shared/cases and ../shared/cases-2.
"""
import functools
import gzip
import io
import json
import math
import pathlib
import pickle
import re
import struct
import tempfile
import zipfile
import zlib
from typing import Callable, NamedTuple

import numpy as np

import runners
from campaign import Case, verdict
from draw import box_mesh, gmsh_2

MAX_UNHELPFUL = 5  # largest number of unhelpful messages


class Row(NamedTuple):
    """An input, its command, and what is expected. `files`: their contents by name, or a function that returns them. `refused`,
    `remark`: patterns that a rejection or a remark must match, joined by ` & `. `truth(output, folder)`: whether the numbers
    are right."""
    name: str
    command: str
    files: dict | Callable[[], dict]
    refused: str
    truth: Callable | None = None
    remark: str | None = None


def write(folder, files):
    for name, content in (files() if callable(files) else files).items():
        file = folder / name
        file.parent.mkdir(exist_ok=True)
        file.write_bytes(content if isinstance(content, bytes) else content.encode())


def run(command, folder):
    return runners.shell(command, folder, F=folder, PYTHON=f"PYTHONPATH={runners.PACKAGE} {runners.PYTHON}")


def output_of(command, files, name):
    """Returns the content of the file `name` that the command makes of its input in the plain form."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        write(folder, files)
        status, output = run(command, folder)
        assert status == 0, output
        return (folder / name).read_bytes()


# ---- tables of test machines: a neo-Hookean gel of E = 81 kPa, compressed to 30 %, cylinder of 50 mm x 30 mm

E = 81e3
HEIGHT, AREA = 0.03, math.pi / 4 * 0.05**2
STRAIN = np.linspace(0, 0.3, 61)
STRESS = -E / 3 * ((1 - STRAIN) - (1 - STRAIN)**-2)  # nominal, positive
LOAD = AREA * STRESS  # [N]
TRAVEL = HEIGHT * STRAIN  # [m]
CYCLES = np.concatenate([np.arange(61), np.arange(61)[::-1]] * 3)
SOFTENING = np.repeat([1, 0.8, 0.75, 0.65, 0.7, 0.6], 61)
MINUTES = np.linspace(0, 12, 145)
RELAXING = 600 * (0.6 + 0.4 * np.exp(-MINUTES / 2))
SIZED = "{BIN}/palpate-slave identify compression={F}/test.csv --diameter 50mm --height 30mm --ends free --out {F}/out"
STRESSES = "{BIN}/palpate-slave identify compression={F}/test.csv --ends free --out {F}/out"
RELAXATION = "{BIN}/palpate-slave identify relaxation={F}/test.csv --out {F}/out"


def modulus(expected, relative=0.02):
    def is_right(output, _):
        found = re.search(r"(?:at rest|fem-green:) E (\S+)", output)
        return bool(found) and abs(float(found[1]) / expected - 1) <= relative
    return is_right


def table(header, *columns, separator=",", form="%.6g"):
    rows = [separator.join(header)] + [separator.join(form % x for x in row) for row in zip(*columns)]
    return "\n".join(rows) + "\n"


PLAIN = table(["Displacement (mm)", "Load (N)"], 1e3 * TRAVEL, LOAD)


def relaxes(output, _):
    """Relaxes from 18 kPa to 10.8 kPa with two minutes, the weighted mean of the time constants."""
    found = re.search(r"young_modulus (\S+) \+- .*, (\S+) Pa for quick", output)
    terms = [(float(a), float(b)) for a, b in re.findall(r"share: ([\d.]+), time: (\S+) s", output)]
    mean = sum(a * b for a, b in terms) / max(sum(a for a, _ in terms), 1e-9)
    return bool(found) and abs(float(found[1]) / 10.8e3 - 1) < 0.03 and abs(float(found[2]) / 18e3 - 1) < 0.03 and 100 < mean < 140


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
PRESSES = {"press.csv": table(["case"] + COLUMNS, range(len(PLACES)), *PLACES.T)}


def gel(geometry=BOX, **changes):
    text = GEL.replace("{GEOMETRY}", geometry)
    for old, new in changes.items():
        text = re.sub(rf"{old}: [^,\n}}]+", f"{old}: {new}", text)
    return {"scene.yaml": text}


def heavy(gravity, density, **changes):
    text = gel(**changes)["scene.yaml"].replace("{kind: fem-green}", f"{{kind: fem, gravity: [0, 0, {gravity}]}}")
    return {"scene.yaml": text.replace("poisson_ratio: 0.4", f"poisson_ratio: 0.4, density: {density}")}


def forces(answers):
    return np.array([runners.vector(row) for row in runners.rows_of(answers)])


@functools.cache
def plain_forces():
    """Returns the forces of the presses on the box that `solve` computes for the plain table."""
    return forces(output_of(SOLVE, {**gel(), **PRESSES}, "answers.csv").decode())


def same_forces(_, folder):
    answers = forces((folder / "answers.csv").read_text())
    return answers.shape == plain_forces().shape and np.allclose(answers, plain_forces(), rtol=1e-5, atol=1e-9)


def pressed(titles, by, separator=",", force_by=1.0, extra=None, force_titles=("fx", "fy", "fz")):
    """Returns a table of presses with the forces that `solve` computes for 20 kPa."""
    columns = [c for c in (PLACES * by).T] + [c for c in (plain_forces() * force_by).T]
    titles = list(titles) + list(force_titles)
    for title, column in (extra or {}).items():
        titles.append(title)
        columns.append(np.full(len(PLACES), column))
    return table(["case"] + titles, range(len(PLACES)), *columns, separator=separator)


IN_JSON = {
    "name": "gel", "tool": {"shape": "flat", "width": 0.012}, "model": {"kind": "fem-green"},
    "object": {"geometry": {"box": {"size": [0.04, 0.04, 0.02], "cells": [8, 8, 4]}},
               "material": {"young_modulus": 20e3, "poisson_ratio": 0.4}, "fixed": {"plane": {"axis": "z", "at": 0}}}}

# ---- meshes of the same box


def meshed(name, text, unit=""):
    return {**gel(geometry="{mesh: %s%s}" % (name, unit)), name: text, **PRESSES}


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


def near_forces(_, folder):
    """Expects forces within a third: a surface is filled with other tetrahedra, of 5 mm under a tool of 12 mm."""
    return np.allclose(forces((folder / "answers.csv").read_text())[:, 2], plain_forces()[:, 2], rtol=0.33)


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


def outlined(text):
    press = table(["case", "x", "y", "dx", "dy"], ["1"], ["0.025"], ["0.03"], ["0"], ["-0.001"], form="%s")
    return {"scene.yaml": PLANE, "outline.csv": text, "press.csv": press}


@functools.cache
def plain_plane_force():
    return forces(output_of(SOLVE, outlined(table(["x", "y"], *OUTLINE.T)), "answers.csv").decode())


def same_plane_force(_, folder):
    return np.allclose(forces((folder / "answers.csv").read_text()), plain_plane_force(), rtol=1e-5, atol=1e-9)


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


def pgm(pixels):
    return b"P5\n%d %d\n65535\n" % (pixels.shape[1], pixels.shape[0]) + pixels.astype(">u2").tobytes()


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


def filmed(change=lambda z: z, scene_changes=(), count=30, unit=1e-4, name="%03d.png", encode=png, **camera):
    rng, text = np.random.default_rng(3), DEPTH
    for old, new in scene_changes:
        assert old in text, old
        text = text.replace(old, new)
    images = (np.clip(np.round(change(depth_image(rng, **camera)) / unit), 0, 65535).astype(np.uint16) for _ in range(count))
    return {"scene.yaml": text, **{"d/" + name % i: encode(pixels) for i, pixels in enumerate(images)}}


def along_the_ray(z):
    """Displacements are differences of two depths, so they are at most 1.5 % too large at the edge of the body."""
    u, v = np.meshgrid(np.arange(z.shape[1]), np.arange(z.shape[0]))
    return z * np.sqrt(1 + ((u - 159.5) / 390)**2 + ((v - 119.5) / 390)**2)


def states(folder):
    return runners.table(folder / "out/states.csv")


def all_valid_without_force(_, f):
    rows = states(f)
    return len(rows) >= 10 and all(row["validity"] == "valid" and abs(float(row["fz"] or "nan")) < 0.02 for row in rows[-5:])


def no_state_is_valid(output, f):
    """Expects that no state is valid, and that the message names the surface at rest."""
    rows = states(f)
    named = [row for row in rows if "rest" in (row.get("check") or "")]
    return len(named) >= 10 and "the surface at rest" in output and not any(row["validity"] == "valid" for row in rows)


# ---- lenses of other programs, to register a camera of 640 x 480, fx 812

LENS = np.array([[812.0, 0, 318.5], [0, 806.0, 243.25], [0, 0, 1]])
# Position of the camera, which looks straight down on z = 0 [m].
POSE_AT = np.array([0.04, 0.05, 0.3])
REGISTER = "{BIN}/palpate-slave calibrate --register {F}/tips.csv --rig {F}/lens.yaml --plane"


def tips(change=lambda uv: uv, lens=LENS):
    rng = np.random.default_rng(8)
    places = rng.uniform([-0.02, -0.02, 0], [0.1, 0.1, 0], (14, 3))
    seen = (places - POSE_AT) * [1, -1, -1]
    uv = change((seen / seen[:, 2:]) @ lens.T[:, :2] + rng.normal(0, 0.05, (14, 2)))
    return {"tips.csv": table(["x", "y", "z", "u", "v"], *places.T, *uv.T, form="%.6f")}


def pose_is_right(output, _):
    found = re.search(r"translation: \[([^\]]+)\]", output)
    if not found:
        return False
    at = [float(re.sub(r"[^-+.\de]", "", part.replace("mm", "e-3").replace(" m", ""))) for part in found[1].split(",")]
    return np.allclose(at[:2], POSE_AT[:2], atol=2e-3)


NUMBERS = ", ".join("%g" % x for x in LENS.ravel())
ROS_LENS = f"""image_width: 640
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
"""
ROS_TOPIC = f"""header:
  stamp: {{sec: 1, nanosec: 2}}
  frame_id: camera
height: 480
width: 640
distortion_model: plumb_bob
d: [0.0, 0.0, 0.0, 0.0, 0.0]
k: [{NUMBERS}]
r: [1, 0, 0, 0, 1, 0, 0, 0, 1]
p: [812, 0, 318.5, 0, 0, 806, 243.25, 0, 0, 0, 1, 0]
"""
FISHEYE = f"""image_width: 640
image_height: 480
camera_matrix: {{rows: 3, cols: 3, data: [{NUMBERS}]}}
distortion_model: equidistant
distortion_coefficients: {{rows: 1, cols: 4, data: [0.1, 0.01, 0, 0]}}
"""
OPENCV_XML = f"""<?xml version="1.0"?>
<opencv_storage>
<image_width>640</image_width>
<image_height>480</image_height>
<camera_matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
  <data>{NUMBERS.replace(",", "")}</data></camera_matrix>
<distortion_coefficients type_id="opencv-matrix"><rows>5</rows><cols>1</cols><dt>d</dt>
  <data>0. 0. 0. 0. 0.</data></distortion_coefficients>
</opencv_storage>
"""
KALIBR = """cam0:
  camera_model: pinhole
  intrinsics: [812, 806, 318.5, 243.25]
  distortion_model: radtan
  distortion_coeffs: [0, 0, 0, 0]
  resolution: [640, 480]
"""
LENS_FILE = {"lens.yaml": f"image_width: 640\nimage_height: 480\ncamera_matrix: {{rows: 3, cols: 3, data: [{NUMBERS}]}}\n"
                          "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n"}

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


def recorded(change=lambda t, c, w: (t, c, w), titles="t c1 c2 c3 c4 fx fy fz", shift=0.0, form="%.9g"):
    files = {}
    for k in range(4):
        t, c, w = change(*touches(k, shift=shift))
        files[f"data/p{k}.csv"] = table(titles.split(), t, *c.T, *w.T, form=form)
    return files


def learnt(output, f):
    network = json.loads((f / "net/network.json").read_text())
    return network["architecture"] == "qnn_4" and abs(network["learnt_force"] / 1.9 - 1) < 0.3 and network["sigma"][2] < 0.1


def honest(output, f):
    """Expects that the sigma of the network covers its errors, because the forces cannot be right."""
    return json.loads((f / "net/network.json").read_text())["sigma"][2] > 0.3


@functools.cache
def network():
    return output_of(TRAIN, recorded, "net/network.json")


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


def touched(change=lambda t, c: (t, c), titles="t,c1,c2,c3,c4"):
    t, c, _ = touches(11, 3)
    t, c = change(t, c)
    return {"net/network.json": network(), "scene.yaml": PAD, "touch.csv": table(titles.split(","), t, *c.T, form="%.12g")}


def json_lines():
    t, c, _ = touches(11, 3)
    return "".join(json.dumps({"t": x, "c1": a, "c2": b, "c3": y, "c4": z}) + "\n" for x, (a, b, y, z) in zip(t, c))


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


# ---- recordings, forces of other sources, networks, clouds and motions

RECORDING = "{BIN}/palpate-slave process {F}/x.mcap --out {F}/out"
EXPORT = "{PYTHON} -m palpate.export {F}/x.mcap {F}/out"
NAMES = ["t"] + [f"{w}_f{a}" for w in ("measured", "estimated") for a in "xyz"]
FORCES = "{BIN}/palpate-slave verify --forces {F}/f.csv --out {F}/out"
ROS_NAMES = ["header.stamp.sec", "header.stamp.nanosec", "wrench.force.x", "wrench.force.y", "wrench.force.z"]
CONVERT = "{PYTHON} -m palpate.convert_network {F}/net.pt --window 20 --out {F}/net"
CLOUD = "{BIN}/palpate-slave evaluate {F}/scene.yaml --cloud {F}/cloud.pcd --segment no --out {F}/out"
CLOUD_SCENE = GEL.replace("{GEOMETRY}", BOX).replace("model:", """sense:
  tactile: {source: simulated}
  depth_camera: {pose: {translation: [20 mm, 20 mm, 300 mm], rotation: [180 deg, 0, 0]}}
model:""").replace("tool: {shape: flat, width: 12 mm}\n", "").replace("fem-green", "fem")
PCD = """# .PCD v0.7
VERSION 0.7
FIELDS x y z
SIZE 4 4 4
TYPE F F F
COUNT 1 1 1
WIDTH 1681
HEIGHT 1
VIEWPOINT 0 0 0 1 0 0 0
POINTS 1681
DATA ascii
""" + "".join("%.4g %.4g 280\n" % (x, y) for y in np.linspace(-20, 20, 41) for x in np.linspace(-20, 20, 41))
PLY = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0.28\n"
PLAYBACK = "{BIN}/palpate-master connect 127.0.0.1:1 --wait 0.2 --device playback:{F}/p.csv"
RUN = np.linspace(0, 2, 40)
TWICE = np.concatenate([RUN, RUN])


def forces_table(n=1500):
    rng = np.random.default_rng(2)
    t = np.arange(n) * 0.02
    measured = np.column_stack([np.sin(0.7 * t), 0.5 * np.cos(1.1 * t), -2 * np.sin(0.4 * t)**2])
    return t, measured, measured + rng.normal(0, 0.02, measured.shape)


def passes(output, _):
    return bool(re.search(r"\bpasses\b|all right", output)) and not re.search(r"\bwrong\b", output)


def archive(members):
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as zipped:
        for name, text in members.items():
            zipped.writestr(name, text)
    return packed.getvalue()


def torchscript():
    script = ("import sys, torch; torch.jit.script(torch.nn.Sequential(torch.nn.Linear(19, 8), torch.nn.Tanh(), torch.nn.Linear(8, 3)))"
              ".save(sys.argv[1])")
    with tempfile.TemporaryDirectory() as scratch:
        file = pathlib.Path(scratch) / "net.pt"
        runners.run(runners.PYTHON, "-c", script, file)
        return {"net.pt": file.read_bytes()}


def rows():
    nodes, elements = box_mesh((8, 8, 4))
    nodes = 0.005 * nodes
    abaqus_nodes = "".join(f"{i + 1}, %.9g, %.9g, %.9g\n" % tuple(p) for i, p in enumerate(nodes))
    abaqus_elements = "*ELEMENT, TYPE=C3D4\n" + "".join(f"{i + 1}, {', '.join(map(str, e + 1))}\n" for i, e in enumerate(elements))
    tetgen_nodes = f"{len(nodes)} 3 1 1\n" + "".join(f"{i} %.9g %.9g %.9g 7 0\n" % tuple(p) for i, p in enumerate(nodes))
    tetgen_elements = f"{len(elements)} 4 1\n" + "".join(f"{i} {' '.join(map(str, e))} 3\n" for i, e in enumerate(elements))
    t, m, e = forces_table()
    return [
        Row("identify german names tabs and decimal commas", SIZED,
            {"test.csv": table(["Standardweg [mm]", "Kraft [N]"], 1e3 * TRAVEL, LOAD, separator="\t").replace(".", ",")},
            "column|displacement|Weg", modulus(E)),
        Row("identify inches and ounces of force", SIZED,
            {"test.csv": table(["Displacement (in)", "Load (ozf)"], TRAVEL / 0.0254, LOAD / 0.2780139)},
            "unit|force", modulus(E)),
        Row("identify kilograms of force per square centimetre", STRESSES,
            {"test.csv": table(["Strain (%)", "Stress (kgf/cm2)"], 100 * STRAIN, STRESS / 98066.5)},
            "stress", modulus(E)),
        Row("identify newtons per square millimetre in latin 1", STRESSES,
            {"test.csv": table(["Strain (%)", "Stress (N/mm\u00b2)"], 100 * STRAIN, STRESS / 1e6).encode("latin-1")},
            "stress", modulus(E)),
        Row("identify dynes per square centimetre", STRESSES,
            {"test.csv": table(["Strain (%)", "Stress (dyn/cm2)"], 100 * STRAIN, STRESS / 0.1)},
            "stress", modulus(E)),
        Row("identify millimetres of mercury", STRESSES,
            {"test.csv": table(["Strain (%)", "Stress (mmHg)"], 100 * STRAIN, STRESS / 133.322)},
            "stress", modulus(E)),
        Row("identify microstrain", STRESSES, {"test.csv": table(["Strain (\u00b5\u03b5)", "Stress (kPa)"], 1e6 * STRAIN, STRESS / 1e3)},
            "strain|unit|number", modulus(E)),
        Row("identify thousands separators", SIZED,
            {"test.csv": "Displacement (um),Load (mN)\n" + "".join(f'"{1e6 * x:,.1f}","{1e3 * y:,.1f}"\n' for x, y in zip(TRAVEL, LOAD))},
            "number|comma", modulus(E)),
        Row("identify travel and load with offsets", SIZED,
            {"test.csv": table(["Displacement (mm)", "Load (N)"], 1e3 * TRAVEL + 2.05, LOAD + 0.3)},
            "travel|begin|rest", modulus(E), "travel|begin"),
        Row("identify a gap that closes", SIZED, {"test.csv": table(["Displacement (mm)", "Load (N)"], 1e3 * (HEIGHT - TRAVEL), LOAD)},
            "decreas|travel|displacement|gap|stretch", modulus(E), "gap|decreas|travel"),
        Row("identify a column gap", SIZED, {"test.csv": table(["Gap (mm)", "Normal force (N)"], 1e3 * (HEIGHT - TRAVEL), LOAD)},
            "deformation|column|gap", modulus(E)),
        Row("identify three cycles that soften", SIZED,
            {"test.csv": table(["Displacement (mm)", "Load (N)"], 1e3 * TRAVEL[CYCLES], SOFTENING * LOAD[CYCLES])},
            "cycle|unloading|differ", modulus(E), "cycle|loading"),
        Row("identify statistics below the rows", SIZED,
            {"test.csv": PLAIN + "Maximum,%g\nMean,%g\nStd. dev.,%g\n" % (LOAD.max(), LOAD.mean(), LOAD.std())},
            ":63: & Maximum", modulus(E)),
        Row("identify two tables in one file", SIZED,
            {"test.csv": PLAIN + "\n" + table(["Displacement (mm)", "Load (N)"], 1e3 * TRAVEL, 2 * LOAD)},
            "second|two", modulus(E)),
        Row("identify dashes for a lost reading", SIZED, {"test.csv": re.sub(r"((?:.*\n){31}[^,]*,)[^\n]*", r"\1--", PLAIN, count=1)},
            ":32: & Load", modulus(E)),
        Row("identify pounds", SIZED, {"test.csv": table(["Displacement (mm)", "Load (lb)"], 1e3 * TRAVEL, LOAD / 4.4482216)},
            "unit|lb", modulus(E)),
        Row("identify newtons that are millinewtons", SIZED,
            {"test.csv": table(["Displacement (mm)", "Load (N)"], 1e3 * TRAVEL, 1e3 * LOAD)},
            "units?|size|modul|Check", modulus(E), "If that is not so"),
        Row("identify a compressed table", SIZED, {"test.csv": gzip.compress(PLAIN.encode())}, "gzip"),
        Row("identify a table in json", SIZED,
            {"test.csv": json.dumps({"Displacement (mm)": list(1e3 * TRAVEL), "Load (N)": list(LOAD)}, indent=1)},
            "JSON"),
        Row("identify an hdf5 file", SIZED, {"test.csv": b"\x89HDF\r\n\x1a\n" + bytes(600)}, "HDF5"),
        Row("identify a labview file", SIZED, {"test.csv": b"TDSm\x0e\0\0\0\x69\x12\0\0" + bytes(500)}, "LabVIEW|TDMS"),
        Row("identify relaxation in minutes", RELAXATION,
            {"test.csv": table(["Time (min)", "Shear strain (%)", "Stress (Pa)"], MINUTES, 0 * MINUTES + 10, RELAXING)},
            "time|min", relaxes),
        Row("press in millimetres with titles", PRESS,
            {**gel(young_modulus="5 kPa"), "press.csv": pressed([c + " (mm)" for c in COLUMNS], 1e3)},
            "unit|mm", modulus(20e3)),
        Row("press in grams of force with titles", PRESS,
            {**gel(), "press.csv": pressed(COLUMNS, 1, force_by=1 / 9.80665e-3, force_titles=("fx (gf)", "fy (gf)", "fz (gf)"))},
            "unit|force", modulus(20e3)),
        Row("press with the reaction", PRESS, {**gel(), "press.csv": pressed(COLUMNS, 1, force_by=-1)},
            "force.*(away|reaction|tool on the object)"),
        Row("press with its width in millimetres", PRESS, {**gel(), "press.csv": pressed(COLUMNS, 1, extra={"width (mm)": 12})},
            "width|unit", modulus(20e3)),
        Row("press 5 mm above the surface", PRESS,
            {**gel(), "press.csv": pressed(COLUMNS, 1).replace("0.02,0.02,0.02,", "0.02,0.02,0.025,")},
            "surface & 0\\.02\\) m"),
        Row("press with a column that is unknown", PRESS, {**gel(), "press.csv": pressed(COLUMNS, 1, extra={"tx": 0})}, "column|torque|tx"),
        Row("press without names of cases", PRESS,
            {**gel(), "press.csv": "\n".join(row.partition(",")[2] for row in pressed(COLUMNS, 1).splitlines()) + "\n"},
            "column|case", modulus(20e3)),
        Row("solve semicolons decimal commas and millimetres", SOLVE,
            {**gel(), "press.csv": table(["case"] + [c + " [mm]" for c in COLUMNS], range(3), *(1e3 * PLACES).T, separator=";").replace(".", ",")},
            "column|separat|comma", same_forces),
        Row("solve in centimetres", SOLVE,
            {**gel(), "press.csv": table(["case"] + [c + " (cm)" for c in COLUMNS], range(3), *(1e2 * PLACES).T)},
            "unit|cm", same_forces),
        Row("solve micrometres without a unit", SOLVE, {**gel(), "press.csv": table(["case"] + COLUMNS, range(3), *(1e6 * PLACES).T)},
            "surface & reaches"),
        Row("press 5 mm above a coarse surface", PRESS,
            {**gel(geometry=BOX.replace("[8, 8, 4]", "[2, 2, 1]")), "press.csv": pressed(COLUMNS, 1).replace("0.02,0.02,0.02,", "0.02,0.02,0.025,")},
            "surface", None, "off the surface.*0.005 m"),
        Row("press in grams without a unit", PRESS, {**gel(), "press.csv": pressed(COLUMNS, 1, force_by=1 / 9.80665e-3)}, "modul|times"),
        Row("solve with capital titles", SOLVE, {**gel(), "press.csv": table(["Case"] + [c.upper() for c in COLUMNS], range(3), *PLACES.T)},
            "column", same_forces),
        Row("solve a plane that misses by half a millimetre", SOLVE, {**gel(at="0.5 mm"), **PRESSES}, "nearest"),
        Row("scene poisson in percent", SOLVE, {**gel(poisson_ratio="40"), **PRESSES}, "poisson_ratio & 0\\.5"),
        Row("scene newtons per square millimetre", SOLVE, {**gel(young_modulus="0.02 N/mm2"), **PRESSES},
            "young_modulus|unit", same_forces),
        Row("scene megapascals without a unit", SOLVE, {**gel(young_modulus="0.02"), **PRESSES},
            "young_modulus & [kM]Pa", None, "young_modulus & MPa"),
        Row("scene gravity in millimetres", SOLVE, {**heavy("-9810", "1000", young_modulus="20 MPa"), **PRESSES},
            "gravity", None, "gravity & mm"),
        Row("scene tonnes per cubic millimetre", SOLVE, {**heavy("-9.81", "1.07e-9"), **PRESSES},
            "density", None, "density & (t/mm3|g/cm3)"),
        Row("scene of sofa", SOLVE,
            {"scene.yaml": '<?xml version="1.0"?>\n<Node name="root" dt="0.02" gravity="0 0 -9.81">\n</Node>\n', **PRESSES},
            "XML"),
        Row("scene of mujoco without a prolog", SOLVE,
            {"scene.yaml": '<mujoco model="gel">\n  <worldbody>\n    <geom type="box" size="1 1 1"/>\n  </worldbody>\n</mujoco>\n', **PRESSES},
            "XML"),
        Row("mesh gmsh 2 binary", SOLVE, meshed("box.msh", gmsh_2(nodes, elements, binary=True)), "binary & gmsh", same_forces),
        Row("mesh of tetrahedra that turn the other way", SOLVE, meshed("box.msh", gmsh_2(nodes, elements[:, [0, 1, 3, 2]])),
            "tet|inverted|turned|volume", same_forces),
        Row("mesh in millimetres without a unit", SOLVE, meshed("box.msh", gmsh_2(1e3 * nodes, elements)),
            "mm|millimetre|surface", same_forces, "millimetre|mm"),
        Row("mesh of abaqus", SOLVE, meshed("box.inp", "*HEADING\n*NODE\n" + abaqus_nodes + abaqus_elements), "Abaqus"),
        Row("mesh of abaqus with a comment first", SOLVE, meshed("box.inp", "** Job name: Job-1\n*Heading\n*Node\n" + abaqus_nodes),
            "Abaqus"),
        Row("mesh of wavefront", SOLVE,
            meshed("box.obj", "# Blender v3\no Cube\nv 0 0 0\nv 0.04 0 0\nv 0 0.04 0\nv 0 0 0.02\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"),
            "Wavefront"),
        Row("mesh of geomview", SOLVE,
            meshed("box.off", "OFF\n4 4 6\n0 0 0\n0.04 0 0\n0 0.04 0\n0 0 0.02\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"),
            "Geomview"),
        Row("mesh of cad", SOLVE,
            meshed("box.step", "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"),
            "STEP & gmsh"),
        Row("mesh of a browser", SOLVE, meshed("box.glb", b"glTF\x02\0\0\0" + bytes(200)), "glTF"),
        Row("mesh of nastran", SOLVE,
            meshed("box.bdf", "$ Nastran input\nSOL 101\nCEND\nBEGIN BULK\nGRID    1       0       0.      0.      0.\nENDDATA\n"),
            "Nastran"),
        Row("mesh of paraview", SOLVE,
            meshed("box.vtk", "# vtk DataFile Version 3.0\nbox\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n"),
            "VTK"),
        Row("mesh of febio", SOLVE,
            meshed("box.feb", '<?xml version="1.0" encoding="ISO-8859-1"?>\n<febio_spec version="4.0">\n<Mesh></Mesh>\n</febio_spec>\n'),
            "FEBio|XML"),
        Row("mesh whose surface is inside out", SOLVE,
            meshed("box.stl", stl(nodes, [face[::-1] for face in surface_of(nodes, elements)]), ", resolution: 3 mm"),
            "inside|outward|turned|inverted", near_forces),
        Row("mesh whose surface has a hole", SOLVE, meshed("box.stl", stl(nodes, surface_of(nodes, elements)[3:]), ", resolution: 3 mm"),
            "open|hole|closed"),
        Row("mesh of two bodies", SOLVE,
            meshed("box.msh", gmsh_2(np.vstack([nodes, nodes + [0, 0, 0.03]]), np.vstack([elements, elements + len(nodes)]))),
            "parts|bodies|components|pieces|connected", None, "parts|bodies|components|pieces|connected"),
        Row("mesh of hexahedra", SOLVE,
            meshed("box.msh", gmsh_2(nodes, np.zeros((0, 4), dtype=int)).replace("$Elements\n0\n", "$Elements\n1\n1 5 2 1 1 1 2 7 6 46 47 52 51\n")),
            "hexahedr|type 5|element"),
        Row("mesh of tetgen from zero with attributes", SOLVE,
            {**gel(geometry="{mesh: box.node}"), "box.node": tetgen_nodes, "box.ele": tetgen_elements, **PRESSES},
            "twice|nodes|numbers", same_forces),
        Row("outline clockwise", SOLVE, outlined(table(["x", "y"], *OUTLINE[::-1].T)), "clockwise|order", same_plane_force),
        Row("outline whose first point is repeated", SOLVE, outlined(table(["x", "y"], *OUTLINE[[0, 1, 2, 3, 0]].T)),
            "twice|equal|edge|point", same_plane_force),
        Row("outline in columns y and x with semicolons", SOLVE,
            outlined(table(["Y [mm]", "X [mm]"], 1e3 * OUTLINE[:, 1], 1e3 * OUTLINE[:, 0], separator=";")),
            "column|separat", same_plane_force),
        Row("outline in pixels", SOLVE, outlined(table(["x", "y"], *(1e4 * OUTLINE).T)),
            "surface|boundary|metres|pixel|unit", None, "metres|unit"),
        Row("outline that crosses itself", SOLVE, outlined(table(["x", "y"], *OUTLINE[[0, 2, 1, 3]].T)), "cross|area"),
        Row("scene with a key twice", SOLVE,
            {"scene.yaml": gel()["scene.yaml"].replace("  fixed:", "  material: {young_modulus: 80 kPa, poisson_ratio: 0.4}\n  fixed:"), **PRESSES},
            "each key once"),
        Row("scene kilopascals in capitals", SOLVE, {**gel(young_modulus="20 KPA"), **PRESSES}, "young_modulus", same_forces),
        Row("scene in json", SOLVE, {"scene.yaml": json.dumps(IN_JSON), **PRESSES}, "never", same_forces),
        Row("depth as the scene has it", PROCESS, lambda: filmed(), "never", all_valid_without_force),
        Row("depth with holes", PROCESS, lambda: filmed(lambda z: np.where(np.random.default_rng(5).random(z.shape) < 0.1, 0, z)),
            "never", all_valid_without_force),
        Row("depth in millimetres read as tenths", PROCESS, lambda: filmed(unit=1e-3), "rest|unit|farther", no_state_is_valid),
        Row("depth 10 percent too long", PROCESS, lambda: filmed(lambda z: 1.1 * z), "rest", no_state_is_valid),
        Row("depth halved with the intrinsics of the whole", PROCESS, lambda: filmed(lambda z: z[::2, ::2]),
            "rest|size|principal", no_state_is_valid),
        Row("depth with the principal point at the corner", PROCESS,
            lambda: filmed(scene_changes=[("cx: 159.5 px", "cx: 0 px"), ("cy: 119.5 px", "cy: 0 px")]),
            "rest|cx|principal", no_state_is_valid),
        Row("depth of a camera 20 mm too high", PROCESS, lambda: filmed(above=0.27), "rest", no_state_is_valid),
        Row("depth of a tilted camera", PROCESS, lambda: filmed(tilt=0.1), "rest", no_state_is_valid),
        Row("depth with half of fy", PROCESS, lambda: filmed(scene_changes=[("fy: 390 px", "fy: 195 px")]),
            "rest|fy|square", no_state_is_valid),
        Row("depth along the ray", PROCESS, lambda: filmed(along_the_ray), "rest|distance|depth", all_valid_without_force),
        Row("depth of another size in the middle", PROCESS,
            lambda: {**filmed(), "d/015.png": png(np.full((120, 160), 2500, dtype=np.uint16))},
            "size|image", all_valid_without_force),
        Row("depth in 8 bits", PROCESS, lambda: filmed(encode=lambda p: png((p // 16).astype(np.uint8))), "16.bit"),
        Row("depth as a coloured map", PROCESS,
            lambda: filmed(encode=lambda p: png(np.repeat((p // 16).astype(np.uint8)[..., None], 3, axis=2))),
            "16.bit|colour|channel"),
        Row("depth in openexr", PROCESS,
            lambda: filmed(name="%03d.exr", encode=lambda p: b"v/1\x01\x02\0\0\0" + bytes(64), scene_changes=[("*.png", "*.exr")]),
            "EXR"),
        Row("depth in numpy arrays", PROCESS,
            lambda: filmed(name="%03d.npy", scene_changes=[("*.png", "*.npy")], encode=lambda p: b"\x93NUMPY\x01\0v\0{'descr': '<u2'}" + p.tobytes()),
            "NumPy & PNG"),
        Row("depth in pgm", PROCESS,
            lambda: filmed(name="%03d.pgm", scene_changes=[("*.png", "*.pgm")], encode=pgm),
            "PGM|P5|byte|image|16.bit", all_valid_without_force),
        Row("lens of ros", REGISTER, {**tips(), "lens.yaml": ROS_LENS}, "never", pose_is_right),
        Row("lens of a ros topic", REGISTER, {**tips(), "lens.yaml": ROS_TOPIC}, "camera_matrix|image_width|K", pose_is_right),
        Row("lens of a fisheye", REGISTER, {**tips(), "lens.yaml": FISHEYE}, "equidistant|plumb_bob|fisheye"),
        Row("lens of opencv in xml", REGISTER, {**tips(), "lens.yaml": OPENCV_XML}, "XML|camera_matrix", pose_is_right),
        Row("lens of kalibr", REGISTER, {**tips(), "lens.yaml": KALIBR}, "cam0 & camera_matrix"),
        Row("lens of colmap", REGISTER,
            {**tips(), "lens.yaml": "# Camera list with one line of data per camera:\n1 PINHOLE 640 480 812 806 318.5 243.25\n"},
            "camera_matrix|image_width"),
        Row("lens of matlab", REGISTER, {**tips(), "lens.yaml": b"MATLAB 5.0 MAT-file, Platform: GLNXA64" + bytes(500)}, "MATLAB"),
        Row("register pixels from the bottom", REGISTER, {**tips(lambda uv: np.column_stack([uv[:, 0], 480 - uv[:, 1]])), **LENS_FILE},
            "residual|contradict|reject|mirror|pose|fit"),
        Row("register pixels of a larger image", REGISTER, {**tips(lambda uv: 2 * uv), **LENS_FILE}, "outside|image"),
        Row("register u and v exchanged", REGISTER, {**tips(lambda uv: uv[:, ::-1]), **LENS_FILE},
            "residual|contradict|reject|mirror|pose|fit|outside"),
        Row("train as documented", TRAIN, lambda: recorded(), "never", learnt),
        Row("train channels with other names", TRAIN, lambda: recorded(titles="t ch0 ch1 ch2 ch3 fx fy fz"), "column|c1", learnt),
        Row("train times in nanoseconds", TRAIN, lambda: recorded(lambda t, c, w: (1.7e18 + 1e9 * t, c, w), form="%.19g"),
            "nanoseconds", learnt),
        Row("train with a dead channel", TRAIN, lambda: recorded(lambda t, c, w: (t, np.where(np.arange(4) == 2, 40, c), w)),
            "nothing|follow|correlat|constant|c3", learnt),
        Row("train with the normal along x", TRAIN, lambda: recorded(lambda t, c, w: (t, c, w[:, [2, 0, 1]])),
            "fz|normal|axis|contact", learnt),
        Row("train with a wrench that is half a second late", TRAIN, lambda: recorded(shift=0.5), "delay|late|shift|time|follow", honest),
        Row("tactile as documented", PROCESS, lambda: touched(), "never", tactile_force_is_right),
        Row("tactile in pascals with a title", PROCESS, lambda: touched(lambda t, c: (t, 1e3 * c), "t,c1 [Pa],c2 [Pa],c3 [Pa],c4 [Pa]"),
            "unit|Pa"),
        Row("tactile in pascals without a title", PROCESS, lambda: touched(lambda t, c: (t, 1e3 * c)),
            "unit|range|expected", no_large_force_is_valid),
        Row("tactile touched at the start", PROCESS, lambda: touched(lambda t, c: (t[:-190], c[190:])),
            "rest|touch", no_large_force_is_valid),
        Row("tactile times in milliseconds with a title", PROCESS, lambda: touched(lambda t, c: (1e3 * t, c), "t [ms],c1,c2,c3,c4"),
            "unit", tactile_force_is_right),
        Row("tactile times in nanoseconds", PROCESS, lambda: touched(lambda t, c: (1.7e18 + 1e9 * t, c)),
            "nanoseconds|time", tactile_force_is_right),
        Row("tactile of two runs joined", PROCESS, lambda: touched(lambda t, c: (np.concatenate([t, t]), np.vstack([c, c]))),
            "time & (back|increase|decrease)", no_large_force_is_valid),
        Row("tactile with a channel that is dead", PROCESS, lambda: touched(lambda t, c: (t, np.column_stack([c[:, :3], 0 * t + 7.5]))),
            "channel|constant|pattern", no_large_force_is_valid),
        Row("tactile with channels exchanged", PROCESS, lambda: touched(lambda t, c: (t, c[:, [3, 1, 2, 0]])),
            "channel|pattern|order", no_large_force_is_valid),
        Row("tactile with three of four channels", PROCESS, lambda: touched(lambda t, c: (t, c[:, :3]), "t,c1,c2,c3"),
            "column|c1|channels"),
        Row("tactile lines of json", PROCESS, lambda: {**touched(), "touch.csv": json_lines()}, "JSON|column|CSV"),
        Row("recording compressed as a whole", RECORDING, {"x.mcap": b"\x28\xb5\x2f\xfd\x04\x00" + bytes(300)}, "zstd"),
        Row("recording of ros 1", RECORDING, {"x.mcap": b"#ROSBAG V2.0\n" + bytes(300)}, "ROS 1 & MCAP"),
        Row("recording of a header alone", RECORDING, {"x.mcap": b"\x89MCAP0\r\n\x01" + struct.pack("<Q", 8) + bytes(8)},
            "cut|damaged|MCAP|no "),
        Row("export of a database", EXPORT, {"x.mcap": b"SQLite format 3\0" + bytes(500)}, "MCAP|rosbag2|SQLite"),
        Row("forces as documented", FORCES, {"f.csv": table(NAMES, t, *m.T, *e.T)}, "never", passes),
        Row("forces measured by a scale", FORCES,
            {"f.csv": table(["t"] + [f"measured_f{a} (gf)" for a in "xyz"] + NAMES[4:], t, *(m / 9.80665e-3).T, *e.T)},
            "unit|g", passes),
        Row("forces of a ros table", FORCES, {"f.csv": table(ROS_NAMES, t // 1, 1e9 * (t % 1), *m.T)}, "measured_fx|column"),
        Row("forces in parquet", FORCES, {"f.csv": b"PAR1" + bytes(400) + b"PAR1"}, "Parquet"),
        Row("forces in millinewtons without a unit", FORCES, {"f.csv": table(NAMES, t, *m.T, *(1e3 * e).T)},
            "magnitude & wrong", None, "magnitude"),
        Row("forces of two runs joined", FORCES,
            {"f.csv": table(NAMES, np.concatenate([t, t]), *np.vstack([m, m]).T, *np.vstack([e, e]).T)},
            "time|back|decrease", None, "back|decrease|time"),
        Row("network of keras", CONVERT, {"net.pt": b"\x89HDF\r\n\x1a\n" + bytes(500)}, "HDF5"),
        Row("network of keras 3", CONVERT,
            {"net.pt": archive({"metadata.json": "{}", "config.json": '{"class_name": "Sequential"}', "model.weights.h5": b"\x89HDF"})},
            "Keras"),
        Row("network in torchscript", CONVERT, torchscript, "TorchScript"),
        Row("network in onnx", CONVERT, {"net.pt": b"\x08\x07\x12\x07pytorch\x1a\x051.9.1:\x80\x01" + bytes(200)}, "ONNX"),
        Row("network of scikit learn", CONVERT, {"net.pt": pickle.dumps({"coefs_": [[1.0]], "intercepts_": [[0.0]]}, protocol=4)},
            "pickle|scikit|PyTorch"),
        Row("network in text", CONVERT, {"net.pt": "0.1 0.2 0.3\n0.4 0.5 0.6\n"}, "text|weights|PyTorch"),
        Row("cloud in las", CLOUD, {"scene.yaml": CLOUD_SCENE, "cloud.pcd": b"LASF" + bytes(400)}, "LAS"),
        Row("cloud in millimetres", CLOUD,
            {"scene.yaml": CLOUD_SCENE, "cloud.pcd": PCD},
            "metres|mm|far|no point|unit", None, "millimetre|mm|no point|beyond"),
        Row("cloud in ply", CLOUD, {"scene.yaml": CLOUD_SCENE, "cloud.pcd": PLY}, "PLY.*PCD|PCD.*PLY"),
        Row("playback in feet", PLAYBACK, {"p.csv": table(["time_s", "x (ft)", "y (ft)", "z (ft)"], RUN, 0 * RUN, 0 * RUN, 0 * RUN)},
            "ft & unit"),
        Row("playback whose time runs back", PLAYBACK,
            {"p.csv": table(["time_s", "x", "y", "z"], TWICE, 0 * TWICE, 0 * TWICE, -0.001 * TWICE)},
            ":42: time_s.*(more than the row before|increase|back)"),
    ]


def has_all(text, patterns):
    return all(re.search(p, text, re.I) for p in (patterns or "never").split(" & "))


def judged(row, folder):
    write(folder, row.files)
    status, output = run(row.command, folder)
    words, end = output.replace(str(folder), ""), "\n      ".join(["", *output.splitlines()[-12:]])
    if "Traceback" in output or not 0 <= status <= 2:  # a crash
        return verdict("unhelpful", end)
    if (row.truth and status == 0 and row.truth(output, folder)) or (row.remark and has_all(words, row.remark)):
        return verdict("right")
    if status != 0:
        return verdict("refused") if has_all(words, row.refused) else verdict("unhelpful", end)
    return verdict("silent", end)


def cases(options):
    return [Case(row.name, functools.partial(judged, row), row.name.split()[0]) for row in rows()]


def demands(results, options):
    silent, unhelpful = (sum(outcome.counts[word] for _, outcome in results) for word in ("silent", "unhelpful"))
    yield f"{silent} silent", silent == 0
    yield f"{unhelpful} unhelpful, at most {MAX_UNHELPFUL}", unhelpful <= MAX_UNHELPFUL
