#!/usr/bin/env python3
"""Motion and figures of an insertion into a simulated embryo.

insertion.py hand OFFLINE DURATION FILE.csv   writes a playback: home, straight to the target, a pause, and back,
                                              repeated within DURATION [s]. OFFLINE: the folder of a `process` run
insertion.py figures OFFLINE LOG.csv OUT      draws OUT/insertion.svg (images of the slave before the puncture, after it
                                              and at the target), OUT/force-deformation.svg (paper A, figure 10) and
                                              OUT/force-time.svg (figure 11, from the master's LOG.csv), and prints the
                                              results. Exit 1: the puncture or the target was missed
"""
import base64
import csv
import json
import math
import pathlib
import sys

RATE = 100        # rows of a playback [Hz]
STAY, REST = 1.5, 1.0  # pauses at the target and at home [s]
NEAR = 3e-6       # largest distance at which the target counts as reached [m]
WIDTH, HEIGHT, LEFT, TOP = 560, 300, 70, 40


def minimum_jerk(u):
    return u ** 3 * (10 + u * (-15 + 6 * u))


def write_hand(offline, duration, file):
    plan = json.loads((offline / "summary.json").read_text())["insertion"]
    way = [(t - h) / plan["position_scale"] for t, h in zip(plan["target"], plan["home"])]
    length = math.dist(plan["target"], plan["home"])
    ramp = 15 / 8 * length / plan["speed"]
    cycle = REST + 2 * ramp + STAY
    rows = []
    for i in range(int(max(duration, cycle + REST) * RATE)):
        t = i / RATE
        at = t % cycle - REST
        whole = t - t % cycle + cycle <= max(duration, cycle + REST)
        share = 0.0
        if whole and at > 0:
            share = minimum_jerk(min(at / ramp, 1.0)) if at < ramp + STAY else minimum_jerk(max(0.0, 1 - (at - ramp - STAY) / ramp))
        rows.append([f"{t:.3f}"] + [f"{w * share:.9g}" for w in way])
    with open(file, "w", newline="") as out:
        csv.writer(out).writerows([["time_s", "x", "y", "z"], *rows])


def read(file):
    with open(file, newline="") as rows:
        return list(csv.DictReader(rows))


def number(text):
    return float(text) if text else None


def size(row, name):
    parts = [number(row[f"{name}{axis}"]) for axis in ("x", "y", "z")]
    return None if None in parts else math.hypot(*parts)


def nice_step(most):
    """Returns the distance of the ticks of an axis, which has four to ten."""
    step = 10 ** math.floor(math.log10(most))
    return next(step * part for part in (1, 0.5, 0.2, 0.1) if most / (step * part) >= 4)


class Plot:
    def __init__(self, title, x_label, y_label, x_max, y_max, y_name="{:g}".format):
        self.x_max, self.y_max = x_max, y_max
        self.parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {LEFT + WIDTH + 30} {TOP + HEIGHT + 60}" '
                      'font-family="sans-serif" font-size="13">',
                      f"<title>{title}</title>", '<rect width="100%" height="100%" fill="white"/>',
                      f'<rect x="{LEFT}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#999"/>',
                      f'<text x="{LEFT}" y="{TOP - 14}">{y_label}</text>',
                      f'<text x="{LEFT + WIDTH / 2}" y="{TOP + HEIGHT + 44}" text-anchor="middle">{x_label}</text>']
        for i in range(int(x_max / nice_step(x_max)) + 1):
            at = i * nice_step(x_max)
            self.parts.append(f'<text x="{self.x(at):.1f}" y="{TOP + HEIGHT + 20}" text-anchor="middle">{at:g}</text>')
        for i in range(int(y_max / nice_step(y_max)) + 1):
            at = i * nice_step(y_max)
            self.parts.append(f'<text x="{LEFT - 8}" y="{self.y(at) + 4:.1f}" text-anchor="end">{y_name(at)}</text>')
        self.legend = 0

    def x(self, value):
        return LEFT + WIDTH * value / self.x_max

    def y(self, value):
        return TOP + HEIGHT * (1 - value / self.y_max)

    def curve(self, points, colour, name, dash=""):
        path = " ".join(f"{self.x(x):.1f},{self.y(y):.1f}" for x, y in points)
        style = f'stroke="{colour}" stroke-width="2" fill="none"' + (f' stroke-dasharray="{dash}"' if dash else "")
        y = TOP + 18 + 18 * self.legend
        self.legend += 1
        self.parts += [f'<polyline points="{path}" {style}/>', f'<path d="M {LEFT + 12} {y - 4} h 26" {style}/>',
                       f'<text x="{LEFT + 44}" y="{y}">{name}</text>']

    def mark(self, x, name):
        self.parts += [f'<path d="M {self.x(x):.1f} {TOP} v {HEIGHT}" stroke="#555" stroke-dasharray="2 4"/>',
                       f'<text x="{self.x(x) + 5:.1f}" y="{TOP + HEIGHT - 8}" fill="#555">{name}</text>']

    def write(self, file):
        file.write_text("\n".join([*self.parts, "</svg>"]) + "\n")


def depths(states):
    """Depth of the pipette beyond the first contact, along its path [m]; 0 before."""
    first = next(row for row in states if size(row, "f"))
    start = [float(first[f"contact_{axis}"]) for axis in "xyz"]
    home = [float(states[0][f"tip_{axis}"]) for axis in "xyz"]
    way = [s - h for s, h in zip(start, home)]
    unit = [w / math.hypot(*way) for w in way]
    return [max(0.0, sum(u * (float(row[f"tip_{axis}"]) - s) for u, s, axis in zip(unit, start, "xyz"))) if row["tip_x"] else None
            for row in states]


def draw_deformation(states, plan, file):
    """Force over deformation on the way in: paper A, figure 10."""
    deep = depths(states)
    puncture_depth = deep[plan["detected_sample"] - 1]
    shown = [(d, row) for d, row in zip(deep, states) if d is not None]
    shown = shown[:next((i for i, (d, _) in enumerate(shown) if d > 1.6 * puncture_depth), len(shown))]
    rows = [(1e6 * d, row) for d, row in shown]
    estimated_force = [(d, 1e3 * size(row, "f")) for d, row in rows if size(row, "f") is not None]
    true = [(d, 1e3 * size(row, "true_f")) for d, row in rows if size(row, "true_f") is not None]
    plot = Plot("Force and deformation of the embryo", "deformation [um]", "force of the embryo on the pipette [mN]",
                1.02 * max(d for d, _ in true), 1.15 * max(f for _, f in estimated_force + true))
    plot.curve(true, "#bbb", "true force of the simulator")
    plot.curve(estimated_force, "#c33", "estimated from images")
    plot.mark(1e6 * puncture_depth, "puncture reported")
    plot.write(file)


def draw_time(log, file):
    """The scaled force on the device over time: paper A, figure 11."""
    rows = log[::max(1, len(log) // 3000)]
    scaled = [(float(row["t"]), size(row, "scaled_")) for row in rows]
    sent = [(float(row["t"]), size(row, "sent_")) for row in rows]
    plot = Plot("Scaled force on the device", "time [s]", "force on the device [N]", max(t for t, _ in sent),
                1.15 * max(f for _, f in scaled + sent))
    plot.curve(scaled, "#bbb", "scaled")
    plot.curve(sent, "#36c", "sent to the device (limited)")
    plot.write(file)


def embed(image):
    return base64.b64encode(image.read_bytes()).decode()


def draw_images(offline, shown, file):
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {660 * len(shown) + 20} 530" font-family="sans-serif" font-size="22">',
             '<rect width="100%" height="100%" fill="white"/>']
    for i, (number_of, words) in enumerate(shown):
        parts += [f'<text x="{20 + 660 * i}" y="30">{words}</text>',
                  f'<image x="{20 + 660 * i}" y="44" width="640" height="480" '
                  f'href="data:image/jpeg;base64,{embed(offline / "images" / f"{number_of:06}.jpg")}"/>']
    file.write_text("\n".join([*parts, "</svg>"]) + "\n")


def drop_at_the_hand(log):
    """Returns the largest force sent, and the largest one in the half second after the puncture. None: no puncture."""
    broken = next((i for i, row in enumerate(log) if "punctured" in row["reason"]), None)
    if broken is None:
        return None
    t = float(log[broken]["t"])
    after = [size(row, "sent_") for row in log[broken:] if 0.02 < float(row["t"]) - t < 0.5]
    return max(size(row, "sent_") for row in log[:broken]), max(after)


def figures(offline, log_file, out):
    plan = json.loads((offline / "summary.json").read_text())["insertion"]
    states, log = read(offline / "states.csv"), read(log_file)
    if not plan["detected_sample"]:
        sys.exit("insertion.py: the slave reported no puncture")
    deep = depths(states)
    nearest = min(range(len(states)), key=lambda i: math.dist(
        [number(states[i][f"tip_{axis}"]) or 0 for axis in "xyz"], plan["target"]))
    draw_images(offline, [(plan["detected_sample"] - 1, "before the puncture"), (plan["detected_sample"], "the puncture is reported"),
                            (nearest + 1, "at the target")], out / "insertion.svg")
    draw_deformation(states, plan, out / "force-deformation.svg")
    draw_time(log, out / "force-time.svg")
    sample = plan["detected_sample"] - 1
    force = 1e3 * size(states[sample - 1], "f")
    print(f"force rises to {force:.1f} mN at {1e6 * deep[sample - 1]:.0f} um, the puncture is reported in image "
          f"{plan['detected_sample']} (true: {plan['punctured_sample']}), force {1e3 * size(states[sample], 'f'):g} mN after it, "
          f"target reached to {1e6 * plan['closest_m']:.1f} um")
    drop = drop_at_the_hand(log)
    print("on the device: " + ("no puncture" if drop is None else f"up to {drop[0]:.2f} N, then {drop[1]:.2f} N"))
    good = size(states[sample], "f") == 0 and plan["closest_m"] < NEAR and drop is not None and drop[1] < 0.05 * drop[0]
    return 0 if good else 1


def main():
    command, *words = sys.argv[1:] or [""]
    if command == "hand" and len(words) == 3:
        write_hand(pathlib.Path(words[0]), float(words[1]), words[2])
        return 0
    if command == "figures" and len(words) == 3:
        return figures(*map(pathlib.Path, words))
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
