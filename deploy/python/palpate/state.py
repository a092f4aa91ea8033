"""States, fingertips and meshes as NumPy arrays."""
from __future__ import annotations

import dataclasses
import enum
import pathlib
from typing import Any, Iterable, Sequence

import numpy as np
import numpy.typing as npt

from palpate.v1 import state_pb2

Array = npt.NDArray[np.float64]


class Validity(enum.IntEnum):
    """How far a state can be trusted; state.proto explains the values."""
    UNSPECIFIED = 0
    VALID = 1
    EXTRAPOLATED = 2
    TRACKING_LOST = 3
    PUNCTURED = 4
    STALE = 5
    FAILED = 6


class Phase(enum.IntEnum):
    """How the slave treats the operator's motion."""
    UNSPECIFIED = 0
    READY = 1
    FOLLOWING = 2
    CLUTCHED = 3
    HOLD = 4
    ESTOP = 5
    OBSERVING = 6
    SETUP = 7


def check_name(number: int) -> str:
    """Name of a FailedCheck, for example `ARM`. Empty: none."""
    return "" if number == 0 else _name(state_pb2.FailedCheck, "FAILED_CHECK_", number)


# Checks and events grow with the protocol: an unknown number stays a number.
def _name(kind: Any, prefix: str, number: int) -> str:
    known = number in kind.values()
    return str(kind.Name(number)).removeprefix(prefix) if known else str(number)


def vector(message: Any) -> Array:
    """The three numbers of a Vec3 or Vec3f."""
    return np.array([message.x, message.y, message.z], dtype=np.float64)


def rotation_matrix(quaternion: Sequence[float]) -> Array:
    """The 3x3 rotation matrix of a unit quaternion w, x, y, z."""
    w, (x, y, z) = quaternion[0], quaternion[1:]
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    matrix: Array = np.eye(3) + 2 * w * cross + 2 * cross @ cross
    return matrix


def _unknown() -> Array:
    return np.full(3, np.nan)


def seconds(timestamp: Any) -> float:
    """A timestamp of protobuf [s since 1970]."""
    return 1e-9 * float(timestamp.ToNanoseconds())


def _validity(number: int) -> Validity:
    return Validity(number) if number in Validity._value2member_map_ else Validity.FAILED


class Fingertip:
    """One of several fingertips."""

    def __init__(self, message: state_pb2.FingerContact) -> None:
        self.message = message

    @property
    def point(self) -> Array:
        """Contact point on the object at rest, or the fingertip while it is free [m]."""
        return vector(self.message.p_S_contact)

    @property
    def force(self) -> Array:
        """Force of the object on the fingertip [N]. NaN: unknown."""
        known = self.message.HasField("force") and self.validity != Validity.STALE
        return vector(self.message.force) if known else _unknown()

    @property
    def in_contact(self) -> bool:
        """The fingertip touches the object."""
        return bool(self.message.in_contact)

    @property
    def validity(self) -> Validity:
        """How far the numbers can be trusted."""
        return _validity(self.message.validity)


class State:
    """The estimate at one instant. `message` is the whole SlaveState."""

    def __init__(self, message: state_pb2.SlaveState) -> None:
        self.message = message

    @property
    def sequence(self) -> int:
        """Increases by one per state. A gap: states were skipped for this reader."""
        return int(self.message.sequence)

    @property
    def t(self) -> float:
        """Time of the image or tactile sample, on the slave's clock [s since 1970]. The force belongs to it."""
        return seconds(self.message.sensed_at)

    @property
    def tip(self) -> Array:
        """Measured tool tip [m]."""
        return vector(self.message.p_S_tip)

    @property
    def force(self) -> Array:
        """Force of the object on the tool [N]. NaN: unknown. Use it as a measurement only if `valid`."""
        return vector(self.message.force) if self.known else _unknown()

    @property
    def sigma(self) -> float:
        """One standard deviation of the force [N]. NaN: unknown."""
        return float(self.message.sigma) if self.known else float("nan")

    @property
    def known(self) -> bool:
        """There is a force. A stale state repeats the last one, which is not known to hold any more."""
        return bool(self.message.HasField("force")) and self.validity != Validity.STALE

    @property
    def valid(self) -> bool:
        """The force is a measurement: all checks pass and the model is within its range."""
        return self.validity == Validity.VALID

    @property
    def validity(self) -> Validity:
        """How far the numbers can be trusted."""
        return _validity(self.message.validity)

    @property
    def check(self) -> str:
        """The failed check that explains `validity`. Empty: none."""
        return check_name(self.message.check)

    @property
    def phase(self) -> Phase:
        """How the slave treats the operator's motion."""
        number = self.message.phase
        return Phase(number) if number in Phase._value2member_map_ else Phase.UNSPECIFIED

    @property
    def in_contact(self) -> bool:
        """The slave detects contact."""
        return bool(self.message.local_model.in_contact)

    @property
    def depth(self) -> float:
        """Distance of the tip beyond the surface at rest, along its normal [m]. Negative: free. NaN: unknown."""
        model = self.message.local_model
        known = self.message.HasField("local_model") and model.HasField("normal")
        return float((vector(model.reference) - self.tip) @ vector(model.normal)) if known else float("nan")

    @property
    def stiffness(self) -> Array:
        """Decrease of the force per motion of the tip, 3x3 [N/m]. NaN: unknown."""
        numbers = self.message.local_model.stiffness
        return np.reshape(numbers, (3, 3)).astype(np.float64) if len(numbers) == 9 else np.full((3, 3), np.nan)

    @property
    def moment(self) -> Array:
        """Moment of the object on the tool about the tip [N m]. NaN: unknown, or not requested by `details`."""
        return vector(self.message.moment) if self.message.HasField("moment") and self.known else _unknown()

    @property
    def true_force(self) -> Array:
        """Force that a simulator or a force sensor measures [N]. NaN: there is none."""
        return vector(self.message.true_force) if self.message.HasField("true_force") else _unknown()

    @property
    def fingertips(self) -> list[Fingertip]:
        """All fingertips in the order of the scene, if there is more than one."""
        return [Fingertip(message) for message in self.message.fingers]

    @property
    def events(self) -> list[str]:
        """Names of what happened since the last state."""
        return [_name(state_pb2.Event, "EVENT_", number) for number in self.message.events]

    def __repr__(self) -> str:
        return f"<State {self.sequence}: {self.force} +- {self.sigma:.3g} N, {self.validity.name} {self.check}>"


@dataclasses.dataclass(frozen=True)
class States:
    """Many states as arrays, one row per sample. Unknown numbers are NaN."""
    t: Array  # [s since 1970], slave's clock
    tip: Array  # n x 3 [m]
    depth: Array  # of the tip beyond the surface at rest [m]
    force: Array  # n x 3 [N]
    sigma: Array  # [N]
    true_force: Array  # n x 3 [N]
    validity: npt.NDArray[np.int64]  # numbers of `Validity`
    check: npt.NDArray[np.int64]  # numbers of FailedCheck

    @classmethod
    def of(cls, states: Iterable[State]) -> States:
        """Collects states. A state that repeats the sample of the one before it is left out."""
        kept: list[State] = []
        for state in states:
            if not kept or state.message.sensed_at != kept[-1].message.sensed_at:
                kept.append(state)

        def rows(name: str) -> Array:
            return np.array([getattr(state, name) for state in kept], dtype=np.float64).reshape(-1, 3)

        return cls(np.array([state.t for state in kept]), rows("tip"), np.array([state.depth for state in kept]),
                   rows("force"), np.array([state.sigma for state in kept]), rows("true_force"),
                   np.array([int(state.validity) for state in kept], dtype=np.int64),
                   np.array([state.message.check for state in kept], dtype=np.int64))

    def __len__(self) -> int:
        return len(self.t)

    @property
    def valid(self) -> npt.NDArray[np.bool_]:
        """True where the force is a measurement."""
        return np.equal(self.validity, Validity.VALID)

    @property
    def peak(self) -> float:
        """Largest valid force [N]. NaN: there is none."""
        sizes = np.linalg.norm(self.force[self.valid], axis=1)
        return float(sizes.max()) if len(sizes) else float("nan")

    def save(self, file: str | pathlib.Path) -> None:
        """Writes all arrays to an .npz file."""
        np.savez(file, **{field.name: getattr(self, field.name) for field in dataclasses.fields(self)})


@dataclasses.dataclass(frozen=True)
class Mesh:
    """The deformed boundary at one instant."""
    t: float  # time of the sample, slave's clock [s since 1970]
    elements: npt.NDArray[np.int64]  # nodes of each element: 2 for a line, 3 for a triangle
    rest: Array  # n x 3 [m]
    positions: Array  # n x 3 [m]
    validity: Validity
