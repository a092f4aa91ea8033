"""An operator pinches through fingertips: slave, master and drivers together."""
import csv
import math
import pathlib
import random
import subprocess
import tempfile
import unittest

from programs import BARE, MASTER, PACKAGE, PATIENCE, ROOT, FolderTest, Slave, load_package, read_rows, run, wait_until
from tick_log import followed, press_until

CUBE = ROOT / "deploy/scenes/foam-cube.yaml"
EXAMPLES = ROOT / "deploy/examples"
ELECTRODES = [f"E{i}" for i in range(1, 20)]
STREAM = ("--override", "sense.tactile.source=stream")


@unittest.skipUnless("tactile:" in CUBE.read_text(), "the foam cube has no fingertips here")
class Fingertips(FolderTest):
    def test_a_pinch_is_estimated_and_seen(self):
        with Slave(CUBE) as slave:
            report, printed = press_until(lambda rows: followed(rows) > 1500, slave.address, self.out, "--record", self.out / "pinch.mcap")
            self.assertEqual(slave.stop(), 0)
        error, peak = report["force_error"], report["force_peak_N"]
        print(f"force error {error['rms_N']:.4f} N rms, {error['rms_N'] / peak:.0%} of {peak:.3f} N; "
              f"{report['states'] / report['duration_s']:.0f} states/s; fingers {report['fingers']}")
        self.assertEqual(report["force_peak_is"], "true")
        self.assertGreater(error["contact_ticks"], 500)
        # An estimate of zero has an error equal to the peak. The error itself is printed.
        self.assertLess(error["rms_N"], peak)
        self.assertGreater(report["states"] / report["duration_s"], 90, "states are repeated at 100 Hz or more")
        self.assertEqual([finger["name"] for finger in report["fingers"]], ["ff", "th"])
        for finger in report["fingers"]:
            self.assertGreater(finger["contact_share"], 0.05, finger)
            self.assertGreater(finger["force_peak_N"], 0.05, finger)
        # The estimated deformation is larger than zero and at most twice the depth of the motion.
        self.assertGreater(report["shape"]["deflection_peak_m"], 0.5e-3)
        self.assertLess(report["shape"]["deflection_peak_m"], 20e-3)
        self.assert_finite(self.out / "log.csv")
        self.assertIn("ff", printed, "a person sees the fingers")

    def rest_recording(self, seconds):
        """Writes a recording without contact: counts around 3000 with a noise of one count."""
        noise = random.Random(1)
        path = self.out / "rest.csv"
        with open(path, "w", newline="") as out:
            rows = csv.writer(out)
            names = [f"{finger}_{name}" for finger in ("ff", "th") for name in (*ELECTRODES, "pdc", "pac0")]
            rows.writerow(["time_s", *names])
            for i in range(int(100 * seconds)):
                rows.writerow([f"{i * 0.01:.2f}", *(f"{3000 + noise.gauss(0, 1):.1f}" for _ in names)])
        return path

    def test_a_driver_in_another_language_feeds_the_fingertips(self):
        with Slave(CUBE, *STREAM) as slave:
            stub = self.client(slave.address)
            environment = {**BARE, "PYTHONPATH": str(PACKAGE)}
            driver = subprocess.Popen(["/usr/bin/python3", EXAMPLES / "feed_tactile.py", slave.address,
                                       self.rest_recording(4)], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                      stderr=subprocess.STDOUT, text=True, env=environment)
            known = (self.states.VALIDITY_VALID, self.states.VALIDITY_EXTRAPOLATED)
            stream = stub.WatchState(self.messages.WatchStateRequest(max_rate=100), timeout=PATIENCE)
            seen = []

            def both_are_known():
                seen.append(next(stream))
                fingers = seen[-1].fingers
                return len(fingers) == 2 and all(finger.validity in known for finger in fingers)

            self.assertTrue(wait_until(both_are_known), "no force was ever known")
            force = [seen[-1].fingers[0].force.x, seen[-1].fingers[0].force.y, seen[-1].fingers[0].force.z]
            self.assertTrue(all(map(math.isfinite, force)))
            output, _ = driver.communicate(timeout=PATIENCE)
            self.assertEqual(driver.returncode, 0, output)
            silent = wait_until(lambda: all(finger.validity not in known for finger in next(stream).fingers))
            self.assertTrue(silent, "a driver that is gone is noticed")
            stream.cancel()


NODULE = """name: nodule
object:
  geometry: {{box: {{size: [50 mm, 30 mm, 25 mm], cells: [14, 6, 5]}}}}
  material: {{young_modulus: 40 kPa, poisson_ratio: 0.45}}
  regions: [{{sphere: {{centre: [15 mm, 15 mm, 15 mm], radius: 5 mm}}, young_modulus: 200 kPa}}]
  fixed: {{plane: {{axis: z, at: 0}}}}
sense:
  tactile:
    source: simulated
    network: {network}
    rest: first 50
    hold: displacement
    fingers:
      ff: {{pose: {{translation: [{x} mm, 15 mm, 38 mm], rotation: [0 deg, 40 deg, 0 deg]}}}}
model: {{kind: fem-green, rate: 100 Hz, range: 20 %}}
operator: {{force_limit: 3.3 N}}
"""


class Nodule(unittest.TestCase):
    # A nodule of 10 mm, five times as stiff, 5 mm deep. The truth is that of the simulator, which uses neo-Hookean
    # hexahedra and a rigid finger. The ratio of the estimated forces above and beside the nodule is within 5 % of the
    # true ratio.
    def held_force(self, folder, x):
        """Returns the force of the first of five presses that was in FOLLOWING to its end: a busy machine may hold the
        tool while the playback continues."""
        for _ in range(5):
            held = self.held_rows(folder, x)
            if len(held) > 200:
                return [sum(float(row[column]) for row in held) / len(held) for column in ("estimated_z", "true_z")]
        self.fail(f"{x} mm: no press was followed to its end")

    def held_rows(self, folder, x):
        scene = folder / f"nodule-{x}.yaml"
        scene.write_text(NODULE.format(network=ROOT / "deploy/fingertips/simulated-tnn21", x=x))
        motion, log = folder / "motion.csv", folder / f"log-{x}.csv"
        with open(motion, "w") as out:
            out.write("time_s,x,y,z\n")
            for i in range(500):  # 10 mm down from 1 to 3 s, which is 2.4 mm deep, then held
                part = min(max((i * 0.01 - 1) / 2, 0), 1)
                out.write(f"{i * 0.01},0,0,{-0.01004 * part * part * (3 - 2 * part)}\n")
        palpate, messages, states = load_package()
        with Slave(scene) as slave, palpate.connect(slave.address) as connection:
            status = lambda: connection.stub.GetStatus(messages.GetStatusRequest(), timeout=PATIENCE)
            self.assertTrue(wait_until(lambda: status().validity == states.VALIDITY_VALID), "the baseline is measured")
            done = run(MASTER, "connect", slave.address, "--device", f"playback:{motion}", "--duration", "5", "--log", log)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return [row for row in read_rows(log) if float(row["t"]) > 3.7 and row["state"] == "FOLLOWING" and row["true_z"]]

    def test_a_stiff_nodule_increases_the_force_correctly(self):
        with tempfile.TemporaryDirectory() as name:
            over, beside = (self.held_force(pathlib.Path(name), x) for x in (19.5, 40.5))
        estimated, true = over[0] / beside[0], over[1] / beside[1]
        print(f"over the nodule {estimated:.3f} times the force beside it, in truth {true:.3f}")
        self.assertGreater(true, 1.15)
        self.assertLess(abs(estimated / true - 1), 0.05)

    # A contact at a position without a solution yet does not stop the tool. A busy machine may stop it, too, but not at
    # each of three new positions.
    def test_a_contact_beside_solved_ones_does_not_stop_the_tool(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            scene, motion, log = folder / "nodule.yaml", folder / "motion.csv", folder / "log.csv"
            scene.write_text(NODULE.format(network=ROOT / "deploy/fingertips/simulated-tnn21", x=25))
            free = []
            with Slave(scene) as slave:
                for beside in (8, -8, 12):  # [mm]
                    with open(motion, "w") as out:
                        out.write("time_s,x,y,z\n")
                        for i in range(450):  # moves sideways in half a second, then 10 mm down and up again
                            aside = beside * 1e-3 * min(i / 50, 1)
                            part = min(max((i * 0.01 - 1) / 1.5, 0), 1) - min(max((i * 0.01 - 3) / 1.5, 0), 1)
                            out.write(f"{i * 0.01},{aside},0,{-0.01 * part * part * (3 - 2 * part)}\n")
                    done = run(MASTER, "connect", slave.address, "--device", f"playback:{motion}", "--duration", "5", "--log", log)
                    self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                    rows = read_rows(log)
                    touches = any(row["state"] == "FOLLOWING" and float(row["estimated_z"] or 0) > 0.05 for row in rows)
                    free.append(touches and all(row["state"] != "HOLD" for row in rows))
            self.assertIn(True, free)


if __name__ == "__main__":
    unittest.main(verbosity=2)
