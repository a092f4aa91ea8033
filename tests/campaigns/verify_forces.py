"""`palpate-slave verify --forces`, or `python3 -m palpate.verify`, on public recordings with known corruptions.

40 random corruptions of the 9DTact pairs and of the foam bar of seed paper 1, and 10 random subsets of the pairs without one. A
case is right if the report finds the corrupted quantity wrong with its size, and no other quantity. The foam bar's own scale and
turned axes must always be named. With a wrong unit the factor includes this scale and fits no unit; then the scale must be named
with its size, and no unit. A clean subset is right without an alarm, and flagged with one.
"""
import functools
import json
import math
import random
from typing import Callable, NamedTuple

import runners
from campaign import Case, Skipped, verdict
from runners import DATA

import bags

CORRUPTIONS, CLEAN = 40, 10
UNITS = {"mN": 1000.0, "g": 1000 / 9.80665, "kgf": 1 / 9.80665, "9.81": 9.80665, "1/1000": 0.001, "lbf": 1 / 4.4482216,
         "known in lbf": 4.4482216}
FOAM_OWN = {"magnitude", "frame"}
FOAM_SCALE = 1 / 1.47


def nine_d_tact():
    """Returns pairs (None, measured, estimated), without time."""
    return [(None, [float(row[f"true_f{a}_N"]) for a in "xyz"], [float(row[f"predicted_f{a}_N"]) for a in "xyz"])
            for row in runners.table(DATA / "tactile_9dtact/pairs.csv")]


def foam_bar():
    """Returns the force of the network and that of the sensor, minus its baseline."""
    rows = [(float(row["rel_time_s"]), [float(row[f"meas_f{a}_N"]) for a in "xyz"], [float(row[f"y{i}"]) for i in range(3)])
            for row in runners.table(DATA / "seed001_rf_foam_bar/lstm_expected_rf.csv")]
    rest = [sum(row[1][k] for row in rows[:50]) / 50 for k in range(3)]
    return [(t, [m - r for m, r in zip(measured, rest)], estimate) for t, measured, estimate in rows]


class Corruption(NamedTuple):
    """A corruption. `apply` changes rows (t, measured, estimated, sigma). `expected` are the keys that the report must find wrong,
    and `check` their sizes."""
    name: str
    expected: set
    apply: Callable
    check: Callable
    factor: float = 1.0  # of a wrong unit


def value_of(card, key):
    return card["lines"][key]["low_value_high"][1]


def each(change):
    return lambda rows: [(t, m, change(e), s) for t, m, e, s in rows]


def turned(rng):
    """Returns a rotation by 15 to 40 degrees about a random axis (Rodrigues)."""
    axis = [rng.gauss(0, 1) for _ in range(3)]
    size = math.sqrt(sum(x * x for x in axis))
    x, y, z = (a / size for a in axis)
    angle = math.radians(rng.uniform(15, 40))
    c, s = math.cos(angle), math.sin(angle)
    rows = [[c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s],
            [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s],
            [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)]]
    return lambda e: [sum(rows[i][j] * e[j] for j in range(3)) for i in range(3)]


def scale(rng, own):
    """Returns a factor that differs from the one that would correct the source's own scale."""
    factor = rng.choice([rng.uniform(0.6, 0.85), rng.uniform(1.2, 1.9)])
    while 0.8 < factor * own < 1.2:
        factor = rng.choice([rng.uniform(0.6, 0.85), rng.uniform(1.2, 1.9)])
    return Corruption(f"scale {factor:.3f}", {"magnitude"}, each(lambda e: [factor * x for x in e]),
                      lambda card: abs(value_of(card, "magnitude") / (own * factor) - 1) < 0.1)


def offset(rng, peak):
    axis, size = rng.randrange(3), rng.choice([-1, 1]) * rng.uniform(0.06, 0.3) * peak
    return Corruption(f"offset {size:+.3f} N on {'xyz'[axis]}", {"zero"},
                      each(lambda e: [x + size * (k == axis) for k, x in enumerate(e)]),
                      lambda card: abs(value_of(card, "zero") / abs(size) - 1) < 0.35)


def sign(rng, _):
    flipped = rng.choice([(0, 1, 2), (0, 1, 2), (0,), (1,), (2,)])
    return Corruption("sign of " + "".join("xyz"[k] for k in flipped), {"sign"},
                      each(lambda e: [-x if k in flipped else x for k, x in enumerate(e)]),
                      lambda card: card["map"]["sign"] == [-1 if k in flipped else 1 for k in range(3)])


def axes(rng, _):
    order = rng.choice([(1, 0, 2), (2, 1, 0), (0, 2, 1), (1, 2, 0), (2, 0, 1)])
    return Corruption("axes " + "".join("xyz"[k] for k in order), {"frame"}, each(lambda e: [e[k] for k in order]),
                      lambda card: [order[a] for a in card["map"]["reported_axis"]] == [0, 1, 2])


def turn(rng, _):
    change = turned(rng)
    return Corruption("turn", {"frame"}, each(change), lambda card: True)


def unit(rng, _):
    name = rng.choice(sorted(UNITS))
    return Corruption("unit " + name, {"unit"}, each(lambda e: [UNITS[name] * x for x in e]),
                      lambda card: abs(float(card["lines"]["unit"]["text"] or 1) / UNITS[name] - 1) < 0.01, UNITS[name])


def delay(rng):
    late = rng.choice([-1, 1]) * rng.uniform(0.03, 0.4)
    return Corruption(f"delay {1e3 * late:+.0f} ms", {"delay"}, lambda rows: moved(rows, late),
                      lambda card: abs(value_of(card, "delay") - late) < 0.02)


def moved(rows, late):
    """Delays the estimate by `late` seconds on the same times."""
    times = [row[0] for row in rows]
    result, at = [], 0
    for t, m, _, s in rows:
        wanted = t - late
        if not times[0] <= wanted < times[-1]:
            continue
        while times[at + 1] < wanted:
            at += 1
        share = (wanted - times[at]) / (times[at + 1] - times[at])
        result.append((t, m, [a + share * (b - a) for a, b in zip(rows[at][2], rows[at + 1][2])], s))
    return result


def sigma(rng):
    """Returns a sigma that covers the foam bar's own errors, times a factor."""
    factor = rng.choice([rng.uniform(0.15, 0.35), rng.uniform(4, 8)])

    def apply(rows):
        return [(t, m, e, factor * max(0.01, math.dist(m, e))) for t, m, e, _ in rows]
    return Corruption(f"sigma times {factor:.2f}", {"sigma"}, apply, lambda card: True)


def drift(rng):
    """Adds a drift along z from the first row to the last one."""
    size = rng.choice([-1, 1]) * rng.uniform(0.2, 0.4)

    def apply(rows):
        begin, end = rows[0][0], rows[-1][0]
        return [(t, m, [e[0], e[1], e[2] + size * (t - begin) / (end - begin)], s) for t, m, e, s in rows]
    return Corruption(f"drift {size:+.2f} N", {"time"}, apply,
                      lambda card: abs(value_of(card, "time") / abs(size) - 1) < 0.3)


def peak_of(rows):
    return max(math.hypot(*row[1]) for row in rows)


def corruptions(rng):
    """Yields (set, rows, corruption, own findings) for every corruption."""
    tact, foam = nine_d_tact(), foam_bar()
    kinds = [scale, offset, sign, axes, turn, unit]
    for i in range(CORRUPTIONS):
        if i % 2 == 0:
            kind = kinds[i // 2 % len(kinds)]
            rows = sorted(rng.sample(range(len(tact)), rng.choice([300, 800, 2000])))
            pairs = [tact[k] for k in rows]
            given = 1.0 if kind is scale else peak_of(pairs)
            yield "9DTact", pairs, kind(rng, given), set()
        else:
            kind = rng.choice([scale, offset, unit, delay, delay, drift, sigma, sign])
            if kind in (delay, drift, sigma):
                corruption = kind(rng)
            else:
                corruption = kind(rng, FOAM_SCALE if kind is scale else peak_of(foam))
            if kind is unit:
                factor = corruption.factor
                corruption = Corruption(corruption.name, {"magnitude"}, corruption.apply,
                                        lambda card, factor=factor: abs(value_of(card, "magnitude") / (FOAM_SCALE * factor) - 1) < 0.1)
            if kind is sign:  # the bar is pressed in one direction only
                corruption = Corruption("sign", {"sign"}, each(lambda e: [-x for x in e]), lambda card: True)
            yield "foam bar", foam, corruption, FOAM_OWN


SPACING = 0.1  # [s] between rows without time, in a bag


def bag_messages(rows, apart):
    """Returns messages of the sensor and of the estimate. `apart`: the sensor has one before and one after each
    estimate."""
    start = 1_700_000_000 * 10**9
    times = [start + round(1e9 * (SPACING * i if row[0] is None else row[0])) for i, row in enumerate(rows)]
    shift = min(b - a for a, b in zip(times, times[1:])) // 3 if apart else 0
    sensor, estimate = [], []
    for t_ns, (_, measured, estimated, sigma) in zip(times, rows):
        for at in sorted({t_ns - shift, t_ns + shift}):
            sensor.append(("/sensor", bags.STAMPED, at, bags.wrench(bags.STAMPED, at, measured)))
        kind = bags.STAMPED if sigma is None else bags.CONTACT
        estimate.append(("/estimate", kind, t_ns, bags.wrench(kind, t_ns, estimated, sigma)))
    return sensor, estimate


def judge_bag(rows, folder, source):
    sensor, estimate = bag_messages(rows, source == "topics")
    topics = ["--measured", "/sensor", "--estimated", "/estimate"]
    if source == "mcap":
        bags.write_mcap(folder / "run.mcap", sorted(sensor + estimate, key=lambda message: message[2]))
        return judge_by_python([folder / "run.mcap", *topics], folder)
    (folder / "sensor.db3").unlink(missing_ok=True)
    bags.write_db3(folder / "sensor.db3", sensor)
    bags.write_mcap(folder / "estimate.mcap", estimate)
    return judge_by_python([folder / "sensor.db3", folder / "estimate.mcap", *topics], folder)


def judge_by_python(arguments, folder):
    runners.run_python("palpate.verify", *arguments, "--json", folder / "report.json", codes=(0, 1))
    return json.loads((folder / "report.json").read_text())["cards"][0]


def card_of(rows, folder, source):
    if source in ("mcap", "topics"):
        return judge_bag(rows, folder, source)
    with_time, with_sigma = rows[0][0] is not None, rows[0][3] is not None
    names = ["t"] * with_time + [f"{w}_f{a}" for w in ("measured", "estimated") for a in "xyz"] + ["sigma"] * with_sigma
    file = runners.write_table(folder / "forces.csv", names, ([f"{x:.9g}" for x in [t] * with_time + list(m) + list(e) + [s] * with_sigma]
                                                              for t, m, e, s in rows))
    if source == "csv":
        return judge_by_python([file], folder)
    return runners.report(folder / "card", "verify", "--forces", file, codes=(0, 1))["cards"][0]


def found_in(card, result="wrong"):
    return {key for key, line in card["lines"].items() if line["verdict"] == result}


def judged(pairs, corruption, own, source, folder):
    card = card_of(corruption.apply([(t, m, e, None) for t, m, e in pairs]), folder, source)
    found = found_in(card)
    is_named = corruption.expected <= found <= corruption.expected | own and corruption.check(card)
    return verdict("right" if is_named else "silent", " ".join(sorted(found)))


def judged_clean(pairs, source, folder):
    card = card_of([(t, m, e, None) for t, m, e in pairs], folder, source)
    alarms = found_in(card) | found_in(card, "not decided")
    return verdict("flagged" if alarms else "right", " ".join(sorted(alarms)), holds=not alarms)


def arguments(parser):
    parser.add_argument("--from", choices=("command", "csv", "mcap", "topics"), default="command", dest="source", help="""
        command: palpate-slave with a CSV file. csv: palpate.verify with the same file. mcap: palpate.verify with both topics of one
        MCAP file. topics: palpate.verify with a database of rosbag2 and an MCAP file, whose messages have different times""")


def cases(options):
    if not (DATA / "tactile_9dtact").is_dir():
        raise Skipped("no ../shared/data/tactile_9dtact")
    rng = random.Random(options.seed)
    for name, pairs, corruption, own in corruptions(rng):
        yield Case(f"{name} {len(pairs)} {corruption.name}", functools.partial(judged, pairs, corruption, own, options.source), "corrupted")
    tact = nine_d_tact()
    for k in range(CLEAN):
        pairs = rng.sample(tact, rng.choice([200, 500, 1000, 2500]))
        yield Case(f"9DTact {len(pairs)} clean {k}", functools.partial(judged_clean, pairs, options.source), "clean")
