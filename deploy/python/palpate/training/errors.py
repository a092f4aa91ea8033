"""Errors of force estimates against measured forces (paper B, table I)."""
from __future__ import annotations

import dataclasses
import math

import numpy as np

from palpate.training.recordings import Array

CONTACT_SHARE = 0.02  # contact: force above this share of the largest one
WITHIN = 0.6827  # share of the errors within one sigma
SAME_SIZES = 1e-6  # relative spread below which all forces count as equal


@dataclasses.dataclass(frozen=True)
class ErrorLaw:
    """68 % of the errors are at most sqrt(growing |f| + relative^2 |f|^2). Both 0: not known."""
    growing: float = 0.0  # [N]
    relative: float = 0.0  # [-]

    def at(self, size: Array) -> Array:
        """Returns one sigma for forces of this magnitude [N]."""
        return np.sqrt(self.growing * size + self.relative**2 * size**2)


def fit_law(square: Array, size: Array) -> ErrorLaw:
    """`square`: squared errors [N^2], `size`: magnitudes of the forces [N], > 0. Errors that are not finite are not used.

    The ratio of the two terms follows from the mean squares relative to |f| and to |f|^2. The law is then scaled so
    that it contains the share WITHIN of the errors.
    """
    used = np.isfinite(square)
    square, size = square[used], size[used]
    n = len(size)
    if n == 0:
        return ErrorLaw()
    sizes, inverses = size.sum(), (1 / size).sum()
    by_size, by_size2 = (square / size).sum(), (square / size**2).sum()
    spread = sizes * inverses - n * n
    law = ErrorLaw(0.0, math.sqrt(by_size2 / n))
    if spread > SAME_SIZES * n * n:
        growing = (sizes * by_size2 - n * by_size) / spread
        relative2 = (inverses * by_size - n * by_size2) / spread
        if growing > 0:
            law = ErrorLaw(growing, math.sqrt(relative2)) if relative2 > 0 else ErrorLaw(by_size / n, 0.0)
    if law == ErrorLaw():
        return law
    height = float(np.partition(np.sqrt(square) / law.at(size), int(WITHIN * n))[int(WITHIN * n)])
    return ErrorLaw(law.growing * height**2, law.relative * height)


@dataclasses.dataclass(frozen=True)
class ForceErrors:
    """Errors per axis, frame F. NaN: not known."""
    count: int
    rmse: Array  # [N]
    smse: Array  # mean squared error / variance of the measured values
    correlation: Array
    peak: Array  # largest |measured| [N]
    at_peak: Array  # |error| at that sample [N]
    worst: Array  # largest |error| [N]
    at_rest: float  # rms of the error vector where the force is zero [N]; 0: no such sample
    law: ErrorLaw

    def along_normal(self) -> str:
        share = 100 * self.at_peak[2] / self.peak[2] if self.peak[2] > 0 else 0.0
        return (f"fz: RMSE {1e3 * self.rmse[2]:.1f} mN, SMSE {cell(self.smse[2])}, correlation {cell(self.correlation[2])}, "
                f"peak {self.peak[2]:.3f} N with an error of {1e3 * self.at_peak[2]:.1f} mN ({share:.1f} %), "
                f"largest error {1e3 * self.worst[2]:.1f} mN, {self.count} samples")


def cell(value: float, width: int = 0, decimals: int = 4) -> str:
    return f"{value:>{width}.{decimals}f}" if math.isfinite(value) else f"{'-':>{width}}"


def compare_forces(estimated: Array, measured: Array) -> ForceErrors:
    """`estimated`, `measured`: n x 3 [N], n > 0."""
    error = estimated - measured
    mse = (error**2).mean(axis=0)
    variance = measured.var(axis=0)
    spread = np.sqrt(estimated.var(axis=0) * variance)
    product = ((estimated - estimated.mean(axis=0)) * (measured - measured.mean(axis=0))).mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        smse = np.where(variance > 0, mse / variance, math.nan)
        correlation = np.where(spread > 0, product / spread, math.nan)
    at = np.abs(measured).argmax(axis=0)
    axes = np.arange(3)
    size = np.linalg.norm(measured, axis=1)
    square = (error**2).sum(axis=1)
    rest = square[size == 0]
    contact = size > CONTACT_SHARE * size.max()
    return ForceErrors(len(measured), np.sqrt(mse), smse, correlation, np.abs(measured[at, axes]), np.abs(error[at, axes]),
                       np.abs(error).max(axis=0), math.sqrt(rest.mean()) if len(rest) else 0.0,
                       fit_law(square[contact], size[contact]))


def force_table(tested: list[tuple[str, ForceErrors]]) -> str:
    """Formats the errors as table I of the paper."""
    table = ("                 RMSE [mN]                     SMSE\n"
             "              fx       fy       fz        fx       fy       fz\n")
    for name, errors in tested:
        table += f"{name:<8}" + "".join(cell(1e3 * value, 9, 2) for value in errors.rmse) + " "
        table += "".join(cell(value, 9, 4) for value in errors.smse) + "\n"
    return table
