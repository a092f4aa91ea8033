"""Computes the stiffness of sheets under a glued flat tool that reaches through all of the thickness, and of blocks under
one that reaches through a part of it. Quadratic triangles and bricks with mean dilatation, graded towards the tool. E = 1."""
import math

import gmsh
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import cg, splu


def elasticity(nu, dimension, plane=None):
    """Returns the elasticity matrix for E = 1; strains xx, yy, (zz,) xy, (xz, yz) with engineering shears."""
    if plane == "stress":
        return np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]]) / (1 - nu * nu)
    lam, mu = nu / ((1 + nu) * (1 - 2 * nu)), 0.5 / (1 + nu)
    n = 3 if dimension == 2 else 6
    D = np.zeros((n, n))
    D[:dimension, :dimension] = lam
    D[range(dimension), range(dimension)] += 2 * mu
    D[range(dimension, n), range(dimension, n)] = mu
    return D


def triangle_matrix(X, conn, D):
    """Returns the stiffness of quadratic triangles with straight sides, nodes in Gmsh's order."""
    T = np.concatenate([np.ones((len(conn), 3, 1)), X[conn[:, :3]]], 2)
    grad = np.linalg.inv(T)[:, 1:, :].transpose(0, 2, 1)  # of the barycentric coordinates
    area = np.abs(np.linalg.det(T)) / 2
    K = np.zeros((len(conn), 12, 12))
    for L in [(2 / 3, 1 / 6, 1 / 6), (1 / 6, 2 / 3, 1 / 6), (1 / 6, 1 / 6, 2 / 3)]:
        edges = [4 * (L[i] * grad[:, j] + L[j] * grad[:, i]) for i, j in [(0, 1), (1, 2), (2, 0)]]
        G = np.concatenate([grad * (4 * np.array(L) - 1)[None, :, None], np.stack(edges, 1)], 1)
        B = np.zeros((len(conn), 3, 12))
        B[:, 0, 0::2] = B[:, 2, 1::2] = G[:, :, 0]
        B[:, 1, 1::2] = B[:, 2, 0::2] = G[:, :, 1]
        K += (area / 3)[:, None, None] * (B.transpose(0, 2, 1) @ (D @ B))
    return assemble(K, conn, 2, len(X))


def assemble(K, conn, d, nodes):
    dof = (conn[:, :, None] * d + np.arange(d)).reshape(len(conn), -1)
    m = dof.shape[1]
    return sp.csr_matrix((K.ravel(), (np.repeat(dof, m, 1).ravel(), np.tile(dof, (1, m)).ravel())), shape=(d * nodes,) * 2)


def solve(A, u, fixed, direct):
    free = ~fixed
    rhs, inner = -(A[free][:, fixed] @ u[fixed]), A[free][:, free]
    if direct:
        u[free] = splu(inner.tocsc()).solve(rhs)
    else:
        u[free], code = cg(inner, rhs, x0=u[free], M=sp.diags(1 / inner.diagonal()), tol=1e-6, maxiter=20000)
        if code:
            raise RuntimeError("the reference did not converge")
    return u


def meshed(build, size):
    """Meshes the geometry that `build` makes. Returns nodes and quadratic triangles. `size(x, y)`: length of the
    elements."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("m")
    build(gmsh.model.occ)
    gmsh.model.occ.synchronize()
    for name in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
        gmsh.option.setNumber("Mesh." + name, 0)
    gmsh.model.mesh.setSizeCallback(lambda dim, tag, x, y, z: size(x, y))
    gmsh.model.mesh.generate(2)
    gmsh.option.setNumber("Mesh.SecondOrderLinear", 1)
    gmsh.model.mesh.setOrder(2)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    X = coordinates.reshape(-1, 3)
    _, _, nodes = gmsh.model.mesh.getElements(2)
    gmsh.finalize()
    number = np.zeros(int(max(tags)) + 1, int)
    number[tags.astype(int)] = np.arange(len(tags))
    conn = number[nodes[0].astype(int)].reshape(-1, 6)
    used, flat = np.unique(conn, return_inverse=True)
    return X[used][:, :2], flat.reshape(conn.shape)


def pressed(A, X, bottom, tool):
    """Returns the force for a unit displacement of the glued nodes `tool` along -y."""
    u, fixed = np.zeros(A.shape[0]), np.zeros(A.shape[0], bool)
    for k in range(2):
        fixed[2 * bottom + k] = fixed[2 * tool + k] = True
    u[2 * tool + 1] = -1
    u = solve(A, u, fixed, True)
    return -(A @ u)[2 * tool + 1].sum()


def graded(low, high, centre, fine, growth):
    """Returns points from low to high with the spacing `fine` at the centre, growing away from it."""
    def away(span):
        points, h, x = [], fine, 0.0
        while x + h < span - 0.5 * h:
            x += h
            points.append(x)
            h *= growth
        return np.array(points + [span])
    left = centre - away(centre - low)[::-1] if centre > low else np.array([])
    right = centre + away(high - centre) if high > centre else np.array([])
    return np.concatenate([left, [centre], right])


def bricks(xs, ys, zs, nu):
    """Returns nodes and stiffness of trilinear bricks with mean dilatation, E = 1."""
    nx, ny, nz = len(xs), len(ys), len(zs)
    idx = np.arange(nx * ny * nz).reshape(nx, ny, nz)
    X = np.stack(np.meshgrid(xs, ys, zs, indexing="ij"), -1).reshape(-1, 3)
    conn = np.stack([idx[a:nx - 1 + a, b:ny - 1 + b, c:nz - 1 + c].ravel() for a in (0, 1) for b in (0, 1) for c in (0, 1)], 1)
    s = np.array([[a, b, c] for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)], float)
    size, D = X[conn[:, 7]] - X[conn[:, 0]], elasticity(nu, 3)
    grads = []
    for p in s / math.sqrt(3):
        N = np.stack([0.125 * s[:, k] * np.prod([1 + s[:, o] * p[o] for o in range(3) if o != k], axis=0) for k in range(3)], 1)
        grads.append(N[None] * (2 / size)[:, None, :])
    mean, K = sum(grads) / 8, np.zeros((len(conn), 24, 24))
    for G in grads:
        B = np.zeros((len(conn), 6, 24))
        for k in range(3):
            B[:, k, k::3] = G[:, :, k]
        for r, (i, j) in enumerate([(0, 1), (0, 2), (1, 2)]):
            B[:, 3 + r, i::3] = G[:, :, j]
            B[:, 3 + r, j::3] = G[:, :, i]
        for k in range(3):
            B[:, :3, k::3] += ((mean - G)[:, :, k] / 3)[:, None, :]
        K += (B.transpose(0, 2, 1) @ (D @ B)) * (size.prod(1) / 8)[:, None, None]
    return X, assemble(K, conn, 3, len(X))


def sheet_flat(width, height, thickness, place, tool, nu, plane, holes):
    """Returns the stiffness relative to E of a sheet under a flat tool that is glued to its top."""
    half, fine = tool / 2, tool / 24
    def build(occ):
        p = [occ.addPoint(x, y, 0) for x, y in ((0, 0), (width, 0), (width, height), (place + half, height), (place - half, height), (0, height))]
        lines = [occ.addLine(p[i], p[(i + 1) % 6]) for i in range(6)]
        surface = (2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))
        if holes:
            occ.cut([surface], [(2, occ.addDisk(x, y, 0, r, r)) for x, y, r in holes])
    def h(x, y):
        away = min(math.hypot(x - place - half, y - height), math.hypot(x - place + half, y - height))
        rings = [abs(math.hypot(x - a, y - b) - r) / 2 + r / 8 for a, b, r in holes]
        return min([fine / 4 + 0.2 * away, min(width, height) / 12, *rings])
    X, conn = meshed(build, h)
    A = triangle_matrix(X, conn, elasticity(nu, 2, plane))
    bottom = np.where(X[:, 1] < 1e-9)[0]
    tool_nodes = np.where((X[:, 1] > height - 1e-9) & (np.abs(X[:, 0] - place) < half * (1 + 1e-6)))[0]
    return thickness * pressed(A, X, bottom, tool_nodes)


def block_meshed(across, width, height, thickness, place, tool, extent, nu, behind):
    """Returns the stiffness of a block with `across` bricks across the shorter side of the tool."""
    fine, growth = min(tool, extent) / across, 1.3 ** (6 / across)
    def two(low, high, a, b, h):
        left, right = graded(low, (a + b) / 2, a, h, growth), graded((a + b) / 2, high, b, h, growth)
        return np.unique(np.round(np.concatenate([left, right]), 12))
    xs, ys = two(0, width, place - tool / 2, place + tool / 2, fine), height - graded(0, height, 0, fine, growth)[::-1]
    half, thin = behind is None, min(fine, thickness * 0.75 / across)
    low, high = (-1, extent / 2) if half else (behind, behind + extent)
    zs = graded(0, thickness / 2, high, thin, growth) if half else two(0, thickness, low, high, thin)
    X, A = bricks(xs, ys, zs, nu)
    e = 1e-9
    u, fixed = np.zeros(A.shape[0]), np.zeros(A.shape[0], bool)
    if half:
        fixed[3 * np.where(X[:, 2] < e)[0] + 2] = True
    bottom = np.where(X[:, 1] < e)[0]
    held = np.where((X[:, 1] > height - e) & (np.abs(X[:, 0] - place) < tool / 2 + e) & (X[:, 2] > low - e) & (X[:, 2] < high + e))[0]
    for k in range(3):
        fixed[3 * bottom + k] = fixed[3 * held + k] = True
    u[3 * held + 1] = -1
    u = solve(A, u, fixed, False)
    return -(2 if half else 1) * (A @ u)[3 * held + 1].sum()


def block_flat(width, height, thickness, place, tool, extent, nu, behind=None, coarse=4, fine=8):
    """Returns the stiffness relative to E of a block under a glued flat tool that reaches `extent` through its
    thickness: in the middle (half of the block is meshed) or `behind` the front face. The stress is singular at the
    tool's rim, so the error is proportional to the length of the bricks; two meshes are extrapolated."""
    a, b = (block_meshed(n, width, height, thickness, place, tool, extent, nu, behind) for n in (coarse, fine))
    return (fine * b - coarse * a) / (fine - coarse)
