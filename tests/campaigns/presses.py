"""Forces of `solve` and `check` in random presses of boxes, sheets, blocks, plates and sheets with holes against independent
references.

A volume is pressed by a flat disc or a round end, a sheet by a flat tool through all of its thickness, a block by a flat tool
through a part of it, a plate by a rigid flat tool in its middle. The references are those of `truth`. `solve` states the
tolerance of its scene, `check` an error. A force is silent if it is valid and off by more than 1.5 times the stated error;
one such force is accepted, but none that is off by more than 15 %. Needs NumPy, SciPy and Gmsh.
"""
import math
import random
import re
from typing import Callable, NamedTuple

import runners
from campaign import Case, Refused, verdict
from truth import pressed_box, pressed_plane, pressed_sheet

COUNT = 60
TOLERANCE = 0.05  # `tolerance` in the scenes
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
    stated: float  # relative error; None: unknown
    validity: str


def solved(folder, press):
    contacts = folder / "contacts.csv"
    place, moved = press.row
    axes = "xyz"[:len(place)]
    contacts.write_text(",".join(["case", *axes, *("d" + a for a in axes)]) + "\n" + ",".join(["a", *(f"{v:.12g}" for v in (*place, *moved))]) + "\n")
    (row, *_), remarks = runners.solve(folder / "scene.yaml", contacts, folder / "answers.csv")
    force = math.sqrt(sum(float(row["f" + a] or "nan") ** 2 for a in axes))
    why = [line.split("): ")[-1] for line in remarks.splitlines() if "rows are extrapolated" in line]
    return Answer(force, TOLERANCE, row["validity"] + "".join(f" ({w})" for w in why))


def checked(folder, press):
    run = runners.run(runners.SLAVE, "check", folder / "scene.yaml")
    force = re.search(r"contact +([-\d.e+]+) N for an indentation", run.stdout)
    if force is None:
        raise Refused(run.stderr + run.stdout)
    flag = re.search(r"extrapolated: .*|error .* MISSES .*|error +not known.*", run.stdout)
    stated = re.search(r"error +about ([-\d.e+]+) %", run.stdout)
    return Answer(float(force[1]), float(stated[1]) / 100 if stated else None, flag[0] if flag else "valid")


def judged(folder, press):
    (folder / "scene.yaml").write_text(press.scene)
    try:
        answer = (checked if press.command == "check" else solved)(folder, press)
    except Refused as why:
        return verdict("refused", str(why).strip().splitlines()[-1])
    truth = press.truth()
    error, is_valid = abs(answer.force / truth - 1), answer.validity == "valid"
    is_off = is_valid and error > FACTOR * answer.stated
    stated = "" if answer.stated is None else f" (stated {100 * answer.stated:.2g} %)"
    return verdict("silent" if is_off else "right" if is_valid else "flagged",
                   f"{answer.force:.4g} N, truth {truth:.4g} N, {100 * (answer.force / truth - 1):+.1f} %{stated}, {answer.validity}",
                   far=is_valid and error > MAX_ERROR, fine=press.elements >= 4 and press.kind in ("volume", "sheet", "holes"))


DRAWS = {"volume": draw_volume, "sheet": draw_sheet, "holes": lambda rng: draw_sheet(rng, True), "block": draw_block, "plate": draw_plate}
ORDER = ("volume", "sheet", "plate", "volume", "holes", "block")


def cases(options):
    order = [options.only] if options.only in DRAWS else ORDER
    for number in range(options.count):
        press = DRAWS[order[number % len(order)]](random.Random(1000 * options.seed + number))
        yield Case(f"{number} {press.kind} {press.command} {press.words}", lambda folder, press=press: judged(folder, press), press.kind)


def demands(results, options):
    outcomes = [outcome for _, outcome in results if "far" in outcome.values]
    beyond, far = (sum(counts) for counts in ([o.counts["silent"] for o in outcomes], [o.values["far"] for o in outcomes]))
    yield f"{beyond} beyond {FACTOR:g} times the stated error", beyond <= 1
    yield f"{far} valid forces beyond {100 * MAX_ERROR:g} %", far == 0
    fine = [outcome for outcome in outcomes if outcome.values["fine"]]
    yield f"with 4 or more elements under the tool {sum(not o.counts['flagged'] for o in fine)} of {len(fine)} valid", True
