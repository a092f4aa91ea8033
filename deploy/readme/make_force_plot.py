#!/usr/bin/env python3
"""Makes force.svg: estimated force with its one-sigma band beside the true force, for three simulated scenes.

usage: deploy/readme/make_force_plot.py [palpate-slave]   (default build/release/bin/palpate-slave)
"""
import csv
import math
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SCENES = {"silicone-block": "one camera", "rubber-membrane": "stereo pair", "foam-cube": "fingertip"}
WIDTH, HEIGHT, GAP, LEFT, TOP = 250, 190, 70, 50, 50  # of one panel [px]


def magnitude(row, prefix):
    parts = [row[f"{prefix}f{axis}"] for axis in "xyz"]
    return math.hypot(*map(float, parts)) if all(parts) else None


def rows_of(slave, scene):
    """Returns rows (time, estimate, sigma, truth) of the first fingertip or of the tool, without unknown forces."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([slave, "process", ROOT / f"deploy/scenes/{scene}.yaml", "--out", folder], check=True,
                       stdout=subprocess.DEVNULL)
        with open(pathlib.Path(folder) / "states.csv", newline="", encoding="utf-8") as states:
            rows = list(csv.DictReader(states))
    rows = [row for row in rows if row["finger"] == rows[0]["finger"] and row["validity"] == "valid"]
    found = [(float(row["t"]), magnitude(row, ""), float(row["sigma"]), magnitude(row, "true_")) for row in rows]
    return [row for row in found if None not in row]


def step_for(largest):
    return next(step for step in (0.05, 0.1, 0.2, 0.5, 1, 2, 5) if largest / step <= 6)


def panel(index, scene, sensor, rows):
    left, bottom = LEFT + index * (WIDTH + GAP), TOP + HEIGHT
    duration, largest = rows[-1][0], 1.05 * max(max(force + sigma, true) for _, force, sigma, true in rows)

    def points(pairs):
        return " ".join(f"{left + WIDTH * t / duration:.1f},{bottom - HEIGHT * max(f, 0) / largest:.1f}" for t, f in pairs)

    band = [(t, f + s) for t, f, s, _ in rows] + [(t, f - s) for t, f, s, _ in reversed(rows)]
    step = step_for(largest)
    return [
        f'<text x="{left}" y="{TOP - 10}" font-weight="bold">{scene}: {sensor}</text>',
        f'<rect x="{left}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#999"/>',
        *(f'<text x="{left + WIDTH * t / duration:.1f}" y="{bottom + 16}" text-anchor="middle">{t}</text>'
          for t in range(int(duration) + 1)),
        *(f'<text x="{left - 6}" y="{bottom - HEIGHT * step * i / largest + 4:.1f}" text-anchor="end">{step * i:g}</text>'
          for i in range(int(largest / step) + 1)),
        f'<polygon points="{points(band)}" fill="#d9480f" fill-opacity="0.2"/>',
        f'<polyline points="{points([(t, true) for t, _, _, true in rows])}" fill="none" stroke="#999" stroke-width="5"/>',
        f'<polyline points="{points([(t, f) for t, f, _, _ in rows])}" fill="none" stroke="#d9480f" stroke-width="1.5"/>',
    ]


def main():
    slave = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "build/release/bin/palpate-slave")
    width, height = LEFT + 3 * WIDTH + 2 * GAP + 20, TOP + HEIGHT + 60
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
           'font-size="12" fill="#333">', "<title>Estimated and true force of three simulated scenes</title>",
           f'<rect width="{width}" height="{height}" fill="#fff"/>',
           f'<text x="{LEFT}" y="18">force [N] over time [s]</text>']
    for index, (scene, sensor) in enumerate(SCENES.items()):
        svg += panel(index, scene, sensor, rows_of(slave, scene))
    svg += [f'<text x="{LEFT}" y="{height - 12}"><tspan fill="#777">grey: true force of the simulator</tspan>'
            '<tspan dx="24" fill="#d9480f">red: estimated force, with one standard deviation (sigma) to each side</tspan></text>',
            "</svg>"]
    (HERE / "force.svg").write_text("\n".join(svg) + "\n", encoding="utf-8")
    print(HERE / "force.svg")


if __name__ == "__main__":
    main()
