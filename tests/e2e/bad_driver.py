"""An arm's driver that goes wrong when it gets SIGUSR1.

usage: bad_driver.py HOST:PORT [options of drive_arm.py] flood|nan|jump|fault|scale|stuck

flood: reports as fast as it can; nan: a place that is no number; jump: the tool is a metre away; fault: it says what is wrong with it.
In silence: scale, the tool goes 0.64 of the way that is told; stuck, the encoders tell the same place, whatever the tool does.
"""
import math
import signal
import sys
import time

import drive_arm


class BadSite(drive_arm.Site):
    from_here = None

    def tell(self, tip):
        if BadDriver.is_bad and HOW == "scale":
            self.from_here = self.from_here or list(tip)
            tip = [a + 0.64 * (b - a) for a, b in zip(self.from_here, tip)]
        super().tell(tip)


class BadDriver(drive_arm.Driver):
    is_bad = False
    stuck_at = None

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
        elif HOW == "stuck":
            self.stuck_at = self.stuck_at or [message.p_S_tip.x, message.p_S_tip.y, message.p_S_tip.z]
            message.p_S_tip.x, message.p_S_tip.y, message.p_S_tip.z = self.stuck_at
            message.velocity.x = message.velocity.y = message.velocity.z = 0
        elif HOW != "scale":
            message.fault = "axis 3 has lost its encoder"


if __name__ == "__main__":
    HOW = sys.argv.pop()

    def go_wrong(*_):
        BadDriver.is_bad = True
    signal.signal(signal.SIGUSR1, go_wrong)
    drive_arm.Driver, drive_arm.Site = BadDriver, BadSite
    while True:  # as a supervisor that starts it again and again
        drive_arm.main()
        time.sleep(0.05)
