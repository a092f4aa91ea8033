"""Computes the force on a rigid tool that is pressed into a body of revolution, or into a prism in plane strain, with a
clamped bottom. Taylor-Hood triangles (quadratic displacement, linear pressure) over half of the section are right up to a
Poisson ratio of 0.5. The tool is flat or round, on the axis, and touches where the surface reaches it.

Small strain, or the neo-Hookean law of Smith, de Goes and Kim 2018 with constants that agree with E and nu at rest:

  Psi = m/2 (I_C - 3) - m/2 ln((I_C + 1)/4) - 3/4 m (J - 1) + k/2 (J - 1)^2,   m = 4/3 mu,   k = lambda + 5/6 mu

At small strain the gap and the normal of the tool are those at rest. A node that touches slides (friction 0), sticks to the
tool until it is pulled (infinite friction), or follows Coulomb's law. E = 1; z points out of the body; lengths in any unit.
"""
import math
from typing import NamedTuple

import gmsh
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

GLUED = math.inf


class Profile(NamedTuple):
    """Half of the section: a flat bottom of `radius`, `height` on the axis, and a top that is flat (cap 0) or an arc of
    radius `cap`. A half sphere has radius = height = cap. `plane`: a prism of thickness 1 in place of a body of revolution."""
    radius: float
    height: float
    cap: float = 0
    plane: bool = False

    def fall(self, r):
        """Returns by how much the top lies below its middle."""
        return self.cap - np.sqrt(np.maximum(self.cap ** 2 - r ** 2, 0)) if self.cap else 0 * r


class Tool(NamedTuple):
    """A flat tool (radius of its face `half_width`) or a round one (`radius` of its sphere)."""
    half_width: float = 0
    radius: float = 0

    def gap(self, r, z, tip):
        """Returns the distance of points from the tool whose tip is at the height `tip`, their normals into the tool (n, 2),
        the curvature of the distance, and whether they lie under it."""
        if not self.radius:
            return tip - z, np.tile([0.0, 1.0], (len(r), 1)), np.zeros(len(r)), r <= self.half_width * (1 + 1e-9)
        away = np.stack([-r, tip + self.radius - z], 1)
        distance = np.hypot(*away.T)
        return distance - self.radius, away / distance[:, None], 1 / distance, r < self.radius


def contact_radius(profile, tool, depth):
    """Estimates the radius of the contact (Hertz)."""
    curvature = (1 / tool.radius if tool.radius else 0) + (1 / profile.cap if profile.cap else 0)
    hertz = math.sqrt(depth / curvature) if curvature else math.inf
    return min(hertz, tool.half_width or hertz, 0.9 * profile.radius)


def mesh(profile, tool, depth, fineness):
    """Returns nodes (n, 2), triangles with six nodes in Gmsh's order, and how many of their nodes are corners. `fineness`: elements
    across the radius of the contact."""
    c, top = contact_radius(profile, tool, depth), profile.height
    reach, face = min(1.5 * c, tool.half_width or math.inf), tool.half_width
    largest = min(profile.radius, profile.height) / 10
    def size(r, z):
        below = math.hypot(max(0, r - reach), top - float(profile.fall(np.float64(min(r, profile.radius)))) - z)
        h = min(c / fineness + 0.25 * below, max(largest, 0.12 * math.hypot(r, top - z)))
        if face and face < profile.radius:  # where the stress is singular
            rim = math.hypot(r - face, z - top + float(profile.fall(np.float64(face))))
            h = min(h, c / fineness / 20 + 0.25 * rim)
        return min(h, c / fineness + 0.25 * math.hypot(r - profile.radius, z))
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("profile")
    occ, side = gmsh.model.occ, top - float(profile.fall(np.float64(profile.radius)))
    heights = [(0, 0), (profile.radius, 0)] + ([(profile.radius, side)] if side > 1e-9 * top else [])
    tops = [r for r in (face,) if 0 < r < profile.radius] + [0]
    heights += [(r, top - float(profile.fall(np.float64(r)))) for r in tops]
    if len(heights) == 3 + len(tops) - 1 and profile.cap:
        side = 0
    points = [occ.addPoint(r, z, 0) for r, z in heights]
    first = len(points) - len(tops) - 1  # where the top begins
    centre = occ.addPoint(0, top - profile.cap, 0) if profile.cap else None
    lines = []
    for i in range(len(points)):
        ends = points[i], points[(i + 1) % len(points)]
        is_arc = profile.cap and first <= i < len(points) - 1
        lines.append(occ.addCircleArc(ends[0], centre, ends[1]) if is_arc else occ.addLine(*ends))
    occ.addPlaneSurface([occ.addCurveLoop(lines)])
    occ.synchronize()
    for name in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
        gmsh.option.setNumber("Mesh." + name, 0)
    gmsh.model.mesh.setSizeCallback(lambda dim, tag, x, y, z: size(x, y))
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.setOrder(2)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    _, _, nodes = gmsh.model.mesh.getElements(2)
    gmsh.finalize()
    number = np.zeros(int(max(tags)) + 1, int)
    number[tags.astype(int)] = np.arange(len(tags))
    triangles = number[nodes[0].astype(int)].reshape(-1, 6)
    corners = np.unique(triangles[:, :3])
    order = np.concatenate([corners, np.setdiff1d(np.unique(triangles), corners)])  # corners first
    place = np.full(len(tags), -1)
    place[order] = np.arange(len(order))
    return coordinates.reshape(-1, 3)[order, :2], place[triangles], len(corners)


# Quadrature of degree 4 over a triangle (Dunavant 1985).
_A, _B = 0.445948490915965, 0.091576213509771
QUADRATURE = [(w / 2, p) for w, q in ((0.223381589678011, _A), (0.109951743655322, _B)) for p in ((q, q), (1 - 2 * q, q), (q, 1 - 2 * q))]


def shapes(x, y):
    """Returns the quadratic functions (6,), their derivatives (6, 2), and the linear ones (3,)."""
    L = np.array([1 - x - y, x, y])
    G = np.array([[-1, -1], [1, 0], [0, 1.0]])
    pairs = ((0, 1), (1, 2), (2, 0))
    N = np.concatenate([L * (2 * L - 1), [4 * L[i] * L[j] for i, j in pairs]])
    slopes = np.concatenate([G * (4 * L - 1)[:, None], [4 * (G[i] * L[j] + G[j] * L[i]) for i, j in pairs]])
    return N, slopes, L


class Body:
    """The mesh of a profile and its law. Unknowns: displacements (r, z) of the nodes, then the pressures of the corners."""

    def __init__(self, profile, tool, depth, nu, finite, fineness):
        self.profile, self.finite = profile, finite
        self.X, self.triangles, corners = mesh(profile, tool, depth, fineness)
        self.mu, scale = 0.5 / (1 + nu), (1 + nu) * (1 - 2 * nu)
        self.give = scale / (nu + 5 / 12 * (1 - 2 * nu)) if finite else scale / nu  # 1 / k
        n = len(self.X)
        dof = (2 * self.triangles[:, :, None] + np.arange(2)).reshape(len(self.triangles), 12)
        self.dof, self.size = np.concatenate([dof, 2 * n + self.triangles[:, :3]], 1), 2 * n + corners
        at = self.X[self.triangles]
        self.points = []
        for weight, (x, y) in QUADRATURE:
            N, slopes, L = shapes(x, y)
            J = np.einsum("eni,nk->eik", at, slopes)
            G = np.einsum("nk,eki->eni", slopes, np.linalg.inv(J))
            r = at[:, :, 0] @ N
            B = np.zeros((len(at), 5, 12))  # rr, rz, zr, zz, round
            B[:, 0, 0::2] = B[:, 2, 1::2] = G[:, :, 0]
            B[:, 1, 0::2] = B[:, 3, 1::2] = G[:, :, 1]
            if not profile.plane:
                B[:, 4, 0::2] = N / r[:, None]
            self.points.append((B, L, weight * np.linalg.det(J) * (2 if profile.plane else 2 * np.pi * r)))
        self.fixed = np.zeros(self.size, bool)
        self.fixed[2 * np.flatnonzero(self.X[:, 0] < 1e-9 * profile.radius)] = True
        bottom = np.flatnonzero(self.X[:, 1] < 1e-9 * profile.height)
        self.fixed[2 * bottom] = self.fixed[2 * bottom + 1] = True
        surface = profile.height - profile.fall(self.X[:, 0])
        on_top = (np.abs(self.X[:, 1] - surface) < 1e-6 * profile.height) & (self.X[:, 1] > 1e-9 * profile.height)
        # The node on the axis has no area.
        self.top = np.flatnonzero(on_top & (self.X[:, 0] > (-1 if profile.plane else 1e-9 * profile.radius)))
        self.top = self.top[np.argsort(self.X[self.top, 0])]

    def forces(self, u):
        """Returns the forces on the unknowns and their derivative; None where an element is inverted."""
        f, K = np.zeros(len(u)), np.zeros((len(self.dof), 15, 15))
        moved, pressures = u[self.dof[:, :12]], u[self.dof[:, 12:]]
        for B, L, w in self.points:
            H, p = np.einsum("ekd,ed->ek", B, moved), pressures @ L
            if self.finite:
                g, stress, cof, tangent = self.neo_hookean(H, p)
                if g is None:
                    return None, None
            else:
                g, cof = H[:, 0] + H[:, 3] + H[:, 4], np.tile([1.0, 0, 0, 1, 1], (len(H), 1))
                tangent = np.tile(self.mu * np.array([[2.0, 0, 0, 0, 0], [0, 1, 1, 0, 0], [0, 1, 1, 0, 0], [0, 0, 0, 2, 0], [0, 0, 0, 0, 2]]), (len(H), 1, 1))
                stress = np.einsum("ekl,el->ek", tangent, H) + p[:, None] * cof
            f += np.bincount(self.dof[:, :12].ravel(), np.einsum("ekd,ek,e->ed", B, stress, w, optimize=True).ravel(), len(u))
            f += np.bincount(self.dof[:, 12:].ravel(), np.outer(w * (g - self.give * p), L).ravel(), len(u))
            K[:, :12, :12] += np.matmul(B.transpose(0, 2, 1), np.matmul(tangent * w[:, None, None], B))
            side = np.einsum("ekd,ek,e,p->edp", B, cof, w, L, optimize=True)
            K[:, :12, 12:] += side
            K[:, 12:, :12] += side.transpose(0, 2, 1)
            K[:, 12:, 12:] -= self.give * w[:, None, None] * np.outer(L, L)
        row, column = np.repeat(self.dof, 15, 1).ravel(), np.tile(self.dof, (1, 15)).ravel()
        return f, sp.csc_matrix((K.ravel(), (row, column)), shape=(len(u),) * 2)

    def neo_hookean(self, H, p):
        """Returns J - 1, the stress, cof F and the tangent without the pressure's own part, over rr, rz, zr, zz, round."""
        a, b, c, d, e = (H + np.array([1, 0, 0, 1, 1])).T
        area = a * d - b * c
        if (area <= 0).any() or (e <= 0).any():
            return None, None, None, None
        F, cof = np.stack([a, b, c, d, e], 1), np.stack([d * e, -c * e, -b * e, a * e, area], 1)
        m, first = 4 / 3 * self.mu, (F * F).sum(1)
        factor, outer = p - 0.75 * m, 2 * m / (first + 1) ** 2
        stress = (m * (1 - 1 / (first + 1)))[:, None] * F + factor[:, None] * cof
        T = outer[:, None, None] * F[:, :, None] * F[:, None, :]
        T[:, range(5), range(5)] += (m * (1 - 1 / (first + 1)))[:, None]
        for i, j, change in ((0, 3, e), (1, 2, -e), (0, 4, d), (3, 4, a), (1, 4, -c), (2, 4, -b)):
            T[:, i, j] += factor * change
            T[:, j, i] += factor * change
        return area * e - 1, stress, cof, T


class Condensed:
    """A body at small strain, reduced to the displacements of the nodes that a tool may reach."""

    def __init__(self, body, reach):
        self.profile, self.finite, self.top = body.profile, False, np.flatnonzero(body.X[body.top, 0] <= reach)
        kept = body.top[self.top]
        self.X, self.top = body.X[kept], np.arange(len(kept))
        _, K = body.forces(np.zeros(body.size))
        free = np.flatnonzero(~body.fixed)
        dof = (2 * kept[:, None] + np.arange(2)).ravel()
        self.fixed = body.fixed[dof]
        place = np.full(body.size, -1)
        place[free] = np.arange(len(free))
        open_ = np.flatnonzero(~self.fixed)
        loads = np.zeros((len(free), len(open_)))
        loads[place[dof[open_]], range(len(open_))] = 1
        compliance = splu(K[free][:, free]).solve(loads)[place[dof[open_]]]
        self.K = np.zeros((len(dof),) * 2)
        self.K[np.ix_(open_, open_)] = np.linalg.inv((compliance + compliance.T) / 2)
        self.size = len(dof)

    def forces(self, u):
        return self.K @ u, self.K


def held_solve(K, rows, columns, fixed, wanted, residual):
    """Returns the change x of the unknowns, columns x, where those in `fixed` take the value `wanted` and the others fulfil
    rows (K columns x + residual) = 0."""
    free = np.flatnonzero(~fixed)
    if isinstance(K, np.ndarray):
        A = (rows @ K @ columns) if rows is not None else K
        x = wanted.copy()
        b = residual + A @ x
        x[free] = np.linalg.solve(A[np.ix_(free, free)], -b[free])
        return x
    A = (rows @ K @ columns).tocsr()
    x = wanted.copy()
    b = residual + A @ x
    x[free] = splu(A[free][:, free].tocsc()).solve(-b[free])
    return x


def press(body, tool, depth, friction=0.0, steps=1):
    """Returns the force of the tool, its contact radius, and the forces at all steps. Newton's method with an active set; the nodes
    of the top are free, slip or stick."""
    n, top = len(body.top), body.top
    X, scale = body.X[top], depth
    u = np.zeros(body.size)
    z = 2 * top + 1
    rest = tool.gap(*X.T, body.profile.height)
    touching = rest[3] & (rest[0] < 1e-9 * scale)
    stuck = touching & (friction > 0)
    anchor = X.copy()  # where a node sticks, relative to the tip
    anchor[:, 1] -= body.profile.height
    sign, curve = np.zeros(n), []
    f, K = body.forces(u)
    for step in range(1, steps + 1):
        tip = body.profile.height - depth * step / steps
        began, was = X + u.reshape(-1)[np.stack([2 * top, z], 1)], touching.copy()
        gap_before = tool.gap(*(began if body.finite else X).T, tip + depth / steps)[0]
        if not body.finite:
            gap_before = tip + depth / steps + rest[0] - body.profile.height + (X[:, 1] - began[:, 1]) * 0
        seen = set()
        for iteration in range(80):
            moved = u[np.stack([2 * top, z], 1)]
            if body.finite:
                gap, normal, bend, under = tool.gap(*(X + moved).T, tip)
            else:
                gap, normal, bend, under = rest[0] + tip - body.profile.height - moved[:, 1], np.tile([0.0, 1.0], (n, 1)), np.zeros(n), rest[3]
            on = f[np.stack([2 * top, z], 1)]  # internal forces: those of the tool on the nodes
            pull = (on * normal).sum(1)  # positive: pulled
            tangent = np.stack([normal[:, 1], -normal[:, 0]], 1)
            along = (on * tangent).sum(1)
            if iteration:
                new = np.where(touching, (pull < 0) & (under | ~np.bool_(body.finite)), under & (gap < -1e-9 * scale))
                if iteration > 25:  # one node at a time ends a cycle
                    measure = np.where(touching, pull / np.abs(pull).max(), -gap / scale) * (new != touching)
                    keep = np.argmax(measure)
                    new = np.where(np.arange(n) == keep, new, touching)
                state = stuck & new
                if friction and friction != GLUED:
                    over = stuck & (np.abs(along) > friction * np.abs(pull) * (1 + 1e-9))
                    sign = np.where(over, np.sign(along), sign)
                    slide = ((X + moved - anchor - [0, tip]) * tangent).sum(1) * sign  # against the friction
                    back = touching & ~stuck & was & (slide > 0)
                    state = (stuck & new & ~over) | (back & new)
                changed = (new != touching) | (state != stuck)
                # A node that touches anew slides in this step and sticks in the next.
                if not changed.any() and part == 1 and np.abs(x[: 2 * len(body.X)]).max() < 1e-8 * scale:
                    break
                touching, stuck = new, state
            wanted, fixed = np.zeros(body.size), body.fixed.copy()
            rows, columns = None, None
            first = np.flatnonzero(touching)
            fixed[z[first]] = True
            wanted[z[first]] = gap[first]
            glued = np.flatnonzero(stuck)
            fixed[2 * top[glued]] = True
            back = ((anchor + [0, tip] - X - moved) * tangent).sum(1)
            wanted[2 * top[glued]] = back[glued]
            slips = np.flatnonzero(touching & ~stuck) if friction and friction != GLUED else np.array([], int)
            turned = body.finite and tool.radius
            T, R = sp.identity(body.size, format="lil"), sp.identity(body.size, format="lil")
            if turned:
                for i in first:  # columns: along the tool, into the tool
                    a, b = 2 * top[i], z[i]
                    T[a, a], T[b, a], T[a, b], T[b, b] = *tangent[i], *normal[i]
            R = T.T.tolil()
            stiff = K
            if turned:
                curvature = np.where(touching, -pull * bend, 0)  # of the constraint, times its force
                blocks = curvature[:, None, None] * tangent[:, :, None] * tangent[:, None, :]
                index = np.stack([2 * top, z], 1)
                stiff = K + sp.csc_matrix((-blocks.ravel(), (np.repeat(index, 2, 1).ravel(), np.tile(index, (1, 2)).ravel())), shape=K.shape)
            T, R = T.tocsr(), R.tocsr()
            if len(slips):
                slide = sp.identity(body.size, format="lil")
                for i in slips:
                    slide[2 * top[i], z[i]] = friction * sign[i]  # along - sign friction |pull|, pull < 0
                R = slide.tocsr() @ R
            if isinstance(stiff, np.ndarray):
                x = held_solve(stiff if not len(slips) else R @ stiff, None, None, fixed, wanted, R @ f)
            else:
                x = held_solve(stiff, R, T, fixed, wanted, R @ f)
            x = T @ x
            part = 1.0
            while True:
                f_new, K_new = body.forces(u + part * x)
                if f_new is not None:
                    break
                part /= 2
            u, f, K = u + part * x, f_new, K_new
        else:
            raise RuntimeError("the contact did not settle")
        moved = u[np.stack([2 * top, z], 1)]
        if friction:
            # Where a gap closed within the step, its node sticks where it was at that moment.
            fresh = touching & ~was
            share = np.clip(np.where(fresh, gap_fraction(rest, began, X, body, tool, tip, depth / steps), 1), 0, 1)[:, None]
            place = began + share * (X + moved - began)
            anchor = np.where(fresh[:, None], place - [0, tip], anchor)
            slid = touching & was & ~stuck
            anchor = np.where(slid[:, None], X + moved - [0, tip], anchor)
            stuck = touching.copy() if friction == GLUED else (stuck | fresh) & touching | slid
        curve.append(-f[z].sum())
    reached = np.flatnonzero(touching)
    return curve[-1], (X[reached, 0].max() if len(reached) else 0.0), curve


def gap_fraction(rest, began, X, body, tool, tip, way):
    """Returns the share of a step after which the gap of a node closes, if the node moves steadily and ends on the tool."""
    if body.finite:
        gap = tool.gap(*began.T, tip + way)[0]
    else:
        gap = rest[0] + tip + way - body.profile.height - (began - X)[:, 1]
    return np.maximum(gap, 0) / way


def force(profile, tool, depth, nu, friction=0.0, finite=False, fineness=None, steps=None):
    """Returns the force of a tool relative to E."""
    fineness = fineness or 24
    body = Body(profile, tool, depth, nu, finite, fineness)
    if not finite:
        c = contact_radius(profile, tool, depth)
        body = Condensed(body, tool.half_width * (1 + 1e-9) if tool.half_width else min(1.6 * c, 0.999 * tool.radius))
    is_flat = tool.half_width and not profile.cap
    steps = steps or (1 if not finite and (friction == 0 or (is_flat and friction == GLUED)) else 40 if friction else 10)
    answer, reached, _ = press(body, tool, depth, friction, steps)
    return answer
