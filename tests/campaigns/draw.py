"""Draws of the campaigns: random numbers, meshes, and scenes of seven kinds."""
import itertools
import math
import pathlib
import struct
import tempfile

import numpy as np


class Dice:
    """Draws of std::mt19937, the first 16 numbers apart."""

    def __init__(self, seed):
        self.random = np.random.RandomState(seed)
        self.random.randint(0, 2**32, 16, np.uint32)

    def share(self):
        return float(self.random.randint(0, 2**32, dtype=np.uint32)) / 2**32

    def between(self, low, high):
        return low + (high - low) * self.share()

    def decades(self, low, high):
        return low * (high / low) ** self.share()

    def chance(self, p):
        return self.share() < p

    def whole(self, low, high):
        return low + int(self.share() * (high - low + 1))

    def normal(self):
        radius = math.sqrt(-2 * math.log(max(1 - self.share(), 1e-12)))
        return radius * math.cos(2 * math.pi * self.share())


def vector(*values):
    return "[" + ", ".join(f"{value:.9g}" for value in values) + "]"


def box_mesh(cells):
    """Returns nodes and tetrahedra of a grid of cubes with an edge of 1, six in each."""
    n = np.array(cells) + 1
    grid = np.stack(np.meshgrid(*(np.arange(k) for k in n), indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(grid)).reshape(n)
    elements = []
    for place in np.ndindex(*cells):
        for order in itertools.permutations(range(3)):
            corner, path = list(place), [place]
            for axis in order:
                corner[axis] += 1
                path.append(tuple(corner))
            elements.append([number[at] for at in path])
    elements = np.array(elements)
    a, b, c, d = (grid[elements[:, i]] for i in range(4))
    turned = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) < 0
    elements[turned] = elements[turned][:, [0, 1, 3, 2]]
    return grid, elements


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


# ---- scenes: text of the scene and further files. `size`: of the object [m]; the press is 0.5 to 5 % of it deep

def scene(dice, size, width):
    """Draws what all scenes have."""
    return {"young_modulus": dice.decades(3e3, 3e6), "poisson_ratio": dice.between(0.2, 0.499), "width": width,
            "depth": size * dice.decades(0.005, 0.05), "tolerance": dice.decades(0.005, 0.2), "rate": dice.decades(60, 5000), "model": ""}


def planar(dice, size):
    drawn = scene(dice, size, size * dice.decades(0.03, 0.2))
    plane, contact = "stress" if dice.chance(0.5) else "strain", "frictionless" if dice.chance(0.25) else "bonded"
    return {**drawn, "model": f", plane: {plane}, contact: {contact}"}


def rectangle(dice):
    size = dice.decades(0.002, 0.2)
    drawn, height = planar(dice, size), size * dice.between(0.35, 1)
    shape = f"rectangle: {{width: {size:.9g}, height: {height:.9g}, thickness: {size * dice.between(0.05, 0.3):.9g}}}"
    return {**drawn, "shape": shape, "fixed": "side: bottom", "home": (size * dice.between(0.3, 0.7), height + 0.1 * size, 0), "size": size}


def block(dice):
    """A thick rectangle under a tool that reaches through all or a part of its thickness."""
    size = dice.decades(0.002, 0.2)
    drawn, height, thickness = planar(dice, size), size * dice.between(0.5, 1), size * dice.between(0.2, 0.6)
    shape = f"rectangle: {{width: {size:.9g}, height: {height:.9g}, thickness: {thickness:.9g}}}"
    extent = thickness * (1 if dice.chance(0.5) else dice.between(0.4, 0.8))
    return {**drawn, "shape": shape, "extent": f"{extent:.9g}", "fixed": "side: bottom", "home": (size * dice.between(0.3, 0.7), height + 0.1 * size, 0),
            "size": size}


def disc(dice):
    radius = dice.decades(0.0005, 0.1)
    drawn = planar(dice, 2 * radius)
    shape = f"disc: {{radius: {radius:.9g}, thickness: {radius * dice.between(0.1, 1):.9g}}}"
    fixed = f"arc: {{centre: 180 deg, half_angle: {dice.between(0.3, 1.2):.9g}}}"
    return {**drawn, "shape": shape, "fixed": fixed, "home": (1.2 * radius, 0, 0), "size": 2 * radius}


def polygon(dice):
    """Corners on a bent circle above a flat bottom; often with a hole."""
    size = dice.decades(0.005, 0.2)
    drawn, corners, holes = planar(dice, size), [(-0.35 * size, 0), (0.35 * size, 0)], ""
    count = dice.whole(3, 5)
    for i in range(count):
        angle, reach = math.pi * (i + dice.between(0.3, 0.7)) / count, size * dice.between(0.45, 0.55)
        corners.append((reach * math.cos(angle), 0.15 * size + reach * math.sin(angle)))
    if dice.chance(0.5):
        radius, angles = size * dice.between(0.05, 0.12), [2 * math.pi * i / 24 for i in range(24)]
        ring = ", ".join(vector(radius * math.cos(angle), 0.25 * size + radius * math.sin(angle)) for angle in angles)
        holes = f", holes: [[{ring}]]"
    shape = f"polygon: {{points: [{', '.join(vector(*p) for p in corners)}]{holes}, thickness: {0.1 * size:.9g}}}"
    return {**drawn, "shape": shape, "fixed": "side: bottom", "home": (0, size, 0), "size": size}


def volume(dice, size):
    drawn = scene(dice, size, size * dice.decades(0.15, 0.4))
    return {**drawn, "tolerance": dice.decades(0.02, 0.5), "fixed": "plane: {axis: z, at: 0}"}


def box(dice):
    extent = dice.decades(0.01, 0.2)
    drawn = volume(dice, extent)
    sides, cells = (extent, extent * dice.between(0.6, 1), extent * dice.between(0.4, 1)), dice.whole(4, 8)
    cells = [max(2, math.floor(cells * side / extent + 0.5)) for side in sides]
    return {**drawn, "shape": f"box: {{size: {vector(*sides)}, cells: {cells}}}"}


def cap(dice):
    """A cylinder with a round top, meshed by Gmsh with four edges under the tool."""
    from truth import volumes
    radius = dice.decades(0.005, 0.1)
    drawn, height, top = volume(dice, radius), radius * dice.between(0.8, 1.4), radius * dice.between(1.3, 3)
    press = volumes.Press(radius=1e3 * radius, height=1e3 * height, cap=1e3 * top, half_width=500 * drawn["width"])
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "cap.msh"
        volumes.write_mesh(file, press, volumes.Mesh(edge=250 * drawn["width"], growth=0.4))
        return {**drawn, "shape": "mesh: cap.msh, unit: mm", "cap.msh": file.read_text()}


def membrane(dice):
    """The press is a tenth to five times the thickness deep: a plate stretches from about its thickness on."""
    radius = dice.decades(0.005, 0.1)
    drawn, thickness = scene(dice, radius, radius * dice.between(0.1, 0.3)), radius / dice.decades(15, 80)
    changes = {"poisson_ratio": dice.between(0.3, 0.49), "depth": min(thickness * dice.decades(0.1, 5), 0.15 * radius),
               "tolerance": dice.decades(0.02, 0.2)}
    return {**drawn, **changes, "shape": f"membrane: {{radius: {radius:.9g}, thickness: {thickness:.9g}}}", "fixed": "side: rim"}


KINDS = (rectangle, box, membrane, disc, cap, polygon, block)


def random_scene(seed):
    """Returns the name of a scene with `model.kind: auto` and its files."""
    dice, kind = Dice(seed), KINDS[seed % len(KINDS)]
    drawn = kind(dice)
    # In scenes with a camera the slave corrects the force for the shape of the tool.
    has_camera = "home" in drawn and dice.chance(0.5)
    extent = f"depth: {drawn.get('extent', 'whole')}, " if "home" in drawn else ""
    text = f"""name: {kind.__name__}
object:
  geometry: {{{drawn['shape']}}}
  material: {{young_modulus: {drawn['young_modulus']:.9g}, poisson_ratio: {drawn['poisson_ratio']:.9g}}}
  fixed: {{{drawn['fixed']}}}
tool: {{shape: flat, {extent}width: {drawn['width']:.9g}}}
operator: {{press: {{depth: {drawn['depth']:.9g}}}}}
model: {{kind: auto, range: 0.1, tolerance: {drawn['tolerance']:.9g}, rate: {drawn['rate']:.9g}{drawn['model']}}}
"""
    if "home" in drawn:
        text += f"manipulator: {{home: {vector(*drawn['home'])}}}\n"
    if has_camera:
        place = f"{{translation: {vector(drawn['home'][0], drawn['home'][1] - 0.3 * drawn['size'], 0)}}}"
        text += (f"sense:\n  camera: {{source: simulated, rate: 30 Hz, size: [640, 480], pixel: {drawn['size'] / 250:.9g}, pose: {place}}}\n"
                 "  tip: {track: template, roi: 64 px}\n")
    return kind.__name__ + " before a camera" * has_camera, {"scene.yaml": text, **{name: drawn[name] for name in drawn if "." in name}}
