"""Computes forces and outlines of pressed bodies by finite elements that are independent of the product: plane sheets
of any outline under a flat or round tool that may tilt and move sideways, and blocks under a stick in the middle of
their thickness.

Lengths in mm, moduli in kPa, forces in N. The face that the camera sees lies in the plane z = 0; y points up.
"""
import math

import numpy as np
from scipy.sparse.linalg import splu

from truth.pressed_plane import block_flat, bricks, elasticity, graded, meshed, sheet_flat, solve, triangle_matrix

UNDER = 24  # surface elements across the width of a tool
GROWTH = 1.3  # ratio of the sizes of neighbouring bricks away from the tool


def ring_of(conn):
    """Returns the boundary nodes of quadratic triangles in order around the body."""
    sides = {}
    for a, b, c, ab, bc, ca in conn:
        for first, last, middle in ((a, b, ab), (b, c, bc), (c, a, ca)):
            key = (min(first, last), max(first, last))
            sides[key] = None if key in sides else middle
    ways = {}
    for (first, last), middle in sides.items():
        if middle is not None:
            ways.setdefault(first, []).append((last, middle))
            ways.setdefault(last, []).append((first, middle))
    start = next(iter(ways))
    ring, at, before = [], start, None
    while True:
        following, middle = next((n, m) for n, m in ways[at] if n != before)
        ring += [at, middle]
        before, at = at, following
        if at == start:
            return np.array(ring)


class Tool:
    """The end of a rigid tool: half width, shape, and tilt from straight down [rad]."""

    def __init__(self, width, shape, tilt=0.0):
        self.half, self.shape = width / 2, shape
        self.direction = np.array([math.sin(tilt), -math.cos(tilt)])
        self.across = np.array([math.cos(tilt), math.sin(tilt)])

    def recess(self, aside):
        """Returns the distance of the end face behind the tip at the distance `aside` from the axis; infinite beside
        the tool."""
        if self.shape == "flat":
            return np.where(np.abs(aside) <= self.half, 0.0, np.inf)
        inside = np.maximum(self.half ** 2 - aside ** 2, 0)
        return np.where(np.abs(aside) < self.half, self.half - np.sqrt(inside), np.inf)


class Sheet:
    """A sheet in plane stress that is fixed where `held(X)` and pressed by a tool of `width` near `place` on its
    outline."""

    def __init__(self, outline, held, place, width, nu):
        outline, place = np.asarray(outline, float), np.asarray(place, float)
        extent = (outline.max(0) - outline.min(0)).min()
        fine, reach = width / UNDER, 0.75 * width

        def build(occ):
            p = [occ.addPoint(x, y, 0) for x, y in outline]
            occ.addPlaneSurface([occ.addCurveLoop([occ.addLine(a, b) for a, b in zip(p, p[1:] + p[:1])])])

        def size(x, y):
            away = math.hypot(x - place[0], y - place[1])
            return min(fine + 0.2 * max(0, away - reach), extent / 11)
        X, conn = meshed(build, size)
        A = triangle_matrix(X, conn, elasticity(nu, 2, "stress"))
        self.ring = X[ring_of(conn)]
        ring = ring_of(conn)
        free = np.repeat(~held(X), 2)
        near = ring[(np.hypot(*(X[ring] - place).T) < reach) & ~held(X[ring])]
        number = np.cumsum(free) - 1
        loads = np.zeros((free.sum(), 2 * len(near)))
        dofs = (2 * near[:, None] + [0, 1]).ravel()
        loads[number[dofs], np.arange(len(dofs))] = 1
        moved = np.zeros((len(free), len(dofs)))
        moved[free] = splu(A[free][:, free].tocsc()).solve(loads)
        self.near, self.compliance = X[near], moved[dofs]
        self.ring_compliance = moved[(2 * ring[:, None] + [0, 1]).ravel()]

    def press(self, tool, tips):
        """Returns for each position of the tool's tip the force divided by E and thickness [mm], and the outline. A
        surface point in contact sticks until its force pulls."""
        offsets, results = {}, []  # for each sticking point its distance from the tool's axis
        loads = np.zeros((len(self.near), 2))
        for tip in np.asarray(tips, float):
            for _ in range(60):
                now = self.near + (self.compliance @ loads.ravel()).reshape(-1, 2)
                aside, along = (now - tip) @ tool.across, (now - tip) @ tool.direction
                depth = -along - tool.recess(aside)  # negative: the point does not reach the tool
                depth[~np.isfinite(depth)] = -1
                new = [i for i in np.where(depth > 1e-6)[0] if i not in offsets]
                pulled = [i for i in offsets if loads[i] @ tool.direction < 0]
                if not new and not pulled:
                    ends = self._ends(tool, tip, offsets)
                    if not offsets or np.abs(now[list(offsets)] - ends).max() < 1e-6:
                        break
                for i in new:
                    offsets[i] = aside[i]
                for i in pulled:
                    del offsets[i]
                loads = np.zeros_like(loads)
                if offsets:
                    stuck = np.array(sorted(offsets))
                    rows = (2 * stuck[:, None] + [0, 1]).ravel()
                    wanted = self._ends(tool, tip, {i: offsets[i] for i in stuck}) - self.near[stuck]
                    loads.ravel()[rows] = np.linalg.solve(self.compliance[np.ix_(rows, rows)], wanted.ravel())
            ring = self.ring + (self.ring_compliance @ loads.ravel()).reshape(-1, 2)
            results.append((np.hypot(*loads.sum(0)), ring))
        return results

    @staticmethod
    def _ends(tool, tip, offsets):
        aside = np.array(list(offsets.values()))
        return tip + aside[:, None] * tool.across - tool.recess(aside)[:, None] * tool.direction if len(aside) else np.zeros((0, 2))


def solid_share(size, place, tool, nu):
    """Returns the stiffness of a solid body of `size` [width, height, thickness] under a flat tool through its whole thickness,
    relative to plane stress. It is 1.01 to 1.07 for a thickness about as large as the tool's width."""
    width, height, thickness = size
    return block_flat(*size, place, tool, thickness, nu) / sheet_flat(width, height, thickness, place, tool, nu, "stress", [])


class Block:
    """A block [width, height, thickness] with a fixed bottom, whose top a flat stick presses in the middle of the thickness. The outline
    comes from one mesh. The stiffness by E [mm] is extrapolated from two, because that of the first is 4 to 7 % too high."""

    def __init__(self, size, place, tool, extent, nu):
        width, height, thickness = size
        self.stiffness = block_flat(*size, place, tool, extent, nu)
        fine, half = min(tool, extent) / 6, thickness / 2

        def two(low, high, a, b, h):
            left, right = graded(low, (a + b) / 2, a, h, GROWTH), graded((a + b) / 2, high, b, h, GROWTH)
            return np.unique(np.round(np.concatenate([left, right]), 9))
        xs, ys = two(0, width, place - tool / 2, place + tool / 2, fine), height - graded(0, height, 0, fine, GROWTH)[::-1]
        zs = graded(0, half, extent / 2, min(fine, thickness / 16), GROWTH)
        X, A = bricks(xs, ys, zs, nu)
        e = 1e-6
        u, fixed = np.zeros(A.shape[0]), np.zeros(A.shape[0], bool)
        fixed[3 * np.where(X[:, 2] < e)[0] + 2] = True
        bottom = np.where(X[:, 1] < e)[0]
        held = np.where((X[:, 1] > height - e) & (np.abs(X[:, 0] - place) < tool / 2 + e) & (X[:, 2] < extent / 2 + e))[0]
        for k in range(3):
            fixed[3 * bottom + k] = fixed[3 * held + k] = True
        u[3 * held + 1] = -1
        u = solve(A, u, fixed, False)
        moved = u.reshape(-1, 3)
        face = X[:, 2] > half - e
        line = [face & (X[:, 1] < e), face & (X[:, 0] > width - e), face & (X[:, 1] > height - e), face & (X[:, 0] < e)]
        order = [np.where(side)[0][np.argsort(X[side, k] * way)] for side, k, way in zip(line, (0, 1, 0, 1), (1, 1, -1, -1))]
        ring = np.concatenate([side[:-1] for side in order])
        self.ring, self.moved, self.height = X[ring, :2], moved[ring, :2], height

    def press(self, tool, tips):
        """As Sheet.press, for a tool that moves straight down. The force is divided by E only [mm^2]."""
        depths = np.maximum(0, self.height - np.asarray(tips, float)[:, 1])
        return [(self.stiffness * depth, self.ring + depth * self.moved) for depth in depths]
