"""palpate-simulator: recordings with the same seed are equal files and differ with another seed; a slave that it feeds
estimates the true force."""
import filecmp
import subprocess
import unittest

from force_error import force_error
from programs import BARE, BLOCK, ROOT, SIMULATOR, FolderTest, Slave, run
from tick_log import followed, press_until

SCENES = ROOT / "deploy/scenes"
SLOW = ["--override", "operator.press.speed=4 mm/s"]
SHALLOW = ("--override", "operator.press.depth=2 mm")  # takes a short time to record
MIN_TICKS = 2000  # ticks in contact whose force is known


class Simulator(FolderTest):
    def record(self, scene, name, *options):
        folder = self.out / name
        done = run(SIMULATOR, SCENES / f"{scene}.yaml", "--record", folder, *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return folder

    def test_record(self):
        for scene in ("silicone-block", "foam-cube"):
            first, again = (self.record(scene, f"{scene}-{i}", *SHALLOW) / "samples.pb" for i in (1, 2))
            self.assertTrue(filecmp.cmp(first, again, shallow=False), scene)
            other = self.record(scene, f"{scene}-3", *SHALLOW, "--override", "site.seed=7") / "samples.pb"
            self.assertFalse(filecmp.cmp(first, other, shallow=False), scene)

    def test_no_slave(self):
        done = run(SIMULATOR, SCENES / "silicone-block.yaml", "--slave", "127.0.0.1:1")
        self.assertEqual(done.returncode, 1)
        self.assertIn("palpate-simulator: ", done.stderr)

    def test_samples_that_a_slave_cannot_use_are_reported(self):
        with Slave(BLOCK, simulates=False) as slave, \
                subprocess.Popen([SIMULATOR, BLOCK, "--slave", slave.address, "--override", "sense.camera.pixel=0.5 mm"],
                                 stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=BARE) as process:
            try:
                self.assertTrue(any("waiting for the slave: " in line for line in process.stderr))
            finally:
                process.kill()

    def press(self, scene, most):
        """Runs a slow press. `most` limits the rms error of the estimated force, relative to the peak."""
        log = self.out / "log.csv"
        with Slave(SCENES / f"{scene}.yaml", *SLOW) as slave:
            press_until(lambda rows: followed(rows) > 1.5 * MIN_TICKS, slave.address, self.out)
        error, delay, ticks = force_error(log)
        print(f"{scene}: {100 * error:.2f} % after {delay} ms", flush=True)
        self.assertGreater(ticks, MIN_TICKS)
        self.assertLess(error, most)

    # The limit is twice the error of the offline runs in RESULTS, because the tool moves between samples.
    def test_block(self):
        self.press("silicone-block", 0.01)

    def test_cube(self):
        self.press("foam-cube", 0.06)


if __name__ == "__main__":
    unittest.main()
