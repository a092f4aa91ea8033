#!/usr/bin/env python3
"""Makes press.svg, the README's picture, from the simulated site: the picture of the deepest press as the slave sees
it, and the force over time beside the truth.

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


def axes(t_end, f_end):
    x, y, width, height = (PLOT[k] for k in ("x", "y", "width", "height"))
    parts = [f'<rect x="{x}" y="{y}" width="{width}" height="{height}" fill="none" stroke="#999"/>']
    for i in range(int(t_end) + 1):
        at = x + width * i / t_end
        parts.append(f'<text x="{at:.1f}" y="{y + height + 18}" text-anchor="middle">{i}</text>')
    for i in range(int(2 * f_end) + 1):
        at = y + height * (1 - 0.5 * i / f_end)
        parts.append(f'<text x="{x - 8}" y="{at + 4:.1f}" text-anchor="end">{0.5 * i:g}</text>')
    parts.append(f'<text x="{x + width / 2}" y="{y + height + 38}" text-anchor="middle">time [s]</text>')
    parts.append(f'<text x="{x}" y="{y - 12}">force of the block on the tool [N]</text>')
    return parts


def main():
    slave = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "build/release/bin/palpate-slave")
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder)
        subprocess.run([slave, "process", str(ROOT / "deploy/scenes/silicone-block.yaml"), "--out", str(out),
                        "--pictures"], check=True, stdout=subprocess.DEVNULL)
        with open(out / "states.csv", newline="") as states:
            rows = [row for row in csv.DictReader(states) if row["fy"]]
        deepest = max(rows, key=lambda row: float(row["fy"]))
        jpeg = base64.b64encode((out / f"pictures/{int(deepest['sequence']):06}.jpg").read_bytes()).decode()
    times = [float(row["t"]) for row in rows]
    felt = [float(row["fy"]) for row in rows]
    true = [float(row["true_fy"]) for row in rows]
    t_end, f_end = max(times), 1.1 * max(true + felt)
    svg = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 960 360" font-family="sans-serif" font-size="13" '
           'fill="#333">', '<rect width="960" height="360" fill="#fff"/>',
           f'<image x="20" y="20" width="440" height="330" href="data:image/jpeg;base64,{jpeg}"/>', *axes(t_end, f_end),
           polyline(times, true, t_end, f_end, 'stroke="#bbb" stroke-width="6"'),
           polyline(times, felt, t_end, f_end, 'stroke="#d9480f" stroke-width="2"'),
           '<text x="634" y="200" fill="#888">thick grey: true force at the site</text>',
           '<text x="634" y="220" fill="#d9480f">thin: felt through the camera</text>', "</svg>"]
    (HERE / "press.svg").write_text("\n".join(svg) + "\n")
    print(HERE / "press.svg")


if __name__ == "__main__":
    main()
