"""The comparison of measured with estimated forces of any source: `verify_forces`."""
from __future__ import annotations

import dataclasses
import json
import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from palpate import _core


@dataclasses.dataclass(frozen=True)
class Comparison:
    """Verdicts on delay, channels, drift, unit, scale, sign, frame, offset and sigma.

    passes  everything that was tested is right, and the magnitude was tested
    text    a table of the verdicts, and what is likely wrong; `print(comparison)` prints it
    report  the same as report.json of `palpate-slave verify --forces`. Its `cards` have one entry per fingertip, with
            `lines[key]["verdict"]`: right, wrong, not decided or not tested, and the interval of 95 % `low_value_high`
    """
    passes: bool
    text: str
    report: dict[str, Any]

    def __str__(self) -> str:
        return self.text

    @property
    def wrong(self) -> list[str]:
        """Keys of the lines that are wrong in any card: magnitude, unit, sign, frame, zero, delay, time, sigma, ..."""
        return sorted({key for card in self.report["cards"] for key, line in card["lines"].items() if line["verdict"] == "wrong"})

    @property
    def likely_wrong(self) -> list[str]:
        """Likely causes, one sentence each."""
        return [cause for card in self.report["cards"] for cause in card["likely_wrong"]]


def verify_forces(measured: ArrayLike, estimated: ArrayLike, t: ArrayLike | None = None, *, sigma: ArrayLike | None = None,
                  valid: ArrayLike | None = None, hold: ArrayLike | None = None, source: str = "arrays") -> Comparison:
    """Compares measured with estimated forces and says what is likely wrong with the estimate.

    measured   force of a sensor, or known loads, (n, 3) [N]; (n,): along z. NaN is unknown
    estimated  the same force as the source under test reports it, in the same frame and with the same sign
    t          times [s], (n,), which do not fall; or integers [ns]. None: rows without time; delay and drift are not tested
    sigma      standard deviation that the estimate states, (n,) [N]
    valid      whether the source calls the estimate valid, (n,)
    hold       number of the load that was held, (n,), from 0. None: a record, whose neighbouring rows share their errors

    Raises ValueError: shapes that differ, no axis with both forces, times that fall.
    Source: `palpate-slave verify --forces`, the same function.
    """
    forces = [_vectors(measured, "measured"), _vectors(estimated, "estimated")]
    count = len(forces[0])
    if len(forces[1]) != count:
        raise ValueError(f"estimated: {len(forces[1])} rows: expected {count}, as many as measured")
    if count == 0:
        raise ValueError("measured: no row: expected forces of shape (n, 3)")
    if not np.any(np.isfinite(forces[0]) & np.isfinite(forces[1])):
        raise ValueError("measured, estimated: no axis has both forces: expected numbers in the same column of both")
    times = None if t is None else _seconds(t, count)
    spread = _column(sigma, "sigma", count, np.float64)
    if spread is not None and np.any(spread < 0):
        raise ValueError("sigma: a negative number: expected 0 or more [N]")
    holds = _column(hold, "hold", count, np.int64)
    if holds is not None and np.any((holds < 0) | (holds > 10**9)):
        raise ValueError("hold: expected the number of a load, from 0")
    kept = _column(valid, "valid", count, np.int64)
    return of_report(*_core.compare_arrays(forces[0], forces[1], times, spread, holds, kept, str(source)))


def of_report(report: str, text: str, passes: bool) -> Comparison:
    return Comparison(passes, text, json.loads(report))


def verify_table(file: str | os.PathLike[str], **columns: str) -> Comparison:
    """Compares the forces of a CSV file.

    columns: names as the options of `palpate-slave verify --forces`: measured, estimated, time, sigma, validity;
    measured_unit, estimated_unit, time_unit. Raises ValueError with file and line.
    """
    request = _core.ForceColumns()
    for name, value in columns.items():
        if not hasattr(request, name):
            raise TypeError(f"verify_table: {name}: expected {', '.join(n for n in dir(request) if n[0] != '_')}")
        if not isinstance(value, str):
            raise ValueError(f"{name} = {value}: expected a text such as \"Fx,Fy,Fz\"")
        setattr(request, name, value)
    return of_report(*_core.compare_table(os.fspath(file), request))


def _vectors(values: ArrayLike, name: str) -> NDArray[np.float64]:
    try:
        force = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: expected numbers: {error}") from None
    if force.ndim == 1:
        force = np.column_stack([np.full((len(force), 2), np.nan), force])
    if force.ndim != 2 or force.shape[1] != 3:
        raise ValueError(f"{name}: shape {force.shape}: expected (n, 3), or (n,) along z [N]")
    if np.any(np.isinf(force)):
        raise ValueError(f"{name}: an infinite force: expected numbers, NaN where it is unknown")
    return force


def _column(values: ArrayLike | None, name: str, count: int, kind: type[np.generic]) -> Any:
    if values is None:
        return None
    given = np.asarray(values)
    if given.dtype.kind == "U":
        wanted = "booleans, validity == \"valid\"" if name == "valid" else "numbers"
        raise ValueError(f"{name}: texts such as {given.flat[0]}: expected {wanted}")
    if kind is np.int64 and given.dtype.kind == "f" and not np.all(given == np.round(given)):
        raise ValueError(f"{name}: expected whole numbers")
    try:
        column = given.astype(kind)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: expected numbers: {error}") from None
    if column.shape != (count,):
        raise ValueError(f"{name}: shape {column.shape}: expected ({count},)")
    return column


def _seconds(t: ArrayLike, count: int) -> NDArray[np.float64]:
    """Seconds since the first row; integers are nanoseconds."""
    times = np.asarray(t)
    if times.dtype.kind in "mM" and np.any(np.isnat(times)):
        raise ValueError("t: not a time (NaT): expected a time in every row")
    if times.dtype.kind in "mM":  # numpy.datetime64, timedelta64
        times = times.astype("datetime64[ns]" if times.dtype.kind == "M" else "timedelta64[ns]").astype(np.int64)
    if times.dtype.kind in "iu":
        times = 1e-9 * (times.astype(np.int64) - (int(times[0]) if times.size else 0))
    column: NDArray[np.float64] = _column(times, "t", count, np.float64)
    if not np.all(np.isfinite(column)):
        raise ValueError("t: a time that is not finite: expected seconds, or integers [ns]")
    falls = np.flatnonzero(np.diff(column) < 0)
    if falls.size:
        i = int(falls[0]) + 1
        raise ValueError(f"t[{i}] = {column[i]:g} s after {column[i - 1]:g} s: expected rows in order of time")
    return column
