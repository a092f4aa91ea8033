"""Ranges and correlations of a sensor's channels, which the slave's checks use (key `channels` of network.json)."""
from __future__ import annotations

import dataclasses
from typing import Callable, Sequence

import numpy as np
import numpy.typing as npt

from palpate.training.recordings import Array, Recording

NOISES = 6  # noise alone does not exceed this many rms of a residual without contact
MARGIN = 1.5  # factor on the largest recorded values, because other contacts may exceed them
MIN_BASELINES = 2


@dataclasses.dataclass
class ChannelPattern:
    """Values are in the unit of the channels and include the margins."""
    expectation: Array  # N x N: the best linear prediction of each channel from the others
    tolerance: Array
    relative_tolerance: Array  # relative to the rms of the other channels [-]
    below: Array
    above: Array
    second_difference: Array
    baseline: Array = dataclasses.field(default_factory=lambda: np.zeros(0))  # mean baseline; empty: there are too few
    baseline_force: float = 0.0  # largest force that the network estimates for one of the baselines [N]

    def arrays(self) -> dict[str, Array]:
        return {key: getattr(self, key) for key in ("expectation", "tolerance", "relative_tolerance", "below", "above",
                                                    "second_difference")}

    def set_baselines(self, baselines: Array, force_of: Callable[[Array], Array]) -> None:
        if len(baselines) < MIN_BASELINES:
            return
        self.baseline = baselines.mean(axis=0)
        self.baseline_force = float(np.linalg.norm(force_of(baselines - self.baseline), axis=1).max())


def baselines_of(recordings: Sequence[Recording]) -> Array:
    """Returns one baseline per file, n x N."""
    return np.stack(list({r.file.resolve(): r.baseline for r in recordings}.values()))


def _expectation(x: Array, noise: float) -> Array:
    precision = np.linalg.inv(x.T @ x / len(x) + noise**2 * np.eye(x.shape[1]))
    expectation: Array = -precision / np.diag(precision)[:, None]
    np.fill_diagonal(expectation, 0)
    return expectation


def learn_channels(recordings: Sequence[Recording], x: Array, at_rest: npt.NDArray[np.bool_], part: npt.NDArray[np.int64],
                   noise: float) -> ChannelPattern:
    """`x`: changes of the channels in contact, n x N. Each sample belongs to a `part`; its residual is that of a
    prediction learnt from the other parts."""
    residual = np.empty_like(x)
    for p in np.unique(part):
        own = part == p
        residual[own] = x[own] - x[own] @ _expectation(x[~own], noise).T
    count = x.shape[1]
    others = np.sqrt(((x**2).sum(axis=1, keepdims=True) - x**2) / max(count - 1, 1))
    rest = at_rest if at_rest.any() else np.ones(len(x), bool)

    def rms(values: Array) -> Array:
        floored: Array = np.maximum(np.sqrt((values**2).mean(axis=0)), noise)
        return floored

    tolerance = np.maximum(NOISES * rms(residual[rest]), MARGIN * np.abs(residual[rest]).max(axis=0))
    excess = np.sqrt(np.maximum(residual**2 - tolerance**2, 0))
    quiet = NOISES * rms(x[rest])
    second = np.stack([np.abs(np.diff(r.change, n=2, axis=0)).max(axis=0, initial=0) for r in recordings]).max(axis=0)
    return ChannelPattern(_expectation(x, noise), tolerance, MARGIN * (excess / np.maximum(others, noise)).max(axis=0),
                          MARGIN * np.maximum(-x.min(axis=0), 0) + quiet, MARGIN * np.maximum(x.max(axis=0), 0) + quiet,
                          MARGIN * second + NOISES * noise)
