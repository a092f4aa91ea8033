"""Computes the force on a rigid tool that is pressed into an elastic box with a clamped bottom.

The compliance of the top face is that of the half-space (Boussinesq, Cerruti; Johnson, Contact Mechanics, 3.2 and 3.6),
integrated over square cells in closed form, plus the effect of the box's sides and bottom. That effect is smooth:
quadratic bricks with reduced integration carry minus the half-space's tractions on the sides and minus its
displacements on the bottom. An active-set method finds the cells in contact. Small strain. E = 1; z points into the
body, and so does a positive force.
"""
import math

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

CELLS = 11     # across the radius of a contact
FITTED = 4     # degree of the polynomials for the smooth part
BRICK = 0.2    # largest edge, relative to the smaller side


def half_space(x, y, z, nu):
    """Returns displacements at (x, y, z >= 0) by unit forces along x, y, z at the origin: (..., component, force)."""
    r = np.sqrt(x * x + y * y + z * z)
    s, k = r + z, 1 - 2 * nu
    u = np.empty(r.shape + (3, 3))
    for a, b, i, j in ((x, y, 0, 1), (y, x, 1, 0)):
        u[..., i, i] = 1 / r + a * a / r ** 3 + k * (1 / s - a * a / (r * s * s))
        u[..., j, i] = a * b / r ** 3 - k * a * b / (r * s * s)
        u[..., 2, i] = a * z / r ** 3 + k * a / (r * s)
        u[..., i, 2] = a * z / r ** 3 - k * a / (r * s)
    u[..., 2, 2] = z * z / r ** 3 + 2 * (1 - nu) / r
    return u * (1 + nu) / (2 * math.pi)


def half_space_stress(p, nu, step):
    """Returns stresses (..., i, j, force) of half_space at p (..., 3), by central differences."""
    def at(q):
        return half_space(*np.moveaxis(q, -1, 0), nu)
    slopes = [(at(p + step * e) - at(p - step * e)) / (2 * step) for e in np.eye(3)]
    gradient = np.stack(slopes, -2)  # (..., component, derivative, force)
    lam, mu = nu / ((1 + nu) * (1 - 2 * nu)), 0.5 / (1 + nu)
    trace = np.einsum("...iif->...f", gradient)
    return mu * (gradient + np.swapaxes(gradient, -2, -3)) + lam * np.eye(3)[:, :, None] * trace[..., None, None, :]


def cells(i, j, h, nu):
    """Returns surface displacements at the centre of a cell by uniform loads of unit force on a cell that is i, j cells
    away."""
    def over(f):
        x, y = (np.stack([n - 0.5, n + 0.5]) for n in (i, j))
        return f(x[1], y[1]) - f(x[0], y[1]) - f(x[1], y[0]) + f(x[0], y[0])
    along = over(lambda x, y: y * np.arcsinh(x / np.abs(y)))  # x x / r^3
    across = over(lambda x, y: x * np.arcsinh(y / np.abs(x)))
    mixed = over(lambda x, y: -np.hypot(x, y))
    slope_x = over(lambda x, y: y * np.log(np.hypot(x, y)) + x * np.arctan(y / x))
    slope_y = over(lambda x, y: x * np.log(np.hypot(x, y)) + y * np.arctan(x / y))
    one, k = along + across, (1 - 2 * nu) / 2
    u = np.empty(i.shape + (3, 3))
    u[..., 0, 0], u[..., 1, 1] = (1 - nu) * one + nu * along, (1 - nu) * one + nu * across
    u[..., 0, 1] = u[..., 1, 0] = nu * mixed
    u[..., 2, 0], u[..., 2, 1] = k * slope_x, k * slope_y
    u[..., 0, 2], u[..., 1, 2] = -k * slope_x, -k * slope_y
    u[..., 2, 2] = (1 - nu) * one
    return u * (1 + nu) / (math.pi * h)


CORNERS = np.array([[a, b, c] for c in (-1, 1) for b in (-1, 1) for a in (-1, 1)], float)
MIDDLES = np.array([[a, b, c] for a in (-1, 0, 1) for b in (-1, 0, 1) for c in (-1, 0, 1) if [a, b, c].count(0) == 1], float)
NODES = np.concatenate([CORNERS, MIDDLES])  # of a brick


def shapes(p):
    """Returns values (points, 20) and derivatives (points, 20, 3) of the serendipity functions at p."""
    values, slopes = [], []
    for node in NODES:
        factors = [1 - p[:, k] ** 2 if node[k] == 0 else 1 + p[:, k] * node[k] for k in range(3)]
        changes = [-2 * p[:, k] if node[k] == 0 else np.full(len(p), node[k]) for k in range(3)]
        product = lambda change: np.prod([changes[k] if k == change else factors[k] for k in range(3)], 0)  # noqa: E731
        if 0 in node:
            values.append(product(None) / 4)
            slopes.append(np.stack([product(k) / 4 for k in range(3)], -1))
            continue
        tail = p @ node - 2
        values.append(product(None) * tail / 8)
        slopes.append(np.stack([(product(k) * tail + product(None) * node[k]) / 8 for k in range(3)], -1))
    return np.stack(values, 1), np.stack(slopes, 1)


class Box:
    """A box of `size` that is clamped at the bottom, with its factorised stiffness. z points down from its top."""

    def __init__(self, size, nu):
        self.size, self.nu = np.array(size), nu
        n = [max(1, math.ceil(side / (BRICK * min(size)))) for side in size]
        self.h = self.size / n
        fine = [2 * k + 1 for k in n]
        number = np.full(fine, -1)
        grid = np.stack(np.meshgrid(*map(np.arange, n), indexing="ij"), -1).reshape(-1, 3)
        places = 2 * grid[:, None, :] + (NODES + 1).astype(int)[None]
        used = np.zeros(fine, bool)
        used[tuple(np.moveaxis(places, -1, 0))] = True
        number[used] = np.arange(used.sum())
        self.X = np.argwhere(used) * self.h / 2
        self.elements, self.grid, self.n = number[tuple(np.moveaxis(places, -1, 0))], grid, n
        lam, mu = nu / ((1 + nu) * (1 - 2 * nu)), 0.5 / (1 + nu)
        K = np.zeros((60, 60))
        g = CORNERS / math.sqrt(3)
        for G in shapes(g)[1] * (2 / self.h):
            strain = np.zeros((3, 3, 20, 3))
            for k in range(3):
                strain[k, :, :, k] += G.T / 2
                strain[:, k, :, k] += G.T / 2
            B = strain.reshape(9, 60)
            trace = B[0] + B[4] + B[8]
            K += (2 * mu * B.T @ B + lam * np.outer(trace, trace)) * self.h.prod() / 8
        dof = (3 * self.elements[:, :, None] + np.arange(3)).reshape(len(grid), 60)
        row, column = np.repeat(dof, 60, 1).ravel(), np.tile(dof, (1, 60)).ravel()
        A = sp.csr_matrix((np.tile(K.ravel(), len(grid)), (row, column)), shape=(3 * len(self.X),) * 2)
        held = np.repeat(self.X[:, 2] > self.size[2] - 1e-9 * self.size[2], 3)
        self.free, self.held = np.flatnonzero(~held), np.flatnonzero(held)
        self.coupling = A[self.free][:, self.held]
        self.factor = splu(A[self.free][:, self.free].tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def side_loads(self, sources):
        """Returns the consistent nodal forces of the negative half-space tractions on the four sides: (dof, 3
        sources)."""
        loads = np.zeros((len(self.X), 3, len(sources), 3))
        g, w = np.polynomial.legendre.leggauss(4)
        for axis, sign in ((0, -1), (0, 1), (1, -1), (1, 1)):
            on = self.grid[:, axis] == (0 if sign < 0 else self.n[axis] - 1)
            other = 1 - axis
            for a, wa in zip(g, w):
                for b, wb in zip(g, w):
                    local = np.zeros(3)
                    local[axis], local[other], local[2] = sign, a, b
                    N = shapes(local[None])[0][0]
                    p = (self.grid[on] + (local + 1) / 2) * self.h
                    weight = wa * wb * self.h[other] * self.h[2] / 4
                    for k, source in enumerate(sources):
                        away = p - np.array([*source, 0])
                        traction = sign * half_space_stress(away, self.nu, 1e-5 * self.size.min())[:, axis]  # (n, i, force)
                        part = -weight * N[None, :, None, None] * traction[:, None]
                        np.add.at(loads[:, :, k], self.elements[on], part)
        return loads.reshape(3 * len(self.X), -1)

    def change(self, sources):
        """Returns displacements at `sources` on the top by unit forces there, minus those of the half-space: (n, 3, n,
        3)."""
        loads = self.side_loads(sources)
        bottom = self.X[self.held[::3] // 3]
        at = np.stack([-half_space(*(bottom - np.array([*s, 0])).T, self.nu) for s in sources], 2)  # (node, i, source, force)
        moved = at.reshape(3 * len(bottom), -1)
        u = np.zeros((3 * len(self.X), loads.shape[1]))
        u[self.held] = moved
        u[self.free] = self.factor.solve(loads[self.free] - self.coupling @ moved)
        u = u.reshape(len(self.X), 3, -1)
        out = []
        for s in sources:
            cell = np.minimum((np.array(s) / self.h[:2]).astype(int), np.array(self.n[:2]) - 1)
            local = np.array([*(2 * (np.array(s) / self.h[:2] - cell) - 1), -1])
            e = np.flatnonzero((self.grid == [*cell, 0]).all(1))[0]
            out.append(np.einsum("n,nif->if", shapes(local[None])[0][0], u[self.elements[e]]))
        return np.array(out).reshape(len(sources), 3, len(sources), 3)


def monomials(p):
    return np.stack([p[:, 0] ** a * p[:, 1] ** b for a in range(FITTED + 1) for b in range(FITTED + 1 - a)], 1)


def compliance(size, place, reach, h, nu):
    """Returns the cells of width h within `reach` of `place`, and their compliance (n, 3, n, 3) on the box and on the
    half-space."""
    m = math.ceil(reach / h)
    ij = np.array([(i, j) for i in range(-m, m + 1) for j in range(-m, m + 1) if math.hypot(i, j) * h <= reach])
    table = cells(*np.meshgrid(np.arange(-2 * m, 2 * m + 1.0), np.arange(-2 * m, 2 * m + 1.0), indexing="ij"), h, nu)
    away = ij[:, None] - ij[None] + 2 * m
    on_half_space = table[away[..., 0], away[..., 1]].transpose(0, 2, 1, 3)
    rings = [(0, 1)] + [(q, k) for q, k in ((0.45, 6), (0.95, 10))]
    turns = [(q, 2 * math.pi * (i + 0.3) / k) for q, k in rings for i in range(k)]
    sources = np.array([(q * math.cos(t), q * math.sin(t)) for q, t in turns])
    changed = Box(size, nu).change([place + reach * s for s in sources])
    fit = monomials(ij * h / reach) @ np.linalg.pinv(monomials(sources))
    smooth = np.einsum("as,sitj,bt->aibj", fit, changed, fit, optimize=True)
    return ij * h, on_half_space + smooth, on_half_space


def contact(C, wanted, bonded, guess):
    """Returns the force along z on the cells, which move by `wanted` where they touch. Cells with a pulling force are
    released."""
    active = guess.copy()
    for _ in range(40):
        k = np.flatnonzero(active)
        if bonded:
            A = C[k][:, :, k].reshape(3 * len(k), -1)
            u = np.zeros((len(k), 3))
            u[:, 2] = wanted[k]
            f = np.linalg.solve(A, u.ravel()).reshape(-1, 3)
        else:
            f = np.zeros((len(k), 3))
            f[:, 2] = np.linalg.solve(C[k][:, 2, k, 2], wanted[k])
        new = np.zeros(len(C), bool)
        new[k] = f[:, 2] > 0
        out = np.flatnonzero(~active)
        u = np.einsum("akj,kj->a", C[out][:, 2, k], f)
        new[out] = u < wanted[out]
        if (new == active).all():
            return f[:, 2].sum(), active
        active = new
    raise RuntimeError("the contact did not settle")


def flat(size, place, width, depth, nu, bonded, across=CELLS):
    """Returns the force of a flat disc. The error of its approximation by cells is corrected by that on the half-space,
    whose force is known."""
    a = width / 2
    p, on_box, on_half_space = compliance(size, np.array(place), a, a / across, nu)
    n = len(p)
    def force(C):
        if not bonded:
            return np.linalg.solve(C[:, 2, :, 2], np.full(n, depth)).sum()
        return np.linalg.solve(C.reshape(3 * n, -1), np.tile([0, 0, depth], n))[2::3].sum()
    exact = 2 * a * depth / (1 - nu * nu)
    if bonded:  # Spence 1968
        exact = 2 * a * depth * math.log(3 - 4 * nu) / ((1 + nu) * (1 - 2 * nu))
    return exact * force(on_box) / force(on_half_space)


def round_end(size, place, radius, depth, nu, bonded, across=CELLS):
    """Returns the force of a sphere."""
    c = math.sqrt(radius * depth)
    reach = min(1.45 * c, radius)
    p, on_box, _ = compliance(size, np.array(place), reach, c / across, nu)
    r = np.hypot(*p.T)
    wanted = depth - (radius - np.sqrt(radius ** 2 - r ** 2))
    force, active = contact(on_box, wanted, bonded, r < 0.9 * c)
    assert r[active].max() < 0.97 * reach
    return force
