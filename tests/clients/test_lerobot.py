"""Tests the plug-in for LeRobot with stand-ins of LeRobot's interfaces and a fake slave. Needs PYTHONPATH."""
import math
import pathlib
import sys
import time
import unittest
from dataclasses import dataclass

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE / "lerobot_stub"), str(HERE.parents[1] / "deploy/python/lerobot")]

try:
    import palpate
    from lerobot.robots import Robot, RobotConfig, make_robot_from_config
    from lerobot_robot_palpate import FEATURES, PalpateWrench, PalpateWrenchConfig, Wrench, WrenchSensor
    from palpate.v1 import state_pb2
    from test_examples import fake_slave
except ImportError as missing:
    print(f"skipped: {missing}: deploy/install.sh tests")
    sys.exit(77)


@dataclass(kw_only=True)
class ArmConfig(RobotConfig):
    extra: str = "joint.pos"


class Arm(Robot):
    config_class = ArmConfig

    def __init__(self, config):
        super().__init__(config)
        self.observation_features = {config.extra: float, "front": (4, 4, 3)}
        self.action_features = {"joint.pos": float}
        self.is_connected, self.is_calibrated, self.sent = False, True, []

    observation_features = action_features = is_connected = is_calibrated = None

    def connect(self, calibrate=True):
        self.is_connected = True

    def calibrate(self):
        pass

    def configure(self):
        pass

    def get_observation(self):
        return {"joint.pos": 1.5, "front": "image"}

    def send_action(self, action):
        self.sent.append(action)
        return {"joint.pos": min(action["joint.pos"], 1.0)}

    def disconnect(self):
        self.is_connected = False


class Handle:
    """A teleoperator that renders fz and fx."""
    feedback_features = {"wrench.fx": float, "wrench.fz": float, "vibration": float}

    def __init__(self):
        self.rendered = []

    def send_feedback(self, feedback):
        self.rendered.append(feedback)


class Source(fake_slave()):
    """A fake slave whose force rises by 1 N per state along y. The test sets `validity`, and `repeats`: it sends the
    same sample again."""
    validity, repeats, sequence = state_pb2.VALIDITY_VALID, False, 0

    def WatchState(self, request, context):
        sensed = time.time_ns()
        while context.is_active():
            self.sequence += 1
            sensed = sensed if self.repeats else time.time_ns()
            state = state_pb2.SlaveState(sequence=self.sequence, validity=self.validity, sigma=0.25,
                                         force=state_pb2.Vec3(x=-1, y=self.sequence, z=2))
            state.moment.z = 0.5
            state.sensed_at.FromNanoseconds(sensed)
            yield state
            time.sleep(0.02)


def wait_until(condition, seconds=20):
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.01)
    return condition()


class SensorTest(unittest.TestCase):
    def test_unit_frame_sigma_validity_and_methods_of_a_camera(self):
        source = Source()
        with source.served() as address:
            sensor = WrenchSensor(address, frame="tool_base")
            self.assertEqual(list(sensor.features), [f"wrench.{n}" for n in ("fx", "fy", "fz", "tx", "ty", "tz", "sigma", "valid", "age")])
            self.assertEqual((sensor.info["unit"]["force"], sensor.info["frame"], sensor.info["sign"]),
                             ("N", "tool_base", "of the object on the tool"))
            with self.assertRaisesRegex(RuntimeError, "connect"):
                sensor.read()
            sensor.connect()
            first = sensor.async_read(5000)
            second = sensor.async_read(5000)
            self.assertGreater(second["wrench.fy"], first["wrench.fy"])
            self.assertEqual(set(first), set(FEATURES))
            self.assertEqual({k: first[f"wrench.{k}"] for k in ("fx", "fz", "tz", "sigma", "valid")},
                             {"fx": -1.0, "fz": 2.0, "tz": 0.5, "sigma": 0.25, "valid": 1.0})
            latest, at = sensor.read_latest()
            self.assertLess(abs(time.perf_counter() - at - latest["wrench.age"]), 1)
            with self.assertRaisesRegex(RuntimeError, "already"):
                sensor.connect()
            sensor.disconnect()
            self.assertFalse(sensor.is_connected)

    def test_feedback_is_zero_unless_the_force_is_a_measurement(self):
        source, handle = Source(), Handle()
        with source.served() as address:
            sensor = WrenchSensor(address)
            sensor.connect()
            self.addCleanup(sensor.disconnect)
            self.assertTrue(wait_until(lambda: sensor.send_feedback(handle) == {"wrench.fx": -1.0, "wrench.fz": 2.0}))
            self.assertEqual(handle.rendered[-1], {"wrench.fx": -1.0, "wrench.fz": 2.0})
            source.validity = state_pb2.VALIDITY_EXTRAPOLATED
            self.assertTrue(wait_until(lambda: sensor.send_feedback(handle) == {"wrench.fx": 0.0, "wrench.fz": 0.0}))
            source.validity = state_pb2.VALIDITY_VALID
            self.assertTrue(wait_until(lambda: sensor.read()["wrench.valid"] == 1))
            source.repeats = True  # the same sample again and again
            self.assertTrue(wait_until(lambda: sensor.read()["wrench.valid"] == 0 and sensor.read()["wrench.age"] > 0.2))
            sensor.async_read(5000)  # the last one that arrived
            with self.assertRaisesRegex(TimeoutError, "no wrench within 100 ms"):
                sensor.async_read(100)
            with self.assertRaisesRegex(ValueError, "feedback_features"):
                sensor.send_feedback(type("Keyboard", (), {"feedback_features": {}}))

    def test_unknown_numbers_are_zero_and_not_valid(self):
        nan = math.nan
        unknown = Wrench((nan, nan, nan), (nan, nan, nan), nan, True, 10.0).observation(10.1)
        self.assertEqual([unknown[f"wrench.{k}"] for k in ("fx", "sigma", "valid")], [0.0, 0.0, 0.0])
        no_moment = Wrench((1.0, 2.0, 3.0), (nan, nan, nan), 0.1, True, 10.0).observation(10.1)
        self.assertEqual([no_moment[f"wrench.{k}"] for k in ("fx", "tx", "valid")], [1.0, 0.0, 1.0])

    def test_a_lost_slave_is_an_error(self):
        source = Source()
        with source.served() as address:
            sensor = WrenchSensor(address)
            sensor.connect()
            self.addCleanup(sensor.disconnect)

        def lost():
            try:
                sensor.read()
            except palpate.Error:
                return True
            return False
        self.assertTrue(wait_until(lost))


class RobotTest(unittest.TestCase):
    def test_any_robot_gets_the_wrench(self):
        self.assertIs(RobotConfig.known["palpate_wrench"], PalpateWrenchConfig)
        with Source().served() as address:
            robot = make_robot_from_config(PalpateWrenchConfig(robot=ArmConfig(id="a"), target=address, id="b"))
            self.assertIsInstance(robot, PalpateWrench)
            self.assertEqual(set(robot.observation_features), {"joint.pos", "front", *FEATURES})
            robot.connect()
            self.assertTrue(robot.is_connected and robot.is_calibrated)
            seen = robot.get_observation()
            self.assertEqual(set(seen), set(robot.observation_features))
            self.assertEqual((seen["joint.pos"], seen["wrench.fz"]), (1.5, 2.0))
            self.assertEqual(robot.send_action({"joint.pos": 3.0}), {"joint.pos": 1.0})
            robot.disconnect()
            self.assertFalse(robot.robot.is_connected or robot.wrench.is_connected)

    def test_a_robot_with_a_wrench_is_refused(self):
        with self.assertRaisesRegex(ValueError, "wrench.fx"):
            PalpateWrench(PalpateWrenchConfig(robot=ArmConfig(extra="wrench.fx")))


if __name__ == "__main__":
    unittest.main()
