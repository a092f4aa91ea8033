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
FILLET = 0.025  # at large strain, relative to the radius of a flat tool: a sharp rim has no solution without folds


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
    """A flat tool (radius of its face `half_width`, rounded at its rim with the radius `fillet`) or a round one (`radius` of its
    sphere)."""
    half_width: float = 0
    radius: float = 0
    fillet: float = 0

    def gap(self, r, z, tip):
        """Returns the distance of points from the tool whose tip is at the height `tip`, their normals into the tool (n, 2),
        the curvature of the distance, and whether they lie under it."""
        bend = self.radius or self.fillet
        if not bend:
            return tip - z, np.tile([0.0, 1.0], (len(r), 1)), np.zeros(len(r)), r <= self.half_width * (1 + 1e-9)
        flat = self.half_width - self.fillet if self.fillet else 0.0
        away = np.stack([np.minimum(flat - r, 0), tip + bend - z], 1)
        distance = np.hypot(*away.T)
        gap, normal = distance - bend, away / distance[:, None]
        curvature = np.where(away[:, 0] < 0, 1 / distance, 0) if self.fillet else 1 / distance
        inside = (away[:, 1] < 0.5 * bend) & (r < flat + 0.99 * bend)  # along z, where the distance has no use
        across = np.minimum(away[:, 0], 0) / bend
        upright = np.sqrt(np.maximum(1 - across ** 2, 1e-4))
        gap = np.where(inside, (tip + bend * (1 - upright) - z) * upright, gap)
        normal = np.where(inside[:, None], np.stack([across, upright], 1), normal)
        curvature = np.where(inside & (away[:, 0] < 0), 1 / bend, np.where(inside & bool(self.fillet), 0, curvature))
        return gap, normal, curvature, r < (self.radius or self.half_width)


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
            h = min(h, (tool.fillet / 4 if tool.fillet else c / fineness / 20) + 0.25 * rim)
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


class Unsettled(Exception):
    """Newton's method or the active set did not settle."""


class Contact:
    """A tool on the top of a body: which of its nodes touch, and which of those stick. Arrays have one row per node of the top."""

    def __init__(self, body, tool, friction):
        self.body, self.tool, self.friction = body, tool, friction
        self.X, self.index = body.X[body.top], np.stack([2 * body.top, 2 * body.top + 1], 1)
        self.depth, self.u = 0.0, np.zeros(body.size)
        self.f, self.K = body.forces(self.u)
        self.rest, _, _, self.under = tool.gap(*self.X.T, body.profile.height)
        self.touching = self.under & (self.rest < 1e-9 * body.profile.height)
        self.stuck = self.touching & (friction > 0)
        self.anchor = self.X - [0, body.profile.height]  # where a node sticks, from the tip
        self.sign = np.zeros(len(self.X))  # of the sliding friction

    def places(self):
        return self.X + self.u[self.index]

    def gaps(self, places, depth):
        """Returns distance, normal, curvature, and whether a node lies under the tool: at small strain those at rest."""
        tip = self.body.profile.height - depth
        if self.body.finite:
            return self.tool.gap(*places.T, tip)
        up = np.tile([0.0, 1.0], (len(places), 1))
        return self.rest - depth - (places - self.X)[:, 1], up, np.zeros(len(places)), self.under

    def force(self):
        return -self.f[self.index[:, 1]].sum()

    def advance(self, depth):
        """Moves the tool to `depth`. Throws Unsettled and keeps the state."""
        kept = self.u, self.f, self.K, self.touching, self.stuck, self.sign
        began, was, way = self.places(), self.touching, depth - self.depth
        tip = np.array([0, self.body.profile.height - depth])
        try:
            self.settle(depth, way, was, tip)
        except (Unsettled, np.linalg.LinAlgError, RuntimeError):
            self.u, self.f, self.K, self.touching, self.stuck, self.sign = kept
            raise Unsettled
        if self.friction:
            # Where a gap closed within the step, its node sticks where it was at that moment.
            fresh, moved = self.touching & ~was, self.places()
            share = np.clip(self.gaps(began, self.depth)[0] / way, 0, 1)[:, None]
            self.anchor = np.where(fresh[:, None], began + share * (moved - began) - tip, self.anchor)
            slid = self.touching & was & ~self.stuck
            self.anchor = np.where(slid[:, None], moved - tip, self.anchor)
            self.stuck = self.touching.copy()
        self.depth = depth

    def settle(self, depth, way, was, tip):
        part, scale = 1.0, depth
        for iteration in range(40):
            places = self.places()
            gap, normal, bend, under = self.gaps(places, depth)
            tangent = np.stack([normal[:, 1], -normal[:, 0]], 1)
            on = self.f[self.index]  # of the tool on the nodes
            pull, along = (on * normal).sum(1), (on * tangent).sum(1)
            lag = ((self.anchor + tip - places) * tangent).sum(1)
            if iteration and part == 1:
                touching = np.where(self.touching, pull < 0, under & (gap < -1e-9 * scale))
                if iteration > 20:  # one node at a time ends a cycle
                    worst = np.argmax(np.where(self.touching, pull / np.abs(pull).max(), -gap / scale) * (touching != self.touching))
                    touching = np.where(np.arange(len(gap)) == worst, touching, self.touching)
                stuck = self.stuck & touching
                if self.friction and self.friction != GLUED:
                    over = self.stuck & (np.abs(along) > self.friction * np.abs(pull) * (1 + 1e-9))
                    self.sign = np.where(over, np.sign(along), self.sign)
                    back = touching & was & ~self.stuck & (lag * self.sign < 0)  # slides with the friction
                    stuck = (stuck & ~over) | back
                is_settled = (touching == self.touching).all() and (stuck == self.stuck).all()
                if is_settled and np.abs(x).max() < 1e-8 * scale:
                    return
                self.touching, self.stuck = touching, stuck
            x = self.step(gap, normal, tangent, bend, pull, lag)
            part = 1.0
            while (new := self.body.forces(self.u + part * x))[0] is None:
                part /= 2
                if part < 1e-3:
                    raise Unsettled
            self.u = self.u + part * x
            self.f, self.K = new
            x = x[: 2 * len(self.body.X)]
        raise Unsettled

    def step(self, gap, normal, tangent, bend, pull, lag):
        """Returns the change of the unknowns by one step of Newton's method. Nodes that touch have their unknowns along and across
        the tool."""
        n, (r, z) = self.body.size, self.index.T
        wanted, fixed = np.zeros(n), self.body.fixed.copy()
        wanted[z[self.touching]], wanted[r[self.stuck]] = gap[self.touching], lag[self.stuck]
        fixed[z[self.touching]] = fixed[r[self.stuck]] = True
        slips = self.touching & ~self.stuck
        K, f, on = self.K, self.f, np.flatnonzero(self.touching)
        is_turned, has_slip = self.body.finite and (self.tool.radius or self.tool.fillet), 0 < self.friction < GLUED and slips.any()
        T = sp.identity(n, format="csr")
        if is_turned:
            T = sp.identity(n, format="lil")
            for i in on:
                T[r[i], r[i]], T[z[i], r[i]], T[r[i], z[i]], T[z[i], z[i]] = *tangent[i], *normal[i]
            # The curvature of the tool, times its force.
            blocks = np.where(self.touching, pull * bend, 0)[:, None, None] * tangent[:, :, None] * tangent[:, None, :]
            rows, columns = np.repeat(self.index, 2, 1).ravel(), np.tile(self.index, (1, 2)).ravel()
            T, K = T.tocsr(), K + sp.csc_matrix((blocks.ravel(), (rows, columns)), shape=K.shape)
        R = T.T.tocsr()
        if has_slip:  # along the tool: friction times the normal force
            k = np.flatnonzero(slips)
            R = (sp.identity(n) + sp.csr_matrix((self.friction * self.sign[k], (r[k], z[k])), shape=(n, n))) @ R
        if isinstance(K, np.ndarray):
            A, load = (R @ K if has_slip else K), R @ f
        else:
            A, load = (R @ K @ T).tocsr(), R @ f
        free, x = np.flatnonzero(~fixed), wanted
        b = (load + A @ x)[free]
        x[free] = -(np.linalg.solve(A[np.ix_(free, free)], b) if isinstance(A, np.ndarray) else splu(A[free][:, free].tocsc()).solve(b))
        return T @ x


def press(body, tool, depth, friction, steps):
    """Returns the forces at the depths of `steps` steps, which are divided where needed."""
    contact, forces = Contact(body, tool, friction), []
    for k in range(1, steps + 1):
        parts, end = 1, depth * k / steps
        while contact.depth < end * (1 - 1e-12):
            try:
                contact.advance(min(end, contact.depth + depth / steps / parts))
            except Unsettled:
                parts *= 2
                if parts > 32:
                    raise RuntimeError(f"the contact did not settle beyond the depth {contact.depth:g}") from None
        forces.append(contact.force())
    return forces


def force(profile, tool, depth, nu, friction=0.0, finite=False, fineness=24, steps=None):
    """Returns the force of a tool relative to E."""
    if finite and tool.half_width and not tool.fillet:
        # The error is proportional to the fillet.
        coarse, fine = (force(profile, tool._replace(fillet=share * tool.half_width), depth, nu, friction, True, fineness, steps)
                        for share in (2 * FILLET, FILLET))
        return 2 * fine - coarse
    body = Body(profile, tool, depth, nu, finite, fineness)
    if not finite:
        c = contact_radius(profile, tool, depth)
        body = Condensed(body, tool.half_width * (1 + 1e-9) if tool.half_width else min(1.6 * c, 0.999 * tool.radius))
    is_single = not finite and (friction == 0 or (friction == GLUED and tool.half_width and not profile.cap))
    return press(body, tool, depth, friction, steps or (1 if is_single else 40 if friction and not finite else 16))[-1]
