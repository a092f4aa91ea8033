"""Correlation of a fingertip's signals in contact, by kinds of contact (key `pattern` of network.json)."""
from __future__ import annotations

import dataclasses
from typing import Sequence

import numpy as np
import numpy.typing as npt

from palpate.training.errors import ErrorLaw, fit_law
from palpate.training.recordings import Array, Recording, Windows, last_samples

USED = [*range(19), 20]  # E1 to E19 and pdc; pac0 is the rate of pdc and depends on the past
NOISE2 = np.array([0.85] * 19 + [1.6])  # usual variance of the signals without contact: five real fingers [counts^2]

MIN_SIZE = 30.0  # signals below it are noise [counts]
MIN_SIZE_KIND = 10.0  # size of the gentlest contact when its kind is determined [counts]
MIN_FORCE, MAX_FORCE = 0.02, 3.0  # range of the forces from which the pattern is learnt [N]
KINDS = 40
MIN_SAMPLES = 100 * len(USED)  # samples per kind
MAX_SAMPLES = 200_000  # samples used
BY_DIRECTION, BY_LIKELIHOOD = 12, 8  # rounds
FLOOR = 2e-5  # smallest variance, relative to that of unit signals
RIDGE = 1e-6
INFORMATIVE = 500  # samples that determine the error of a kind


@dataclasses.dataclass
class Kind:
    share: float
    shape: Array  # 20 x 20: mean of x x' / x'x
    law: ErrorLaw = ErrorLaw()


@dataclasses.dataclass
class Pattern:
    kinds: list[Kind]
    force: Array  # 3 x 20: force of small signals by least squares [N/count]


def _kinds(x: Array, kind: npt.NDArray[np.int64], count: int) -> list[Kind]:
    found = []
    for k in range(count):
        own = x[kind == k]
        shape = own.T @ own / max(len(own), 1) + FLOOR * np.eye(len(USED))
        found.append(Kind(len(own) / len(x), shape))
    return found


def _likelihood_cost(x: Array, kinds: Sequence[Kind]) -> Array:
    costs = np.full((len(x), len(kinds)), np.inf)
    for k, kind in enumerate(kinds):
        if kind.share > 0:
            costs[:, k] = (x * np.linalg.solve(kind.shape, x.T).T).sum(axis=1)
            costs[:, k] += np.linalg.slogdet(kind.shape)[1] - 2 * np.log(kind.share)
    return costs


def learn_pattern(recordings: Sequence[Recording], windows: Windows) -> Pattern | None:
    """Learns the pattern from the last samples of `windows`. None: fewer samples than a hundred times the number of
    signals."""
    signals, forces = last_samples(recordings, windows[::len(windows) // MAX_SAMPLES + 1])
    signals = signals[:, USED]
    size, length = np.linalg.norm(forces, axis=1), np.linalg.norm(signals, axis=1)
    used = (size > MIN_FORCE) & (size < MAX_FORCE) & (length > MIN_SIZE)
    signals, forces, size, length = signals[used], forces[used], size[used], length[used]
    count = min(KINDS, len(signals) // MIN_SAMPLES)
    if count == 0:
        return None
    weighted = signals / size[:, None]
    normal = weighted.T @ weighted
    normal += RIDGE * np.trace(normal) * np.eye(len(USED))
    force = np.linalg.solve(normal, weighted.T @ (forces / size[:, None])).T

    x = signals / length[:, None]
    directions = x[np.arange(count) * len(x) // count]
    for _ in range(BY_DIRECTION):
        kind = np.abs(x @ directions.T).argmax(axis=1)
        directions = np.stack([np.linalg.eigh(k.shape)[1][:, -1] for k in _kinds(x, kind, count)])
    for _ in range(BY_LIKELIHOOD):
        kind = _likelihood_cost(x, _kinds(x, kind, count)).argmin(axis=1)
    return Pattern([k for k in _kinds(x, kind, count) if k.share > 0], force)


def learn_errors(pattern: Pattern, recordings: Sequence[Recording], windows: Windows, estimated: Array,
                 measured: Array) -> None:
    """Sets the error law of each kind from windows that were not used for training."""
    signals = last_samples(recordings, windows)[0][:, USED]
    size = np.linalg.norm(measured, axis=1)
    in_contact = size > MIN_FORCE
    size2 = np.maximum((signals**2).sum(axis=1) - NOISE2.sum(), MIN_SIZE_KIND**2)
    costs = np.empty((len(signals), len(pattern.kinds)))
    for k, kind in enumerate(pattern.kinds):
        # Computes determinant and inverse of size2 shape + noise in the basis that diagonalises shape relative to the
        # noise.
        scale = 1 / np.sqrt(NOISE2)
        values, vectors = np.linalg.eigh(kind.shape * np.outer(scale, scale))
        variance = size2[:, None] * values + 1
        costs[:, k] = ((signals * scale @ vectors)**2 / variance + np.log(variance)).sum(axis=1) - 2 * np.log(kind.share)
    kind_of = costs.argmin(axis=1)
    square = ((estimated - measured)**2).sum(axis=1)
    for k, kind in enumerate(pattern.kinds):
        own = in_contact & (kind_of == k) & np.isfinite(square)
        if own.sum() >= INFORMATIVE:
            kind.law = fit_law(square[own], size[own])
