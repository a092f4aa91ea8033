#!/usr/bin/env python3
"""Writes heart-target.ply [mm]: half an ellipsoid with a smooth relief, closed by a flat lid.

    u = (sin a cos b, sin a sin b, -cos a),   a = 0 ... 90 deg from the tip, b around
    p = (34 ux, 30 uy, 20 uz) + 0.6 sin(9 ux + 1) cos(8 uy) cos(a) u

The textured half faces -z, the lid lies in z = 0 and the origin in its middle. The simulated target
of slave/simulator/points/textured_target.cpp has the same surface.
"""
import math
import pathlib

RINGS, AROUND = 9, 32
SEMI_AXES, RELIEF = (34.0, 30.0, 20.0), 0.6


def place(polar, turn):
    u = (math.sin(polar) * math.cos(turn), math.sin(polar) * math.sin(turn), -math.cos(polar))
    bump = RELIEF * math.sin(9 * u[0] + 1) * math.cos(8 * u[1]) * math.cos(polar)
    return tuple(axis * x + bump * x for axis, x in zip(SEMI_AXES, u))


def vertex(ring, k):
    return 0 if ring == 0 else 1 + (ring - 1) * AROUND + k % AROUND


nodes = [place(0, 0)]
for ring in range(1, RINGS + 1):
    nodes += [place(math.pi / 2 * ring / RINGS, 2 * math.pi * k / AROUND) for k in range(AROUND)]
lid = len(nodes)
nodes.append((0.0, 0.0, 0.0))

triangles = []  # counter-clockwise seen from outside
for ring in range(RINGS):
    for k in range(AROUND):
        a, b = vertex(ring, k), vertex(ring + 1, k)
        c, d = vertex(ring + 1, k + 1), vertex(ring, k + 1)
        triangles.append((a, c, b))
        if ring > 0:
            triangles.append((a, d, c))
triangles += [(lid, vertex(RINGS, k), vertex(RINGS, k + 1)) for k in range(AROUND)]

with open(pathlib.Path(__file__).with_suffix(".ply"), "w", encoding="ascii") as out:
    out.write("ply\nformat ascii 1.0\ncomment written by heart-target.py, lengths in mm\n"
              f"element vertex {len(nodes)}\n"
              "property float x\nproperty float y\nproperty float z\n"
              f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    out.writelines("%.4f %.4f %.4f\n" % p for p in nodes)
    out.writelines("3 %d %d %d\n" % t for t in triangles)
