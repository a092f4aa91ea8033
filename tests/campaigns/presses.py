"""Forces of `solve`, `check` and Python in random presses of volumes, sheets, blocks and plates against independent references.

A flat or round tool presses bodies of revolution (cylinders, caps, half spheres, layers), boxes and sheets with a curved top, each on
two meshes; some of them deep or with friction. A sheet is also pressed by a flat tool through all of its thickness, a block by one
through a part of it, a plate by a rigid flat tool in its middle. The references are those of `truth`; those of the campaign's own
seeds are in truth/volumes.csv. A force is silent if it is valid and off by more than 1.5 times the stated error; one such force is
accepted, but none that is off by more than 15 %. Needs NumPy, SciPy and Gmsh.
"""
import json
import math
import os
import re
from typing import Callable, NamedTuple

import runners
from campaign import Case, Refused, verdict
from truth import pressed_plane, pressed_sheet, volumes

COUNT = 76
TOLERANCE = 0.1  # `tolerance` in the scenes
RATIO = 1, 3  # median of the stated over the true error
FINE, VALID = 12, 0.6  # with so many elements across the tool, or edges graded to it, this share of the forces is valid
FACTOR, MAX_ERROR = 1.5, 0.15  # largest error of a valid force: relative to the stated error, and absolute
SIDES = 48  # sides of the polygon of a hole


class Press(NamedTuple):
    """A random press: its scene, the row of its contact, its reference, and the elements under its tool."""
    kind: str
    scene: str
    row: tuple
    truth: Callable[[], float]
    words: str
    elements: float
    command: str = "solve"
    mesh: Callable[[str], None] | None = None  # writes the mesh
    python: dict | None = None  # arguments of palpate.solve in place of the scene
    is_graded: bool = False


def millimetres(*values):
    return ", ".join(f"{1e3 * value:.6g} mm" for value in values)


def draw_models(rng, press, kind):
    """Returns two models that fit a press, with their elements."""
    if kind == "rubbing":
        return [(rng.choice(["kind: fem, law: linear", "kind: fem, law: neo-hookean"]), "tet4")]
    if kind == "deep":
        return [("kind: fem, law: neo-hookean", rng.choice(["tet4", "tet4", "tet10"]) if press.friction else "tet4")]
    fits = ["neo-hookean", "corotational"] if press.finite else ["linear"]
    models = [(f"kind: fem, law: {law}", element) for law in fits for element in ("tet4", "tet10")]
    if not press.finite:
        models += 2 * [("kind: fem-green", "tet4"), ("kind: fem-green", "tet10")]
    if not press.friction:  # which `fem` with ten nodes rejects
        models = [m for m in models if m[1] == "tet4" or "green" in m[0]]
    return [rng.choice(models), rng.choice(models)]


def draw_volumes(rng, kind):
    press = volumes.DRAWS[kind](rng)
    for model, element in draw_models(rng, press, kind):
        mesh, across = volumes.draw_mesh(rng, press, element)
        command = "solve" if kind == "rubbing" else rng.choice(["solve", "solve", "check", "python"])
        text = f"{model}, element: {element}"
        meshing = None if mesh.cells else lambda file, mesh=mesh: volumes.write_mesh(file, press, mesh)
        words = f"{model.removeprefix('kind: ').replace(', law:', '')} {element} {press.words()}, across {across:.1f}" \
            + (f" cells {list(mesh.cells)}" if mesh.cells else " graded" if mesh.rim else "")
        yield Press(kind, volumes.scene(press, mesh, text, tolerance=TOLERANCE), volumes.contact_row(press),
                    lambda: volumes.true_force(press), words, across, command, meshing, volumes.arguments(press, mesh, text, TOLERANCE), bool(mesh.rim))


def draw_arc(rng):
    """Sheets with a flat or curved top, on two meshes."""
    press = volumes.draw_sheet(rng)
    thickness, E = 0.02 * min(2 * press.radius, press.height), volumes.E
    angle = math.asin(press.radius / press.cap) if press.cap else 0
    top = 2 * press.cap * angle if press.cap else 2 * press.radius
    outline = 2 * (press.radius + press.height - float(press.profile.fall(press.radius))) + top
    for _ in range(2):
        across, order = round(4 * 4 ** rng.random()), rng.choice(["constant", "quadratic"])
        elements = max(64, min(2000, round(outline * across / (2 * press.reach))))
        across = elements * 2 * press.reach / outline
        # One side of the polygon for each element, whose corners lie above the arc by what makes it lie on the arc in the mean.
        steps = 2 * round(elements * top / outline / 2) if press.cap else 1
        lift = (top / steps) ** 2 / (12 * press.cap) if press.cap else 0
        places = [press.radius * (1 - 2 * i / steps) for i in range(steps + 1)]
        points = [(-press.radius, 0), (press.radius, 0), *((x, press.height - float(press.profile.fall(x)) + lift) for x in places)]
        text = ", ".join(f"[{x:.7g} mm, {y:.7g} mm]" for x, y in points)
        tool = f"shape: round, width: {2 * press.tool_radius:g} mm" if press.tool_radius else f"shape: flat, width: {2 * press.half_width:g} mm"
        scene = f"""name: sheet
object:
  geometry: {{polygon: {{points: [{text}], thickness: {thickness:.5g} mm}}}}
  material: {{young_modulus: {E:g} Pa, poisson_ratio: {press.nu}}}
  fixed: {{plane: {{axis: y, at: 0 mm}}}}
tool: {{{tool}, depth: whole}}
model: {{kind: bem2d, plane: stress, order: {order}, elements: {elements}, contact: {'bonded' if press.friction else 'frictionless'}, tolerance: {TOLERANCE}}}
"""
        yield Press("arc", scene, ([0, (press.height + lift) / 1e3], [0, -(press.depth + lift) / 1e3]), lambda: thickness * volumes.true_force(press),
                    f"bem2d {order} {press.words()}, across {across:.1f}", across)


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
    truth = lambda: E * depth * pressed_plane.sheet_flat(width, height, thickness, place, tool, nu, plane, circles)  # noqa: E731
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
    truth = lambda: E * depth * pressed_plane.block_flat(width, height, thickness, place, tool, extent, nu, behind)  # noqa: E731
    words += "" if behind is None else f" behind {behind / thickness:.2f}"
    return Press("block", scene, ([place, height], [0, -depth]), truth, words, 6)


class Answer(NamedTuple):
    force: float  # [N]
    stated: float | None  # relative error; None: not stated
    validity: str


def solved(folder, press):
    contacts = folder / "contacts.csv"
    place, moved = press.row
    axes = "xyz"[:len(place)]
    contacts.write_text(",".join(["case", *axes, *("d" + a for a in axes)]) + "\n" + ",".join(["a", *(f"{v:.12g}" for v in (*place, *moved))]) + "\n")
    (row, *_), remarks = runners.solve(folder / "scene.yaml", contacts, folder / "answers.csv")
    force = math.sqrt(sum(float(row["f" + a] or "nan") ** 2 for a in axes))
    why = [line.split("): ")[-1] for line in remarks.splitlines() if "rows are extrapolated" in line]
    return Answer(force, relative(row.get("error"), force), row["validity"] + "".join(f" ({w})" for w in why))


def relative(error, force):
    """Returns the error of a force relative to it. None: not stated."""
    error = float(error or "nan")
    return None if math.isnan(error) else error / force


def checked(folder, press):
    run = runners.run(runners.SLAVE, "check", folder / "scene.yaml")
    force = re.search(r"contact +([-\d.e+]+) (m|u|n|)N for an indentation", run.stdout)
    if force is None:
        raise Refused(run.stderr + run.stdout)
    flag = re.search(r"extrapolated: .*|error .* MISSES .*|error +not known.*", run.stdout)
    stated = re.search(r"error +about ([-\d.e+]+) %", run.stdout)
    return Answer(float(force[1]) * {"": 1, "m": 1e-3, "u": 1e-6, "n": 1e-9}[force[2]], float(stated[1]) / 100 if stated else None, flag[0] if flag else "valid")


PROGRAM = """
import json, sys
import palpate
arguments = json.loads(sys.argv[1])
answer = palpate.solve(arguments.pop("mesh"), arguments.pop("modulus"), arguments.pop("ratio"), arguments.pop("row"), **arguments)
print(json.dumps([*answer.force[0].tolist(), float(answer.error[0]), str(answer.validity[0]), str(answer.why[0])]))
"""


def asked(folder, press):
    """The answer of palpate.solve."""
    arguments = {**press.python, "row": [[*press.row[0], *press.row[1]]]}
    if "mesh.msh" in arguments["mesh"]:
        arguments["mesh"] = str(folder / "mesh.msh")
    run = runners.run(runners.PYTHON, "-W", "ignore", "-c", PROGRAM, json.dumps(arguments), env={**os.environ, "PYTHONPATH": str(runners.PACKAGE)})
    *force, error, validity, why = json.loads(run.stdout.splitlines()[-1])
    size = math.hypot(*force)
    return Answer(size, relative(error, size), validity + (f" ({why})" if why else ""))


def judged(folder, press):
    (folder / "scene.yaml").write_text(press.scene)
    if press.mesh:
        press.mesh(folder / "mesh.msh")
    try:
        answer = {"check": checked, "python": asked, "solve": solved}[press.command](folder, press)
    except Refused as why:
        return verdict("refused", str(why).strip().splitlines()[-1])
    try:
        truth = float(press.truth())
    except RuntimeError as why:
        return verdict("unhelpful", str(why))
    error, is_valid = abs(answer.force / truth - 1), answer.validity == "valid"
    limit = TOLERANCE if answer.stated is None else answer.stated
    is_off = is_valid and error > FACTOR * limit
    stated = "" if answer.stated is None else f" (stated {100 * answer.stated:.2g} %)"
    return verdict("silent" if is_off else "right" if is_valid else "flagged",
                   f"{answer.force:.4g} N, truth {truth:.4g} N, {100 * (answer.force / truth - 1):+.1f} %{stated}, {answer.validity}",
                   far=is_valid and error > MAX_ERROR, fine=press.elements >= FINE - 0.5 or press.is_graded,
                   ratio=answer.stated / error if is_valid and answer.stated is not None and error else None)


DRAWS = {"sheet": draw_sheet, "holes": lambda rng: draw_sheet(rng, True), "block": draw_block, "plate": draw_plate}
# 40 shallow presses on two meshes each, 12 deep ones, 8 with friction, and 16 of planes and plates.
ORDER = ("revolved", "box", "revolved", "deep", "arc", "sheet", "revolved", "rubbing", "revolved", "plate", "deep", "box", "revolved", "holes",
         "arc", "rubbing", "revolved", "deep", "block")


def draw(kind, rng):
    if kind == "arc":
        return draw_arc(rng)
    return draw_volumes(rng, kind) if kind in volumes.DRAWS else [DRAWS[kind](rng)]


def cases(options):
    for number in range(options.count):
        kind = ORDER[number % len(ORDER)]
        for index, press in enumerate(draw(kind, volumes.random_of(options.seed, number))):
            yield Case(f"{number}{'ab'[index]} {press.kind} {press.command} {press.words}", lambda folder, press=press: judged(folder, press), press.kind)


def demands(results, options):
    outcomes = [outcome for _, outcome in results if "far" in outcome.values]
    beyond, far = (sum(counts) for counts in ([o.counts["silent"] for o in outcomes], [o.values["far"] for o in outcomes]))
    yield f"{beyond} beyond {FACTOR:g} times the stated error", beyond <= 1
    yield f"{far} valid forces beyond {100 * MAX_ERROR:g} %", far == 0
    ratios = sorted(o.values["ratio"] for o in outcomes if o.values["ratio"] is not None)
    median = ratios[len(ratios) // 2] if ratios else math.nan
    yield f"median of the stated over the true error {median:.2g} ({len(ratios)} valid forces)", RATIO[0] <= median <= RATIO[1]
    fine = [outcome for outcome in outcomes if outcome.values["fine"]]
    valid = sum(not o.counts["flagged"] for o in fine)
    yield f"with {FINE} or more elements across the tool or graded edges {valid} of {len(fine)} valid", valid >= VALID * len(fine)
