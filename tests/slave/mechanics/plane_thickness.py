#!/usr/bin/env python3
"""Compares plane models with a solid: computes the reference values of tool_domain_test.cpp by bricks that are
independent of the product.

A block L x H x T is held at its bottom and pressed in the middle of its top by a rigid glued tool of width w, which reaches b
through the thickness. Trilinear bricks with mean dilatation, graded to the tool's ends, a quarter by symmetry. The plane values are
those of the same mesh in x and y, so that its error cancels. Needs NumPy and SciPy; ten minutes.
"""
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import cg, spsolve


def graded(length, edge, fine, growth=1.35, coarse=None):
    """Returns points from 0 to length, fine on both sides of `edge` (0 < edge <= length) and growing away from it."""
    coarse = coarse or length / 6
    def away(span):
        pts, h, x = [0.0], fine, 0.0
        while x + h < span - 0.4 * h:
            x += h
            pts.append(x)
            h = min(h * growth, coarse)
        pts.append(span)
        return np.array(pts)
    left = edge - away(edge)[::-1]
    right = edge + away(length - edge)[1:] if length - edge > 1e-12 else np.array([])
    return np.concatenate([left, right])


def stiffness(xs, ys, zs, nu, tool, plane=None):
    """Returns the sum of the reactions under a quarter of the tool divided by its displacement, E = 1. `plane`: stress
    or strain, with one layer."""
    nx, ny, nz = len(xs), len(ys), len(zs)
    idx = np.arange(nx * ny * nz).reshape(nx, ny, nz)
    X = np.stack(np.meshgrid(xs, ys, zs, indexing="ij"), -1).reshape(-1, 3)
    lam, mu = nu / ((1 + nu) * (1 - 2 * nu)), 0.5 / (1 + nu)
    D = np.zeros((6, 6))
    D[:3, :3] = lam
    D[range(3), range(3)] += 2 * mu
    D[range(3, 6), range(3, 6)] = mu
    c = [idx[a:nx - 1 + a, b:ny - 1 + b, d:nz - 1 + d].ravel() for a in (0, 1) for b in (0, 1) for d in (0, 1)]
    conn = np.stack(c, 1)
    s = np.array([[a, b, d] for a in (-1, 1) for b in (-1, 1) for d in (-1, 1)], float)
    size = np.stack([X[conn[:, 4], 0] - X[conn[:, 0], 0], X[conn[:, 2], 1] - X[conn[:, 0], 1], X[conn[:, 1], 2] - X[conn[:, 0], 2]], 1)
    g = 1 / np.sqrt(3)
    n = len(conn)
    K = np.zeros((n, 24, 24))
    vol = size.prod(1)
    mean = np.zeros((n, 8, 3))
    grads = []
    for p in s * g:
        N = np.zeros((8, 3))
        for k in range(3):
            o = [i for i in range(3) if i != k]
            N[:, k] = 0.125 * s[:, k] * (1 + s[:, o[0]] * p[o[0]]) * (1 + s[:, o[1]] * p[o[1]])
        G = N[None] * (2 / size)[:, None, :]
        grads.append(G)
        mean += G / 8
    for G in grads:
        B = np.zeros((n, 6, 24))
        for k in range(3):
            B[:, k, k::3] = G[:, :, k]
        for r, (i, j) in enumerate([(0, 1), (1, 2), (0, 2)]):
            B[:, 3 + r, i::3] = G[:, :, j]
            B[:, 3 + r, j::3] = G[:, :, i]
        for k in range(3):
            d = (mean[:, :, k] - G[:, :, k]) / 3
            for r in range(3):
                B[:, r, k::3] += d
        K += np.einsum("eri,rs,esj->eij", B, D, B) * (vol / 8)[:, None, None]
    dof = (conn[:, :, None] * 3 + np.arange(3)).reshape(n, 24)
    A = sp.csr_matrix((K.ravel(), (np.repeat(dof, 24, 1).ravel(), np.tile(dof, (1, 24)).ravel())), shape=(3 * len(X),) * 2)
    u = np.zeros(3 * len(X))
    fixed = np.zeros(3 * len(X), bool)
    e = 1e-9
    fixed[3 * np.where(X[:, 0] < e)[0]] = True
    fixed[3 * np.where(X[:, 2] < e)[0] + 2] = True
    if plane == "strain":
        fixed[2::3] = True
    bottom = np.where(X[:, 1] < e)[0]
    w2, b2 = tool
    top = np.where((X[:, 1] > ys[-1] - e) & (X[:, 0] <= w2 + e) & (X[:, 2] <= b2 + e))[0]
    for k in range(3):
        if k == 2 and plane == "stress":
            continue
        fixed[3 * bottom + k] = True
        fixed[3 * top + k] = True
    u[3 * top + 1] = -1
    free = ~fixed
    rhs = -(A[free][:, fixed] @ u[fixed])
    inner = A[free][:, free]
    if inner.shape[0] < 6000:
        u[free] = spsolve(inner.tocsc(), rhs)
    else:
        u[free], _ = cg(inner, rhs, M=sp.diags(1 / inner.diagonal()), tol=1e-6, maxiter=20000)
    return -(A @ u)[3 * top + 1].sum()


def ratios(L, H, T, w, b, nu, fine=0.08):
    """Returns K_stress / K and K_strain / K. `fine`: length of the bricks at the tool's ends, relative to its width."""
    xs, ys = graded(L / 2, w / 2, fine * w, coarse=L / 10), graded(H, H, fine * w, coarse=H / 8)
    zs = graded(T / 2, b / 2, min(fine * w, T / 8), coarse=T / 8)
    solid = 4 * stiffness(xs, ys, zs, nu, (w / 2, b / 2))
    one = 1e-3 * L
    strain, stress = (2 * stiffness(xs, ys, np.array([0, one]), nu, (w / 2, one), plane) / one for plane in ("strain", "stress"))
    return T * stress / solid, T * strain / solid


if __name__ == "__main__":
    for nu, H, w, b in ((0.49, 1, 1 / 15, 1), (0.49, 1, 1 / 15, 0.75), (0.49, 1, 1 / 15, 0.5), (0.49, 1, 1 / 15, 0.1), (0.49, 1, 0.2, 1),
                        (0.49, 0.3, 1 / 15, 1), (0.49, 0.3, 1 / 15, 0.9), (0.3, 1, 1 / 15, 1), (0.3, 1, 0.2, 1)):
        for T in (0.05, 0.1, 0.2, 0.5, 1, 2, 4):
            stress, strain = ratios(1, H, T, w, b * T, nu)
            print(f"nu {nu} H/L {H} T/L {T} w/L {w:.3f} b/T {b}: stress {stress:.3f} strain {strain:.3f}", flush=True)
