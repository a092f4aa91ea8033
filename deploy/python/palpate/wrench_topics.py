"""Forces of the wrench topics of MCAP files and of rosbag2 folders and databases (.mcap, .db3)."""
from __future__ import annotations

import dataclasses
import math
import os
import pathlib
import sqlite3
import struct
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.recording import channel_messages

# Types of messages with a force, as rosbag2 and MCAP name them.
STAMPED, PLAIN, CONTACT = "geometry_msgs/msg/WrenchStamped", "geometry_msgs/msg/Wrench", "palpate_msgs/msg/ContactWrench"
ON_OBJECT = 2  # ContactWrench.acts_on; a force here is that on the tool
WRENCHES = (STAMPED, PLAIN, CONTACT)
SQLITE = b"SQLite format 3\x00"


@dataclasses.dataclass(frozen=True)
class Forces:
    """The forces of one topic, in order of time.

    t_ns  [ns since 1970]: the message's stamp, or where it has none the time at which it was recorded
    force (n, 3) [N]; sigma (n,) [N] and valid (n,): of a ContactWrench, else NaN and True; frame: of the first message
    """
    topic: str
    frame: str
    t_ns: NDArray[np.int64]
    force: NDArray[np.float64]
    sigma: NDArray[np.float64]
    valid: NDArray[np.bool_]


def is_bag(file: str | os.PathLike[str]) -> bool:
    """Returns whether this is an MCAP file, a database of rosbag2, or a folder of them."""
    path = pathlib.Path(file)
    if path.is_dir():
        return True
    if path.suffix == ".mcap":
        return True
    with open(path, "rb") as stream:
        return stream.read(len(SQLITE)) == SQLITE


def read_topics(file: str | os.PathLike[str]) -> dict[str, Forces]:
    """Returns the wrench topics by name. Raises ValueError: no bag, no wrench, a message that is damaged."""
    rows: dict[str, list[_Row]] = {}
    others: set[str] = set()
    for topic, kind, encoding, recorded_ns, data in _messages(pathlib.Path(file)):
        if kind not in WRENCHES:
            others.add(f"{topic} ({kind or 'of no type'})")
            continue
        if encoding != "cdr":
            raise ValueError(f"{os.fspath(file)}: topic {topic}: encoding {encoding or '(none)'}: expected cdr, as ROS 2 writes it")
        try:
            rows.setdefault(topic, []).append(_decoded(kind, data, recorded_ns))
        except (struct.error, UnicodeDecodeError):
            raise ValueError(f"{os.fspath(file)}: topic {topic}: message {len(rows.get(topic, ())) + 1} is damaged") from None
    if not rows:
        seen = f"; there are {', '.join(sorted(others)[:10])}" if others else ""
        raise ValueError(f"{os.fspath(file)}: no topic of {', '.join(WRENCHES)}{seen}")
    return {topic: _forces(topic, of_topic) for topic, of_topic in sorted(rows.items())}


def join(measured: Forces, estimated: Forces) -> dict[str, NDArray[Any]]:
    """Returns both forces at the times of the estimate as arguments of `palpate.verify_forces`: measured, estimated, t
    [s], sigma, valid.

    The measured force is linear between two of its messages. An estimate is left out if no measured force is within
    five of the sensor's usual intervals. Raises ValueError: none is left.
    """
    start = min(measured.t_ns[0], estimated.t_ns[0])
    t_m, t_e = 1e-9 * (measured.t_ns - start), 1e-9 * (estimated.t_ns - start)
    after = np.searchsorted(t_m, t_e, side="left")
    inside = (t_e >= t_m[0]) & (t_e <= t_m[-1])
    after = np.clip(after, 1, max(1, len(t_m) - 1))
    if len(t_m) > 1:
        gaps = np.diff(t_m)
        largest = 5 * float(np.median(gaps[gaps > 0])) if np.any(gaps > 0) else math.inf
        exact = np.isin(measured.t_ns, estimated.t_ns)
        at_sample = np.isin(estimated.t_ns, measured.t_ns[exact])
        inside &= at_sample | (t_m[after] - t_m[after - 1] <= largest)
    if not np.any(inside):
        raise ValueError(f"{measured.topic} from {t_m[0]:.3f} to {t_m[-1]:.3f} s and {estimated.topic} from {t_e[0]:.3f} to "
                         f"{t_e[-1]:.3f} s: expected topics of the same time and clock")
    t = t_e[inside]
    force = np.column_stack([np.interp(t, t_m, measured.force[:, axis]) for axis in range(3)])
    return {"t": t, "measured": force, "estimated": estimated.force[inside], "sigma": estimated.sigma[inside],
            "valid": estimated.valid[inside]}


_Row = tuple[int, str, tuple[float, float, float], float, bool]  # t_ns, frame, force, sigma, valid


def _forces(topic: str, rows: list[_Row]) -> Forces:
    stamped = [row for row in rows if row[0] != 0]
    if stamped and len(stamped) < len(rows):
        print(f"{topic}: {len(rows) - len(stamped)} messages without a time are left out", file=sys.stderr)
        rows = stamped
    rows = sorted(rows, key=lambda row: row[0])
    return Forces(topic, rows[0][1], np.array([row[0] for row in rows], dtype=np.int64), np.array([row[2] for row in rows]),
                  np.array([row[3] for row in rows]), np.array([row[4] for row in rows], dtype=bool))


def _messages(path: pathlib.Path) -> Iterator[tuple[str, str, str, int, bytes]]:
    """Yields topic, type, encoding, time of recording [ns] and content of each message."""
    if path.is_dir():
        files = sorted(one for one in path.iterdir() if one.suffix in (".mcap", ".db3"))
        if not files:
            raise ValueError(f"{path}: no .mcap and no .db3: expected a bag of rosbag2; zstd -d unpacks compressed files")
        for one in files:
            yield from _messages(one)
    elif path.suffix == ".mcap":
        for channel, log_time, data in channel_messages(path):
            yield channel.topic, channel.schema, channel.encoding, log_time, data
    else:
        yield from _of_database(path)


def _of_database(path: pathlib.Path) -> Iterator[tuple[str, str, str, int, bytes]]:
    try:
        with sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True) as database:
            yield from database.execute("SELECT topics.name, topics.type, topics.serialization_format, messages.timestamp, messages.data "
                                        "FROM messages JOIN topics ON messages.topic_id = topics.id ORDER BY messages.timestamp")
    except sqlite3.Error as error:
        raise ValueError(f"{path}: {error}: expected a database of rosbag2") from None


def _decoded(kind: str, data: bytes, recorded_ns: int) -> _Row:
    cdr = _Cdr(data)
    stamp_ns, frame = recorded_ns, ""
    if kind != PLAIN:
        seconds, nanoseconds = cdr.take("i", 4), cdr.take("I", 4)
        stamp_ns = int(seconds) * 10**9 + int(nanoseconds) or recorded_ns
        frame = cdr.text()
    numbers = [float(cdr.take("d", 8)) for _ in range(6)]
    sigma, valid = math.nan, True
    if kind == CONTACT:
        sigma = float(cdr.take("d", 8))
        valid = cdr.take("B", 1) == 1
        if cdr.take("B", 1) == ON_OBJECT:
            numbers = [-number for number in numbers]
    return stamp_ns, frame, (numbers[0], numbers[1], numbers[2]), sigma, valid


class _Cdr:
    """Values of a message in the encoding of ROS 2 (OMG CDR): aligned to their size from the fifth byte on."""

    def __init__(self, data: bytes) -> None:
        if len(data) < 4 or data[0] != 0 or data[1] not in (0, 1):
            raise struct.error
        self._data, self._at, self._order = data, 4, "<" if data[1] else ">"

    def take(self, kind: str, size: int) -> float:
        self._at += (4 - self._at) % size
        value: float = struct.unpack_from(self._order + kind, self._data, self._at)[0]
        self._at += size
        return value

    def text(self) -> str:
        length = int(self.take("I", 4))
        begin, self._at = self._at, self._at + length
        if self._at > len(self._data):
            raise struct.error
        return self._data[begin:self._at].rstrip(b"\0").decode()
