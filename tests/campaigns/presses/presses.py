#!/usr/bin/env python3
"""Compares the forces of `solve` and `check` in random presses of boxes, sheets, blocks, plates and sheets with holes
with independent references.

usage: presses.py [--count N] [--seed N] [--only KIND] [--bin FOLDER]   (60 presses; FOLDER build/release/bin)

A volume is pressed by a flat disc or a round end, a sheet by a flat tool through all of its thickness, a block by a flat tool
through a part of it, a plate by a rigid flat tool in its middle. The references: pressed_box.py for volumes; quadratic
triangles for sheets and bricks with mean dilatation for blocks, graded towards the tool; pressed_sheet.py for plates.
`solve` states the tolerance of its scene, `check` an error. Prints a line for each press. Exit code 1: more than one
valid force is off by more than 1.5 times the stated error, or one by more than 15 %. Needs NumPy, SciPy and Gmsh.
"""
import argparse
import csv
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile

import gmsh
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import cg, splu

import pressed_box
import pressed_sheet

TOLERANCE = 0.05  # `tolerance` in the scenes
FACTOR, MAX_ERROR = 1.5, 0.15  # largest error of a valid force: relative to the stated error, and absolute
SIDES = 48  # sides of the polygon of a hole


def elasticity(nu, dimension, plane=None):
    """Returns the elasticity matrix for E = 1; strains xx, yy, (zz,) xy, (xz, yz) with engineering shears."""
    if plane == "stress":
        return np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]]) / (1 - nu * nu)
    lam, mu = nu / ((1 + nu) * (1 - 2 * nu)), 0.5 / (1 + nu)
    n = 3 if dimension == 2 else 6
    D = np.zeros((n, n))
    D[:dimension, :dimension] = lam
    D[range(dimension), range(dimension)] += 2 * mu
    D[range(dimension, n), range(dimension, n)] = mu
    return D


def triangle_matrix(X, conn, D):
    """Returns the stiffness of quadratic triangles with straight sides, nodes in Gmsh's order."""
    T = np.concatenate([np.ones((len(conn), 3, 1)), X[conn[:, :3]]], 2)
    grad = np.linalg.inv(T)[:, 1:, :].transpose(0, 2, 1)  # of the barycentric coordinates
    area = np.abs(np.linalg.det(T)) / 2
    K = np.zeros((len(conn), 12, 12))
    for L in [(2 / 3, 1 / 6, 1 / 6), (1 / 6, 2 / 3, 1 / 6), (1 / 6, 1 / 6, 2 / 3)]:
        edges = [4 * (L[i] * grad[:, j] + L[j] * grad[:, i]) for i, j in [(0, 1), (1, 2), (2, 0)]]
        G = np.concatenate([grad * (4 * np.array(L) - 1)[None, :, None], np.stack(edges, 1)], 1)
        B = np.zeros((len(conn), 3, 12))
        B[:, 0, 0::2] = B[:, 2, 1::2] = G[:, :, 0]
        B[:, 1, 1::2] = B[:, 2, 0::2] = G[:, :, 1]
        K += (area / 3)[:, None, None] * (B.transpose(0, 2, 1) @ (D @ B))
    return assemble(K, conn, 2, len(X))


def assemble(K, conn, d, nodes):
    dof = (conn[:, :, None] * d + np.arange(d)).reshape(len(conn), -1)
    m = dof.shape[1]
    return sp.csr_matrix((K.ravel(), (np.repeat(dof, m, 1).ravel(), np.tile(dof, (1, m)).ravel())), shape=(d * nodes,) * 2)


def solve(A, u, fixed, direct):
    free = ~fixed
    rhs, inner = -(A[free][:, fixed] @ u[fixed]), A[free][:, free]
    if direct:
        u[free] = splu(inner.tocsc()).solve(rhs)
    else:
        u[free], code = cg(inner, rhs, x0=u[free], M=sp.diags(1 / inner.diagonal()), tol=1e-6, maxiter=20000)
        assert code == 0
    return u


def meshed(build, size):
    """Meshes the geometry that `build` makes. Returns nodes and quadratic triangles. `size(x, y)`: length of the
    elements."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("m")
    build(gmsh.model.occ)
    gmsh.model.occ.synchronize()
    for name in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
        gmsh.option.setNumber("Mesh." + name, 0)
    gmsh.model.mesh.setSizeCallback(lambda dim, tag, x, y, z: size(x, y))
    gmsh.model.mesh.generate(2)
    gmsh.option.setNumber("Mesh.SecondOrderLinear", 1)
    gmsh.model.mesh.setOrder(2)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    X = coordinates.reshape(-1, 3)
    _, _, nodes = gmsh.model.mesh.getElements(2)
    gmsh.finalize()
    number = np.zeros(int(max(tags)) + 1, int)
    number[tags.astype(int)] = np.arange(len(tags))
    conn = number[nodes[0].astype(int)].reshape(-1, 6)
    used, flat = np.unique(conn, return_inverse=True)
    return X[used][:, :2], flat.reshape(conn.shape)


def pressed(A, X, bottom, tool):
    """Returns the force for a unit displacement of the glued nodes `tool` along -y."""
    u, fixed = np.zeros(A.shape[0]), np.zeros(A.shape[0], bool)
    for k in range(2):
        fixed[2 * bottom + k] = fixed[2 * tool + k] = True
    u[2 * tool + 1] = -1
    u = solve(A, u, fixed, True)
    return -(A @ u)[2 * tool + 1].sum()


def graded(low, high, centre, fine, growth):
    """Returns points from low to high with the spacing `fine` at the centre, growing away from it."""
    def away(span):
        points, h, x = [], fine, 0.0
        while x + h < span - 0.5 * h:
            x += h
            points.append(x)
            h *= growth
        return np.array(points + [span])
    left = centre - away(centre - low)[::-1] if centre > low else np.array([])
    right = centre + away(high - centre) if high > centre else np.array([])
    return np.concatenate([left, [centre], right])


def bricks(xs, ys, zs, nu):
    """Returns nodes and stiffness of trilinear bricks with mean dilatation, E = 1."""
    nx, ny, nz = len(xs), len(ys), len(zs)
    idx = np.arange(nx * ny * nz).reshape(nx, ny, nz)
    X = np.stack(np.meshgrid(xs, ys, zs, indexing="ij"), -1).reshape(-1, 3)
    conn = np.stack([idx[a:nx - 1 + a, b:ny - 1 + b, c:nz - 1 + c].ravel() for a in (0, 1) for b in (0, 1) for c in (0, 1)], 1)
    s = np.array([[a, b, c] for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)], float)
    size, D = X[conn[:, 7]] - X[conn[:, 0]], elasticity(nu, 3)
    grads = []
    for p in s / math.sqrt(3):
        N = np.stack([0.125 * s[:, k] * np.prod([1 + s[:, o] * p[o] for o in range(3) if o != k], axis=0) for k in range(3)], 1)
        grads.append(N[None] * (2 / size)[:, None, :])
    mean, K = sum(grads) / 8, np.zeros((len(conn), 24, 24))
    for G in grads:
        B = np.zeros((len(conn), 6, 24))
        for k in range(3):
            B[:, k, k::3] = G[:, :, k]
        for r, (i, j) in enumerate([(0, 1), (0, 2), (1, 2)]):
            B[:, 3 + r, i::3] = G[:, :, j]
            B[:, 3 + r, j::3] = G[:, :, i]
        for k in range(3):
            B[:, :3, k::3] += ((mean - G)[:, :, k] / 3)[:, None, :]
        K += (B.transpose(0, 2, 1) @ (D @ B)) * (size.prod(1) / 8)[:, None, None]
    return X, assemble(K, conn, 3, len(X))


def sheet_flat(width, height, thickness, place, tool, nu, plane, holes):
    """Returns the stiffness relative to E of a sheet under a flat tool that is glued to its top."""
    half, fine = tool / 2, tool / 24
    def build(occ):
        p = [occ.addPoint(x, y, 0) for x, y in ((0, 0), (width, 0), (width, height), (place + half, height), (place - half, height), (0, height))]
        lines = [occ.addLine(p[i], p[(i + 1) % 6]) for i in range(6)]
        surface = (2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))
        if holes:
            occ.cut([surface], [(2, occ.addDisk(x, y, 0, r, r)) for x, y, r in holes])
    def h(x, y):
        away = min(math.hypot(x - place - half, y - height), math.hypot(x - place + half, y - height))
        rings = [abs(math.hypot(x - a, y - b) - r) / 2 + r / 8 for a, b, r in holes]
        return min([fine / 4 + 0.2 * away, min(width, height) / 12, *rings])
    X, conn = meshed(build, h)
    A = triangle_matrix(X, conn, elasticity(nu, 2, plane))
    bottom = np.where(X[:, 1] < 1e-9)[0]
    tool_nodes = np.where((X[:, 1] > height - 1e-9) & (np.abs(X[:, 0] - place) < half * (1 + 1e-6)))[0]
    return thickness * pressed(A, X, bottom, tool_nodes)


def block_meshed(across, width, height, thickness, place, tool, extent, nu, behind):
    """Returns the stiffness of a block with `across` bricks across the shorter side of the tool."""
    fine, growth = min(tool, extent) / across, 1.3 ** (6 / across)
    def two(low, high, a, b, h):
        left, right = graded(low, (a + b) / 2, a, h, growth), graded((a + b) / 2, high, b, h, growth)
        return np.unique(np.round(np.concatenate([left, right]), 12))
    xs, ys = two(0, width, place - tool / 2, place + tool / 2, fine), height - graded(0, height, 0, fine, growth)[::-1]
    half, thin = behind is None, min(fine, thickness * 0.75 / across)
    low, high = (-1, extent / 2) if half else (behind, behind + extent)
    zs = graded(0, thickness / 2, high, thin, growth) if half else two(0, thickness, low, high, thin)
    X, A = bricks(xs, ys, zs, nu)
    e = 1e-9
    u, fixed = np.zeros(A.shape[0]), np.zeros(A.shape[0], bool)
    if half:
        fixed[3 * np.where(X[:, 2] < e)[0] + 2] = True
    bottom = np.where(X[:, 1] < e)[0]
    held = np.where((X[:, 1] > height - e) & (np.abs(X[:, 0] - place) < tool / 2 + e) & (X[:, 2] > low - e) & (X[:, 2] < high + e))[0]
    for k in range(3):
        fixed[3 * bottom + k] = fixed[3 * held + k] = True
    u[3 * held + 1] = -1
    u = solve(A, u, fixed, False)
    return -(2 if half else 1) * (A @ u)[3 * held + 1].sum()


def block_flat(width, height, thickness, place, tool, extent, nu, behind=None, coarse=4, fine=8):
    """Returns the stiffness relative to E of a block under a glued flat tool that reaches `extent` through its
    thickness: in the middle (half of the block is meshed) or `behind` the front face. The stress is singular at the
    tool's rim, so the error is proportional to the length of the bricks; two meshes are extrapolated."""
    a, b = (block_meshed(n, width, height, thickness, place, tool, extent, nu, behind) for n in (coarse, fine))
    return (fine * b - coarse * a) / (fine - coarse)


class Press:
    """A random press: text of its scene, row of contacts, and a function that computes its reference."""

    def __init__(self, kind, scene, row, truth, words, elements, command="solve"):
        self.kind, self.scene, self.row, self.truth, self.elements = kind, scene, row, truth, elements
        self.command, self.words = command, f"{command} {words}"


def millimetres(*values):
    return ", ".join(f"{1e3 * value:.6g} mm" for value in values)


def draw_volume(rng):
    size = [round(rng.uniform(40, 60)) / 1e3, round(rng.uniform(40, 60)) / 1e3, round(rng.uniform(25, 50)) / 1e3]
    nu, E = rng.choice([0.3, 0.4, 0.45, 0.49]), 20e3
    is_round, bonded = rng.random() < 0.5, rng.random() < 0.5
    model, element = rng.choice(["fem-green", "fem"]), rng.choice(["tet4", "tet10"])
    bonded |= model == "fem" and element == "tet10"  # these models reject frictionless contacts
    command = rng.choice(["solve", "solve", "check"])
    elements, most = rng.choice([1, 2, 3, 4, 5, 6]), 8 if element == "tet10" else 13
    wanted = elements * max(size[:2]) / most  # smallest extent of so many elements
    aside = command == "solve" and wanted < 0.25 * min(size) and rng.random() < 0.4
    place = [size[0] * (0.35 if aside else 0.5), size[1] / 2]
    if is_round:
        radius = round(1e4 * rng.uniform(0.2, 0.5) * min(size)) / 1e4
        depth = min(max(rng.uniform(0.01, 0.03) * size[2], (wanted / 2) ** 2 / radius), 0.06 * min(size))
        width, tool = 2 * math.sqrt(radius * depth), f"{{shape: round, width: {millimetres(2 * radius)}}}"
        truth = lambda: E * pressed_box.round_end(size, place, radius, depth, nu, bonded)  # noqa: E731
    else:
        depth = rng.uniform(0.01, 0.03) * size[2]
        width = min(max(rng.uniform(0.15, 0.4) * min(size), wanted), 0.5 * min(size))
        tool = f"{{shape: flat, width: {millimetres(width)}}}"
        truth = lambda: E * pressed_box.flat(size, place, width, depth, nu, bonded)  # noqa: E731
    cells = [max(3, min(most, round(side * elements / width))) for side in size]
    law = "law: linear, " if model == "fem" else ""
    contact = "bonded" if bonded else "frictionless"
    scene = f"""name: volume
object:
  geometry: {{box: {{size: [{millimetres(*size)}], cells: {cells}}}}}
  material: {{young_modulus: {E:g} Pa, poisson_ratio: {nu}}}
  fixed: {{plane: {{axis: z, at: 0 mm}}}}
tool: {tool}
operator: {{press: {{depth: {1e3 * depth:.6g} mm}}}}
model: {{kind: {model}, element: {element}, {law}contact: {contact}, tolerance: {TOLERANCE}}}
"""
    spanned = width * max(c / side for c, side in zip(cells[:2], size))
    words = f"{model} {element} {contact} {'round' if is_round else 'flat'} nu {nu} cells {cells} under {spanned:.1f}"
    return Press("volume", scene, ([*place, size[2]], [0, 0, -depth]), truth, words, spanned, command)


def draw_plate(rng):
    radius, nu, E = round(rng.uniform(20, 50)) / 1e3, rng.choice([0.3, 0.45, 0.49]), 1e6
    thickness, tool = radius / rng.choice([20, 40, 60, 80]), radius * rng.choice([0.02, 0.05, 0.1, 0.2, 0.3])
    depth, kind = thickness * rng.choice([0.1, 0.3, 1, 2, 4]), rng.choice(["plate", "plate-large", "plate-large"])
    command = rng.choice(["solve", "solve", "check"])
    scene = f"""name: plate
object:
  geometry: {{membrane: {{radius: {millimetres(radius)}, thickness: {millimetres(thickness)}}}}}
  material: {{young_modulus: {E:g} Pa, poisson_ratio: {nu}}}
  fixed: {{side: rim}}
tool: {{shape: flat, width: {millimetres(2 * tool)}, load: rigid}}
operator: {{press: {{depth: {millimetres(depth)}}}}}
model: {{kind: {kind}, tolerance: {TOLERANCE}}}
"""
    truth = lambda: E * pressed_sheet.flat(radius, thickness, tool, depth, nu)  # noqa: E731
    words = f"{kind} nu {nu} t/R {thickness / radius:.4f} w/2R {tool / radius:.2f} depth/t {depth / thickness:g}"
    return Press("plate", scene, ([0, 0, 0], [0, 0, -depth]), truth, words, 6, command)


def draw_sheet(rng, holes=False):
    width, height = rng.uniform(40, 100) / 1e3, rng.uniform(30, 80) / 1e3
    nu, E, plane = rng.choice([0.3, 0.45, 0.49]), 100e3, "stress"
    tool = rng.uniform(0.08, 0.2) * width
    thickness = 0.02 * min(width, height)
    place = width * rng.uniform(0.3, 0.7)
    under = rng.choice([1, 2, 3, 4, 6])
    circles = []
    for _ in range(rng.choice([1, 2]) if holes else 0):
        r = rng.uniform(0.06, 0.14) * min(width, height)
        at = (rng.uniform(2 * r, width - 2 * r), rng.uniform(0.35 * height, height - 1.8 * r))
        if all(math.hypot(at[0] - x, at[1] - y) > 1.4 * (r + q) for x, y, q in circles):
            circles.append((*at, r))
    depth = 0.02 * height
    rings = [[(x + r * math.cos(2 * math.pi * i / SIDES), y + r * math.sin(2 * math.pi * i / SIDES)) for i in range(SIDES)]
             for x, y, r in circles]
    text = ", ".join("[" + ", ".join(f"[{1e3 * x:.5g} mm, {1e3 * y:.5g} mm]" for x, y in ring) + "]" for ring in rings)
    corners = ((0, 0), (width, 0), (width, height), (0, height))
    points = ", ".join(f"[{millimetres(*p)}]" for p in corners)
    shape = f"polygon: {{points: [{points}], holes: [{text}], thickness: {1e3 * thickness:.5g} mm}}" if circles else \
        f"rectangle: {{width: {millimetres(width)}, height: {millimetres(height)}, thickness: {millimetres(thickness)}}}"
    fixed = "{plane: {axis: y, at: 0 mm}}" if circles else "{side: bottom}"
    order = rng.choice(["constant", "constant", "quadratic"])
    outer = max(24, round(2 * (width + height) * under / tool))
    if order == "quadratic":
        outer = max(16, outer // 2)
    under = outer * tool / (2 * (width + height))
    # At least one element per side.
    elements = outer + sum(max(SIDES, round(2 * math.pi * r * under / tool)) for _, _, r in circles)
    scene = f"""name: sheet
object:
  geometry: {{{shape}}}
  material: {{young_modulus: {E:g} Pa, poisson_ratio: {nu}}}
  fixed: {fixed}
tool: {{shape: flat, width: {millimetres(tool)}, depth: whole}}
operator: {{press: {{depth: {1e3 * depth:.6g} mm}}}}
model: {{kind: bem2d, plane: {plane}, order: {order}, elements: {elements}, tolerance: {TOLERANCE}}}
"""
    truth = lambda: E * depth * sheet_flat(width, height, thickness, place, tool, nu, plane, circles)  # noqa: E731
    words = f"bem2d {order} {len(circles)} holes nu {nu} elements {elements} under {under:.1f}"
    return Press("holes" if holes else "sheet", scene, ([place, height], [0, -depth]), truth, words, under)


def draw_block(rng):
    width, height = rng.uniform(40, 100) / 1e3, rng.uniform(30, 80) / 1e3
    thickness = width * rng.choice([0.05, 0.1, 0.3, 0.6, 1.0])
    nu, E = rng.choice([0.3, 0.45, 0.49]), 50e3
    kind = rng.choice(["bem2d, plane: stress", "bem2d, plane: strain", "extruded", "extruded", "extruded", "extruded"])
    tool = rng.uniform(0.08, 0.2) * width
    extent = thickness * rng.choice([1.0, 1.0, 0.75, 0.5, 0.2, 0.1, 0.05])
    is_aside = kind == "extruded" and extent < thickness and rng.random() < 0.4
    behind = rng.choice([0.0, 0.1, 0.3]) * (thickness - extent) if is_aside else None
    depth, place = 0.02 * height, width * (rng.choice([0.5, 0.3, 0.2]) if kind == "extruded" else 0.5)
    elements = round(2 * (width + height) / tool * 6)
    words = f"{kind} nu {nu} T/W {thickness / width:.2f} b/T {extent / thickness:.2f} w/W {tool / width:.2f} at {place / width:.2f}"
    text = "" if behind is None else f", behind: {millimetres(behind)}"
    scene = f"""name: block
object:
  geometry: {{rectangle: {{width: {millimetres(width)}, height: {millimetres(height)}, thickness: {millimetres(thickness)}}}}}
  material: {{young_modulus: {E:g} Pa, poisson_ratio: {nu}}}
  fixed: {{side: bottom}}
tool: {{shape: flat, width: {millimetres(tool)}, depth: {millimetres(extent)}{text}}}
operator: {{press: {{depth: {1e3 * depth:.6g} mm}}}}
model: {{kind: {kind}, elements: {elements}, tolerance: {TOLERANCE}}}
"""
    truth = lambda: E * depth * block_flat(width, height, thickness, place, tool, extent, nu, behind)  # noqa: E731
    words += "" if behind is None else f" behind {behind / thickness:.2f}"
    return Press("block", scene, ([place, height], [0, -depth]), truth, words, 6)


class Answer:
    """The result of a command: force [N] (None: rejected), stated relative error, whether it is flagged, and the
    output."""

    def __init__(self, force, stated, validity):
        self.force, self.stated, self.validity = force, stated, validity

    @property
    def is_valid(self):
        return self.validity == "valid"


def solved(programs, folder, press):
    scene, contacts, answers = folder / "scene.yaml", folder / "contacts.csv", folder / "answers.csv"
    place, moved = press.row
    axes = "xyz"[:len(place)]
    contacts.write_text(",".join(["case", *axes, *("d" + a for a in axes)]) + "\n" + ",".join(["a", *(f"{v:.12g}" for v in (*place, *moved))]) + "\n")
    run = subprocess.run([programs / "palpate-slave", "solve", scene, "--contacts", contacts, "--out", answers], capture_output=True, text=True)
    if run.returncode != 0:
        return Answer(None, None, "refused: " + run.stderr.strip().splitlines()[-1])
    with open(answers) as file:
        row = next(csv.DictReader(file))
    force = math.sqrt(sum(float(row["f" + a] or "nan") ** 2 for a in axes))
    why = [line.split("): ")[-1] for line in run.stderr.splitlines() if "rows are extrapolated" in line]
    return Answer(force, TOLERANCE, row["validity"] + "".join(f" ({w})" for w in why))


def checked(programs, folder, press):
    run = subprocess.run([programs / "palpate-slave", "check", folder / "scene.yaml"], capture_output=True, text=True)
    force = re.search(r"contact +([-\d.e+]+) N for an indentation", run.stdout)
    if run.returncode != 0 or force is None:
        return Answer(None, None, "refused: " + (run.stderr + run.stdout).strip().splitlines()[-1])
    flag = re.search(r"extrapolated: .*|error .* MISSES .*|error +not known.*", run.stdout)
    stated = re.search(r"error +about ([-\d.e+]+) %", run.stdout)
    return Answer(float(force[1]), float(stated[1]) / 100 if stated else None, flag[0] if flag else "valid")


def answer(programs, folder, press):
    (folder / "scene.yaml").write_text(press.scene)
    return (checked if press.command == "check" else solved)(programs, folder, press)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=("volume", "sheet", "holes", "block", "plate"))
    parser.add_argument("--bin", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[3] / "build/release/bin")
    options = parser.parse_args()
    holes = ("holes", lambda rng: draw_sheet(rng, True))
    draws = [("volume", draw_volume), ("sheet", draw_sheet), ("plate", draw_plate), ("volume", draw_volume), holes, ("block", draw_block)]
    draws = [draw for draw in draws if options.only in (None, draw[0])]
    valid = beyond = far = fine = fine_valid = 0
    with tempfile.TemporaryDirectory() as scratch:
        for number in range(options.count):
            name, draw = draws[number % len(draws)]
            press = draw(random.Random(1000 * options.seed + number))
            given = answer(options.bin, pathlib.Path(scratch), press)
            if given.force is None:
                print(f"{number} {press.kind} {press.words}: {given.validity}", flush=True)
                continue
            truth = press.truth()
            error = given.force / truth - 1
            is_off = given.is_valid and abs(error) > FACTOR * given.stated
            valid += given.is_valid
            beyond += is_off
            far += given.is_valid and abs(error) > MAX_ERROR
            if press.elements >= 4 and press.kind in ("volume", "sheet", "holes"):
                fine += 1
                fine_valid += given.is_valid
            stated = "" if given.stated is None else f" (stated {100 * given.stated:.2g} %)"
            print(f"{number} {press.kind} {press.words}: {given.force:.4g} N, truth {truth:.4g} N, {100 * error:+.1f} %{stated}, "
                  f"{given.validity}{'  <--' if is_off else ''}", flush=True)
    print(f"{valid} valid; {beyond} beyond {FACTOR:g} times the stated error, {far} beyond {100 * MAX_ERROR:g} %; "
          f"with 4 or more elements under the tool {fine_valid} of {fine} valid")
    return 1 if beyond > 1 or far else 0


if __name__ == "__main__":
    sys.exit(main())
