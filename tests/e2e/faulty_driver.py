"""A driver of an arm that becomes faulty when it gets SIGUSR1.

usage: faulty_driver.py HOST:PORT [options of drive_arm.py] flood|nan|jump|fault

  flood  reports without pause
  nan    positions that are not numbers
  jump   positions displaced by a metre
  fault  reports a fault
"""
import math
import signal
import sys
import time

import drive_arm
import palpate


class FaultyArm(drive_arm.Arm):
    is_bad = False

    def measure(self, dt):
        reading = super().measure(dt)
        if self.is_bad:
            self.spoil(reading)
        return reading

    def spoil(self, reading):
        if HOW == "flood":
            time.sleep = lambda _: None  # removes the pause between reports
        elif HOW == "nan":
            reading.tip = [math.nan, *reading.tip[1:]]
        elif HOW == "jump":
            reading.tip = [reading.tip[0] + 1.0, *reading.tip[1:]]
        else:
            reading.fault = "axis 3 has lost its encoder"


if __name__ == "__main__":
    HOW = sys.argv.pop()

    def go_wrong(*_):
        FaultyArm.is_bad = True
    signal.signal(signal.SIGUSR1, go_wrong)
    drive_arm.Arm = FaultyArm
    while True:  # restarts the driver as a supervisor would
        try:
            drive_arm.main()
        except palpate.Error as error:
            print(f"error: {error}")
        time.sleep(0.05)
