"""Operates a slave: lease, clutch, watchdog, and motions of the tool in frame S."""
from __future__ import annotations

import contextlib
import threading
import time
from types import TracebackType
from typing import Any, Callable, Iterator, Sequence

import grpc
import numpy as np

from palpate.errors import Error, Interrupted, LeaseHeld, reason_of, translated
from palpate.feeds import set_time, set_vector
from palpate.state import Array, Phase, State, States, rotation_matrix, vector
from palpate.v1 import scene_pb2, state_pb2, teleoperation_pb2

PERIOD = 0.004  # [s] between commands; the slave holds the tool after 30 ms of silence
SILENT = 0.5    # [s] without a state: a link that is cut
MAX_HOLD = 1.0  # [s] after which a motion raises Interrupted if the tool does not follow
TIMEOUT = 10.0  # [s] longest wait for the first state and for an engagement


class Operator:
    """Holds the lease of a slave and moves its tool. `Slave.operate` makes it; use it in a `with` block.

    A thread sends the newest target every 4 ms, with the sequence of the newest state. A motion advances only while
    states arrive and the tool follows. So a lost link, a held tool or an emergency stop pause it and never make the tool
    jump. If the program ends or hangs in between, the tool holds its position.
    """

    def __init__(self, stub: Any, name: str) -> None:
        self._stub, self._name = stub, name
        # The settings of the scene as of the last engagement. Before the first one no motion needs them.
        self._scale, self._rotation, self._revision, self._silence = 1.0, np.eye(3), 0, 0.030
        self._changed = threading.Condition()
        self._states: list[State] = []  # the newest, and during a motion all since it began
        self._is_moving = False
        self._heard = 0.0
        self._error: Exception | None = None
        self._closing = self._ended = False
        self._sequence, self._epoch, self._engaged = 0, 0, False
        self._offset: Array | None = None  # tip at the engagement
        # Displacement from there: present and final, frame S; speed.
        self._moved, self._goal, self._speed = np.zeros(3), np.zeros(3), 0.0
        metadata = (("palpate-operator-bin", name.encode()),)
        self._stream = stub.Operate(self._commands(), metadata=metadata)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        try:
            self._wait(lambda: True, TIMEOUT, "no state arrived")
        except Error:
            self.close()
            raise

    # ---- public methods

    @property
    def state(self) -> State:
        """The newest state."""
        with self._changed:
            self._check()
            return self._states[-1]

    @property
    def position(self) -> Array:
        """Commanded tool tip [m]. Before the first engagement the measured one."""
        with self._changed:
            return self._states[-1].tip if self._offset is None else self._offset + self._moved

    def engage(self) -> None:
        """Closes the clutch: from now on the tool follows. It does not move by this. Raises Interrupted if the slave does not follow.

        The settings of the slave may have changed since the last engagement: they are read again.
        """
        with translated():
            scene = self._stub.GetScene(teleoperation_pb2.GetSceneRequest(), timeout=TIMEOUT)
        with self._changed:
            self._use(scene)
            self._epoch += 1
            self._engaged, self._offset, self._speed = True, None, 0.0
            self._moved, self._goal = np.zeros(3), np.zeros(3)

        def follows() -> bool:
            newest = self._states[-1]
            return newest.message.epoch == self._epoch and newest.phase == Phase.FOLLOWING

        self._wait(follows, TIMEOUT, "the slave does not follow")
        with self._changed:
            self._offset = vector(self._states[-1].message.offset)

    def release(self) -> None:
        """Opens the clutch: the tool is stationary."""
        with self._changed:
            self._engaged = False

    def move_to(self, tip: Sequence[float] | Array, speed: float = 0.005) -> States:
        """Moves the commanded tip in a straight line to `tip` [m] at `speed` [m/s]. Returns the states received meanwhile."""
        if not np.isfinite(tip).all() or not 0 < speed < np.inf:
            raise ValueError(f"tip {tip} m, speed {speed} m/s: expected finite numbers, and a speed > 0")
        offset, held = self._engaged_at(), time.monotonic()
        with self._motion():
            self._goal, self._speed = np.asarray(tip, dtype=np.float64) - offset, speed
            try:
                while not np.array_equal(self._moved, self._goal):
                    if self._follows():
                        held = time.monotonic()
                    elif time.monotonic() - held > MAX_HOLD:
                        raise self._interrupted("the tool does not follow")
                    self._changed.wait(PERIOD)
                    self._check()
            finally:
                self._goal = self._moved  # an interrupted motion does not continue by itself
            return States.of(self._states)

    def move_by(self, step: Sequence[float] | Array, speed: float = 0.005) -> States:
        """Moves the commanded tip by `step` [m]; see `move_to`."""
        self._engaged_at()
        return self.move_to(self.position + np.asarray(step, dtype=np.float64), speed)

    def hold(self, seconds: float) -> States:
        """Stays for `seconds`. Returns the states received meanwhile."""
        end = time.monotonic() + seconds
        with self._motion():
            while (left := end - time.monotonic()) > 0:
                self._changed.wait(left)
                self._check()
            return States.of(self._states)

    def stop(self, reason: str = "") -> None:
        """Emergency stop, latched until `Slave.reset`."""
        with translated():
            self._stub.Stop(teleoperation_pb2.StopRequest(reason=reason), timeout=TIMEOUT)

    def close(self) -> None:
        """Opens the clutch and returns the lease."""
        self._closing = True
        self._reader.join(TIMEOUT)
        self._stream.cancel()

    def __enter__(self) -> Operator:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    # ---- threads

    @contextlib.contextmanager
    def _motion(self) -> Iterator[None]:
        """Holds the lock during a motion and keeps all states from the newest one on. Between motions only the newest
        is kept."""
        with self._changed:
            del self._states[:-1]
            self._is_moving = True
            try:
                yield
            finally:
                self._is_moving = False

    def _use(self, scene: scene_pb2.SceneDescription) -> None:
        mapping = scene.operator
        self._scale, self._rotation = float(mapping.position_scale), rotation_matrix(mapping.orientation)
        self._revision, self._silence = scene.settings_revision, mapping.dead_after or 0.030

    def _engaged_at(self) -> Array:
        if self._offset is None or not self._engaged:
            self.engage()
        assert self._offset is not None
        return self._offset

    def _commands(self) -> Iterator[state_pb2.OperatorCommand]:
        last = time.monotonic()
        while not self._closing:
            now = time.monotonic()
            with self._changed:
                command = self._command(min(now - last, 0.02))  # after a stall of the machine the step is limited
            last = now
            yield command
            time.sleep(PERIOD)
        with self._changed:
            self._engaged = False
            command = self._command(0)
        yield command

    def _command(self, dt: float) -> state_pb2.OperatorCommand:
        left = self._goal - self._moved
        distance = float(np.linalg.norm(left))
        step, velocity = np.zeros(3), np.zeros(3)
        if distance > 0 and self._follows():
            step = left * min(1.0, self._speed * dt / distance)
            velocity = self._speed * left / distance
            self._moved = self._goal if distance <= self._speed * dt else self._moved + step
            self._changed.notify_all()
        self._sequence += 1
        command = state_pb2.OperatorCommand(sequence=self._sequence, epoch=self._epoch, engaged=self._engaged,
                                            settings_revision=self._revision)
        set_time(command.sent_at, None)
        to_device = self._rotation.T / self._scale
        set_vector(command.p_M, to_device @ self._moved)
        set_vector(command.velocity, to_device @ velocity)
        if self._sequence == 1:
            command.operator_name = self._name
        if self._states:
            newest = self._states[-1].message
            command.state_sequence = newest.sequence
            command.echo.CopyFrom(newest.sent_at)
        return command

    def _follows(self) -> bool:
        """The link is alive and the tool follows."""
        if not self._engaged or self._offset is None or time.monotonic() - self._heard > self._silence:
            return False
        newest = self._states[-1]
        return newest.message.epoch == self._epoch and newest.phase == Phase.FOLLOWING

    def _read(self) -> None:
        try:
            for message in self._stream:
                with self._changed:
                    if not self._is_moving:
                        self._states.clear()
                    self._states.append(State(message))
                    self._heard = time.monotonic()
                    self._changed.notify_all()
        except grpc.RpcError as error:
            reason = reason_of(error)
            kind = LeaseHeld if reason in ("LEASE_HELD", "LEASE_LOST") else Error
            self._error = kind(error.code().name, error.details() or "", reason)
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def _interrupted(self, what: str) -> Interrupted:
        silent = time.monotonic() - self._heard
        if self._states and silent > SILENT:
            what = f"no state of the slave for {silent:.1f} s: the link is cut"
        elif self._states:
            newest = self._states[-1]
            what += f": phase {newest.phase.name}, validity {newest.validity.name}"
            if newest.message.settings_revision != self._revision != 0:
                what += f"; the settings changed: revision {self._revision}, now {newest.message.settings_revision}"
        return Interrupted("INTERRUPTED", what)

    def _check(self) -> None:
        if self._ended and not self._closing:
            raise self._error or Error("OK", "the slave ended the stream")

    def _wait(self, condition: Callable[[], bool], patience: float, otherwise: str) -> None:
        end = time.monotonic() + patience
        with self._changed:
            while not (self._states and condition()):
                self._check()
                if time.monotonic() > end:
                    raise self._interrupted(otherwise)
                self._changed.wait(0.05)
