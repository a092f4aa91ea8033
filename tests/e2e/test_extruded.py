"""A stick presses a cube in front of one camera: slave, simulator and master together."""
import math
import threading
import unittest

from force_error import force_error
from programs import ROOT, SLAVE, FolderTest, Slave, read_rows, run
from tick_log import followed, press_until

CUBE = ROOT / "deploy/scenes/gel-cube.yaml"
# Limits relative to the peak, as stated for the scene's model: rms error, largest error of a valid state; and share of
# valid states.
RMS, MAX_ERROR, VALID = 0.05, 0.1, 0.8


def collect(stream, states):
    """Appends the messages of a stream until it is cancelled."""
    try:
        for state in stream:
            states.append(state)
    except Exception:  # an error of gRPC, which may not be installed
        pass


def force(row, prefix):
    return [float(row[prefix + axis] or "nan") for axis in "xyz"]


class Extruded(FolderTest):
    def test_the_states_of_a_press_are_valid_and_right(self):
        """Compares each image of a scripted press with the true force at its time, from brick elements that share no
        code with the model."""
        done = run(SLAVE, "process", CUBE, "--out", self.out)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        rows = read_rows(self.out / "states.csv")
        peak = max(math.hypot(*force(row, "true_f")) for row in rows)
        pressed = [row for row in rows if math.hypot(*force(row, "true_f")) > 0.02 * peak]
        valid = [row for row in pressed if row["validity"] == "valid"]
        errors = [math.dist(force(row, "f"), force(row, "true_f")) for row in valid]
        print(f"peak {peak:.3f} N, {len(valid)} of {len(pressed)} valid, largest error {max(errors) / peak:.1%}")
        self.assertGreater(len(pressed), 20)
        self.assertGreaterEqual(len(valid), VALID * len(pressed))
        self.assertLess(math.sqrt(sum(e * e for e in errors) / len(errors)), RMS * peak)
        self.assertLess(max(errors), MAX_ERROR * peak)

    def test_a_press_is_estimated_live(self):
        with Slave(CUBE) as slave:
            states = []
            stream = self.client(slave.address).WatchState(self.messages.WatchStateRequest(details=True))
            self.addCleanup(stream.cancel)
            threading.Thread(target=collect, args=(stream, states), daemon=True).start()
            report, _ = press_until(lambda rows: followed(rows) > 1500, slave.address, self.out)
            stream.cancel()
        pressed = [state for state in states if state.local_model.in_contact]
        valid = [state for state in pressed if state.validity == self.states.VALIDITY_VALID]
        error, delay, ticks = force_error(self.out / "log.csv")
        print(f"{len(valid)} of {len(pressed)} contact states valid, rms {error:.1%} of {report['force_peak_N']:.2f} N, {ticks} ticks, {delay} ms late")
        self.assertEqual(report["force_peak_is"], "true")
        self.assertGreater(len(pressed), 20)
        self.assertGreaterEqual(len(valid), VALID * len(pressed))
        self.assertGreater(ticks, 500)
        self.assertLess(error, RMS)


if __name__ == "__main__":
    unittest.main(verbosity=2)
