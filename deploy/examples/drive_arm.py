#!/usr/bin/python3
"""Drives the slave's manipulator: a simulated six-axis arm in place of a real one.

usage: drive_arm.py HOST:PORT [--home X,Y,Z] [--rate HZ] [--duration S] [--site HOST:PORT] [--tls DIR]

The scene needs `manipulator: {source: stream}`. Three axes move the wrist, three turn the tool.
The driver of a real arm only replaces `Arm.measure`, `Arm.go` and `Arm.hold`.
--home: start position of the tool tip, frame S [m]; default: the middle of the workspace.
--site: sends the tip by UDP to a simulator, `x y z` in metres. The simulator returns the force on the tool,
`fx fy fz` in newtons, as a force sensor at the tool would measure it.

Prints the number of reports and targets. Exit code 0: both were exchanged; 1: rejected; 2: unusable arguments.
"""
import argparse
import math
import signal
import socket
import sys
from typing import Sequence

import numpy as np
import numpy.typing as npt
import palpate

Array = npt.NDArray[np.float64]
SERVO = 0.003     # [s] time constant of each axis
FASTEST = 3.0     # [rad/s] largest speed of an axis
UPPER = LOWER = 0.25  # [m] lengths of the two links of the arm


class Site:
    """A simulator of the object, which returns the force on the tool."""

    def __init__(self, address: str | None) -> None:
        self.socket: socket.socket | None = None
        self.force: list[float] | None = None
        if address:
            host, port = address.rsplit(":", 1)
            self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self.socket.connect((host, int(port)))
            self.socket.setblocking(False)

    def exchange(self, tip: Sequence[float]) -> list[float] | None:
        """Sends the tip and returns the newest force."""
        if self.socket is None:
            return None
        try:
            self.socket.send(" ".join(f"{x:.9g}" for x in tip).encode())
            while True:
                self.force = [float(x) for x in self.socket.recv(200).split()]
        except OSError:
            return self.force  # no newer answer, or no simulator


class Arm:
    """Six axes that follow their commanded angles with a first-order lag. The shoulder is placed so that `home` is well within reach."""

    def __init__(self, home: Sequence[float], site: Site) -> None:
        self.base = [home[0] - 0.3, home[1], home[2] - 0.15]
        self.commanded = self.inverse(home)
        self.angles = list(self.commanded)
        self.rotation: Array = np.array([1.0, 0, 0, 0])  # unit quaternions, measured and commanded
        self.turn = self.rotation
        self.previous, self.site = list(home), site

    def inverse(self, p: Sequence[float]) -> list[float]:
        """Angles of yaw, shoulder and elbow for a wrist at p. The other three axes follow the tool's rotation."""
        x, y, z = (a - b for a, b in zip(p, self.base))
        yaw, flat = math.atan2(y, x), math.hypot(x, y)
        reach = min(math.hypot(flat, z), UPPER + LOWER - 1e-6)
        cosine = (reach ** 2 - UPPER ** 2 - LOWER ** 2) / (2 * UPPER * LOWER)
        elbow = math.acos(max(-1.0, min(1.0, cosine)))
        shoulder = math.atan2(z, flat) - math.atan2(LOWER * math.sin(elbow), UPPER + LOWER * math.cos(elbow))
        return [yaw, shoulder, elbow]

    def tip(self) -> list[float]:
        yaw, shoulder, elbow = self.angles
        flat = UPPER * math.cos(shoulder) + LOWER * math.cos(shoulder + elbow)
        z = UPPER * math.sin(shoulder) + LOWER * math.sin(shoulder + elbow)
        return [self.base[0] + flat * math.cos(yaw), self.base[1] + flat * math.sin(yaw), self.base[2] + z]

    def go(self, tip: Array, velocity: Array, orientation: Array | None) -> None:
        self.commanded = self.inverse([float(x) for x in tip])
        self.turn = self.turn if orientation is None else orientation

    def hold(self) -> None:
        self.commanded, self.turn = list(self.angles), self.rotation

    def measure(self, dt: float) -> palpate.ArmReading:
        """Advances the arm by `dt` seconds and reads its encoders."""
        share = 1 - math.exp(-dt / SERVO)
        for i, wanted in enumerate(self.commanded):
            step = share * (wanted - self.angles[i])
            self.angles[i] += max(-FASTEST * dt, min(FASTEST * dt, step))
        moved = self.rotation + share * (self.turn - self.rotation)  # targets never change their sign
        self.rotation = moved / np.linalg.norm(moved)
        tip = self.tip()
        velocity = [(a - b) / dt if dt > 0 else 0.0 for a, b in zip(tip, self.previous)]
        self.previous = tip
        return palpate.ArmReading(tip, velocity, orientation=self.rotation, force=self.site.exchange(tip))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("--home", help="X,Y,Z [m]")
    parser.add_argument("--rate", type=float, default=250)
    parser.add_argument("--duration", type=float)
    parser.add_argument("--site", help="HOST:PORT")
    parser.add_argument("--tls", metavar="DIR", help="folder with ca.pem, cert.pem and key.pem")
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    with palpate.connect(arguments.target, arguments.tls) as slave:
        can = slave.scene().capabilities
        low, high = can.workspace_min, can.workspace_max
        home = [0.5 * (a + b) for a, b in ((low.x, high.x), (low.y, high.y), (low.z, high.z))]
        if arguments.home:
            home = [float(x) for x in arguments.home.split(",")]
        done = slave.drive(Arm(home, Site(arguments.site)), arguments.rate, arguments.duration, "fake six-axis arm")
    print(f"{done.reports} reports, {done.targets} targets")
    return 0 if done.reports and done.targets else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except palpate.Error as error:
        sys.exit(f"error: {error}")
