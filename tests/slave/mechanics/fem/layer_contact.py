"""Computes the forces of a rigid sphere on a linear elastic layer bonded to a rigid base, with Coulomb's friction.

The layer's compliance as a function of the wavenumber is exact (a 4 x 4 system of first order through the thickness).
The sphere is pressed in four increments and then dragged; pressure and shear on a periodic grid of 32 mm are found by
accelerated projected gradients. Prints the reference values of sphere_contact_test.cpp:

    python3 layer_contact.py RADIUS DEPTH NU FRICTION NODES [DRAG...]       (SI units)
    python3 layer_contact.py 0.05 0.2266e-3 0.49 0.5 144 3.5e-4 4e-4 4.5e-4
"""
import sys

import numpy as np

SIDE, THICKNESS, MODULUS = 32e-3, 4e-3, 1e5  # side of the grid [m], thickness of the layer [m], E [Pa]


def layer_compliance(nu, k):
    """Returns the compliance times E [mm] along the wave (a), between wave and normal (b), along the normal (d) and
    across (s), for h = 4 mm and wavenumbers k [1/mm]. For waves shorter than the thickness only the depth 9 / k is
    integrated."""
    mu = 1 / (2 * (1 + nu))
    lam = nu / ((1 + nu) * (1 - 2 * nu))
    stiff = lam + 2 * mu
    found = np.zeros((3, len(k)))
    for i, q in enumerate(k):
        depth = min(THICKNESS * 1e3, 9 / q)
        M = depth * np.array([[0, -q, 1 / mu, 0],
                              [lam * q / stiff, 0, 0, 1 / stiff],
                              [q * q * (stiff - lam * lam / stiff), 0, 0, -q * lam / stiff],
                              [0, 0, q, 0]])
        halvings = int(np.ceil(np.log2(np.abs(M).max()))) + 4
        P, term = np.eye(4), np.eye(4)
        for j in range(1, 14):
            term = term @ M / 2**halvings / j
            P = P + term
        for _ in range(halvings):
            P = P @ P
        C = P[:2, 2:] @ np.linalg.inv(P[2:, 2:])
        found[:, i] = C[0, 0], C[0, 1], C[1, 1]
    return (*found, np.tanh(k * THICKNESS * 1e3) / (mu * k))


def forces(radius, depth, nu, friction, nodes, drags):
    k1 = 2 * np.pi * np.fft.fftfreq(nodes, SIDE / nodes)
    kx, ky = np.meshgrid(k1, k1, indexing="ij")
    k = np.hypot(kx, ky)
    known = np.unique(np.round(k[k > 0], 6))
    a, b, d, s = (np.where(k > 0, np.interp(k, known, t), 0) * 1e-3 / MODULUS
                  for t in layer_compliance(nu, known * 1e-3))
    a[0, 0] = s[0, 0] = THICKNESS * 2 * (1 + nu) / MODULUS
    b[0, 0] = 0
    d[0, 0] = THICKNESS * (1 - 2 * nu) * (1 + nu) / (1 - nu) / MODULUS
    cx, cy = kx / np.where(k > 0, k, 1), ky / np.where(k > 0, k, 1)
    cx[0, 0] = 1

    def moved(t):
        F = np.fft.fft2(t, axes=(0, 1))
        along, across = cx * F[..., 0] + cy * F[..., 1], cx * F[..., 1] - cy * F[..., 0]
        u, v = a * along + 1j * b * F[..., 2], s * across
        U = np.stack([cx * u - cy * v, cy * u + cx * v, d * F[..., 2] - 1j * b * along], -1)
        return np.real(np.fft.ifft2(U, axes=(0, 1)))

    x = (np.arange(nodes) - nodes // 2) * SIDE / nodes
    r = np.hypot(*np.meshgrid(x, x, indexing="ij"))
    sphere = radius - np.sqrt(radius**2 - np.minimum(r, radius)**2)
    near = r < 1.6 * np.sqrt(2 * radius * depth)
    step = 1.6 / max(np.abs(a).max(), d.max(), s.max())
    stuck_at, t = np.zeros((nodes, nodes, 2)), np.zeros((nodes, nodes, 3))
    for way, down in [(0, depth * i / 4) for i in range(1, 5)] + [(q, depth) for q in drags]:
        y, pace = t.copy(), 1.0
        for count in range(1500):
            u = moved(y)
            p = np.maximum(step * (u[..., 2] + down - sphere) - y[..., 2], 0) * near
            q = y[..., :2] - step * (u[..., :2] - [way, 0] - stuck_at)
            size = np.hypot(q[..., 0], q[..., 1])
            q *= np.where(size > friction * p, friction * p / np.maximum(size, 1e-30), 1)[..., None]
            new = np.concatenate([q, -p[..., None]], -1)
            if ((y - new) * (new - t)).sum() > 0:
                pace = 1.0
            faster = (1 + np.sqrt(1 + 4 * pace**2)) / 2
            change = np.abs(new - t).max()
            y, t, pace = new + (pace - 1) / faster * (new - t), new, faster
            if count > 30 and change < 2e-5 * p.max():
                break
        slips = np.hypot(t[..., 0], t[..., 1]) >= -friction * t[..., 2] * (1 - 1e-9)
        stuck_at = np.where(slips[..., None], moved(t)[..., :2] - [way, 0], stuck_at)
        total = t.sum((0, 1)) * (SIDE / nodes)**2
        print(f"drag {way:.3g} depth {down:.4g} normal {-total[2]:.4f} tangential {total[0]:.4f}")


if __name__ == "__main__":
    values = [float(v) for v in sys.argv[1:]]
    forces(*values[:4], int(values[4]), values[5:])
