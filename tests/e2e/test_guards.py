"""An operator engages repeatedly and presses deeper each time: measures how far the guards of the shipped scenes are
exceeded.

Prints for each scene and pattern of strokes the guards, the largest true force and the largest depth. With PALPATE_QUICK only the block.
"""
import dataclasses
import math
import queue
import pathlib
import re
import tempfile
import threading
import time
import unittest

from plugs import messages, palpate, states
from programs import BLOCK, PATIENCE, ROOT, SLAVE, Slave, deep, run, wait_until

SCENES = ["silicone-block", "zebrafish-embryo", "rubber-membrane", "foam-cube", "foam-bar", "foam-sponge"]
MAX_SPEED = 0.040  # largest speed of a stroke at the tool [m/s]; a slower manipulator limits it
STROKE = 0.1  # duration of a stroke [s]
PERIOD = 0.002  # between commands [s]
MAX_RATIO = 1.15  # largest force or depth relative to its guard
MIN_RATIO = 0.9  # a run that stays below this share of the guard does not test it
LATERAL_FROM = 0.8  # share of a guard at which strokes along the surface begin
UNITS = {"N": 1, "mm": 1e-3, "um": 1e-6}


def vector(message):
    return (message.x, message.y, message.z)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def mixed(a, x, b, y):
    return tuple(a * p + b * q for p, q in zip(x, y))


def guards(scene):
    """Returns the force [N] and the depth [m] beyond which the slave lets the tool go no deeper."""
    text = (ROOT / f"deploy/scenes/{scene}.yaml").read_text()
    found = [re.search(rf"^  {key}_guard: ([\d.]+) (\w+)", text, re.MULTILINE) for key in ("force", "depth")]
    return [float(match[1]) * UNITS[match[2]] for match in found]


@dataclasses.dataclass
class Surface:
    """The plane that the tool meets, frame S, and a direction along it."""
    reference: tuple
    outward: tuple

    def depth(self, tip):
        return dot(self.outward, mixed(1, self.reference, -1, tip))

    def along(self):
        x, y, _ = self.outward
        return (0, 1, 0) if abs(x) > abs(y) else (1, 0, 0)


class Operator:
    """Sends strokes to a slave and records its states meanwhile."""

    def __init__(self, stub):
        self.scale = stub.GetScene(messages.GetSceneRequest(), timeout=PATIENCE).operator.position_scale
        self.speed = min(MAX_SPEED, stub.GetScene(messages.GetSceneRequest(), timeout=PATIENCE).capabilities.max_speed)
        self.commands, self.sequence, self.epoch = queue.Queue(), 0, 0
        self.hand = (0.0, 0.0, 0.0)
        self.surface, self.newest = None, None
        self.force, self.depth, self.limits = 0.0, -math.inf, 0
        self.stream = stub.Operate(iter(self.commands.get, None), timeout=36000)
        self.reading = threading.Thread(target=self.read, daemon=True)
        self.reading.start()

    def read(self):
        for state in self.stream:
            if self.surface is None and state.HasField("local_model"):
                self.surface = Surface(vector(state.local_model.reference), vector(state.local_model.normal))
            if self.surface:
                self.depth = max(self.depth, self.surface.depth(vector(state.p_S_tip)))
            self.force = max(self.force, math.hypot(*vector(state.true_force)))
            self.limits += states.EVENT_LIMIT in state.events
            self.newest = state

    def send(self, velocity, engaged):
        self.sequence += 1
        command = states.OperatorCommand(sequence=self.sequence, epoch=self.epoch, engaged=engaged)
        command.sent_at.GetCurrentTime()
        command.p_M.x, command.p_M.y, command.p_M.z = self.hand
        command.velocity.x, command.velocity.y, command.velocity.z = velocity
        self.commands.put(command)

    def stroke(self, direction, seconds=STROKE, until=lambda: False):
        """Engages again and moves from the present position of the device."""
        self.epoch += 1
        velocity = mixed(self.speed / self.scale, direction, 0, direction)
        # Counts commands instead of time, so that a stalled script makes no jump.
        for _ in range(round(seconds / PERIOD)):
            if until():
                return
            self.hand = mixed(1, self.hand, PERIOD, velocity)
            self.send(velocity, True)
            time.sleep(PERIOD)

    def release(self, seconds):
        self.send((0, 0, 0), False)
        time.sleep(seconds)

    def leave(self):
        """Disengages, waits for the samples that show the last stroke, and ends the stream."""
        self.release(1)
        self.commands.put(None)
        self.reading.join(PATIENCE)


class Guards(unittest.TestCase):
    def press_on(self, scene, pattern, seconds, overrides=(), pause=0.02):
        force_guard, depth_guard = guards(scene)
        arguments = [word for override in overrides for word in ("--override", override)]
        with Slave(ROOT / f"deploy/scenes/{scene}.yaml", *arguments) as slave:
            stub = palpate.connect(slave.address).stub
            status = lambda: stub.GetStatus(messages.GetStatusRequest(), timeout=PATIENCE)
            self.assertTrue(wait_until(lambda: status().validity == states.VALIDITY_VALID), status())
            operator = Operator(stub)
            self.assertTrue(wait_until(lambda: operator.surface is not None))
            inward = mixed(-1, operator.surface.outward, 0, operator.surface.outward)
            along = operator.surface.along()
            if pattern == "sideways":
                operator.stroke(inward, 10, lambda: operator.force > LATERAL_FROM * force_guard
                                or operator.depth > LATERAL_FROM * depth_guard)
            directions = {"inwards": [inward], "zigzag": [mixed(0.7, inward, s * 0.7, along) for s in (1, -1)],
                          "sideways": 3 * [along] + 3 * [mixed(-1, along, 0, along)] + [inward]}[pattern]
            ratio = lambda: max(operator.force / force_guard, operator.depth / depth_guard)
            end, last = time.monotonic() + seconds, time.monotonic() + PATIENCE
            while (now := time.monotonic()) < end or (pattern == "inwards" and ratio() < MIN_RATIO and now < last):
                operator.stroke(directions[operator.epoch % len(directions)])
                operator.release(pause)
            operator.leave()
            self.assertEqual(slave.stop(), 0, slave.log)
        ratios = operator.force / force_guard, operator.depth / depth_guard
        print(f"{' '.join([scene, pattern, *overrides])}, pause {pause:g} s: guards {force_guard:g} N and "
              f"{1e3 * depth_guard:g} mm, true force {operator.force:.3f} N ({ratios[0]:.2f}), depth "
              f"{1e3 * operator.depth:.2f} mm ({ratios[1]:.2f}), {operator.epoch} engagements", flush=True)
        self.assertLess(max(ratios), MAX_RATIO)
        return ratios, operator.limits

    def test_strokes_into_the_block_end_at_its_guards(self):
        ratios, limits = self.press_on("silicone-block", "inwards", 6)
        self.assertGreater(max(ratios), MIN_RATIO)
        self.assertGreater(limits, 0)

    def test_a_scene_without_guards_is_reported(self):
        text = pathlib.Path(BLOCK).read_text()
        bare = re.sub(r"^manipulator:\n(  .*\n)+", "", text, flags=re.MULTILINE)
        self.assertLess(len(bare), len(text))
        with tempfile.TemporaryDirectory() as folder:
            scene = pathlib.Path(folder, "bare.yaml")
            scene.write_text(bare)
            for overrides, words in (
                    ([], "manipulator.force_guard and manipulator.depth_guard are not set: nothing limits the force and depth"),
                    (["--override", "manipulator.depth_guard=8 mm"],
                     "manipulator.force_guard is not set: nothing limits the force of")):
                self.assertIn(words, run(SLAVE, "check", scene, *overrides).stdout)
                with Slave(scene, *overrides) as slave:
                    slave.stop()
                self.assertIn(words, slave.log)

    @deep
    def test_strokes_into_every_scene_end_at_its_guards(self):
        for scene in SCENES:
            for pattern in "inwards", "zigzag", "sideways":
                with self.subTest(scene=scene, pattern=pattern):
                    ratios, _ = self.press_on(scene, pattern, 5)
                    if pattern == "inwards":
                        self.assertGreater(max(ratios), MIN_RATIO)

    @deep
    def test_neither_pauses_nor_retreats_add_up(self):
        for scene in SCENES:
            with self.subTest(scene=scene):
                self.press_on(scene, "inwards", 7, pause=1)
                self.press_on(scene, "inwards", 5, ["manipulator.guard=retract"])

    @deep
    def test_late_images_change_nothing(self):
        for scene in "silicone-block", "zebrafish-embryo", "rubber-membrane":
            with self.subTest(scene=scene):
                self.press_on(scene, "inwards", 6, ["sense.camera.rate=4 Hz"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
