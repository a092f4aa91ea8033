"""Driver of a manipulator."""
from __future__ import annotations

import dataclasses
import math
import threading
import time
from typing import Any, Iterator, Protocol, Sequence

import numpy as np

from palpate.errors import Source, translated
from palpate.feeds import set_time, set_vector
from palpate.state import Array, vector
from palpate.v1 import devices_pb2

SILENCE = 0.1  # [s] without a target, after which the arm holds on its own


@dataclasses.dataclass
class ArmReading:
    """What the encoders and sensors of a manipulator measure, in frame S."""
    tip: Sequence[float] | Array  # tool tip [m]
    velocity: Sequence[float] | Array | None = None  # [m/s]
    orientation: Sequence[float] | Array = ()  # rotation of the tool, w x y z
    force: Sequence[float] | Array | None = None  # of the object on the tool, by a sensor [N]; no estimator reads it
    fault: str = ""  # why it does not move; the slave then holds the tool
    at_limit: bool = False


class Arm(Protocol):
    """A manipulator. The calls come one at a time."""

    def measure(self, dt: float) -> ArmReading:
        """Reads the encoders; `dt` is the time since the last call [s]."""

    def go(self, tip: Array, velocity: Array, orientation: Array | None) -> None:
        """Moves to `tip` [m], which moves with `velocity` [m/s]."""

    def hold(self) -> None:
        """Holds the present position."""


@dataclasses.dataclass
class Exchange:
    """Numbers of messages of a driver."""
    reports: int = 0
    targets: int = 0


class ArmDriver:
    """Reports `arm` and moves it to the slave's targets. It holds the arm after 100 ms without a target, and at the end."""

    def __init__(self, arm: Arm, rate: float, seconds: float | None, name: str) -> None:
        self._arm, self._rate, self._name = arm, rate, name
        self._end = math.inf if seconds is None else time.monotonic() + seconds
        self._heard, self._target = time.monotonic(), 0
        self._lock = threading.Lock()
        self.exchange = Exchange()

    def run(self, stub: Any) -> Exchange:
        try:
            source = Source(self._reports())
            with translated(source):
                for target in stub.DriveTool(iter(source)):
                    self._take(target)
        finally:
            with self._lock:
                self._arm.hold()
        return self.exchange

    def _take(self, target: devices_pb2.ArmTarget) -> None:
        with self._lock:
            self._heard, self._target = time.monotonic(), target.sequence
            self.exchange.targets += 1
            if target.motion == devices_pb2.ArmTarget.MOTION_FOLLOW:
                turn = np.array(target.orientation) if target.orientation else None
                self._arm.go(vector(target.p_S_tip), vector(target.velocity), turn)
            else:
                self._arm.hold()

    def _reports(self) -> Iterator[devices_pb2.ArmReport]:
        last = due = time.monotonic()
        while due < self._end:
            now = time.monotonic()
            yield self._report(now - last)
            last, due = now, max(due + 1 / self._rate, now)
            time.sleep(max(0.0, due - time.monotonic()))

    def _report(self, dt: float) -> devices_pb2.ArmReport:
        with self._lock:
            if time.monotonic() - self._heard > SILENCE:
                self._arm.hold()
            reading = self._arm.measure(dt)
            self.exchange.reports += 1
            message = devices_pb2.ArmReport(sequence=self.exchange.reports, driver_name=self._name, rate=self._rate,
                                            target_sequence=self._target, fault=reading.fault, at_limit=reading.at_limit,
                                            orientation=[float(x) for x in reading.orientation])
        set_time(message.measured_at, None)
        set_vector(message.p_S_tip, reading.tip)
        if reading.velocity is not None:
            set_vector(message.velocity, reading.velocity)
        if reading.force is not None:
            set_vector(message.measured_force, reading.force)
        return message
