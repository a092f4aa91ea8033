"""A laboratory's own camera and arm: a simulated site played by one process, an arm driven by another."""
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from programs import BARE, BIN, BLOCK, MASTER, OUT, PATIENCE, ROOT, Slave, wait_until

EXAMPLES = ROOT / "deploy/examples"
STUBS = OUT / "plug-stubs"
sys.path.insert(0, str(EXAMPLES))
os.environ["PALPATE_STUBS"] = str(STUBS)
os.environ["PATH"] = BARE["PATH"]
try:
    import grpc
    import palpate_stubs
    messages, services, states = palpate_stubs.load()
except (ImportError, SystemExit) as error:
    print(f"skipped: {error}")
    raise SystemExit(77)

ENVIRONMENT = {**BARE, "PALPATE_STUBS": str(STUBS), "PALPATE_STUBS_READY": "1", "PYTHONDONTWRITEBYTECODE": "1"}
PLUGGED = ["--override", "manipulator.source=stream", "--override", "sense.camera.source=stream"]
HOME = "0.044,0.09416,0"
RAMP = 0.100 + 0.050  # [s] from an event to no force: the slave's silence, the hand's hold and fade, and the machine
REPEATS = 5 if "--full" not in sys.argv else 100


class Plug(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.out = pathlib.Path(self.folder.name)
        self.slave = Slave(BLOCK, *PLUGGED)
        self.slave.__enter__()
        self.addCleanup(self.slave.__exit__)
        self.stub = services.TeleoperationStub(palpate_stubs.connect(grpc, self.slave.address))

    def start(self, *command, **options):
        process = subprocess.Popen([str(c) for c in command], stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   text=True, env=ENVIRONMENT, **options)

        def end():
            if process.poll() is None:
                process.send_signal(signal.SIGCONT)
                process.kill()
            process.wait()
            if process.stdout:
                process.stdout.close()
        self.addCleanup(end)
        return process

    def play(self):
        player = self.start(BIN / "site_player", BLOCK, self.slave.address, stdout=subprocess.PIPE)
        self.site = re.fullmatch(r"site on (\S+)\n", player.stdout.readline()).group(1)
        return player

    def drive(self):
        return self.start("/usr/bin/python3", EXAMPLES / "drive_arm.py", self.slave.address, "--home", HOME, "--site",
                          self.site, "--rate", "500", stdout=subprocess.DEVNULL)

    def status(self):
        return self.stub.GetStatus(messages.GetStatusRequest(), timeout=10)

    def ready(self):
        return wait_until(lambda: not self.status().alarms and self.status().validity == states.VALIDITY_VALID)

    def operate(self, seconds):
        return self.start(MASTER, "connect", self.slave.address, "--duration", seconds, "--report",
                          self.out / "report.json", "--log", self.out / "log.csv", stdout=subprocess.DEVNULL)

    def report(self, master):
        master.wait(timeout=PATIENCE)
        return json.loads((self.out / "report.json").read_text())

    def test_what_is_missing_is_said_and_what_comes_is_felt(self):
        self.assertTrue(any("no picture has come yet" in alarm for alarm in self.status().alarms))
        self.assertTrue(any("nobody drives the arm" in alarm for alarm in self.status().alarms))
        self.play()
        self.drive()
        self.assertTrue(self.ready(), self.status())
        report = self.report(self.operate(8))
        self.assertGreater(report["force_peak_N"], 1.5)
        self.assertGreater(report["force_error"]["contact_ticks"], 500)
        self.assertLess(report["force_error"]["rms_N"], 0.1 * report["force_peak_N"])
        arm = self.status().arm
        self.assertEqual(arm.driver_name, "fake six-axis arm")
        self.assertLess(arm.lag_s, 0.1)
        self.assertAlmostEqual(arm.scale, 1, delta=0.1)
        print(json.dumps({"force_peak_N": report["force_peak_N"], "force_error": report["force_error"],
                          "lag_ms": 1e3 * arm.lag_s, "scale": arm.scale}))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
