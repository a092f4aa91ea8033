#!/usr/bin/env python3
"""Compares Palpate with its peers on this machine; prints three tables in Markdown.

  1. One press on one mesh: `fem` and `fem-green` (palpate-slave solve) and CalculiX (Debian: calculix-ccx). A cube of 60 mm
     is fixed at its bottom. The nodes of a square of 20 mm on its top move down, bonded. Force, and processor time of the
     whole program for one press and for each further one.
  2. A step of `fem` beside figures for Vega FEM with the same body and step.
  3. Wake-up of the haptic loop beside that of a bare loop (palpate-master doctor), in turns, while the slave serves.

tests/bench/bench_peers.py [--cells 12,18] [--rounds 3] [--seconds 8] [--bench FOLDER]
"""
import argparse
import csv
import json
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/e2e"))
from programs import BIN, MASTER, SLAVE, Slave, run  # noqa: E402

SIDE, TOOL, MODULUS, POISSON = 0.06, 0.02, 127e3, 0.45  # [m, m, Pa]
SHALLOW, DEEP = 1e-3, 6e-3  # [m]
ELASTIC = f"*ELASTIC\n{MODULUS:g}, {POISSON:g}"
NEO_HOOKE = f"*HYPERELASTIC, NEO HOOKE\n{MODULUS / (4 * (1 + POISSON)):.9g}, {6 * (1 - 2 * POISSON) / MODULUS:.9g}"
FURTHER = 5                # presses of CalculiX after the first one; of `solve` ten times as many
SCENE = """name: cube
object:
  geometry: {mesh: cube.node}
  material: {young_modulus: %g Pa, poisson_ratio: %g}
  fixed: {plane: {axis: z, at: 0 m}}
model: {%s}
"""
# Milliseconds per step as others stated them for `ImplicitStep` of bench_fem: 1e-6, one thread. Another machine.
VEGA = {"0": "0.44 to 0.62", "5": "5.0", "20": "29", "98": "411"}


class Cube:
    """Six tetrahedra per cell along the diagonal from corner 0 to corner 7."""

    def __init__(self, cells):
        self.n = cells + 1
        self.nodes = [[SIDE * i / cells for i in (x, y, z)] for x in range(self.n) for y in range(self.n) for z in range(self.n)]
        paths = [(1, 3), (1, 5), (2, 3), (2, 6), (4, 5), (4, 6)]  # corners between 0 and 7; bit k: one step along axis k
        self.tets = [self.upright([self.corner(x, y, z, c) for c in (0, *path, 7)])
                     for x in range(cells) for y in range(cells) for z in range(cells) for path in paths]
        near = TOOL / 2 + 1e-9
        self.tool = [i for i, (x, y, z) in enumerate(self.nodes)
                     if z > SIDE - 1e-9 and abs(x - SIDE / 2) <= near and abs(y - SIDE / 2) <= near]
        self.bottom = [i for i, node in enumerate(self.nodes) if node[2] == 0]

    def corner(self, x, y, z, c):
        return ((x + (c & 1)) * self.n + y + (c >> 1 & 1)) * self.n + z + (c >> 2)

    def upright(self, tet):
        a, b, c, d = (self.nodes[i] for i in tet)
        u, v, w = ([q - p for p, q in zip(a, other)] for other in (b, c, d))
        volume = sum(u[i] * (v[i - 2] * w[i - 1] - v[i - 1] * w[i - 2]) for i in range(3))
        return tet if volume > 0 else [tet[0], tet[2], tet[1], tet[3]]

    def write_tetgen(self, folder):
        (folder / "cube.node").write_text(f"{len(self.nodes)} 3 0 0\n" + "".join(
            f"{i} {x:.12g} {y:.12g} {z:.12g}\n" for i, (x, y, z) in enumerate(self.nodes)))
        (folder / "cube.ele").write_text(f"{len(self.tets)} 4 0\n" + "".join(
            f"{i} {' '.join(map(str, tet))}\n" for i, tet in enumerate(self.tets)))


def timed(command, folder):
    """Processor time of the whole program [s]."""
    with open(folder / "printed.txt", "w", encoding="utf-8") as printed:
        process = subprocess.Popen([str(word) for word in command], cwd=folder, stdin=subprocess.DEVNULL, stdout=printed,
                                   stderr=printed, env={**os.environ, "OMP_NUM_THREADS": "1", "CCX_NPROC_EQUATION_SOLVER": "1"})
        _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise RuntimeError(f"{command[0]}: {(folder / 'printed.txt').read_text()[-500:]}")
    return usage.ru_utime + usage.ru_stime


def depths(deepest, presses):
    """The last press is the deepest; the others alternate below it."""
    return [deepest * (0.5 if (presses - k) % 2 == 0 else 0.8) for k in range(1, presses)] + [deepest]


def solve(cube, folder, model, deepest, presses):
    (folder / "scene.yaml").write_text(SCENE % (MODULUS, POISSON, model))
    with open(folder / "contacts.csv", "w", newline="", encoding="utf-8") as table:
        rows = csv.writer(table)
        rows.writerow("case x y z dx dy dz".split())
        rows.writerows([k, *cube.nodes[i], 0, 0, -depth] for k, depth in enumerate(depths(deepest, presses)) for i in cube.tool)
    seconds = timed([SLAVE, "solve", folder / "scene.yaml", "--contacts", folder / "contacts.csv", "--out", folder / "forces.csv"], folder)
    with open(folder / "forces.csv", encoding="utf-8") as table:
        return -sum(float(row["fz"]) for row in list(csv.DictReader(table))[-len(cube.tool):]), seconds


def calculix(cube, folder, option, deepest, presses):
    def listed(name, nodes):
        return f"*NSET, NSET={name}\n" + "".join(f"{i + 1},\n" for i in nodes)

    deck = "*NODE, NSET=ALL\n" + "".join(f"{i}, {x:.12g}, {y:.12g}, {z:.12g}\n" for i, (x, y, z) in enumerate(cube.nodes, 1))
    deck += "*ELEMENT, TYPE=C3D4, ELSET=BODY\n" + "".join(
        f"{i}, {', '.join(str(node + 1) for node in tet)}\n" for i, tet in enumerate(cube.tets, 1))
    deck += listed("BOTTOM", cube.bottom) + listed("TOOL", cube.tool)
    deck += f"*MATERIAL, NAME=M\n{NEO_HOOKE if option else ELASTIC}\n*SOLID SECTION, ELSET=BODY, MATERIAL=M\n*BOUNDARY\nBOTTOM, 1, 3\n"
    for depth in depths(deepest, presses):
        deck += (f"*STEP{option}\n*STATIC\n*BOUNDARY\nTOOL, 1, 2\nTOOL, 3, 3, {-depth:g}\n"
                 "*NODE PRINT, NSET=TOOL, TOTALS=ONLY\nRF\n*END STEP\n")
    (folder / "cube.inp").write_text(deck)
    seconds = timed(["ccx", "cube"], folder)
    totals = re.findall(r"total force.*?\n\s*\n\s*(\S+)\s+(\S+)\s+(\S+)", (folder / "cube.dat").read_text())
    return -float(totals[-1][2]), seconds


PEERS = (("1 mm", "`fem`, `law: linear`", solve, "kind: fem, law: linear", SHALLOW), ("1 mm", "`fem-green`", solve, "kind: fem-green", SHALLOW),
         ("1 mm", "CalculiX, linear", calculix, "", SHALLOW), ("6 mm", "`fem`, `law: neo-hookean`", solve, "kind: fem, law: neo-hookean", DEEP),
         ("6 mm", "CalculiX, neo-Hookean", calculix, ", NLGEOM", DEEP))


def same_press(cells):
    print("| tetrahedra | depth | program | force | first press | each further press |\n" + "|---" * 6 + "|")
    for count in cells:
        cube = Cube(count)
        with tempfile.TemporaryDirectory() as place:
            folder = pathlib.Path(place)
            cube.write_tetgen(folder)
            for depth, name, program, option, deepest in PEERS:
                force, first = program(cube, folder, option, deepest, 1)
                further = FURTHER if program is calculix else 10 * FURTHER
                _, all_of_them = program(cube, folder, option, deepest, 1 + further)
                print(f"| {len(cube.tets)} | {depth} | {name} | {force:.6g} N | {first:.2f} s | "
                      f"{1e3 * max(0.0, all_of_them - first) / further:.3g} ms |", flush=True)


def step_beside_vega(bench):
    printed = subprocess.run([bench / "bench_fem", "--benchmark_filter=ImplicitStep/.*/digits:6/width_mm:20", "--benchmark_format=json"],
                             capture_output=True, text=True, check=True).stdout
    print("\n| degrees of freedom | `fem`: median, p99 | Vega FEM | ratio to the median |\n" + "|---" * 4 + "|")
    for one in json.loads(printed)["benchmarks"]:
        vega = VEGA[re.search(r"ktets:(\d+)", one["name"]).group(1)]
        ratio = " to ".join(f"{float(part) / one['median_ms']:.1f}" for part in vega.split(" to "))
        print(f"| {one['dof']:.0f} | {one['median_ms']:.3g} ms, {one['p99_ms']:.3g} ms | {vega} ms | {ratio} |")


def jitter(rounds, seconds):
    names = ("p50", "p99", "max", "missed")
    kept = {"bare loop": [], "haptic loop": []}
    for _ in range(rounds):
        with Slave() as slave, tempfile.TemporaryDirectory() as folder:
            printed = run(MASTER, "doctor", "--seconds", seconds, timeout=60 + 10 * seconds).stdout
            found = re.search(r"median (\d+) us, 99 % below (\d+) us, maximum (\d+) us; (\d+) periods", printed)
            kept["bare loop"].append([int(text) for text in found.groups()])
            run(MASTER, "connect", slave.address, "--duration", seconds, "--report", f"{folder}/report.json", timeout=60 + seconds)
            report = json.loads(pathlib.Path(folder, "report.json").read_text())
            kept["haptic loop"].append([report["wake_us"][name] for name in names[:3]] + [report["missed"]])
    print("\n| loop at 1 kHz | wake-up late by: median, 99 %, largest | missed periods |\n" + "|---" * 3 + "|")
    for name, rows in kept.items():
        p50, p99, most, missed = (statistics.median(column) for column in zip(*rows))
        print(f"| {name} | {p50:.0f} us, {p99:.0f} us, {most:.0f} us | {missed:.0f} of {1000 * seconds:.0f} |")
    print(f"medians of {rounds} rounds")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", default="12,18", help="cells along each edge of the cube")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=8)
    parser.add_argument("--bench", type=pathlib.Path, default=BIN, help="folder of bench_fem; build/bench/bin is the native build")
    options = parser.parse_args()
    same_press([int(text) for text in options.cells.split(",")])
    if (options.bench / "bench_fem").exists():
        step_beside_vega(options.bench)
    else:
        print(f"\nskipped: no {options.bench / 'bench_fem'}")
    jitter(options.rounds, options.seconds)
    print(f"{os.cpu_count()} cores, load of the last minute {os.getloadavg()[0]:.1f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
