#!/usr/bin/env python3
"""Draws the table of stability_map: draw.py STABILITY.csv OUT.svg

Stiffness at the operator over delay, sample rate and position scale, for two operators. Dashed lines: theoretical
limit, below which the loop is passive. Thin lines: the stiffness that the passivity control assumes. Needs
python3-matplotlib.
"""
import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
from matplotlib import colors, figure, patches

COLOURS = {"calm": "#b8dfc4", "damped": "#f3d38a", "restless": "#e58a8a"}
WORDS = {"calm": "stable", "damped": "stable, the passivity control takes energy out", "restless": "unstable"}


def main() -> int:
    source, out = map(pathlib.Path, sys.argv[1:])
    with source.open(newline="", encoding="utf-8") as text:
        rows = list(csv.DictReader(text))
    panels = list(dict.fromkeys((row["panel"], row["across"]) for row in rows))
    drawing = figure.Figure(figsize=(18, 9), layout="constrained")
    for axes, (panel, across) in zip(drawing.subplots(2, (len(panels) + 1) // 2).flat, panels):
        mine = [row for row in rows if (row["panel"], row["across"]) == (panel, across)]
        x, stiffness = (sorted({float(row[name]) for row in mine}) for name in ("x", "K"))
        outcome = {(float(row["x"]), float(row["K"])): list(COLOURS).index(row["outcome"]) for row in mine}
        axes.pcolormesh(x, stiffness, [[outcome[a, b] for a in x] for b in stiffness], shading="nearest", vmin=0, vmax=2,
                        cmap=colors.ListedColormap(list(COLOURS.values())))
        bound = {float(row["x"]): float(row["bound_K"]) for row in mine}
        axes.plot(x, [bound[a] for a in x], "k--", label=mine[0]["theory"])
        axes.axhline(float(mine[0]["counted_K"]), color="k", linewidth=0.7)
        axes.set(xscale="log", yscale="log", ylim=(min(stiffness), max(stiffness)), title=panel, xlabel=across,
                 ylabel="stiffness at the operator [N/m]")
        axes.legend(loc="upper right", fontsize="small")
    drawing.legend(handles=[patches.Patch(color=COLOURS[name], label=WORDS[name]) for name in COLOURS], loc="outside upper center", ncols=3)
    drawing.savefig(out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
