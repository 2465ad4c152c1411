"""The front of a column of water that is let go at once, without friction: a potential flow by boundary elements.

    python3 tests/reference/dam_break.py [NODES [HEIGHT]] > tests/verification/dam-break-front.csv

Needs numpy, and a minute for the 220 nodes of the stored table; 150 differ by 0.2 %. The column is 0.146 m wide and HEIGHT, else
twice, as high. On its surface the potential φ obeys Dφ/Dt = |u|²/2 - g z and x moves with u = ∇φ; sources outside of the surface,
mirrored in wall and floor, carry φ inwards (desingularised, as Cao, Schultz and Beck 1991). Lengths are in widths a and
times in √(a/2g), so that g is 1/2. The upper corner is rounded by a twentieth; every fifth step nodes are smoothed and
spread anew along splines, closer together towards the toe. The area of the water is kept to 0.1 %, or it says so.
"""

import sys

import numpy as np

NODES = int(sys.argv[1]) if len(sys.argv) > 1 else 220
HEIGHT = float(sys.argv[2]) if len(sys.argv) > 2 else 2.0
GRAVITY, CORNER = 0.5, 0.05
WIDTH_M, GRAVITY_M_S2 = 0.146, 9.81
OUTSIDE, TOE, EVERY = 2.5, 6.0, 5
LAST, APART = 2.8, 0.2


def spline(s, y, even):
    """Cubic spline whose slope is zero at the ends that are even, and its curvature at the others."""
    n, h = len(s), np.diff(s)
    a, b = np.zeros((n, n)), np.zeros(n)
    for i in range(1, n - 1):
        a[i, i - 1 : i + 2] = h[i - 1], 2 * (h[i - 1] + h[i]), h[i]
        b[i] = 6 * ((y[i + 1] - y[i]) / h[i] - (y[i] - y[i - 1]) / h[i - 1])
    a[0, 0] = a[-1, -1] = 1
    if even[0]:
        a[0, :2], b[0] = (2 * h[0], h[0]), 6 * (y[1] - y[0]) / h[0]
    if even[1]:
        a[-1, -2:], b[-1] = (h[-1], 2 * h[-1]), -6 * (y[-1] - y[-2]) / h[-1]
    m = np.linalg.solve(a, b)

    def at(t):
        i = np.clip(np.searchsorted(s, t) - 1, 0, n - 2)
        u, k = t - s[i], h[i]
        slope = (y[i + 1] - y[i]) / k - k * (2 * m[i] + m[i + 1]) / 6
        return y[i] + u * slope + u**2 * m[i] / 2 + u**3 * (m[i + 1] - m[i]) / (6 * k)

    return at


def start():
    """The surface from the wall over the rounded corner to the toe, at rest."""
    top, arc, side = 1 - CORNER, np.pi / 2 * CORNER, HEIGHT - CORNER
    s = np.linspace(0, top + arc + side, 4 * NODES)
    angle = np.clip((s - top) / CORNER, 0, np.pi / 2)
    x = np.where(s < top, s, 1 - CORNER + CORNER * np.sin(angle))
    z = HEIGHT - CORNER + CORNER * np.cos(angle) - np.maximum(0, s - top - arc)
    return np.stack([x, z], 1)


def spread(x, phi):
    """The same surface with its nodes spread anew."""
    s = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(x, axis=0).T))])
    u = np.linspace(0, 1, 2000)
    dense = 1 + TOE * np.exp(-(1 - u) * s[-1] / 0.25)
    share = np.concatenate([[0], np.cumsum(0.5 * (dense[1:] + dense[:-1]))])
    t = np.interp(np.linspace(0, 1, NODES), share / share[-1], u) * s[-1]
    ends = [spline(s, x[:, 0], (False, True))(t), spline(s, x[:, 1], (True, False))(t)]
    ends[0][0] = ends[1][-1] = 0
    return np.stack(ends, 1), spline(s, phi, (True, True))(t)


def rates(x, phi):
    """Velocities of the nodes, and the rates of their potentials."""
    beyond = np.concatenate([[[-x[1, 0], x[1, 1]]], x, [[x[-2, 0], -x[-2, 1]]]])
    along = beyond[2:] - beyond[:-2]
    outward = np.stack([-along[:, 1], along[:, 0]], 1)
    source = x + 0.5 * OUTSIDE * outward
    potential = np.ones((NODES + 1, NODES + 1))
    potential[:NODES, :NODES] = potential[NODES, NODES] = 0
    across, up = np.zeros((NODES, NODES)), np.zeros((NODES, NODES))
    for a, b in [(1, 1), (1, -1), (-1, 1), (-1, -1)]:
        dx, dz = x[:, :1] - a * source[:, 0], x[:, 1:] - b * source[:, 1]
        square = dx**2 + dz**2
        potential[:NODES, :NODES] += 0.5 * np.log(square)
        across, up = across + dx / square, up + dz / square
    strength = np.linalg.solve(potential, np.append(phi, 0))[:NODES]
    u = np.stack([across @ strength, up @ strength], 1)
    u[0, 0] = u[-1, 1] = 0
    return u, 0.5 * (u**2).sum(1) - GRAVITY * x[:, 1]


def smooth(y, first, last):
    """Smoothed over five nodes, mirrored at both ends with these signs."""
    e = np.concatenate([[first * y[2], first * y[1]], y, [last * y[-2], last * y[-3]]])
    return (-e[:-4] + 4 * e[1:-3] + 10 * e[2:-2] + 4 * e[3:-1] - e[4:]) / 16


def area(x):
    return abs(np.sum(0.5 * (x[1:, 0] + x[:-1, 0]) * np.diff(x[:, 1])))


def main():
    x, phi = spread(start(), np.zeros(4 * NODES))
    whole, unit = area(x), np.sqrt(WIDTH_M / (2 * GRAVITY_M_S2))
    time, steps, asked, rows = 0.0, 0, APART, [(0.0, WIDTH_M)]
    while asked < LAST + 0.5 * APART:
        u, change = rates(x, phi)
        near = np.hypot(*np.diff(x, axis=0).T).min()
        dt = min(0.02, 0.35 * near / (np.sqrt((u**2).sum(1)).max() + 1e-3), 0.3 * np.sqrt(near))
        stages = [(u, change)]
        for part in (0.5, 0.5, 1.0):
            stages.append(rates(x + part * dt * stages[-1][0], phi + part * dt * stages[-1][1]))
        toe, weights = x[-1, 0], np.array([1, 2, 2, 1]) / 6
        x = x + dt * sum(w * k[0] for w, k in zip(weights, stages))
        phi = phi + dt * sum(w * k[1] for w, k in zip(weights, stages))
        x[0, 0] = x[-1, 1] = 0
        while asked <= time + dt and asked < LAST + 0.5 * APART:
            front = toe + (x[-1, 0] - toe) * (asked - time) / dt
            rows.append((asked * unit, front * WIDTH_M))
            asked += APART
        time, steps = time + dt, steps + 1
        if steps % EVERY == 0:
            x = np.stack([smooth(x[:, 0], -1, 1), smooth(x[:, 1], 1, -1)], 1)
            x, phi = spread(x, smooth(phi, 1, 1))
    if abs(area(x) / whole - 1) > 1e-3:
        sys.exit(f"the water changed its area to {area(x) / whole:.5f} of what it was")
    print("t,x")
    for row in rows:
        print("{:.5f},{:.5f}".format(*row))


main()
