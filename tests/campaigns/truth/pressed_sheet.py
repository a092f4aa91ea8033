"""Computes the force on a rigid flat tool in the middle of a round sheet that is clamped at its rim. The sheet is an
axisymmetric neo-Hookean solid of quadratic ring elements with reduced integration. An active-set method finds the nodes
that touch the tool, on which they slide. E = 1."""
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

# Nodes of a ring element.
PLACES = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (0, -1), (1, 0), (0, 1), (-1, 0)], float)


def shapes(r, z):
    """Returns values (8,) and derivatives (8, 2) of the serendipity functions."""
    N, G = np.zeros(8), np.zeros((8, 2))
    for i, (a, b) in enumerate(PLACES):
        if a and b:
            N[i] = (1 + a * r) * (1 + b * z) * (a * r + b * z - 1) / 4
            G[i] = a * (1 + b * z) * (2 * a * r + b * z) / 4, b * (1 + a * r) * (2 * b * z + a * r) / 4
        elif b:
            N[i], G[i] = (1 - r * r) * (1 + b * z) / 2, (-r * (1 + b * z), b * (1 - r * r) / 2)
        else:
            N[i], G[i] = (1 - z * z) * (1 + a * r) / 2, (a * (1 - z * z) / 2, -z * (1 + a * r))
    return N, G


class Sheet:
    """Mesh of ring elements, fine at the tool's rim and at the clamp."""

    def __init__(self, radius, thickness, tool, nu, layers=3):
        smallest = thickness / layers / 2
        def away(span):
            h, points = smallest, [0.0]
            while points[-1] + 1.6 * h < span:
                points.append(points[-1] + h)
                h = min(1.35 * h, radius / 25)
            return np.array(points + [span]) if points[-1] < span else np.array(points)
        middle = (radius - tool) / 2
        rs = np.unique(np.concatenate([tool - away(tool), tool + away(middle), radius - away(radius - tool - middle)]).round(12))
        n, m = len(rs) - 1, layers
        fine_r = np.sort(np.concatenate([rs, (rs[1:] + rs[:-1]) / 2]))
        number, X = {}, []
        def node(i, j):
            if (i, j) not in number:
                number[i, j] = len(X)
                X.append((fine_r[i], thickness * j / (2 * m)))
            return number[i, j]
        self.rings = np.array([[node(2 * i + 1 + int(a), 2 * j + 1 + int(b)) for a, b in PLACES] for i in range(n) for j in range(m)])
        self.X = np.array(X)
        self.lam, self.mu = nu / ((1 + nu) * (1 - 2 * nu)), 0.5 / (1 + nu)
        self.B, self.weights = [], []
        g = 1 / np.sqrt(3)
        for a in (-g, g):
            for b in (-g, g):
                N, G = shapes(a, b)
                at = self.X[self.rings]
                J = np.einsum("eni,nk->eik", at, G)
                slope = np.einsum("nk,eki->eni", G, np.linalg.inv(J))
                r = at[:, :, 0] @ N
                B = np.zeros((len(at), 5, 16))  # rr, rz, zr, zz, round
                B[:, 0, 0::2] = B[:, 2, 1::2] = slope[:, :, 0]
                B[:, 1, 0::2] = B[:, 3, 1::2] = slope[:, :, 1]
                B[:, 4, 0::2] = N / r[:, None]
                self.B.append(B)
                self.weights.append(2 * np.pi * r * np.linalg.det(J))
        self.dof = (2 * self.rings[:, :, None] + np.arange(2)).reshape(len(self.rings), 16)
        on_axis, at_rim = self.X[:, 0] < 1e-12, self.X[:, 0] > radius - 1e-9
        self.fixed = np.zeros(2 * len(self.X), bool)
        self.fixed[2 * np.flatnonzero(on_axis)] = True
        self.fixed[2 * np.flatnonzero(at_rim)] = self.fixed[2 * np.flatnonzero(at_rim) + 1] = True
        under = (self.X[:, 1] > thickness * (1 - 1e-9)) & (self.X[:, 0] < tool * (1 + 1e-9))
        self.under = np.flatnonzero(under)[np.argsort(self.X[under, 0])]

    def forces(self, u):
        """Returns the nodal forces and their derivative at the displacements u."""
        f = np.zeros(len(u))
        K = np.zeros((len(self.rings), 16, 16))
        of_ring = u[self.dof]
        for B, weight in zip(self.B, self.weights):
            H = np.einsum("ekd,ed->ek", B, of_ring)
            F = np.zeros((len(H), 3, 3))
            F[:, 0, 0], F[:, 0, 1], F[:, 1, 0], F[:, 1, 1], F[:, 2, 2] = 1 + H[:, 0], H[:, 1], H[:, 2], 1 + H[:, 3], 1 + H[:, 4]
            det, inverse = np.linalg.det(F), np.linalg.inv(F)
            if (det <= 0).any():
                return None, None
            log = np.log(det)[:, None, None]
            P = self.mu * (F - inverse.transpose(0, 2, 1)) + self.lam * log * inverse.transpose(0, 2, 1)
            A = np.einsum("e,ejk,eli->eijkl", self.mu - self.lam * log[:, 0, 0], inverse, inverse)
            A += self.lam * np.einsum("eji,elk->eijkl", inverse, inverse)
            A += self.mu * np.einsum("ik,jl->ijkl", np.eye(3), np.eye(3))
            i, j = [0, 0, 1, 1, 2], [0, 1, 0, 1, 2]
            f += np.bincount(self.dof.ravel(), np.einsum("ekd,ek,e->ed", B, P[:, i, j], weight).ravel(), len(u))
            D = A[:, i, j][:, :, i, j]
            K += np.einsum("ekd,ekl,elc,e->edc", B, D, B, weight, optimize=True)
        row, column = np.repeat(self.dof, 16, 1).ravel(), np.tile(self.dof, (1, 16)).ravel()
        return f, sp.csc_matrix((K.ravel(), (row, column)), shape=(len(u),) * 2)

    def press(self, depth, steps=6):
        """Returns the force of the tool at `depth`."""
        u = np.zeros(2 * len(self.X))
        active = np.zeros(len(self.under), bool)
        active[-1] = True
        z = 2 * self.under + 1
        for step in range(1, steps + 1):
            down = -depth * step / steps
            for _ in range(60):
                held = self.fixed.copy()
                held[z[active]] = True
                change = np.zeros(len(u))
                change[z[active]] = down - u[z[active]]
                f, K = self.forces(u)
                free = np.flatnonzero(~held)
                change[free] = splu(K[free][:, free]).solve(-(f + K @ change)[free])
                part = 1.0
                while self.forces(u + part * change)[0] is None:
                    part /= 2
                u += part * change
                f, _ = self.forces(u)
                new = np.where(active, f[z] < 0, u[z] > down + 1e-9 * depth)
                settled = (new == active).all() and part == 1 and np.abs(change).max() < 1e-7 * depth
                active = new
                active[-1] |= not active.any()
                if settled:
                    break
            else:
                raise RuntimeError("the sheet did not settle")
        return -f[z].sum()


def flat(radius, thickness, tool, depth, nu, layers=3):
    """Returns the force of a tool with the radius `tool`."""
    return Sheet(radius, thickness, tool, nu, layers).press(depth)
