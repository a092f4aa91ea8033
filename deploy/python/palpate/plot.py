"""Draws a table of Palpate: python3 -m palpate.plot FILE.csv... [--out FILE.svg]

The table's header determines the plot. Needs python3-matplotlib. The ending of --out is the format (.svg, .png, .pdf).

  study.csv                    error of the contact force over update time, one colour for each model family. Several
                               files give one picture and print a table of the families
  states.csv                   force and one standard deviation over time; states that are not valid are grey
  log.csv, ticks.csv           forces of the master over time
  measured_f*, estimated_f*    estimated over measured force, and the error over time (the table of `verify --forces`)
"""
from __future__ import annotations

import argparse
import csv
import pathlib
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.formats import what_is

Table = dict[str, list[str]]
Numbers = NDArray[np.float64]
AXES = "xyz"


def read(file: pathlib.Path) -> Table:
    """Reads the columns of a CSV file. Raises ValueError: no header, or a row of another length."""
    if foreign := what_is(file):
        raise ValueError(f"{file}: {foreign}: expected a CSV file")
    try:
        with file.open(newline="", encoding="utf-8-sig") as text:
            rows = list(csv.reader(text))
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"{file}: {error}: expected a CSV file") from error
    if not rows or not rows[0]:
        raise ValueError(f"{file}: expected a CSV file with a header")
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(rows[0]):
            raise ValueError(f"{file}:{number}: {len(row)} cells: expected {len(rows[0])}")
    return {name.strip(): [row[i] for row in rows[1:]] for i, name in enumerate(rows[0])}


def numbers(table: Table, name: str) -> Numbers:
    """A column as numbers. Empty cells are NaN. Raises ValueError naming the column."""
    try:
        return np.array([float(cell) if cell.strip() else np.nan for cell in table[name]])
    except ValueError as error:
        raise ValueError(f"column {name}: {error}") from None


def vectors(table: Table, names: list[str]) -> Numbers:
    """Rows x 3 from three columns."""
    return np.stack([numbers(table, name) for name in names], axis=1)


def draw(table: Table, figure: Any) -> None:
    """Draws `table` into a matplotlib figure. Raises ValueError: no table of Palpate, or nothing to draw."""
    names = set(table)
    if {"family", "update_median_s", "error"} <= names:
        _study(table, figure)
    elif any(name.startswith("measured_f") for name in names) and any(name.startswith("estimated_f") for name in names):
        _pairs(table, figure)
    elif {"t", "fx", "fy", "fz"} <= names:
        _states(table, figure)
    elif {"t", "sent_x", "sent_y", "sent_z"} <= names:
        _ticks(table, figure, ("true", "estimated", "local", "sent"), "_")
    elif {"t", "force_x"} <= names:
        _ticks(table, figure, ("estimated", "force"), "_")
    else:
        raise ValueError(f"the columns {', '.join(sorted(names))}: expected study.csv, states.csv, log.csv, ticks.csv, "
                         "or columns measured_fx ... estimated_fz")


def _study(table: Table, figure: Any) -> None:
    time, error = 1e6 * numbers(table, "update_median_s"), 100 * numbers(table, "error")
    bar = 100 * numbers(table, "error_bar") if "error_bar" in table else np.zeros_like(error)
    known = np.isfinite(time) & np.isfinite(error) & (time > 0) & (error > 0)
    if not known.any():
        raise ValueError("no row has an update time and an error")
    axes = figure.subplots()
    family = np.array(table["family"])
    is_single = len(set(table.get("file", ()))) < 2
    for name, color in zip(dict.fromkeys(family[known]), _colors()):
        rows = known & (family == name)
        below = np.minimum(np.nan_to_num(bar[rows]), 0.99 * error[rows])
        bars = [below, np.nan_to_num(bar[rows])] if is_single else None
        axes.errorbar(time[rows], error[rows], bars, fmt="o", markersize=5 if is_single else 3, alpha=0.75, label=name, color=color)
    if is_single and "on_front" in table:
        front = known & (numbers(table, "on_front") == 1)
        order = np.argsort(time[front])
        axes.plot(time[front][order], error[front][order], "--", color="grey", label="no model is better in both")
    if is_single and "recommended" in table:
        chosen = known & (numbers(table, "recommended") == 1)
        axes.plot(time[chosen], error[chosen], "o", markersize=13, fillstyle="none", color="crimson", label="recommended")
    axes.set(xscale="log", yscale="log", xlabel="update time, median [us]", ylabel="largest error of the contact force [%]")
    axes.legend(fontsize="small")


def _colors() -> Any:
    from matplotlib import colormaps
    return colormaps["tab20"].colors


def joined(files: list[pathlib.Path]) -> Table:
    """The tables of several studies as one, with the column `file`. Raises ValueError: another table, or other columns."""
    whole: Table = {}
    for file in files:
        table = read(file)
        if not {"family", "update_median_s", "error", "on_front"} <= set(table) or (whole and set(whole) != {*table, "file"}):
            raise ValueError(f"{file}: expected files of `study`, all with the same columns")
        table["file"] = [str(file)] * len(table["family"])
        for name, column in table.items():
            whole.setdefault(name, []).extend(column)
    return whole


def summary(table: Table) -> str:
    """The table of the families over several studies, as Markdown: median and 90th percentile of the rows that answered."""
    error, update, start = 100 * numbers(table, "error"), 1e6 * numbers(table, "update_median_s"), 1e3 * numbers(table, "precompute_s")
    family, front, files = np.array(table["family"]), numbers(table, "on_front"), np.array(table["file"])
    lines = ["| model | scenes | rows | error [%] | update [us] | precompute [ms] | on the front |", "|---|---|---|---|---|---|---|"]
    for name in dict.fromkeys(family):
        rows = (family == name) & np.isfinite(error) & np.isfinite(update)
        if not rows.any():
            continue
        halves = (" / ".join(f"{value:.2g}" if value < 100 else f"{value:.0f}" for value in np.percentile(column[rows], [50, 90]))
                  for column in (error, update, start))
        lines.append(f"| {name} | {len(set(files[rows]))} | {rows.sum()} | {' | '.join(halves)} | {100 * front[rows].mean():.0f} % |")
    return "\n".join(lines)


def _states(table: Table, figure: Any) -> None:
    force = np.linalg.norm(vectors(table, ["fx", "fy", "fz"]), axis=1)
    t = numbers(table, "t")
    axes = figure.subplots()
    fingers = np.array(table["finger"]) if "finger" in table else np.full(len(t), "")
    valid = np.array(table["validity"]) == "valid" if "validity" in table else np.ones(len(t), bool)
    sigma = numbers(table, "sigma") if "sigma" in table else np.full(len(t), np.nan)
    for finger in dict.fromkeys(fingers):
        rows = fingers == finger
        line, = axes.plot(t[rows], np.where(valid, force, np.nan)[rows], label=f"valid {finger}".strip())
        axes.fill_between(t[rows], *(np.where(valid, force + sign * sigma, np.nan)[rows] for sign in (-1, 1)),
                          color=line.get_color(), alpha=0.25, linewidth=0)
    axes.plot(t[~valid], force[~valid], ".", color="grey", label="not valid")
    axes.set(xlabel="time [s]", ylabel="size of the force, with one standard deviation [N]")
    axes.legend(fontsize="small")


def _ticks(table: Table, figure: Any, forces: tuple[str, ...], joint: str) -> None:
    axes = figure.subplots()
    for name in forces:
        columns = [f"{name}{joint}{axis}" for axis in AXES]
        if set(columns) <= set(table):
            axes.plot(numbers(table, "t"), np.linalg.norm(vectors(table, columns), axis=1), linewidth=1, label=name)
    axes.set(xlabel="time [s]", ylabel="size of the force [N]")
    axes.legend(fontsize="small")


def _pairs(table: Table, figure: Any) -> None:
    axes_of = [axis for axis in AXES if {f"measured_f{axis}", f"estimated_f{axis}"} <= set(table)]
    if not axes_of:
        raise ValueError("no axis has both measured_f and estimated_f")
    above, below = figure.subfigures(2, 1)
    squares = np.zeros(len(next(iter(table.values()))))
    for panel, axis in zip(np.atleast_1d(above.subplots(1, len(axes_of))), axes_of):
        measured, estimated = numbers(table, f"measured_f{axis}"), numbers(table, f"estimated_f{axis}")
        squares += (estimated - measured) ** 2
        panel.plot(measured, estimated, ".", markersize=3)
        ends = [np.nanmin([measured, estimated]), np.nanmax([measured, estimated])]
        panel.plot(ends, ends, "--", color="grey")
        panel.set(xlabel=f"measured force {axis} [N]", ylabel=f"estimated force {axis} [N]")
    error = below.subplots()
    has_time = "t" in table
    error.plot(numbers(table, "t") if has_time else np.arange(len(squares)), np.sqrt(squares), ".", markersize=3)
    error.set(xlabel="time [s]" if has_time else "row", ylabel="size of the error [N]")


def main() -> int:
    parser = argparse.ArgumentParser(prog="palpate.plot", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", type=pathlib.Path, nargs="+", metavar="FILE.csv", help="several: of `study`")
    parser.add_argument("--out", type=pathlib.Path, metavar="FILE.svg", help="default: FILE.svg beside FILE.csv")
    options = parser.parse_args()
    try:
        import matplotlib
    except ImportError:
        print("palpate.plot: needs matplotlib: apt-get install python3-matplotlib", file=sys.stderr)
        return 2
    matplotlib.use("Agg")
    from matplotlib import figure as figures
    out = options.out or options.files[0].with_suffix(".svg")
    try:
        figure = figures.Figure(figsize=(9, 6), layout="constrained")
        is_single = len(options.files) == 1
        table = read(options.files[0]) if is_single else joined(options.files)
        draw(table, figure)
        figure.suptitle(options.files[0].name if is_single else f"{len(options.files)} studies")
        figure.savefig(out)
    except (OSError, ValueError) as error:
        print(f"palpate.plot: {error}", file=sys.stderr)
        return 2
    if not is_single:
        print(summary(table))
    print(out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
