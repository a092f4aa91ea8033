"""The contact wrench of a slave as a sensor: newest value, unit, frame, sign, standard deviation and validity."""
from __future__ import annotations

import dataclasses
import math
import threading
import time
from typing import Any

import palpate

AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
FEATURES: dict[str, type] = {f"wrench.{name}": float for name in (*AXES, "sigma", "valid", "age")}
STALE = 0.2  # [s] without a new sample, after which a value is not valid


@dataclasses.dataclass(frozen=True)
class Wrench:
    """One estimate. Force [N] and torque [N m] of the object on the tool, at the tip, in the frame of the sensor; NaN is unknown."""
    force: tuple[float, float, float]
    torque: tuple[float, float, float]
    sigma: float  # one standard deviation of the force [N]
    valid: bool  # the force is a measurement
    taken_at: float  # when it arrived [s], time.perf_counter()

    def observation(self, now: float) -> dict[str, float]:
        """The entries of FEATURES. A value that is not valid, or older than STALE, has `wrench.valid` 0 and keeps its numbers;
        unknown numbers are 0, because a data set has no NaN."""
        age = now - self.taken_at
        numbers = [number if math.isfinite(number) else 0.0 for number in (*self.force, *self.torque, self.sigma)]
        is_usable = self.valid and age <= STALE and all(map(math.isfinite, (*self.force, self.sigma)))
        return dict(zip(FEATURES, (*numbers, float(is_usable), age)))


class WrenchSensor:
    """Follows a slave in a thread. The methods are those of LeRobot's cameras.

    target  HOST:PORT of the slave     tls    folder of certificates; None: plain text on loopback
    frame   name of frame S, in which the wrench is, as your data set calls it
    """

    def __init__(self, target: str = "127.0.0.1:50051", tls: str | None = None, frame: str = "palpate_slave") -> None:
        self._target, self._tls, self.frame = target, tls, frame
        self._changed = threading.Condition()
        self._newest: Wrench | None = None
        self._returned_at = -math.inf  # arrival time of the value that async_read returned last
        self._failure: Exception | None = None
        self._slave: palpate.Slave | None = None
        self._thread: threading.Thread | None = None
        self._ends = threading.Event()

    @property
    def features(self) -> dict[str, type]:
        """Names and types of an observation: wrench.fx to wrench.fz [N], wrench.tx to wrench.tz [N m], wrench.sigma [N],
        wrench.valid (1: a measurement), wrench.age [s]."""
        return dict(FEATURES)

    @property
    def info(self) -> dict[str, Any]:
        """What the numbers mean, for the description of a data set."""
        return {"unit": {"force": "N", "torque": "N*m", "sigma": "N", "age": "s"}, "frame": self.frame,
                "sign": "of the object on the tool", "point": "tip of the tool", "sigma": "one standard deviation of the force",
                "valid": "1: a measurement; 0: outside the model's range, a failed check, or stale", "source": "palpate"}

    @property
    def is_connected(self) -> bool:
        return self._thread is not None

    def connect(self, warmup: bool = True) -> None:
        """Connects, and waits up to 5 s for the first value. Raises palpate.Error, TimeoutError."""
        if self.is_connected:
            raise RuntimeError("WrenchSensor is already connected")
        self._ends.clear()
        self._newest, self._failure = None, None
        self._slave = palpate.connect(self._target, self._tls)
        self._thread = threading.Thread(target=self._follow, name="palpate wrench", daemon=True)
        self._thread.start()
        if warmup:
            try:
                self.async_read(timeout_ms=5000)
            except BaseException:
                self.disconnect()
                raise

    def disconnect(self) -> None:
        """Ends the thread and the connection."""
        if self._thread is None or self._slave is None:
            raise RuntimeError("WrenchSensor is not connected")
        self._ends.set()
        self._slave.close()
        self._thread.join()
        self._thread, self._slave = None, None

    def read(self) -> dict[str, float]:
        """The newest value, at once."""
        return self.newest().observation(time.perf_counter())

    def async_read(self, timeout_ms: float = 200) -> dict[str, float]:
        """The next value that was not returned yet. Raises TimeoutError."""
        self._require_connected()
        with self._changed:
            arrived = self._changed.wait_for(lambda: self._failure is not None or
                                             (self._newest is not None and self._newest.taken_at > self._returned_at), timeout_ms / 1000)
            if self._failure is not None:
                raise self._failure
            if not arrived or self._newest is None:
                raise TimeoutError(f"no wrench within {timeout_ms:g} ms")
            self._returned_at = self._newest.taken_at
            return self._newest.observation(time.perf_counter())

    def read_latest(self) -> tuple[dict[str, float], float]:
        """The newest value, and when it arrived [s], time.perf_counter()."""
        newest = self.newest()
        return newest.observation(time.perf_counter()), newest.taken_at

    def newest(self) -> Wrench:
        """Raises RuntimeError: not connected, or no value yet; palpate.Error: the slave is gone."""
        self._require_connected()
        with self._changed:
            if self._failure is not None:
                raise self._failure
            if self._newest is None:
                raise RuntimeError("WrenchSensor has no value yet")
            return self._newest

    def send_feedback(self, teleoperator: Any) -> dict[str, float]:
        """Sends the force to a teleoperator that renders one, and returns what was sent.

        It sends those of wrench.fx to wrench.tz that its `feedback_features` contain. A force that is not valid or
        stale is sent as zero. Raises ValueError: it renders no force.
        """
        wanted = [f"wrench.{axis}" for axis in AXES if f"wrench.{axis}" in teleoperator.feedback_features]
        if not wanted:
            raise ValueError(f"{type(teleoperator).__name__}.feedback_features = {sorted(teleoperator.feedback_features)}: "
                             "expected wrench.fx, wrench.fy or wrench.fz")
        value = self.read()
        feedback = {key: value[key] if value["wrench.valid"] else 0.0 for key in wanted}
        teleoperator.send_feedback(feedback)
        return feedback

    def _require_connected(self) -> None:
        if not self.is_connected:
            raise RuntimeError("WrenchSensor is not connected: call connect()")

    def _follow(self) -> None:
        last = None
        try:
            assert self._slave is not None
            for state in self._slave.states(details=True):
                is_new = state.t != last
                last = state.t
                with self._changed:
                    if is_new or self._newest is None or self._newest.valid != state.valid:
                        at = time.perf_counter() if is_new or self._newest is None else self._newest.taken_at
                        self._newest = Wrench(tuple(map(float, state.force)), tuple(map(float, state.moment)), float(state.sigma),
                                              bool(state.valid), at)
                        self._changed.notify_all()
                if self._ends.is_set():
                    return
        except Exception as error:  # an error of the connection; the next read raises it
            if not self._ends.is_set():
                with self._changed:
                    self._failure = error
                    self._changed.notify_all()
