#!/usr/bin/python3
"""Palpates an object on a grid and draws its stiffness as a map.

usage: palpation_map.py HOST:PORT MAP.svg [--planar] [--points N] [--span MM] [--depth MM] [--tls DIR]

Presses at N x N points around the home position along -z; with --planar at N points in a row along -y. The grid is --span
wide. Each press goes --depth beyond the surface at rest. Stiffness is the valid force over the depth there. A press whose
forces are flagged is repeated twice. If they still are, its square stays grey.

Prints the stiffness at the centre, and the smallest and largest one relative to it. Exit code 0: most
presses gave one; 1: otherwise.
"""
import argparse
import pathlib
import sys

import numpy as np
import numpy.typing as npt
import palpate

Array = npt.NDArray[np.float64]
SPEED, HOLD, TRIALS = 0.02, 0.3, 3  # [m/s], [s] before and during each press, presses until a force is valid
CELL = 80  # [px]


def stiffness(tool: palpate.Operator, inward: Array, depth: float) -> float:
    """Presses at the present place and returns there [N/m]. NaN: no force was valid."""
    start = tool.position
    tool.hold(HOLD)  # until the sensor shows the tool at rest
    tool.move_by((depth - tool.state.depth) * inward, SPEED)
    held = tool.hold(HOLD)
    tool.move_to(start, SPEED)
    loads, depths = -held.force[held.valid] @ inward, held.depth[held.valid]
    return float(np.mean(loads / depths)) if len(loads) else np.nan


def svg(values: Array) -> str:
    """Squares from white (softest) to dark red (stiffest), each with its stiffness [N/m]."""
    low, high = np.nanmin(values), np.nanmax(values)
    cells = []
    for row, column in np.ndindex(*values.shape):
        value = values[-1 - row, column]  # y points up
        shade = 95 - 50 * (value - low) / (high - low if high > low else 1)
        fill, text = (f"hsl(8 70% {shade:.0f}%)", f"{value:.0f}") if np.isfinite(value) else ("grey", "")
        x, y = CELL * column, CELL * row
        cells.append(f'<rect x="{x}" y="{y}" width="{CELL}" height="{CELL}" fill="{fill}"/>'
                     f'<text x="{x + CELL / 2}" y="{y + CELL / 2}" text-anchor="middle">{text}</text>')
    height, width = (CELL * n for n in values.shape)
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif">'
            f'<title>Stiffness [N/m]</title>{"".join(cells)}</svg>\n')


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("map", type=pathlib.Path, help="MAP.svg")
    parser.add_argument("--planar", action="store_true")
    parser.add_argument("--points", type=int, default=5)
    parser.add_argument("--span", type=float, default=20, metavar="MM")
    parser.add_argument("--depth", type=float, default=3, metavar="MM")
    parser.add_argument("--tls", metavar="DIR", help="folder with ca.pem, cert.pem and key.pem")
    arguments = parser.parse_args()
    inward = np.array([0.0, -1, 0] if arguments.planar else [0.0, 0, -1])
    along = 0.5e-3 * arguments.span * np.linspace(-1, 1, arguments.points)
    across = np.zeros(1) if arguments.planar else along
    values = np.full((len(across), len(along)), np.nan)
    with palpate.connect(arguments.target, arguments.tls) as slave, slave.operate("palpation_map.py") as tool:
        tool.engage()
        home = tool.position
        for row, y in enumerate(across):
            for column, x in enumerate(along):
                tool.move_to(home + [x, y, 0], SPEED)
                trials = (stiffness(tool, inward, 1e-3 * arguments.depth) for _ in range(TRIALS))
                values[row, column] = next(filter(np.isfinite, trials), np.nan)
        tool.move_to(home, SPEED)
    arguments.map.write_text(svg(values), encoding="utf-8")
    centre = values[len(across) // 2, len(along) // 2]
    low, high = np.nanmin(values) / centre, np.nanmax(values) / centre
    print(f"{np.isfinite(values).sum()} of {values.size} presses, {centre:.1f} N/m at the centre, {low:.3f} to {high:.3f} of it")
    return 0 if np.isfinite(values).mean() > 0.5 else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except palpate.Error as error:
        sys.exit(f"error: {error}")
