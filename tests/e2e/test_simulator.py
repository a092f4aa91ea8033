"""palpate-simulator: two recordings with one seed are equal files, another seed gives others; and a slave that it feeds
renders the force as rightly as one with the simulator inside, within 1 % of the peak."""
import filecmp
import json
import pathlib
import subprocess
import tempfile
import time
import unittest

from felt_error import felt_error
from programs import BARE, BIN, MASTER, PATIENCE, ROOT, SLAVE, Slave, run

SIMULATOR = str(BIN / "palpate-simulator")
SCENES = ROOT / "deploy/scenes"
SECONDS = 16
SLOW = ["--override", "operator.press.speed=4 mm/s"]
MOST = 0.01  # of the peak, between the errors of the two
BASELINE = 2  # [s], in which nothing touches the fingertips
LEAST = 2000  # ticks in contact whose force is known


class Simulator(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out = pathlib.Path(folder.name)

    def record(self, scene, name, *options):
        folder = self.out / name
        done = run(SIMULATOR, SCENES / f"{scene}.yaml", "--record", folder, *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return folder

    def test_record(self):
        for scene, samples in (("silicone-block", "pictures.pb"), ("foam-cube", "tactile.pb")):
            names = [samples, "arm.pb", "truth.csv"]
            first, again = self.record(scene, f"{scene}-1"), self.record(scene, f"{scene}-2")
            self.assertEqual(filecmp.cmpfiles(first, again, names, shallow=False)[0], names, scene)
            other = self.record(scene, f"{scene}-3", "--override", "site.seed=7")
            self.assertEqual(filecmp.cmpfiles(first, other, [samples], shallow=False)[1], [samples], scene)

    def test_no_slave(self):
        done = run(SIMULATOR, SCENES / "silicone-block.yaml", "--slave", "127.0.0.1:1")
        self.assertEqual(done.returncode, 1)
        self.assertIn("palpate-simulator: ", done.stderr)

    def press(self, scene, *options):
        """(error, delay, ticks) of felt_error in a slow press; and what the simulator prints, if it streams."""
        log = self.out / "log.csv"
        command = [SLAVE, "serve", str(SCENES / f"{scene}.yaml"), "--listen", "127.0.0.1:0", *SLOW, *options]
        with Slave(command=command) as slave:
            simulator = None
            if options:
                simulator = subprocess.Popen(
                    [SIMULATOR, str(SCENES / f"{scene}.yaml"), *SLOW, "--slave", slave.address],
                    stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=BARE)
                self.assertEqual(simulator.stdout.readline(), f"streaming to {slave.address}\n")
                time.sleep(BASELINE)
            try:
                done = run(MASTER, "connect", slave.address, "--duration", SECONDS, "--report", self.out / "report.json",
                           "--log", log)
                self.assertEqual(done.returncode, 0, done.stderr)
            finally:
                if simulator:
                    simulator.terminate()
                    printed = simulator.communicate(timeout=PATIENCE)[1]
        if simulator:
            self.assertEqual(simulator.returncode, 0, printed)
            self.assertIn("computed in", printed)
        json.loads((self.out / "report.json").read_text())
        return felt_error(log)

    def compare(self, scene):
        inside, streamed = self.press(scene), self.press(scene, "--simulator")
        print(f"{scene}: in-process {100 * inside[0]:.2f} % after {inside[1]} ms | "
              f"streamed {100 * streamed[0]:.2f} % after {streamed[1]} ms", flush=True)
        for error, _, ticks in (inside, streamed):
            self.assertGreater(ticks, LEAST)
            self.assertLess(error, inside[0] + MOST)

    def test_block(self):
        self.compare("silicone-block")

    def test_cube(self):
        self.compare("foam-cube")


if __name__ == "__main__":
    unittest.main()
