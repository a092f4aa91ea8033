"""Disturbances of the readings of fingertips. Each function takes the severity and returns a function of a moment and the readings of
all fingers, which it changes. Electrodes count from 0."""
import math

import numpy as np

from alter.engine import Engine
from alter.moment import AT_REST, PRESSED, has_begun

NOISE = 0.87  # of a simulated electrode, one sigma [counts]
ELECTRODES = 19


def of_each(change):
    """Applies `change` to the reading of every finger that is present."""
    def touch(moment, fingers):
        for number, reading in enumerate(fingers):
            if reading["present"]:
                change(moment, number, reading)
    return touch


def of_first(change):
    return lambda moment, fingers: change(moment, fingers[0])


def single(x):
    """Rounds to the precision of the readings."""
    return float(np.float32(x))


class Rest(dict):
    """The reading of each finger in the first sample of a run, which gives the rest values."""

    def of(self, moment, finger, reading):
        if moment.index == 0 or finger not in self:
            self[finger] = {"channels": list(reading["channels"]), "pdc": reading["pdc"]}
        return self[finger]


def amplified(factor):
    """Multiplies the distance of electrodes and pressure from their values at rest by factor(moment)."""
    rest = Rest()

    def change(moment, finger, reading):
        first, gain = rest.of(moment, finger, reading), single(factor(moment))
        reading["channels"] = [single(zero + gain * (x - zero)) for x, zero in zip(reading["channels"], first["channels"])]
        reading["pdc"] = single(first["pdc"] + gain * (reading["pdc"] - first["pdc"]))
    return of_each(change)


def each_electrode(new):
    """Electrodes as new(moment, electrode, distance) makes them of their distance from rest [counts]."""
    rest = Rest()

    def change(moment, finger, reading):
        first = rest.of(moment, finger, reading)["channels"]
        reading["channels"] = [single(zero + new(moment, e, x - zero)) for e, (x, zero) in enumerate(zip(reading["channels"], first))]
    return of_each(change)


def stuck(electrodes, when):
    """From `when` on, the electrodes keep their last value."""
    held = []

    def change(moment, reading):
        if not has_begun(when, moment) or moment.index == 0:
            held[:] = reading["channels"]
        for e in electrodes:
            reading["channels"][e] = held[e]
    return of_first(change)


def reads(electrode, value):
    def change(moment, reading):
        if has_begun(AT_REST, moment):
            reading["channels"][electrode] = value
    return of_first(change)


def reordered(order, when=None):
    """Electrodes in another order, from `when` on of the first finger alone."""
    def change(moment, reading):
        if when is None or has_begun(when, moment):
            reading["channels"] = [reading["channels"][e] for e in order]
    return of_each(lambda moment, _, reading: change(moment, reading)) if when is None else of_first(change)


def swap(a, b):
    order = list(range(ELECTRODES))
    order[a], order[b] = b, a
    return order


def noise(times, first=False):
    """So many times the noise of an electrode. `first`: in the first finger alone, not in its pressure."""
    sigma = NOISE * math.sqrt(times * times - 1)

    def change(moment, finger, reading):
        random = Engine(moment.index if first else 1000 * moment.index + finger)
        reading["channels"] = [single(x + single(random.normal(sigma))) for x in reading["channels"]]
        if not first:
            reading["pdc"] = single(reading["pdc"] + single(random.normal(sigma)))
    return of_first(lambda moment, reading: change(moment, 0, reading)) if first else of_each(change)


def rest_drifts(counts):
    def change(moment, finger, reading):
        signs = [-1 if (e * 7 + finger) % 3 == 0 else 1 for e in range(ELECTRODES)]
        reading["channels"] = [single(x + single(sign * counts * moment.share)) for x, sign in zip(reading["channels"], signs)]
    return of_each(change)


def warms_up(counts):
    def change(moment, _, reading):
        warm = single(counts * (1 - math.exp(-3 * moment.share)))
        reading["channels"] = [single(x - warm) for x in reading["channels"]]
        reading["pdc"] = single(reading["pdc"] + 0.5 * warm)
    return of_each(change)


def pressure_stuck():
    held = [0.0]

    def change(moment, reading):
        if not has_begun(AT_REST, moment):
            held[0] = reading["pdc"]
        reading["pdc"] = held[0]
    return of_first(change)


def pressure_drifts(counts):
    def change(moment, _, reading):
        reading["pdc"] = single(reading["pdc"] + single(counts * moment.share))
    return of_each(change)


def finger_missing():
    def change(moment, reading):
        if has_begun(PRESSED, moment):
            reading["present"] = False
    return of_first(change)


def electrode_late(electrode, samples):
    """One electrode repeats its reading of `samples` before."""
    seen = []

    def change(moment, reading):
        if moment.index == 0:
            seen.clear()
        seen.append(reading["channels"][electrode])
        reading["channels"][electrode] = seen[-1 - min(samples, len(seen) - 1)]
    return of_first(change)


def drifts_from_touch(counts):
    """Each electrode drifts differently, and nothing of it shows at rest."""
    ways = [Engine(e).normal(counts) for e in range(ELECTRODES)]

    def new(moment, e, away):
        since, left = moment.index - moment.script.touch, moment.script.count - moment.script.touch
        return away + ways[e] * max(0.0, since / left)
    return each_electrode(new)


def rest_walks(counts):
    walk = {}

    def change(moment, finger, reading):
        if moment.index == 0:
            walk.clear()
        for e in range(ELECTRODES):
            walk[finger, e] = walk.get((finger, e), 0.0) + Engine(moment.index * 100 + 20 * finger + e).normal(counts)
            reading["channels"][e] = single(reading["channels"][e] + single(walk[finger, e]))
    return of_each(change)


def spikes(counts):
    def new(moment, e, away):
        throws = Engine(moment.index * ELECTRODES + e)() % 200
        return away + (counts if throws == 0 else -counts if throws == 1 else 0)
    return each_electrode(new)


def fingers_swapped(_, fingers):
    """Exchanges the readings of the first and of the last finger of the frame."""
    first, last = fingers[0], fingers[-1]
    for key in ("channels", "pac", "pdc"):
        first[key], last[key] = last[key], first[key]


def mixed(new):
    """Electrodes as new(distances from rest) makes them."""
    rest = Rest()

    def change(moment, finger, reading):
        first = np.array(rest.of(moment, finger, reading)["channels"])
        reading["channels"] = [single(x) for x in first + new(np.array(reading["channels"]) - first)]
    return of_each(change)


def leak(share):
    """Wet skin: each electrode also reads its neighbours' signals."""
    return mixed(lambda away: away + share * ((np.roll(away, -1) + np.roll(away, 1)) / 2 - away))


def another_sensor():
    """Another sensor reports other counts for the same force."""
    return mixed(lambda away: (0.6 + 0.05 * np.arange(ELECTRODES)) * np.roll(away, -5))


def lag(samples):
    lagged = {}

    def change(moment, finger, reading):
        if moment.index == 0:
            lagged[finger] = list(reading["channels"])
        was = lagged[finger]
        for e in range(ELECTRODES):
            was[e] = single(was[e] + single((reading["channels"][e] - was[e]) / (1 + samples)))
        reading["channels"] = list(was)
    return of_each(change)


def moved(reading, pose):
    """Moves the finger by `pose` in its own frame."""
    if "pose" in reading:
        reading["pose"] = (np.array(reading["pose"]).reshape(4, 4) @ pose).ravel().tolist()


def pose_off(metres, degrees, when):
    """Along z of the scene [m], and about y of the finger."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))

    def change(moment, _, reading):
        if "pose" in reading and has_begun(when, moment):
            reading["pose"][11] += metres
            moved(reading, np.array([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1]]))
    return of_each(change)
