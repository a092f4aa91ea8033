"""Networks for the channels of any sensor: the force is quadratic in them, fitted by least squares (architecture
`qnn_N`)."""
from __future__ import annotations

import dataclasses
import math
from typing import Sequence

import numpy as np
import numpy.typing as npt

from palpate.training.channels import baselines_of, learn_channels
from palpate.training.errors import CONTACT_SHARE, ErrorLaw, ForceErrors, compare_forces, fit_law
from palpate.training.networks import QUIET_SIGNAL, Network
from palpate.training.recordings import (MAX_CONSTANT, Array, InputError, Recording, Sensor, Stretch, find_contacts)

MIN_SIZE = 0.1  # added to the size of the channels, see FORMAT.md
# Ridge parameters relative to the mean square of a feature. With smaller ones the fit to one day fails on the next.
RIDGES = (1e-3, 3e-3, 1e-2)
PARTS = 5  # parts of the contacts; each part is estimated by a fit to the others
MIN_CONTACTS = 3
COVERED = ((1, 0.6827), (2, 0.9545))  # sigmas and the share of errors within them
MIN_NOISE = 2e-3  # smallest noise, relative to the rms of the channels
CONSTANT = 3  # a channel that is constant for this many times the longest recorded constant time counts as dead
MIN_CONSTANT = 5  # samples


def features(x: Array) -> Array:
    """Returns n x 3 N features of scaled channels x (n x N): x, x times the size of the sample, x squared."""
    size = np.sqrt((x**2).mean(axis=1, keepdims=True) + MIN_SIZE**2)
    return np.concatenate([x, x * size, x * x], axis=1)


@dataclasses.dataclass
class Samples:
    change: Array  # n x N
    force: Array  # n x 3 [N]
    age: Array  # n: since the baseline [s]
    part: npt.NDArray[np.int64]  # 0 to PARTS - 1


def samples_of(recordings: Sequence[Recording]) -> Samples:
    """Assigns every fifth contact to a part, or with five recordings or more every fifth recording."""
    contacts = find_contacts(recordings)
    if len(contacts) < MIN_CONTACTS:
        raise InputError(f"{len(contacts)} contacts: expected {MIN_CONTACTS} or more")
    by_recording = len({c.recording for c in contacts}) >= PARTS
    count = len(recordings) if by_recording else len(contacts)

    def part(k: int, contact: Stretch) -> int:
        return (contact.recording if by_recording else k) * PARTS // count

    rows = [(recordings[c.recording], c.begin, c.end, part(k, c)) for k, c in enumerate(contacts)]
    return Samples(np.concatenate([r.change[a:b] for r, a, b, _ in rows]), np.concatenate([r.force[a:b] for r, a, b, _ in rows]),
                   np.concatenate([r.t[a:b] - r.baseline_time for r, a, b, _ in rows]),
                   np.concatenate([np.full(b - a, p) for _, a, b, p in rows]))


class Squares:
    """Normal equations of the least-squares fit, one set per part."""

    def __init__(self, x: Array, force: Array, part: npt.NDArray[np.int64]) -> None:
        self.scale = np.sqrt((x**2).mean(axis=0))
        self.scale[self.scale == 0] = 1
        own = [(x[part == p] / self.scale, force[part == p]) for p in range(PARTS)]
        self.matrices = [a.T @ a for a, _ in own]
        self.sides = [a.T @ b for a, b in own]
        self.counts = [len(a) for a, _ in own]

    def solve(self, ridge: float, without: int = -1) -> Array:
        used = [p for p in range(PARTS) if p != without]
        count = sum(self.counts[p] for p in used)
        matrix = sum(self.matrices[p] for p in used) + ridge * count * np.eye(len(self.scale))
        solution: Array = np.linalg.solve(matrix, sum(self.sides[p] for p in used)) / self.scale[:, None]
        return solution


def errors_of(estimated: Array, measured: Array) -> ForceErrors:
    """Compares as compare_forces does, and enlarges the error law: sigma = sqrt(rest^2 + law^2) covers 68 % of the
    errors or more, and twice that 95 %."""
    errors = compare_forces(estimated, measured)
    size = np.linalg.norm(measured, axis=1)
    square = ((estimated - measured)**2).sum(axis=1)
    touches = size > CONTACT_SHARE * size.max()
    rest = 0.0
    if not touches.all():
        rest = max(math.sqrt(np.quantile(square[~touches] / k**2, share)) for k, share in COVERED)
    law = fit_law(square[touches], size[touches])
    if law != ErrorLaw():
        height2 = max(float(np.quantile(np.maximum(square[touches] / k**2 - rest**2, 0) / law.at(size[touches])**2, share))
                      for k, share in COVERED)
        law = ErrorLaw(law.growing * height2, law.relative * math.sqrt(height2))
    return dataclasses.replace(errors, at_rest=rest, law=law)


def drift_of(estimated: Array, measured: Array, age: Array) -> float:
    """Returns the error without contact per time since the baseline [N/s], assuming that it keeps growing at this
    rate."""
    size = np.linalg.norm(measured, axis=1)
    rest = (size <= CONTACT_SHARE * size.max()) & (age > 0)
    square = ((estimated - measured)[rest]**2).sum()
    return math.sqrt(square / (age[rest]**2).sum()) if rest.any() else 0.0


def noise_of(recordings: Sequence[Recording], scale: Array) -> float:
    """Returns the median over the channels of the rms change from sample to sample without contact."""
    largest = max(float(np.linalg.norm(r.force, axis=1).max()) for r in recordings)
    steps = [np.diff(r.change, axis=0)[(np.linalg.norm(r.force, axis=1) < CONTACT_SHARE * largest)[1:]] for r in recordings]
    return float(max(np.median(np.sqrt((np.concatenate(steps)**2).mean(axis=0) / 2)), MIN_NOISE * np.sqrt((scale**2).mean())))


def train(recordings: Sequence[Recording], test: Sequence[Recording], sensor: Sensor) -> tuple[Network, ForceErrors, float]:
    """Returns the network, its errors on `test` (if empty, on contacts that were left out of the fit) and the chosen
    ridge."""
    samples = samples_of(recordings)
    rms = np.sqrt((samples.change**2).mean(axis=0))
    if not rms.max() > 0:
        raise InputError("the channels are constant in all training samples")
    scale = np.maximum(rms, QUIET_SIGNAL * np.sqrt((rms**2).mean()))
    x = features(samples.change / scale)
    squares = Squares(x, samples.force, samples.part)

    def unseen(ridge: float) -> Array:
        estimated = np.empty_like(samples.force)
        for p in range(PARTS):
            estimated[samples.part == p] = x[samples.part == p] @ squares.solve(ridge, p)
        return estimated

    ridge = min(RIDGES, key=lambda each: float(((unseen(each) - samples.force)**2).sum()))
    kernel = squares.solve(ridge)
    if test:
        estimated = np.concatenate([features(r.change[r.begin:r.end] / scale) @ kernel for r in test])
        measured = np.concatenate([r.force[r.begin:r.end] for r in test])
        age = np.concatenate([r.t[r.begin:r.end] - r.baseline_time for r in test])
    else:
        estimated, measured, age = unseen(ridge), samples.force, samples.age
    errors = errors_of(estimated, measured)
    size = np.linalg.norm(samples.force, axis=1)
    noise = noise_of(recordings, scale)
    pattern = learn_channels(recordings, samples.change, size <= CONTACT_SHARE * size.max(), samples.part, noise)
    pattern.set_baselines(baselines_of(recordings), lambda x: features(x / scale) @ kernel)
    channels, constant = len(scale), max(r.constant for r in recordings)
    network = Network(f"qnn_{channels}", channels, 1, 3, np.zeros(channels), scale, np.zeros(3), np.ones(3), [],
                      [(kernel, np.zeros(3))], rate=sensor.rate, sigma=errors.rmse, rest_sigma=errors.at_rest, law=errors.law,
                      learnt_force=float(np.linalg.norm(samples.force, axis=1).max()), unit=sensor.unit,
                      noise=noise, drift=drift_of(estimated, measured, age), channels=pattern,
                      longest_constant=max(CONSTANT * constant, MIN_CONSTANT / sensor.rate) if constant < MAX_CONSTANT else 0.0)
    return network, errors, ridge
