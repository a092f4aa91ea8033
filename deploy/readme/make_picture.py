#!/usr/bin/env python3
"""Makes press.svg and membrane.svg, the README's pictures, from simulated sites: the picture of the deepest press as
the slave sees it, and the force over time beside the truth.

usage: deploy/readme/make_picture.py [palpate-slave]   (default build/release/bin/palpate-slave)
"""
import base64
import csv
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PLOT = {"x": 520, "y": 40, "width": 400, "height": 260}


def polyline(times, forces, t_end, f_end, style):
    points = " ".join(f"{PLOT['x'] + PLOT['width'] * t / t_end:.1f},"
                      f"{PLOT['y'] + PLOT['height'] * (1 - f / f_end):.1f}" for t, f in zip(times, forces))
    return f'<polyline points="{points}" fill="none" {style}/>'


def axes(t_end, f_end, step, what):
    x, y, width, height = (PLOT[k] for k in ("x", "y", "width", "height"))
    parts = [f'<rect x="{x}" y="{y}" width="{width}" height="{height}" fill="none" stroke="#999"/>']
    for i in range(int(t_end) + 1):
        at = x + width * i / t_end
        parts.append(f'<text x="{at:.1f}" y="{y + height + 18}" text-anchor="middle">{i}</text>')
    for i in range(int(f_end / step) + 1):
        at = y + height * (1 - step * i / f_end)
        parts.append(f'<text x="{x - 8}" y="{at + 4:.1f}" text-anchor="end">{step * i:g}</text>')
    parts.append(f'<text x="{x + width / 2}" y="{y + height + 38}" text-anchor="middle">time [s]</text>')
    parts.append(f'<text x="{x}" y="{y - 12}">force of the {what} on the tool [N]</text>')
    return parts


def draw(slave, scene, overrides, axis, what, eyes, words_at, file):
    """`axis`: y or z, along which the object pushes; `words_at`: where the legend leaves the curves free."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder)
        subprocess.run([slave, "process", str(ROOT / f"deploy/scenes/{scene}.yaml"), "--out", str(out), "--pictures",
                        *(word for o in overrides for word in ("--override", o))], check=True,
                       stdout=subprocess.DEVNULL)
        with open(out / "states.csv", newline="") as states:
            rows = [row for row in csv.DictReader(states) if row["f" + axis]]
        deepest = max(rows, key=lambda row: float(row["f" + axis]))
        jpeg = base64.b64encode((out / f"pictures/{int(deepest['sequence']):06}.jpg").read_bytes()).decode()
    times = [float(row["t"]) for row in rows]
    felt = [float(row["f" + axis]) for row in rows]
    true = [float(row["true_f" + axis]) for row in rows]
    t_end, f_end = max(times), 1.1 * max(true + felt)
    x, y = words_at
    svg = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 960 360" font-family="sans-serif" font-size="13" '
           'fill="#333">', '<rect width="960" height="360" fill="#fff"/>',
           f'<image x="20" y="20" width="440" height="330" href="data:image/jpeg;base64,{jpeg}"/>',
           *axes(t_end, f_end, 0.5 if f_end < 3 else 1, what),
           polyline(times, true, t_end, f_end, 'stroke="#bbb" stroke-width="6"'),
           polyline(times, felt, t_end, f_end, 'stroke="#d9480f" stroke-width="2"'),
           f'<text x="{x}" y="{y}" fill="#888">thick grey: true force at the site</text>',
           f'<text x="{x}" y="{y + 20}" fill="#d9480f">thin: felt through the {eyes}</text>', "</svg>"]
    (HERE / file).write_text("\n".join(svg) + "\n")
    print(HERE / file)


def main():
    slave = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "build/release/bin/palpate-slave")
    draw(slave, "silicone-block", [], "y", "block", "camera", (634, 200), "press.svg")
    draw(slave, "rubber-membrane", ["manipulator.home=[12 mm, 5 mm, 4 mm]"], "z", "membrane", "two cameras",
         (540, 70), "membrane.svg")


if __name__ == "__main__":
    main()
