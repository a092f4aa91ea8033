"""Draws presses of bodies of revolution, boxes and curved sheets, writes their scenes and meshes, and knows their forces.

usage: volumes.py --seed N --scenes FOLDER [--count N] [--element tet4|tet10]   scenes for calibration: seeds from 1000 on
       volumes.py --seed N --table [--count N]                                  adds presses of the campaign to volumes.csv

FOLDER/presses.csv has for each press its scene, its contact as columns of `solve`, the true force [N] and what was drawn. Boxes of
`pressed_box` take half a minute each.
"""
import argparse
import csv
import math
import pathlib
import random
import sys
import time
from typing import NamedTuple

import gmsh

if __package__:
    from truth import pressed_box, pressed_profile
else:
    import pressed_box
    import pressed_profile

GLUED = math.inf
TABLE = pathlib.Path(__file__).with_name("volumes.csv")
MOST = {"tet4": 60e3, "tet10": 12e3}  # tetrahedra
E = 20e3  # [Pa]


class Press(NamedTuple):
    """What determines a force. Lengths [mm]. `cap`: radius of the top, 0: flat. `size`: a box in place of a body of revolution.
    `friction`: 0, Coulomb's number, or inf: glued. `finite`: neo-Hookean."""
    radius: float = 0
    height: float = 0
    cap: float = 0
    size_x: float = 0
    size_y: float = 0
    half_width: float = 0
    tool_radius: float = 0
    depth: float = 0
    nu: float = 0
    friction: float = 0
    finite: bool = False
    plane: bool = False

    @property
    def reach(self):
        """Radius of the contact, of a round tool as estimated [mm]."""
        return pressed_profile.contact_radius(self.profile, self.tool, self.depth)

    @property
    def shaft(self):
        """Width of the tool's shaft [mm]."""
        return 2 * min(self.tool_radius, self.profile.radius) if self.tool_radius else 2 * self.half_width

    @property
    def profile(self):
        return pressed_profile.Profile(self.radius or min(self.size_x, self.size_y) / 2, self.height, self.cap, self.plane)

    @property
    def tool(self):
        return pressed_profile.Tool(self.half_width, self.tool_radius)

    def words(self):
        body = f"box {self.size_x:g}x{self.size_y:g}x{self.height:g}" if self.size_x else \
            f"{'half sphere' if self.cap == self.radius else 'cap' if self.cap else 'cylinder'} R {self.radius:g} H {self.height:g}" \
            + (f" cap {self.cap:g}" if self.cap and self.cap != self.radius else "")
        tool = f"round R {self.tool_radius:g}" if self.tool_radius else f"flat {2 * self.half_width:g}"
        contact = {0: "frictionless", GLUED: "bonded"}.get(self.friction, f"mu {self.friction:g}")
        return f"{body}, {tool}, {contact}, depth {self.depth:g}, nu {self.nu:g}"


def computed(press):
    """Returns the force relative to Young's modulus [mm^2]; of a sheet per thickness [mm]."""
    glued, nu = press.friction == GLUED, press.nu
    if press.plane:  # plane stress is plane strain with other constants
        modulus = (1 + 2 * nu) / (1 + nu) ** 2
        return modulus * pressed_profile.force(press.profile, press.tool, press.depth, nu / (1 + nu), press.friction)
    if not press.size_x:
        return pressed_profile.force(press.profile, press.tool, press.depth, nu, press.friction, press.finite)
    size, place = [press.size_x, press.size_y, press.height], [press.size_x / 2, press.size_y / 2]
    if not press.tool_radius:
        return pressed_box.flat(size, place, 2 * press.half_width, press.depth, nu, glued)
    # A node sticks where it touches: what that adds is taken from a cylinder with the same section.
    cylinder = pressed_profile.Profile(math.sqrt(press.size_x * press.size_y / math.pi), press.height)
    slide, stick = (pressed_profile.force(cylinder, press.tool, press.depth, nu, friction) for friction in (0, press.friction))
    return pressed_box.round_end(size, place, press.tool_radius, press.depth, nu, False) * stick / slide


def key(press):
    return ",".join(f"{float(value):.6g}" for value in press)


def known():
    if not TABLE.exists():
        return {}
    with open(TABLE, encoding="utf-8") as lines:
        return {",".join(row[name] for name in Press._fields): float(row["force_by_modulus"]) for row in csv.DictReader(lines)}


_known = known()


def true_force(press):
    """Returns the force on a body with the modulus E [N]: from the table, or computed."""
    return 1e-6 * E * (_known[key(press)] if key(press) in _known else computed(press))


def rounded(value):
    return float(f"{value:.3g}")


def draw_ratio(rng):
    return rng.choice([0.2, 0.3, 0.3, 0.4, 0.45, 0.47, 0.49, 0.4999])


def draw_body(rng):
    kind = rng.choice(["cylinder", "cap", "half sphere", "layer"])
    if kind == "layer":
        return {"radius": rounded(rng.uniform(40, 60)), "height": rounded(rng.uniform(7, 14))}
    radius = rounded(rng.uniform(20, 40))
    if kind == "half sphere":
        return {"radius": radius, "height": radius, "cap": radius}
    height = rounded(rng.uniform(0.8, 1.6) * radius)
    return {"radius": radius, "height": height} if kind == "cylinder" else \
        {"radius": radius, "height": height, "cap": rounded(radius * rng.uniform(1.3, 3))}


def draw_tool(rng, body, deepest):
    """Returns a tool and its depth, which is at most `deepest` of the height."""
    extent = min(body["radius"] if "radius" in body else min(body["size_x"], body["size_y"]) / 2, 2.5 * body["height"])
    reach = extent * rng.uniform(0.15, 0.35)
    curvature = 1 / body["cap"] if body.get("cap") else 0
    if rng.random() < 0.6:
        half_width = rounded(reach)
        most = min(deepest * body["height"], 0.12 * half_width)
        if curvature:  # from a tenth of the face to all of it in contact
            most = min(deepest * body["height"], curvature * half_width ** 2)
        return {"half_width": half_width, "depth": rounded(most * rng.uniform(0.25, 1))}
    radius = rounded(extent * rng.uniform(0.3, 0.9))
    depth = min(0.7 * reach ** 2 * (1 / radius + curvature), deepest * body["height"])
    return {"tool_radius": radius, "depth": rounded(depth)}


def draw_box(rng):
    body = {"size_x": float(round(rng.uniform(40, 60))), "size_y": float(round(rng.uniform(40, 60))), "height": float(round(rng.uniform(18, 45)))}
    return Press(**body, **draw_tool(rng, body, 0.03), nu=draw_ratio(rng), friction=rng.choice([0.0, GLUED]))


def draw_revolved(rng):
    """Returns a shallow press of a body of revolution: a third under the neo-Hookean law."""
    body, finite = draw_body(rng), rng.random() < 0.33
    return Press(**body, **draw_tool(rng, body, 0.015 if finite else 0.03), nu=draw_ratio(rng), friction=rng.choice([0.0, GLUED]), finite=finite)


def draw_deep(rng):
    """Returns a press of 10 to 30 % of the height, by a flat tool of 10 to 14 %, under the neo-Hookean law."""
    body, nu = draw_body(rng), draw_ratio(rng)
    flat = rng.random() < 0.4
    share = rng.uniform(0.1, 0.14 if flat else 0.3)
    depth = rounded(share * body["height"])
    if flat:
        tool = {"half_width": rounded(min(max(rng.uniform(0.3, 0.45) * body["radius"], 5 * depth), 0.7 * body["radius"]))}
    else:
        reach = rng.uniform(0.3, 0.5) * body["radius"]
        tool = {"tool_radius": rounded(max(reach ** 2 / depth, 1.2 * depth, 0.2 * body["radius"]))}
    folds = depth > 0.4 * tool.get("tool_radius", math.inf)  # beside a deep glued sphere
    return Press(**body, **tool, depth=depth, nu=nu, friction=0.0 if folds else rng.choice([0.0, 0.0, GLUED]), finite=True)


def draw_rubbing(rng):
    """Returns a shallow press with Coulomb's friction."""
    body = draw_body(rng)
    return Press(**body, **draw_tool(rng, body, 0.03), nu=draw_ratio(rng), friction=rounded(rng.uniform(0.1, 0.6)))


def draw_sheet(rng):
    """Returns a press of a sheet whose top is flat or an arc."""
    radius = rounded(rng.uniform(20, 40))
    body = {"radius": radius, "height": rounded(rng.uniform(0.8, 1.6) * radius)}
    if rng.random() < 0.7:
        body["cap"] = rounded(radius * rng.uniform(1.3, 3))
    return Press(**body, **draw_tool(rng, body, 0.03), nu=rng.choice([0.3, 0.45, 0.49]), friction=rng.choice([0.0, GLUED]), plane=True)


DRAWS = {"revolved": draw_revolved, "box": draw_box, "deep": draw_deep, "rubbing": draw_rubbing, "arc": draw_sheet}


def random_of(seed, number):
    return random.Random(1000 * seed + number)


class Mesh(NamedTuple):
    """Edges [mm] under the tool, at its rim, and their growth with the distance from it. A lattice has `cells`."""
    edge: float = 0
    rim: float = 0
    growth: float = 0
    cells: tuple = ()

    def size(self, press, place, largest):
        def at(dim, tag, x, y, z):
            r, below = math.hypot(x - place[0], y - place[1]), place[2] - z
            h = min(largest, self.edge + self.growth * math.hypot(max(0.0, r - press.reach), max(0.0, below - press.reach / 2)))
            return min(h, self.rim + 0.35 * math.hypot(r - press.reach, below)) if self.rim else h
        return at


def draw_mesh(rng, press, element):
    """Returns a mesh with 4 to 16 elements across the contact, and their number."""
    across = round(4 * 4 ** rng.random())
    across = min(across, 10) if element == "tet10" else across
    edge = 2 * press.reach / across
    if press.size_x and rng.random() < 0.5:
        sides = (press.size_x, press.size_y, press.height)
        number = lambda edge: 6 * math.prod(max(3, round(s / edge)) for s in sides)  # noqa: E731
        most = MOST[element] * rng.uniform(0.3, 1)  # so that two meshes differ
        while number(edge) > most:
            edge *= 1.03
        return Mesh(cells=tuple(max(3, round(s / edge)) for s in sides)), 2 * press.reach / edge
    volume = press.size_x * press.size_y * press.height or math.pi * press.radius ** 2 * press.height
    uniform = 8 * volume / edge ** 3 < MOST[element] and rng.random() < 0.5
    is_graded = not uniform and press.half_width and rng.random() < 0.3
    return Mesh(edge, edge / 4 if is_graded else 0, 0 if uniform else rng.choice([0.2, 0.3, 0.4])), across


def write_mesh(file, press, mesh):
    """Writes a mesh of tetrahedra [mm]. Its bottom is at z = 0."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("volume")
    occ, place = gmsh.model.occ, (0, 0, press.height)
    if press.size_x:
        occ.addBox(0, 0, 0, press.size_x, press.size_y, press.height)
        place = (press.size_x / 2, press.size_y / 2, press.height)
    else:
        solid = occ.addCylinder(0, 0, 0, 0, 0, press.height, press.radius)
        if press.cap:
            ball = occ.addSphere(0, 0, press.height - press.cap, press.cap)
            occ.intersect([(3, solid)], [(3, ball)])
    occ.synchronize()
    for name in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
        gmsh.option.setNumber("Mesh." + name, 0)
    gmsh.option.setNumber("Mesh.Optimize", 1)
    gmsh.model.mesh.setSizeCallback(mesh.size(press, place, max(min(press.height, press.radius or press.size_x) / 4, mesh.edge)))
    gmsh.model.mesh.generate(3)
    gmsh.write(str(file))
    gmsh.finalize()


def scene(press, mesh, model, file="mesh.msh", tolerance=0.1):
    """Returns the scene of a press. `model`: kind and options without contact and tolerance."""
    geometry = f"mesh: {file}, unit: mm"
    if mesh.cells:
        geometry = f"box: {{size: [{press.size_x:g} mm, {press.size_y:g} mm, {press.height:g} mm], cells: {list(mesh.cells)}}}"
    tool = f"shape: round, width: {press.shaft:g} mm, radius: {press.tool_radius:g} mm" if press.tool_radius else f"shape: flat, width: {press.shaft:g} mm"
    contact = {0: "contact: frictionless", GLUED: "contact: bonded"}.get(press.friction, f"contact: friction, friction: {press.friction:g}")
    return f"""name: volume
object:
  geometry: {{{geometry}}}
  material: {{young_modulus: {E:g} Pa, poisson_ratio: {press.nu:g}}}
  fixed: {{plane: {{axis: z, at: 0 mm}}}}
tool: {{{tool}}}
operator: {{press: {{depth: {press.depth:g} mm}}}}
model: {{{model}, {contact}, tolerance: {tolerance:g}}}
"""


def arguments(press, mesh, model, tolerance):
    """Returns the arguments of palpate.solve for the same press as `scene`."""
    body = {"box": {"size": [press.size_x / 1e3, press.size_y / 1e3, press.height / 1e3], "cells": list(mesh.cells)}} if mesh.cells else "mesh.msh"
    tool = {"shape": "flat", "width": 1e-3 * press.shaft} if press.half_width else \
        {"shape": "round", "width": 1e-3 * press.shaft, "radius": 1e-3 * press.tool_radius}
    options = dict(word.split(": ") for word in model.split(", "))
    contact = {"contact": "bonded" if press.friction == GLUED else "friction" if press.friction else "frictionless"}
    return {"mesh": body, "modulus": E, "ratio": press.nu, "tool": tool, "fixed": {"plane": {"axis": "z", "at": 0}}, "kind": options.pop("kind"),
            "model": {**options, **contact, "tolerance": tolerance}, **({} if mesh.cells else {"unit": "mm"})}


def contact_row(press):
    """Returns the place and the displacement of the contact [m]."""
    x, y = (press.size_x / 2, press.size_y / 2) if press.size_x else (0.0, 0.0)
    return (x / 1e3, y / 1e3, press.height / 1e3), (0.0, 0.0, -press.depth / 1e3)


def write_scenes(options):
    options.scenes.mkdir(parents=True, exist_ok=True)
    names = ["scene", "x", "y", "z", "dx", "dy", "dz", "force", "across", "edge", "rim", "growth", "cells", *Press._fields]
    with open(options.scenes / "presses.csv", "w", newline="", encoding="utf-8") as lines:
        rows = csv.writer(lines)
        rows.writerow(names)
        for number in range(options.count):
            rng = random_of(options.seed, number)
            press = (draw_box if number % 4 == 3 else draw_revolved)(rng)._replace(finite=False)
            force = true_force(press)
            for index in range(2):
                mesh, across = draw_mesh(rng, press, options.element)
                stem = f"press-{options.seed}-{number}-{index}"
                if not mesh.cells:
                    write_mesh(options.scenes / f"{stem}.msh", press, mesh)
                text = scene(press, mesh, f"kind: fem-green, element: {options.element}", f"{stem}.msh")
                (options.scenes / f"{stem}.yaml").write_text(text)
                place, moved = contact_row(press)
                cells = "x".join(map(str, mesh.cells))
                rows.writerow([f"{stem}.yaml", *place, *moved, f"{force:.6g}", f"{across:.1f}", f"{mesh.edge:.4g}", f"{mesh.rim:.4g}", mesh.growth, cells, *press])
                lines.flush()


def add_to_table(options):
    """Appends the forces of the campaign's presses that the table lacks."""
    sys.path.insert(0, str(TABLE.parents[1]))
    from presses import ORDER
    is_new = not TABLE.exists()
    with open(TABLE, "a", newline="", encoding="utf-8") as lines:
        if is_new:
            csv.writer(lines).writerow([*Press._fields, "force_by_modulus"])
        for number in range(options.count):
            kind = ORDER[number % len(ORDER)]
            if kind not in DRAWS:
                continue
            press, began = DRAWS[kind](random_of(options.seed, number)), time.monotonic()
            if key(press) in _known:
                continue
            try:
                force = computed(press)
            except RuntimeError as why:
                print(f"{number} {kind} {press.words()}: {why}", flush=True)
                continue
            lines.write(f"{key(press)},{force:.6g}\n")
            lines.flush()
            print(f"{number} {kind} {press.words()}: {force:.6g} mm^2, {time.monotonic() - began:.0f} s", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=76)
    parser.add_argument("--element", choices=["tet4", "tet10"], default="tet4", help="limits the number of tetrahedra")
    parser.add_argument("--scenes", type=pathlib.Path)
    parser.add_argument("--table", action="store_true")
    options = parser.parse_args()
    if options.scenes:
        write_scenes(options)
    if options.table:
        add_to_table(options)


if __name__ == "__main__":
    main()
