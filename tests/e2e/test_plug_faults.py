"""Drivers of camera and arm are killed, frozen, flooded and garbled: the force ends, the reason is reported, and motion
resumes only after an engagement.

usage: test_plug_faults.py [--times N]   repeats each fault N times, 5 by default"""
import os
import pathlib
import signal
import subprocess
import sys
import time
import unittest

from plugs import Plugged
from programs import BLOCK, SIMULATOR, memory, wait_until
from tick_log import Log

TIMES = int(sys.argv[sys.argv.index("--times") + 1]) if "--times" in sys.argv else 5
HERE = pathlib.Path(__file__).resolve().parent
# [s] from the event to zero force, as required. The 99.9th percentile of the lateness of a bare loop is added.
MAX_DELAY = 0.100
PRESSED = 0.3  # [N]


class Plugs(Plugged):
    def plug(self, driver):
        self.player = self.play()
        self.driver = self.drive(*driver)

    def unplug(self):
        for process in (self.driver, self.player):
            self.end(process)

    def cost(self):
        pid = self.slave.process.pid
        return memory(pid), len(os.listdir(f"/proc/{pid}/fd"))

    def wait_for_ready(self):
        ready = self.ready()
        self.assertTrue(ready, f"player {self.player.poll()}, driver {self.driver.poll()}\n{self.status()}")

    def repeat(self, event, words, driver=()):
        """`event` causes the fault and returns a function that ends it. An alarm must contain one of `words`."""
        self.plug(driver)
        self.wait_for_ready()
        log = Log(self.out / "log.csv")
        bare = self.start("/usr/bin/python3", HERE / "bare_loop.py", stdout=subprocess.PIPE)
        master = self.operate(3600)
        delays, costs = [], []
        for _ in range(TIMES):
            self.assertTrue(wait_until(lambda: log.newest_force() > PRESSED), self.status())
            at = time.monotonic()
            undo = event()
            printed = set()

            def is_silent():
                printed.update(self.status().alarms)
                return log.fell_silent(at) is not None
            self.assertTrue(wait_until(is_silent), "the hand is let go")
            delays.append(log.fell_silent(at))
            self.assertTrue(any(word in alarm for alarm in printed for word in words), printed)
            undo()
            self.unplug()
            self.plug(driver)
            self.wait_for_ready()
            costs.append(self.cost())
        self.assertTrue(wait_until(lambda: log.newest_force() > PRESSED), "it goes on")
        master.send_signal(signal.SIGINT)
        report = self.report(master)
        bare.send_signal(signal.SIGTERM)
        late = float(bare.stdout.readline())
        print(f"{self.id().split('.')[-1]}: no force after {[round(1e3 * delay) for delay in delays]} ms "
              f"(bare loop {1e3 * late:.1f} ms), {costs[0][0]:.0f} to {costs[-1][0]:.0f} MB, {costs[0][1]} to {costs[-1][1]} descriptors", flush=True)
        self.assertLessEqual(max(delays), MAX_DELAY + late)
        self.assertGreaterEqual(report["epochs"], TIMES + 1, "each return by an engagement")
        self.assertLess(costs[-1][0], costs[0][0] + 20, "memory is bounded")
        self.assertLess(costs[-1][0], costs[len(costs) // 2][0] + 10, "memory is flat")
        self.assertLessEqual(costs[-1][1], costs[0][1] + 3, "descriptors are flat")

    @staticmethod
    def signalled(process, what):
        def event():
            process().send_signal(what)
            return lambda: None
        return event


class Faults(Plugs):
    def replaced(self, how):
        """Returns an event in which a faulty camera driver replaces the camera's driver."""
        def event():
            self.player.kill()
            feeder = self.start("/usr/bin/python3", HERE / "faulty_feeder.py", how, self.slave.address)
            return lambda: self.end(feeder)
        return event

    def test_camera_killed(self):
        self.repeat(self.signalled(lambda: self.player, signal.SIGKILL), CAMERA)

    def test_camera_frozen(self):
        self.repeat(self.signalled(lambda: self.player, signal.SIGSTOP), CAMERA)

    def test_camera_flooded(self):
        self.repeat(self.replaced("flood"), CAMERA)

    def test_camera_garbled(self):
        self.repeat(self.replaced("garble"), CAMERA)

    def test_arm_killed(self):
        self.repeat(self.signalled(lambda: self.driver, signal.SIGKILL), ARM)

    def test_arm_frozen(self):
        self.repeat(self.signalled(lambda: self.driver, signal.SIGSTOP), ARM)

    def test_arm_says_no_number(self):
        self.faulty_driver("nan")

    def test_arm_jumps(self):
        self.faulty_driver("jump")

    def test_arm_has_a_fault(self):
        self.faulty_driver("fault")

    def faulty_driver(self, how):
        self.repeat(self.signalled(lambda: self.driver, signal.SIGUSR1), ARM, (HERE / "faulty_driver.py", how))

    def test_arm_floods(self):
        """Too frequent reports are not a fault: the force continues and the memory is bounded."""
        self.plug((HERE / "faulty_driver.py", "flood"))
        self.wait_for_ready()
        log = Log(self.out / "log.csv")
        self.operate(3600)
        self.assertTrue(wait_until(lambda: log.newest_force() > PRESSED))
        before = self.cost()
        self.driver.send_signal(signal.SIGUSR1)
        time.sleep(10)
        self.assertTrue(wait_until(lambda: log.newest_force() > PRESSED), self.status())
        self.assertLess(self.cost()[0], before[0] + 50)


class SimulatorFaults(Plugs):
    """The same faults with palpate-simulator, which feeds images and drives the arm."""

    def plug(self, driver):
        self.player = self.driver = self.start(SIMULATOR, BLOCK, "--slave", self.slave.address, stdout=subprocess.DEVNULL)

    def test_simulator_killed(self):
        self.repeat(self.signalled(lambda: self.player, signal.SIGKILL), CAMERA + ARM)

    def test_simulator_stopped(self):
        self.repeat(self.signalled(lambda: self.player, signal.SIGSTOP), CAMERA + ARM)


CAMERA, ARM = ("no sample from the sensor",), ("arm", "manipulator", "driver")

if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
