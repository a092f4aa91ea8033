"""An arm's driver that goes wrong when it gets SIGUSR1.

usage: bad_driver.py HOST:PORT [options of drive_arm.py] flood|nan|jump|fault

flood: reports as fast as it can; nan: a place that is no number; jump: the tool is a metre away; fault: it says what is wrong with it.
"""
import math
import signal
import sys
import time

import drive_arm


class BadDriver(drive_arm.Driver):
    is_bad = False

    def report(self, dt):
        message = super().report(dt)
        if self.is_bad:
            self.spoil(message)
        return message

    def spoil(self, message):
        if HOW == "flood":
            self.rate = 1e6
        elif HOW == "nan":
            message.p_S_tip.x = math.nan
        elif HOW == "jump":
            message.p_S_tip.x += 1.0
        else:
            message.fault = "axis 3 has lost its encoder"


if __name__ == "__main__":
    HOW = sys.argv.pop()

    def go_wrong(*_):
        BadDriver.is_bad = True
    signal.signal(signal.SIGUSR1, go_wrong)
    drive_arm.Driver = BadDriver
    while True:  # as a supervisor that starts it again and again
        drive_arm.main()
        time.sleep(0.05)
