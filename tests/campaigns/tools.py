"""Force errors for a tool that differs from its scene, or that is tilted, in simulated presses through `process`.

  anchors   The template is cut from the first image of the shipped block, with an error of its anchor of -3 to +5 px
            along the tool.
  leaning   Tools of radius 0 (flat) to 10 mm press a block and a disc, with a constant tilt of 0 to 20 degrees, or in
            a hand that rotates them by as much.

An error is the distance of the estimated from the true force, relative to the largest true force of the press. Contact
states are those whose true force is more than a hundredth of it. A case holds if no valid contact state has an error of
more than a tenth and, with the right anchor or a tilted tool, at least 80 % of the contact states are valid.
"""
import math

import campaign
import runners
from campaign import Case, Estimate
from runners import vector

from programs import png
from setups import BOX, TIP, decoded

SCENE = runners.ROOT / "deploy/scenes/silicone-block.yaml"
MAX_ERROR, MIN_VALID, TOUCHES = 0.1, 0.8, 0.01
DISC = ["object.geometry={disc: {radius: 40 mm, thickness: 9 mm}}",
        "object.fixed={arc: {centre: -90 deg, half_angle: 40 deg}}", "manipulator.home=[0, 46 mm, 0]",
        "sense.camera.pose={translation: [0, 6 mm, 0]}"]


def pressed(folder, overrides, min_valid):
    rows = runners.process(SCENE, folder / "out", overrides=overrides)
    outcome = campaign.compared((Estimate(vector(row), vector(row, "true_f"), 0, row["validity"], row["check"]) for row in rows), TOUCHES, MAX_ERROR)
    valid = outcome.counts["right"] + outcome.counts["silent"]
    outcome.holds &= valid >= min_valid * sum(outcome.counts.values())
    return outcome


def template(folder, seed):
    """Cuts the tip of the tool out of the first image."""
    left, top, right, bottom = BOX
    runners.process(SCENE, folder, "--frames", overrides=[f"site.seed={seed}", "operator.press.depth=1 mm"])
    rows = decoded(sorted((folder / "frames").iterdir())[0].read_bytes())
    file = folder / "tip.png"
    file.write_bytes(png(right - left, bottom - top, 8, [row[left:right] for row in rows[top:bottom]]))
    return file


def anchor(folder, seed, off):
    tip = [TIP[0] - BOX[0], TIP[1] - BOX[1] + off]
    settings = [f"site.seed={seed}", f"sense.tip={{track: template, template: {template(folder / 'first', seed)}, anchor: {tip}}}"]
    return pressed(folder, settings, MIN_VALID if off == 0 else 0)


def leaning(folder, seed, place, radius, angle, way):
    tool = f"shape: round, radius: {radius} mm, width: {2 * radius} mm" if radius else "shape: flat, width: 5.87 mm"
    lean = math.radians(angle) if way == "direction" else 0
    settings = [*place, f"site.seed={seed}", "sense.camera.rate=20 Hz", "sense.camera.pixel=0.25 mm", "model.elements=360",
                f"tool={{{tool}, depth: whole, direction: [{math.sin(lean):.6f}, {-math.cos(lean):.6f}]}}"]
    return pressed(folder, settings + [f"site.hand={{tilt: {angle} deg}}"] * (way == "hand"), MIN_VALID)


def cases(options):
    for off in (0, -3, -2, -1, 1, 2, 3, 4, 5):
        yield Case(f"anchor {off:+d} px", lambda folder, off=off: anchor(folder, options.seed, off), "anchors")
    for body, place in (("block", []), ("disc", DISC)):
        for radius in (0, 3, 5, 10):
            for angle in (0, 8, 15, 20):
                for way in ("direction", "hand") if angle else ("direction",):
                    yield Case(f"{body}, radius {radius} mm, {way} {angle} deg",
                               lambda folder, one=(place, radius, angle, way): leaning(folder, options.seed, *one), "leaning")
