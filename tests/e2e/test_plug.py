"""A laboratory's own camera and arm, from the first words to the force."""
import json
import unittest

from plugs import Plugged
from tick_log import followed, press_until


class Plug(Plugged):
    def test_what_is_missing_is_reported_and_what_comes_is_estimated(self):
        self.assertTrue(any("no image received yet" in alarm for alarm in self.status().alarms))
        self.assertTrue(any("no driver of the manipulator is connected" in alarm for alarm in self.status().alarms))
        self.play()
        self.drive()
        self.assertTrue(self.ready(), self.status())
        report, _ = press_until(lambda rows: followed(rows) > 3000, self.slave.address, self.out)
        print(json.dumps(report))
        self.assertGreater(report["force_peak_N"], 1.5)
        # At the commanded place: what the same instant makes of the way there is the machine's.
        error = report["force_error_delay_compensated"]
        self.assertGreater(error["contact_ticks"], 500)
        self.assertLess(error["rms_N"], 0.1 * report["force_peak_N"])
        arm = self.status().arm
        self.assertEqual(arm.driver_name, "fake six-axis arm")
        self.assertAlmostEqual(arm.scale, 1, delta=0.1)
        print(json.dumps({"lag_ms": 1e3 * arm.lag, "scale": arm.scale}))


if __name__ == "__main__":
    unittest.main(verbosity=2)
