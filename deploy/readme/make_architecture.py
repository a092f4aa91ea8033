#!/usr/bin/env python3
"""Draws the modules as boxes and their includes as arrows, from the sources themselves.

usage: make_architecture.py [--check] [OUT.svg]

A module is drawn above all that it includes. Arrows that follow from others (a module that includes what
its neighbour includes too) are left out. --check: draws nothing, ends with 1 where the drawing in
the tree is not that of the sources, or where modules include each other in a circle.
"""
import argparse
import collections
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = ("shared", "slave", "master")
COLOURS = {"proto": "#e8e2f4", "shared": "#e3eef9", "slave": "#e6f3e4", "master": "#fbeedd"}
INCLUDE = re.compile(r'#include "((?:shared|slave|master|palpate)/[^"]+)"')
BOX, GAP_X, GAP_Y, MARGIN = (104, 34), 14, 46, 24


def module_of(path):
    """`slave/vision/dots/dot.h` is in slave/vision; generated headers are proto's."""
    parts = path.split("/")
    if parts[0] == "palpate":
        return "proto"
    return "/".join(parts[:2]) if len(parts) > 2 else parts[0]


def arrows():
    """Returns the modules, each with the set of modules that it includes."""
    found = collections.defaultdict(set)
    for program in PROGRAMS:
        for file in sorted((ROOT / program).rglob("*")):
            if file.suffix not in (".h", ".cpp"):
                continue
            here = module_of(str(file.relative_to(ROOT)))
            found[here] |= {module_of(name) for name in INCLUDE.findall(file.read_text())}
    for module in list(found):
        found[module].discard(module)
        for below in found[module]:
            found.setdefault(below, set())
    return dict(found)


def levels(graph):
    """Returns the row of each module. Raises an error for circular includes."""
    height = {}

    def climb(module, way):
        if module in way:
            raise SystemExit("modules include each other: " + " -> ".join(way[way.index(module):] + [module]))
        if module not in height:
            height[module] = 1 + max((climb(b, way + [module]) for b in sorted(graph[module])), default=-1)
        return height[module]

    for module in sorted(graph):
        climb(module, [])
    return height


def reduced(graph):
    """Returns the arrows that do not follow from others."""
    reach = {}

    def below(module):
        if module not in reach:
            reach[module] = set(graph[module]).union(*(below(b) for b in graph[module]))
        return reach[module]

    return {module: {b for b in graph[module] if not any(b in below(o) for o in graph[module] if o != b)}
            for module in graph}


def places(graph, height):
    """Returns x and y of each module's upper left corner. Each level is a row, ordered so that arrows are short."""
    rows = collections.defaultdict(list)
    for module in sorted(graph, key=lambda r: (PROGRAMS.index(r.split("/")[0]) if r != "proto" else -1, r)):
        rows[height[module]].append(module)
    column = {}
    for level in sorted(rows):
        def middle(module):
            known = [column[b] for b in graph[module] if b in column]
            return sum(known) / len(known) if known else 0
        if level:
            rows[level].sort(key=lambda module: (module.startswith("master"), middle(module)))
        for i, module in enumerate(rows[level]):
            column[module] = i - (len(rows[level]) - 1) / 2
    width = max(len(row) for row in rows.values()) * (BOX[0] + GAP_X) - GAP_X + 2 * MARGIN
    top = max(rows)
    at = {module: (width / 2 + column[module] * (BOX[0] + GAP_X) - BOX[0] / 2,
                 MARGIN + (top - height[module]) * (BOX[1] + GAP_Y)) for module in graph}
    return at, width, 2 * MARGIN + (top + 1) * (BOX[1] + GAP_Y) - GAP_Y


def picture(graph):
    height_of = levels(graph)
    at, width, height = places(reduced(graph), height_of)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" '
           f'width="{width:.0f}" font-family="sans-serif" font-size="11">',
           '<rect width="100%" height="100%" fill="white"/>',
           '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="6" '
           'markerHeight="6" orient="auto"><path d="M0 0L8 4L0 8z" fill="#777"/></marker></defs>']
    for module, below in sorted(reduced(graph).items()):
        for other in sorted(below):
            (x1, y1), (x2, y2) = at[module], at[other]
            start, end = (x1 + BOX[0] / 2, y1 + BOX[1]), (x2 + BOX[0] / 2, y2 - 2)
            bend = (end[1] - start[1]) / 2
            out.append(f'<path d="M{start[0]:.0f} {start[1]:.0f}C{start[0]:.0f} {start[1] + bend:.0f} '
                       f'{end[0]:.0f} {end[1] - bend:.0f} {end[0]:.0f} {end[1]:.0f}" fill="none" '
                       'stroke="#999" marker-end="url(#tip)"/>')
    for module, (x, y) in sorted(at.items()):
        program, _, name = module.partition("/")
        out.append(f'<rect x="{x:.0f}" y="{y:.0f}" width="{BOX[0]}" height="{BOX[1]}" rx="4" '
                   f'fill="{COLOURS[program]}" stroke="#555"/>')
        middle = x + BOX[0] / 2
        if name:
            out.append(f'<text x="{middle:.0f}" y="{y + 13:.0f}" text-anchor="middle" fill="#777" '
                       f'font-size="9">{program}</text>')
        out.append(f'<text x="{middle:.0f}" y="{y + (26 if name else 21):.0f}" text-anchor="middle">'
                   f'{name or program}</text>')
    return "\n".join(out + ["</svg>", ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true")
    parser.add_argument("out", nargs="?", type=pathlib.Path,
                        default=ROOT / "deploy/readme/architecture.svg")
    arguments = parser.parse_args()
    drawn = picture(arrows())
    if not arguments.check:
        arguments.out.write_text(drawn)
        return 0
    if arguments.out.exists() and arguments.out.read_text() == drawn:
        return 0
    print(f"{arguments.out.relative_to(ROOT)} is out of date: run "
          "deploy/readme/make_architecture.py")
    return 1


if __name__ == "__main__":
    sys.exit(main())
