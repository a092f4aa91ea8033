"""Whether the stated sigma of a force is right: how often the true force lies within one and two sigma, on presses drawn at random.

Object, tool, contact point, depth, images and poses are random. The true modulus, tension and finger poses differ from the scene by as
much as the scene allows. The error is that of the force's magnitude, of fingertips that of its vector, as sigma is. Estimates count
where the tool touches or is estimated to; `near the edge` are those below a tenth of the press's largest force. `material` is what the
stated modulus makes of the error, `rest` what is left. With --exact the modulus is known, so that the other terms of sigma stand alone.

A press is right where an estimate lies within two sigma, silent beyond. Demanded are 95 % intervals of the shares of the valid
estimates, by bootstrap over presses, that meet 63 to 73 % within one sigma and 90 to 99 % within two.
"""
import collections
import functools
import math

import numpy as np

from alter import readings
from campaign import Case, Outcome, size, verdict
from cells import Alteration, Stage
from draw import Dice, vector

COUNT = 50
EDGE = 0.1  # of a press's largest force
ONE, TWO = (0.63, 0.73), (0.90, 0.99)  # 68 % -5 to +5 points, 95 % -5 to +4 points
TENSION_STATED = 0.5  # one sigma, of itself
FOAM, RUBBER = 4e4, 1e6  # moduli [Pa]
WIDE = 0.1  # share of the presses that go beyond the model's range
FINGERS = 2  # of foam-cube
PHASES = ("near the edge", "moving", "still", "not valid")


def arguments(parser):
    parser.add_argument("--sense", choices=("camera", "pairs", "fingertips"), default="camera", help="pairs: stereo and depth cameras")
    parser.add_argument("--exact", action="store_true", help="the true modulus is given, as certain")


def normal_quantile(below):
    low, high = -8.0, 8.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if math.erfc(-middle / math.sqrt(2)) / 2 < below else (low, middle)
    return low


def spread(seed, number):
    """The van der Corput sequence with a shift: any part of it is spread evenly over (0, 1)."""
    share, digit = Dice(seed).share(), 0.5
    while number > 0:
        share, number, digit = share + digit * (number % 2), number // 2, digit / 2
    return share - math.floor(share)


def images(dice):
    return [f"site.noise={dice.between(0.7, 4):.3g}", f"site.blur={dice.between(0.5, 1):.3g}"]


def stated_material(dice, least, most):
    modulus, tolerance = dice.decades(least, most), dice.between(0.01, 0.08)
    return modulus, [f"object.material.young_modulus={modulus:.9g}", f"object.material.tolerance={tolerance:.9g}"], tolerance


def planar(dice, material, wide):
    """A block, a wedge or a disc, with a random tool, place and depth."""
    extent = dice.decades(5e-3, 0.2)
    pixel = extent / dice.between(230, 310)
    height, x = extent * dice.between(0.6, 1), extent * dice.between(0.3, 0.7)
    # The simulated body is plane: a sheet so thin that plane stress is exact for it.
    thickness = extent * dice.between(0.002, 0.005)
    kind, fixed, left, bottom = dice.whole(0, 2), [], 0.0, 0.0
    if kind == 0:
        shape = f"rectangle: {{width: {extent:.9g}, height: {height:.9g}, thickness: {thickness:.9g}}}"
    elif kind == 1:
        inset = extent * dice.between(0, 0.15)
        corners = ((0, 0), (extent, 0), (extent - inset, height), (inset, height))
        shape = f"polygon: {{points: [{', '.join(vector(*corner) for corner in corners)}], thickness: {thickness:.9g}}}"
    else:  # its frame is at its centre
        height, x, left, bottom = extent, 0.5 * extent, -0.5 * extent, -0.5 * extent
        shape = f"disc: {{radius: {0.5 * extent:.9g}, thickness: {thickness:.9g}}}"
        fixed = [f"object.fixed={{arc: {{centre: -90 deg, half_angle: {dice.between(0.4, 1.1):.9g}}}}}"]
    scene = [f"object.geometry={{{shape}}}", *fixed,
             f"manipulator.home={vector(left + x, bottom + height + 0.06 * extent, 0)}",
             f"sense.camera.pose={{translation: {vector(left + 0.5 * extent, bottom + 0.6 * extent, 0)}}}",
             f"sense.camera.pixel={pixel:.9g}", *material,
             f"object.material.poisson_ratio={dice.between(0.3, 0.49):.3g}",
             f"tool.width={extent * dice.between(0.05, 0.12):.9g}",
             f"operator.press.depth={wide * extent if wide > 0 else extent * dice.between(0.02, 0.07):.9g}",
             f"model.elements={dice.whole(80, 300)}"]
    off = pixel * dice.between(-1, 1), pixel * dice.between(-1, 1)
    return scene + [f"site.misplacement={vector(*off)}"] + images(dice)


def membrane(dice, modulus, material, wide):
    radius = dice.between(0.03, 0.045)
    place, angle = radius * dice.between(0, 0.55), dice.between(0, 2 * math.pi)
    thickness = radius / dice.between(30, 60)
    scene = [f"object.geometry={{membrane: {{radius: {radius:.9g}, thickness: {thickness:.9g}}}}}",
             f"manipulator.home={vector(place * math.cos(angle), place * math.sin(angle), 0.08 * radius)}", *material,
             f"object.material.poisson_ratio={dice.between(0.35, 0.47):.3g}",
             f"tool.width={radius * dice.between(0.08, 0.15):.9g}",
             f"operator.press.depth={radius * (0.26 if wide > 0 else dice.between(0.05, 0.13)):.9g}"]
    tension = float(f"{modulus * thickness * dice.decades(1e-4, 3e-3):.9g}") if dice.chance(0.3) else 0.0
    if tension > 0:
        scene.append(f"model.prestress={tension:.9g}")
    if dice.chance(0.3):
        scene.append("sense.points={track: texture}")
    else:
        scene += [f"sense.points.spacing={vector(0.38 * radius, 0.256 * radius)}", f"sense.points.radius={0.05 * radius:.9g}"]
    return scene + images(dice), tension


def pinch(dice, modulus, material, wide):
    """A block whose modulus is between those of foam and rubber. Two fingertips press it from opposite sides, anywhere from near an edge
    to the centre, with their tips, pads or sides."""
    length, width, height = dice.between(0.04, 0.08), dice.between(0.04, 0.08), dice.between(0.045, 0.08)

    def pose(x, turn):
        y, z = width * dice.between(0.2, 0.8), height * dice.between(0.45, 0.75)
        roll, tilt = dice.between(-30, 30), 115 + dice.between(-30, 25)
        return f"{{translation: {vector(x, y, z)}, rotation: [{roll:.9g} deg, {tilt:.9g} deg, {turn:.9g} deg]}}"
    # Limits the force to a few newtons for any modulus.
    depth = 0.012 if wide > 0 else min(1.0, (FOAM / modulus) ** 0.75) * dice.between(0.003, 0.009)
    return [f"object.geometry={{box: {{size: {vector(length, width, height)}, cells: [6, 6, 6]}}}}",
            f"sense.tactile.fingers.ff.pose={pose(length + 0.013, 0)}", f"sense.tactile.fingers.th.pose={pose(-0.013, 180)}", *material,
            f"object.material.poisson_ratio={dice.between(0.05, 0.35):.3g}", f"operator.press.depth={depth:.9g}"]


def rotation(turn):
    """Returns the rotation of a vector (Rodrigues)."""
    angle = np.linalg.norm(turn)
    x, y, z = turn / angle
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * K + (1 - math.cos(angle)) * K @ K


def turned(turns, stage):
    """Errors of the stated finger poses: `turns` times what the scene states for them. The fingers turn about the apices of their pads,
    so that the contact points do not move."""
    poses = []
    for turn in turns:
        pose, apex = np.eye(4), np.array([0, 0, -stage.finger_radius])
        pose[:3, :3] = rotation(stage.pose_tolerance * turn)
        pose[:3, 3] = apex - pose[:3, :3] @ apex
        poses.append(pose)

    def touch(_, fingers):
        for reading, pose in zip(fingers, poses):
            readings.moved(reading, pose)
    return touch


def pressed(sense, seed, number, exact):
    """Draws press `number` of a series. Returns its stage, its alteration and the true over the nominal modulus, less 1. The moduli of a
    series are spread evenly over their distribution; everything else is drawn independently."""
    dice = Dice(seed * 7919 + number & 0xFFFFFFFF)
    wide, tension = 0.12 if dice.chance(WIDE) else 0.0, 0.0
    least, most = {"camera": (5e3, 2e6), "pairs": (1e6, 3e7), "fingertips": (3e3, 2e5 if wide > 0 else RUBBER)}[sense]
    modulus, material, tolerance = stated_material(dice, least, most)
    if sense == "camera":
        base, overrides = "silicone-block", planar(dice, material, wide)
    elif sense == "pairs":
        base, (overrides, tension) = "rubber-membrane", membrane(dice, modulus, material, wide)
    else:
        base, overrides = "foam-cube", pinch(dice, modulus, material, wide)
    overrides.append(f"site.seed={dice.whole(1, 1 << 20)}")
    error = tolerance * normal_quantile(spread(seed, number))
    # The tension at rest in the scene has a relative error of TENSION_STATED (one sigma).
    edits = [["young_modulus *", 1 + error], ["prestress *", max(0.1, 1 + TENSION_STATED * dice.normal())]]
    modulus = float(f"{modulus:.9g}")
    stated = [["prestress =", tension]] + ([["young_modulus_tolerance =", 0]] if exact else [["young_modulus =", modulus]])
    alteration = Alteration(edits=lambda _: stated)
    stage = functools.partial(Stage, scene=base, overrides=overrides, edits=edits)
    if sense == "camera":
        return stage(kind="camera", counts=(4, 22, 8, 12, 3)), alteration, error
    if sense == "fingertips":
        turns, way = [np.array([dice.normal() for _ in range(3)]) for _ in range(FINGERS)], dice.whole(30, 150)
        stage = stage(kind="fingertips", counts=(70, way, 25, way, 10))
        alteration.touch = turned(turns, stage)
        return stage, alteration, error
    if dice.chance(0.25):
        return stage(kind="depth", counts=(8, 10, 5, 6, 2)), alteration, error
    return stage(kind="pair", counts=(16, 10, 5, 6, 2)), alteration, error


def phase_of(estimate, script, index, larger):
    if estimate.validity != "valid":
        return PHASES[3]
    if larger < EDGE:
        return PHASES[0]
    # The network uses a window of past samples, so a press counts as at rest after one window.
    return PHASES[2] if script.hold + (script.back - script.hold) // 4 < index < script.back else PHASES[1]


def tried(sense, seed, number, exact, _):
    stage, alteration, error = pressed(sense, seed, number, exact)
    estimates, refused = stage.replay(alteration)
    rows, of_fingers = [], sense == "fingertips"
    for index, one in estimates:
        if one.force is None:
            continue
        force, truth, sigma = size(one.force) / stage.peak, size(one.truth) / stage.peak, one.sigma / stage.peak
        larger = max(force, truth)
        if not (truth > 0 if of_fingers else larger > 0):  # a force of a network is never zero
            continue
        off = math.dist(one.force, one.truth) / stage.peak
        material = 0.0 if of_fingers or exact else -error / (1 + error) * truth
        rows.append((phase_of(one, stage.script, index, larger), off if of_fingers else force - truth, off, sigma, material))
    counts = collections.Counter(
        "flagged" if phase == PHASES[3] else "right" if abs(wrong) <= 2 * sigma else "silent" for phase, wrong, _, sigma, _ in rows)
    if refused:
        return verdict("refused", refused, holds=True, rows=rows)
    return Outcome(counts, values={"rows": rows})


def cases(options):
    for number in range(options.count):
        yield Case(f"{options.sense} {number}", functools.partial(tried, options.sense, options.seed, number, options.exact), options.sense)


def bands(rows):
    """Returns the shares within one and two sigma, and a line of figures [%]."""
    error, off, sigma, material = np.array([row[1:] for row in rows]).T
    z = [np.divide(x, sigma, out=np.zeros(len(rows)), where=sigma > 0) for x in (error, off)]
    one, two = (np.mean(np.abs(error) <= k * sigma) for k in (1, 2))  # with a sigma of 0, only the exact force counts as within it
    rms = [math.sqrt(np.mean(x * x)) for x in (*z, error, material, error - material)]
    middle = np.sort(sigma)[len(sigma) // 2]
    return one, two, (f"{len(rows):6}{100 * one:8.1f}%{100 * two:8.1f}%{rms[0]:8.2f}{rms[1]:8.2f}{100 * middle:9.2f}{100 * rms[2]:9.2f}"
                      f"{100 * rms[3]:10.2f}{100 * rms[4]:8.2f}")


def intervals(presses, series=2000):
    """95 % intervals of the shares within one and two sigma, by bootstrap over presses, because the estimates of one press have common
    errors (Efron 1979)."""
    counts = np.array([[len(rows), *(sum(abs(row[1]) <= k * row[3] for row in rows) for k in (1, 2))] for rows in presses if rows], float)
    if not len(counts):
        return (0.0, 0.0), (0.0, 0.0)
    drawn = np.random.default_rng(1).integers(len(counts), size=(series, len(counts)))
    sums = counts[drawn].sum(1)
    return tuple(tuple(np.sort(sums[:, k] / sums[:, 0])[[series // 40, -1 - series // 40]]) for k in (1, 2))


def demands(results, options):
    presses = [outcome.values["rows"] for _, outcome in results]
    every = [row for rows in presses for row in rows]
    print(f"{'':26}{'n':>6}{'1 sigma':>9}{'2 sigma':>9}{'z':>8}{'z vec':>8}{'sigma%':>9}{'error%':>9}{'material%':>10}{'rest%':>8}")
    for name, chosen in (*((phase, (phase,)) for phase in PHASES), ("valid", PHASES[:3])):
        rows = [row for row in every if row[0] in chosen]
        print(f"{options.sense + ', ' + name:<26}{bands(rows)[2] if rows else '     0'}")
    valid = [[row for row in rows if row[0] != PHASES[3]] for rows in presses]
    one, two, _ = bands([row for rows in valid for row in rows])
    for share, words, limits, interval in zip((one, two), ("one sigma", "two"), (ONE, TWO), intervals(valid)):
        yield (f"{100 * share:.1f} % ({100 * interval[0]:.1f} to {100 * interval[1]:.1f}) within {words}; modulus "
               f"{'known' if options.exact else 'as stated'}"), interval[0] <= limits[1] and limits[0] <= interval[1]
