#!/usr/bin/python3
"""Drives the slave's manipulator with a Sutter MP-285 or MP-225 on a serial port. Needs python3-serial.

usage: drive_mp285.py HOST:PORT PORT --home X,Y,Z [--speed MM/S] [--duration S] [--tls DIR]

The scene needs `manipulator: {source: stream, silence: 100 ms}`. The axes of the drive are parallel to those of S.
--home: position of the tool tip at the start, frame S [m], as `manipulator.home` of the scene. Small moves at the rate of the port, each followed by a position query: some
20 reports per second. The protocol has no checksum, so an answer is accepted only if it is complete and plausible.

Prints the number of reports and targets. Exit code 0: both were exchanged; 1: rejected, or no manipulator.
"""
import argparse
import signal
import struct
import sys
import time
from typing import Sequence

import numpy as np
import numpy.typing as npt
import palpate
import serial  # type: ignore[import]

Steps = tuple[int, int, int]
STEP = 0.0625e-6   # [m]
TRAVEL = 400_000   # steps, 25 mm
PATIENCE = 0.25    # [s] longest wait for an answer, beyond the duration of a move
RATE = 20          # [Hz] reports
MAX_SILENT_PERIODS = 4           # silent periods of PATIENCE after which the device may have been switched off
ERRORS = {b"0": "a character arrived before the previous one was read", b"1": "a character without a stop bit",
          b"2": "input without an end character", b"4": "unknown command", b"8": "a move was interrupted"}


class Fault(Exception):
    """The position is unknown, and nothing moves."""


class Mp285:
    """The protocol: 9600 baud, three numbers of four bytes, the lowest first, and an end character."""

    def __init__(self, port: str) -> None:
        self.line = serial.Serial(port, 9600, timeout=PATIENCE, write_timeout=PATIENCE)
        self.known: Steps | None = None  # last position
        self.sent: Steps | None = None   # target of a move that may have been executed since
        self.received_at = time.monotonic()

    def find(self) -> Steps:
        """Interrupts a move, discards pending data, and reads the position twice. After a longer silence the position
        must be the last one or on the commanded path: a device that was switched off counts from another origin.
        """
        was_away = self.known is not None and time.monotonic() - self.received_at > MAX_SILENT_PERIODS * PATIENCE
        self._write(b"\x03")
        while self.line.read(64):
            pass
        once, again = self._query(), self._query()
        if once != again:
            raise Fault(f"it reports two different positions, {once} and {again} steps")
        if was_away and self.known and self.sent and not all(
                min(a, b) <= s <= max(a, b) for s, a, b in zip(once, self.known, self.sent)):
            raise Fault(f"its position was {self.known} and is now {once} steps: it was switched off and on, or moved by "
                        "hand; expected a restart at home")
        return self._know(once)

    def _know(self, steps: Steps) -> Steps:
        self.known = self.sent = steps
        self.received_at = time.monotonic()
        return steps

    def move_to(self, steps: Steps, takes: float) -> Steps:
        self.sent = steps
        self._write(b"m" + struct.pack("<3i", *steps) + b"\r")
        self.line.timeout = takes + PATIENCE
        answer = self.line.read(1)
        self.line.timeout = PATIENCE
        if answer != b"\r":
            raise Fault(ERRORS.get(answer, "a malformed answer") if answer else "a move did not finish")
        there = self._query()
        if there != steps:
            raise Fault(f"its position is {there} steps, commanded was {steps}")
        return self._know(there)

    def poll(self) -> Steps:
        once = self._query()
        if once != self.known and self._query() != once:  # a change counts only if it is read twice
            raise Fault("it reports two different positions")
        return self._know(once)

    def _query(self) -> Steps:
        self._write(b"c\r")
        answer = self.line.read(13)
        if len(answer) != 13:
            raise Fault("no complete answer to the position query")
        x, y, z = struct.unpack("<3i", answer[:12])
        steps: Steps = (x, y, z)
        origin = self.known or (0, 0, 0)
        if answer[12:] != b"\r" or any(abs(s) > TRAVEL or abs(s - o) > TRAVEL for s, o in zip(steps, origin)):
            raise Fault("a malformed answer to the position query")
        return steps

    def _write(self, data: bytes) -> None:
        try:
            self.line.write(data)
        except serial.SerialException as error:
            raise Fault(f"the serial port accepts no data: {error}") from error


class Arm:
    """Follows targets in moves of one report's length. After a fault it holds until the position is found again."""

    def __init__(self, drive: Mp285, home: Sequence[float], speed: float) -> None:
        self.drive, self.speed = drive, speed
        self.home: npt.NDArray[np.float64] = np.array(home)
        self.origin = drive.find()
        self.tip = self.home
        self.target: npt.NDArray[np.float64] | None = None
        self.is_lost = False

    def go(self, tip: npt.NDArray[np.float64], velocity: npt.NDArray[np.float64],
           orientation: npt.NDArray[np.float64] | None) -> None:
        self.target = None if self.is_lost else tip

    def hold(self) -> None:
        self.target = None

    def measure(self, dt: float) -> palpate.ArmReading:
        before = self.tip
        try:
            steps = self.drive.find() if self.is_lost else self._step(min(dt, 0.2))
        except (Fault, serial.SerialException) as error:
            self.is_lost, self.target = True, None
            return palpate.ArmReading(self.tip, fault=f"the micromanipulator: {error}")
        self.is_lost = False
        self.tip = self.home + STEP * (np.array(steps) - np.array(self.origin))
        return palpate.ArmReading(self.tip, (self.tip - before) / dt if dt > 0 else np.zeros(3))

    def _step(self, dt: float) -> Steps:
        if self.target is None:
            return self.drive.poll()
        way = self.target - self.tip
        length = float(np.linalg.norm(way))
        wanted = self.tip + way * min(1.0, self.speed * dt / length) if length > 0 else self.tip
        whole = np.rint((wanted - self.home) / STEP).astype(int) + np.array(self.origin)
        x, y, z = (int(s) for s in whole)
        if (x, y, z) == self.drive.known:
            return self.drive.poll()
        return self.drive.move_to((x, y, z), 2 * dt)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("port", help="serial port, for example /dev/ttyUSB0")
    parser.add_argument("--home", required=True, help="X,Y,Z [m]")
    parser.add_argument("--speed", type=float, default=3, metavar="MM/S")
    parser.add_argument("--duration", type=float)
    parser.add_argument("--tls", metavar="DIR", help="folder with ca.pem, cert.pem and key.pem")
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    with palpate.connect(arguments.target, arguments.tls) as slave:
        home = [float(x) for x in arguments.home.split(",")]
        arm = Arm(Mp285(arguments.port), home, 1e-3 * arguments.speed)
        done = slave.drive(arm, RATE, arguments.duration, f"MP-285 on {arguments.port}")
    print(f"{done.reports} reports, {done.targets} targets")
    return 0 if done.reports and done.targets else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (palpate.Error, serial.SerialException, Fault) as error:
        sys.exit(f"error: {error}")
