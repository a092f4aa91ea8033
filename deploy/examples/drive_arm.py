#!/usr/bin/python3
"""Drives a slave's manipulator with only the .proto files: a simulated arm of six axes as a template of a driver.

usage: drive_arm.py HOST:PORT [--home X,Y,Z] [--rate HZ] [--duration S] [--site HOST:PORT]

The scene needs `manipulator: {source: stream}`. Three axes carry the wrist, three keep the rotation of the
tool. A driver of a real arm replaces only `Arm.measure` and `Arm.go`.
--home: position of the tool's tip at the start, frame S [m]; default: the middle of the workspace.
--site: sends the tip by UDP to a simulator, `x y z` in metres, which answers with the force on the tool,
`fx fy fz` in newtons, like a force sensor at the tool.

Prints the numbers of reports and targets. Exit code 0: both above zero; 1: rejected; 2: unusable arguments.
"""
import argparse
import math
import signal
import socket
import sys
import threading
import time

import grpc

import palpate_stubs

messages, services, states = palpate_stubs.load()
from palpate.v1 import devices_pb2 as devices  # noqa: E402: made by palpate_stubs

SILENCE = 0.1     # [s] without a target: the arm stands by itself
SERVO = 0.003     # [s] time constant of each axis
FASTEST = 3.0     # [rad/s] of an axis
UPPER = LOWER = 0.25  # [m] lengths of the arm's two links


class Arm:
    """Six axes that follow their commanded angles as servos do. Its shoulder stands so that `home` is well within reach."""

    def __init__(self, home):
        self.base = [home[0] - 0.3, home[1], home[2] - 0.15]
        self.commanded = self.inverse(home)
        self.angles = list(self.commanded)
        self.previous, self.velocity = list(home), [0.0, 0.0, 0.0]

    def inverse(self, p):
        """Yaw, shoulder, elbow that put the wrist at p, and three of the wrist that undo their rotation."""
        x, y, z = (a - b for a, b in zip(p, self.base))
        yaw, flat = math.atan2(y, x), math.hypot(x, y)
        reach = min(math.hypot(flat, z), UPPER + LOWER - 1e-6)
        cosine = (reach ** 2 - UPPER ** 2 - LOWER ** 2) / (2 * UPPER * LOWER)
        elbow = math.acos(max(-1.0, min(1.0, cosine)))
        shoulder = math.atan2(z, flat) - math.atan2(LOWER * math.sin(elbow), UPPER + LOWER * math.cos(elbow))
        return [yaw, shoulder, elbow, -elbow, -shoulder, -yaw]

    def tip(self):
        yaw, shoulder, elbow = self.angles[:3]
        flat = UPPER * math.cos(shoulder) + LOWER * math.cos(shoulder + elbow)
        z = UPPER * math.sin(shoulder) + LOWER * math.sin(shoulder + elbow)
        return [self.base[0] + flat * math.cos(yaw), self.base[1] + flat * math.sin(yaw), self.base[2] + z]

    def go(self, p):
        self.commanded = self.inverse(p)

    def stand(self):
        self.commanded = list(self.angles)

    def measure(self, dt):
        """Lets `dt` seconds pass; the tip and its velocity as the encoders have them."""
        if dt <= 0:
            return self.previous, self.velocity
        share = 1 - math.exp(-dt / SERVO)
        for i, wanted in enumerate(self.commanded):
            step = share * (wanted - self.angles[i])
            self.angles[i] += max(-FASTEST * dt, min(FASTEST * dt, step))
        tip = self.tip()
        self.velocity = [(a - b) / dt for a, b in zip(tip, self.previous)]
        self.previous = tip
        return tip, self.velocity


class Site:
    """Stands in for a force sensor at the tool."""

    def __init__(self, address):
        self.socket = None
        self.force = None
        if address:
            host, port = address.rsplit(":", 1)
            self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self.socket.connect((host, int(port)))
            self.socket.setblocking(False)

    def tell(self, tip):
        if self.socket is None:
            return
        try:
            self.socket.send(" ".join(f"{x:.9g}" for x in tip).encode())
            while True:
                self.force = [float(x) for x in self.socket.recv(200).split()]
        except OSError:
            pass  # no newer answer, or nobody there


class Driver:
    def __init__(self, arm, site, rate, duration):
        self.arm, self.site, self.rate = arm, site, rate
        self.end = time.monotonic() + duration if duration else math.inf
        self.heard, self.target_sequence, self.reports, self.targets = time.monotonic(), 0, 0, 0
        self.lock = threading.Lock()

    def take(self, target):
        with self.lock:
            self.heard, self.target_sequence = time.monotonic(), target.sequence
            self.targets += 1
            if target.motion == devices.ArmTarget.MOTION_FOLLOW:
                self.arm.go((target.p_S_tip.x, target.p_S_tip.y, target.p_S_tip.z))
            else:
                self.arm.stand()

    def report(self, dt):
        with self.lock:
            if time.monotonic() - self.heard > SILENCE:
                self.arm.stand()
            tip, velocity = self.arm.measure(dt)
            self.site.tell(tip)
            self.reports += 1
            message = devices.ArmReport(sequence=self.reports, driver_name="fake six-axis arm", rate_hz=self.rate,
                                        target_sequence=self.target_sequence, orientation=[1, 0, 0, 0])
        message.measured_at.FromNanoseconds(time.time_ns())
        message.p_S_tip.x, message.p_S_tip.y, message.p_S_tip.z = tip
        message.velocity.x, message.velocity.y, message.velocity.z = velocity
        if self.site.force:
            message.measured_force.x, message.measured_force.y, message.measured_force.z = self.site.force
        return message

    def reporting(self):
        """A report per period, as long as the driver lives."""
        last = due = time.monotonic()
        while due < self.end:
            now = time.monotonic()
            yield self.report(now - last)
            last, due = now, max(due + 1 / self.rate, now)
            time.sleep(max(0.0, due - time.monotonic()))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("--home", help="X,Y,Z [m]")
    parser.add_argument("--rate", type=float, default=250)
    parser.add_argument("--duration", type=float)
    parser.add_argument("--site", help="HOST:PORT")
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))

    stub = services.TeleoperationStub(palpate_stubs.connect(grpc, arguments.target))
    can = stub.GetCapabilities(messages.GetCapabilitiesRequest(), timeout=10)
    low, high = can.workspace_min, can.workspace_max
    home = [0.5 * (a + b) for a, b in ((low.x, high.x), (low.y, high.y), (low.z, high.z))]
    if arguments.home:
        home = [float(x) for x in arguments.home.split(",")]
    driver = Driver(Arm(home), Site(arguments.site), arguments.rate, arguments.duration)
    try:
        for target in stub.DriveTool(driver.reporting()):
            driver.take(target)
    except grpc.RpcError as error:
        print(f"wrong: {error.code().name}: {error.details()}")
        return 1
    print(f"{driver.reports} reports, {driver.targets} targets")
    return 0 if driver.reports and driver.targets else 1


if __name__ == "__main__":
    raise SystemExit(main())
