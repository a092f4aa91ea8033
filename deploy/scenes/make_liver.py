#!/usr/bin/env python3
"""Writes the mesh of liver-press: a smooth body in the shape of a liver, on a flat underside, as Gmsh 2.2 in mm.

make_liver.py                  writes liver-press.msh beside this script: about 100,000 tetrahedra
make_liver.py --tets N         about N tetrahedra
make_liver.py --out FILE.msh   writes FILE.msh

The body is the image of a lattice of cells, u and v from -1 to 1, w from 0 to 1, six tetrahedra each:

    x = u sqrt(1 - v^2 / 4),  y = v sqrt(1 - u^2 / 4)                      rounded outline
    s = 1 - w^2 / 10                                                       walls that lean inwards
    h = 62 (1 - (x^2 + y^2) / 5) (1 - x / 4)                               a thick and a thin lobe p = (80 s x, 52 s (y
    + x^2 / 10 - 0.05), w h)

Its extent is about 160 x 104 x 66 mm. The underside lies in z = 0. Python without packages; the same N gives the same file.
"""
import argparse
import math
import pathlib

CELLS = (36, 26, 18)  # along u, v and w; scaled to the requested number of tetrahedra
# The cube's six tetrahedra around the diagonal from corner 0 to corner 7; corner = i + 2 j + 4 k.
TETS = ((0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7))


def cells_for(tets):
    scale = (tets / (6 * math.prod(CELLS))) ** (1 / 3)
    return tuple(max(2, round(scale * n)) for n in CELLS)


def place(u, v, w):
    x, y = u * math.sqrt(1 - v * v / 4), v * math.sqrt(1 - u * u / 4)
    shrink = 1 - w * w / 10
    height = 62 * (1 - (x * x + y * y) / 5) * (1 - x / 4)
    return 80 * shrink * x, 52 * shrink * (y + x * x / 10 - 0.05), w * height


def body(tets):
    """Returns nodes [mm] and tetrahedra, whose corners are node numbers from 0."""
    cells = cells_for(tets)
    steps = [range(n + 1) for n in cells]
    nodes = [place(2 * i / cells[0] - 1, 2 * j / cells[1] - 1, k / cells[2])
             for k in steps[2] for j in steps[1] for i in steps[0]]
    elements = []
    for k in range(cells[2]):
        for j in range(cells[1]):
            for i in range(cells[0]):
                corner = [i + di + (cells[0] + 1) * (j + dj + (cells[1] + 1) * (k + dk))
                          for dk in (0, 1) for dj in (0, 1) for di in (0, 1)]
                elements += [tuple(corner[c] for c in tet) for tet in TETS]
    return nodes, elements


def write(file, nodes, elements):
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(nodes))]
    lines += ["%d %.9g %.9g %.9g" % (number, *p) for number, p in enumerate(nodes, 1)]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    lines += ["%d 4 2 0 1 %d %d %d %d" % (number, *(corner + 1 for corner in tet)) for number, tet in enumerate(elements, 1)]
    file.write_text("\n".join([*lines, "$EndElements", ""]), encoding="ascii")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Writes the mesh of the scene liver-press.")
    parser.add_argument("--tets", type=int, default=100_000, metavar="N", help="about so many tetrahedra (100000)")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path(__file__).with_name("liver-press.msh"), metavar="FILE.msh")
    options = parser.parse_args()
    if not 48 <= options.tets <= 10_000_000:
        parser.error(f"--tets {options.tets}: expected 48 to 10000000")
    made = body(options.tets)
    write(options.out, *made)
    print(f"{options.out}: {len(made[0])} nodes, {len(made[1])} tetrahedra")
