"""Reads recordings (MCAP files) of a master or a slave."""
from __future__ import annotations

import ctypes
import ctypes.util
import dataclasses
import functools
import os
import pathlib
import struct
import warnings
import zlib
from typing import Any, Iterator, NamedTuple

import numpy as np

from google.protobuf.message import DecodeError, Message

from palpate.formats import what_is
from palpate.state import Array, State, States, vector
from palpate.v1 import recording_pb2, state_pb2

MAGIC = b"\x89MCAP0\r\n"
# Opcodes of the records that are read.
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, ATTACHMENT, METADATA, DATA_END = 2, 3, 4, 5, 6, 9, 12, 15
MAX_CHUNK = 256 << 20  # uncompressed [bytes]
PART_NOTE = "palpate.part"  # metadata that identifies the recording of a part, and its number


class Channel(NamedTuple):
    """A channel record: topic and type of messages."""
    topic: str = ""
    schema: str = ""  # name of the message's type
    encoding: str = ""


class RecordingWarning(UserWarning):
    """A part of a recording cannot be read; the text names file and byte."""


@dataclasses.dataclass(frozen=True)
class Recording:
    """The arrays of a recording. A slave's recording has no ticks."""
    states: States
    tick_t: Array  # one per tick of the master's 1 kHz loop: time on the recorder's clock [s since 1970]
    device: Array  # device tip, frame M, n x 3 [m]
    sent: Array  # force sent to the device, frame M, n x 3 [N]
    damage: tuple[str, ...] = ()  # errors with file and byte; empty: the recording is complete


def read_recording(file: str | os.PathLike[str]) -> Recording:
    """Reads a recording of `palpate-master connect --record` or `palpate-slave serve --record`.

    A truncated file is read up to its end; damaged parts are left out. `damage` and a RecordingWarning state where.
    Raises ValueError for a file of another kind.
    """
    states: list[State] = []
    ticks: list[tuple[float, Any]] = []
    damage: list[str] = []
    for topic, t, data in _read_messages(file, damage):
        if topic == "/slave/state":
            states.append(State(parsed(state_pb2.SlaveState, data, file)))
        elif topic == "/master/tick":
            ticks.append((t, parsed(recording_pb2.ForceTick, data, file)))
        elif topic == "/slave/sense":
            step = parsed(recording_pb2.SenseStep, data, file)
            if step.WhichOneof("step") == "estimate":
                states.append(State(step.estimate.state))
    _warn(damage)
    rows = [[vector(tick.p_M), vector(tick.sent)] for _, tick in ticks]
    pairs = np.array(rows, dtype=np.float64).reshape(-1, 2, 3)
    return Recording(States.of(states), np.array([t for t, _ in ticks]), pairs[:, 0], pairs[:, 1], tuple(damage))


def parsed(kind: type[Any], data: bytes, file: str | os.PathLike[str]) -> Any:
    """Parses a message of this type. Raises ValueError naming the file."""
    try:
        message: Message = kind.FromString(data)
    except DecodeError as error:
        raise ValueError(f"{os.fspath(file)}: a {kind.DESCRIPTOR.name} is damaged") from error
    return message


def messages(file: str | os.PathLike[str]) -> Iterator[tuple[str, float, bytes]]:
    """Yields (topic, time [s since 1970], data) of all messages of an MCAP file, or of its parts `FILE-0001.mcap`, ...

    Damaged and missing parts are left out, with a RecordingWarning at the end. Raises ValueError: no MCAP file.
    """
    damage: list[str] = []
    yield from _read_messages(file, damage)
    _warn(damage)


def channel_messages(file: str | os.PathLike[str]) -> Iterator[tuple[Channel, int, bytes]]:
    """The same as (channel, time [ns since 1970], data)."""
    damage: list[str] = []
    yield from _read_channels(file, damage)
    _warn(damage)


def attachments(file: str | os.PathLike[str]) -> dict[str, bytes]:
    """The attached files of a recording by name: the scene of a slave's recording, and the files it names. Raises ValueError: one of
    them is damaged."""
    found: dict[str, bytes] = {}
    for part in _parts(file):
        for opcode, record, at in part.records():
            if opcode != ATTACHMENT:
                continue
            try:
                name, end = _text(record, 16)  # after the two times
                _, end = _text(record, end)  # media type
                length, = struct.unpack_from("<Q", record, end)
                end += 8
                crc, = struct.unpack_from("<I", record, end + length)
            except (struct.error, UnicodeDecodeError):
                raise ValueError(part.place(at, "an attached file is damaged")) from None
            if crc not in (0, zlib.crc32(record[:end + length])):
                raise ValueError(part.place(at, f"the attached file {name} is damaged"))
            found[name] = bytes(record[end:end + length])
    return found


def _warn(damage: list[str]) -> None:
    for line in damage:
        warnings.warn(line, RecordingWarning, stacklevel=3)


def _text(record: memoryview, at: int) -> tuple[str, int]:
    """Returns a text that is preceded by its length, and the position of the next field."""
    length, = struct.unpack_from("<I", record, at)
    if at + 4 + length > len(record):
        raise struct.error
    return str(record[at + 4:at + 4 + length], "utf-8"), at + 4 + length


class _Known(NamedTuple):
    """Schemas and channels read so far, by their numbers."""
    schemas: dict[int, str]
    channels: dict[int, Channel]


class _Part:
    """One MCAP file. Errors are appended to `damage` with their positions."""

    def __init__(self, file: pathlib.Path, damage: list[str]) -> None:
        self.file, self.damage = file, damage
        self.note: dict[str, str] = {}  # identity and number of a part
        data = file.read_bytes()
        if not data.startswith(MAGIC):
            foreign = what_is(file)
            raise ValueError(f"{file}: {foreign or 'no MCAP file'}: expected a recording (.mcap)")
        self.data = memoryview(data)

    def place(self, at: int, what: str) -> str:
        return f"{self.file}: at byte {at}: {what}"

    def records(self) -> Iterator[tuple[int, memoryview, int]]:
        """Yields opcode, content and position of each record up to the end of the data."""
        at, is_whole = len(MAGIC), False
        while at + 9 <= len(self.data):
            opcode, length = struct.unpack_from("<BQ", self.data, at)
            end = at + 9 + length
            if end > len(self.data):
                break
            is_whole = is_whole or opcode == DATA_END
            if not is_whole:
                yield opcode, self.data[at + 9:end], at
            at = end
            if opcode == FOOTER:
                self._look_behind(at + len(MAGIC))
                return
        if not is_whole:
            left = len(self.data) - at
            self.damage.append(self.place(at, f"it is truncated: the last {left} bytes are incomplete" if left else
                                          "it was never closed: the last messages may be missing"))

    def _look_behind(self, end: int) -> None:
        rest = self.data[end:]
        if bytes(rest[:len(MAGIC)]) == MAGIC:
            self.damage.append(self.place(end, f"another recording follows: its {len(rest)} bytes are not read. Separate the files"))
        elif rest:
            self.damage.append(self.place(end, f"{len(rest)} bytes follow its end: they are not read"))

    def messages(self) -> Iterator[tuple[Channel, int, bytes]]:
        known = _Known({}, {})
        for opcode, record, at in self.records():
            try:
                yield from self._of_record(opcode, record, at, known)
            except (struct.error, UnicodeDecodeError):
                self.damage.append(self.place(at, "a record is damaged"))

    def _of_record(self, opcode: int, record: memoryview, at: int, known: _Known) -> Iterator[tuple[Channel, int, bytes]]:
        if opcode == SCHEMA:
            number, = struct.unpack_from("<H", record)
            known.schemas[number] = _text(record, 2)[0]
        elif opcode == CHANNEL:
            number, schema = struct.unpack_from("<HH", record)
            topic, end = _text(record, 4)
            known.channels[number] = Channel(topic, known.schemas.get(schema, ""), _text(record, end)[0])
        elif opcode == MESSAGE:
            number, _, log_time = struct.unpack_from("<HIQ", record)
            yield known.channels.get(number, Channel()), log_time, bytes(record[22:])
        elif opcode == METADATA:
            name, begin = _text(record, 0)
            begin, entries = begin + 4, {}
            while begin < len(record):
                key, begin = _text(record, begin)
                entries[key], begin = _text(record, begin)
            if name == PART_NOTE:
                self.note = entries
        elif opcode == CHUNK:
            yield from self._of_chunk(record, at, known)

    def _of_chunk(self, record: memoryview, at: int, known: _Known) -> Iterator[tuple[Channel, int, bytes]]:
        first, last, size, crc = struct.unpack_from("<QQQI", record)
        how, begin = _text(record, 28)
        span = f"of {1e-9 * (last - first):.3f} s"
        unpacked = _unpacked(bytes(record[begin + 8:]), size, how)
        if unpacked is None or crc not in (0, zlib.crc32(unpacked)):
            what = "is damaged" if how in ("", "zstd") else f"is compressed with {how}: expected zstd or no compression"
            self.damage.append(self.place(at, f"a chunk {span} {what}; its messages are left out"))
            return
        inside, begin = memoryview(unpacked), 0
        while begin + 9 <= len(inside):
            opcode, length = struct.unpack_from("<BQ", inside, begin)
            if begin + 9 + length > len(inside):
                raise struct.error
            if opcode != CHUNK:
                yield from self._of_record(opcode, inside[begin + 9:begin + 9 + length], at, known)
            begin += 9 + length


def _parts(file: str | os.PathLike[str], damage: list[str] | None = None) -> Iterator[_Part]:
    """Returns the file or its parts. Raises ValueError: no MCAP file."""
    path = pathlib.Path(file)
    parts = sorted(path.parent.glob(f"{path.stem}-[0-9][0-9][0-9][0-9]{path.suffix}"))
    for part in [path] if path.exists() or not parts else parts:
        yield _Part(part, [] if damage is None else damage)


def _read_messages(file: str | os.PathLike[str], damage: list[str]) -> Iterator[tuple[str, float, bytes]]:
    for channel, log_time, data in _read_channels(file, damage):
        yield channel.topic, 1e-9 * log_time, data


def _read_channels(file: str | os.PathLike[str], damage: list[str]) -> Iterator[tuple[Channel, int, bytes]]:
    """Yields the messages of a file or of its parts; errors are appended to `damage`."""
    identity, number = "", 0
    for part in _parts(file, damage):
        is_new = part.file != pathlib.Path(file)
        for message in part.messages():
            if is_new:
                is_new = False
                if part.note.get("recording", "") != (identity or part.note.get("recording")):
                    damage.append(f"{part.file}: is not a part of this recording: it and the following parts are ignored")
                    return
                identity, own = part.note.get("recording", ""), int(part.note.get("number", number + 1))
                if own != number + 1:
                    damage.append(f"{part.file}: earlier messages are missing: there is no part {number + 1}")
                number = own
            yield message


@functools.cache
def _zstd() -> ctypes.CDLL:
    """Returns the library zstd. It is located once, because the search starts other programs."""
    library = ctypes.CDLL(ctypes.util.find_library("zstd") or "libzstd.so.1")
    library.ZSTD_decompress.restype = ctypes.c_size_t
    library.ZSTD_decompress.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t]
    return library


def _unpacked(packed: bytes, size: int, how: str) -> bytes | None:
    """Returns the decompressed data. None: damaged, or compressed by another method."""
    if how == "":
        return packed if len(packed) == size else None
    if how != "zstd" or size > MAX_CHUNK:
        return None
    out = ctypes.create_string_buffer(size)
    if _zstd().ZSTD_decompress(out, size, packed, len(packed)) != size:
        return None
    return out.raw
