"""Material constants from tests: `identify`."""
from __future__ import annotations

import dataclasses
import json
import os
import pathlib
import re
import tempfile
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from palpate import _core
from palpate.model import ForceWarning

SIZES = ("diameter", "height", "area")
# Options of the command whose arguments have other names.
ARGUMENTS = {"from": "smallest", "to": "largest"}


@dataclasses.dataclass(frozen=True)
class Material:
    """Results of tests of a material.

    young_modulus  [Pa]: of presses or loads the modulus that fits them; of test tables the one at rest of the best law, or the
                   modulus that remains after a relaxation. NaN: none is proposed
    half_width     half of its 95 % interval [Pa]; of test tables for another specimen
    text           the results as sentences, with the lines for a scene; `print(material)` prints it
    report         the same as report.json of `palpate-slave identify`: laws, moduli, warnings, relaxation, press, loads
    """
    young_modulus: float
    half_width: float
    text: str
    report: dict[str, Any]

    def __str__(self) -> str:
        return self.text


def identify(*files: str | os.PathLike[str], scene: str | os.PathLike[str] | None = None, overrides: Sequence[str] = (),
             diameter: str = "", height: str = "", area: str = "", ends: str = "free", stress_unit: str = "", x: str = "",
             y: str = "", smallest: float = 0, largest: float | None = None, poisson_ratio: float = 0.5,
             fit_poisson: bool = False, width: float = 0, **tests: str | os.PathLike[str] | ArrayLike) -> Material:
    """Finds the constants of a material from tests.

        palpate.identify(compression="cylinder.csv", diameter="50mm", height="30mm")
        palpate.identify(uniaxial=numpy.column_stack([strain, stress]))       # [-], [Pa]
        palpate.identify(press="presses.csv", scene="cube.yaml")

    tests       KIND=FILE, a CSV table with units in its header, or KIND=array (n, 2), strain [-] and nominal stress [Pa].
                KIND: uniaxial, tension, compression, equibiaxial, planar, biaxial, shear; relaxation (an array (n, 3): time [s],
                strain, stress); press and loads (files only, with `scene`). `palpate-slave identify --help` lists the columns
    files       CSV tables that name the gradients F11, P11, ...; or "KIND=FILE" as on the command line, for several of one kind
    diameter, height, area   size of the specimen with unit, where a table has forces and displacements: "50mm", "400mm2"
    ends        "free", or "bonded" to the plates; then `poisson_ratio` counts
    smallest, largest        strains that are used [-]
    width       press: contact width of rows without one [m]

    Raises ValueError with file and line: units that contradict each other, no deformation, numbers that no soft solid has;
    RuntimeError: no fit. Warns (ForceWarning) of numbers that are hardly meant. Source: `palpate-slave identify`, the same function.
    """
    request = _core.IdentifyRequest()
    request.scene = "" if scene is None else os.fspath(scene)
    request.overrides = list(overrides)
    for name, value in (("diameter", diameter), ("height", height), ("area", area), ("ends", ends), ("stress_unit", stress_unit),
                        ("x", x), ("y", y)):
        if not isinstance(value, str):
            raise ValueError(f"{name} = {value}: expected a text" + (", with its unit: \"50 mm\"" if name in SIZES else ""))
        setattr(request, name, value)
    for name, number in (("smallest", smallest), ("largest", largest), ("poisson_ratio", poisson_ratio), ("width", width)):
        if name == "largest" and number is None:
            continue
        if isinstance(number, bool) or not isinstance(number, (int, float, np.integer, np.floating)):
            raise ValueError(f"{name} = {number}: expected a number")
        setattr(request, name, float(number))
    request.fit_poisson = fit_poisson
    if not (files or tests) or not all(isinstance(file, (str, os.PathLike)) for file in files):
        raise ValueError("identify: expected KIND=FILE or KIND=array, such as compression=\"cylinder.csv\"")
    with tempfile.TemporaryDirectory(prefix="palpate-") as folder:
        data = [os.fspath(file) for file in files]
        for kind, test in tests.items():
            data.append(f"{kind}={os.fspath(test) if isinstance(test, (str, os.PathLike)) else _table(kind, test, folder)}")
        request.data = data
        try:
            report_text, text = _core.identify(request)
        except ValueError as error:
            message = str(error).replace(f"{folder}{os.sep}", "")
            raise ValueError(re.sub(r"--([a-z-]+)", _argument_of, message)) from None
    report: dict[str, Any] = json.loads(report_text)
    young_modulus, half_width = _modulus(report)
    for remark in report["warnings"]:
        warnings.warn(remark, ForceWarning, stacklevel=2)
    return Material(young_modulus, half_width, text, report)


def _argument_of(option: re.Match[str]) -> str:
    return ARGUMENTS.get(option[1], option[1].replace("-", "_"))


def _table(kind: str, test: ArrayLike, folder: str) -> pathlib.Path:
    columns = {"relaxation": ["time (s)", "strain", "stress (Pa)"]}.get(kind, ["strain", "stress (Pa)"])
    try:
        rows = np.asarray(test, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{kind}: expected a file or numbers: {error}") from None
    if kind in ("press", "loads", "images"):
        raise ValueError(f"{kind}: expected the name of a CSV file")
    if rows.ndim != 2 or rows.shape[1] != len(columns):
        raise ValueError(f"{kind}: shape {rows.shape}: expected (n, {len(columns)}): {', '.join(columns)}")
    if not np.all(np.isfinite(rows)):
        raise ValueError(f"{kind}: a number that is not finite: expected {', '.join(columns)}")
    file = pathlib.Path(folder) / f"{kind}.csv"
    np.savetxt(file, rows, fmt="%.17g", delimiter=",", header=",".join(columns), comments="")
    return file


def _modulus(report: dict[str, Any]) -> tuple[float, float]:
    """The proposed modulus and half of its interval [Pa]."""
    for kind in ("press", "loads"):
        if kind in report:
            return report[kind]["young_modulus_Pa"], 1.96 * report[kind]["sigma_Pa"]
    for law in report["laws"]:
        if law["law"] == report.get("best", report.get("closest")):
            return law["young_modulus_Pa"], law["half_width_Pa"]
    if "relaxation" in report:
        return report["relaxation"]["young_modulus_held_Pa"], report["relaxation"]["half_width_Pa"]
    return float("nan"), float("nan")
