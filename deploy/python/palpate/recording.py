"""Reads recordings (MCAP files) of a master or a slave."""
from __future__ import annotations

import ctypes
import ctypes.util
import dataclasses
import functools
import os
import pathlib
import struct
from typing import Any, Iterator

import numpy as np

from palpate.state import Array, State, States, vector
from palpate.v1 import recording_pb2, state_pb2

MAGIC = b"\x89MCAP0\r\n"
CHANNEL, MESSAGE, CHUNK, ATTACHMENT = 4, 5, 6, 9  # opcodes of the records that matter here


@dataclasses.dataclass(frozen=True)
class Recording:
    """The arrays of a recording. A slave's recording has no ticks."""
    states: States
    tick_t: Array  # one per tick of the master's 1 kHz loop: time on the recorder's clock [s since 1970]
    device: Array  # device tip, frame M, n x 3 [m]
    sent: Array  # force sent to the device, frame M, n x 3 [N]


def read_recording(file: str | os.PathLike[str]) -> Recording:
    """Reads a recording of `palpate-master connect --record` or `palpate-slave serve --record`.

    What a cut file contains before the cut is read. Raises ValueError for a file of another kind.
    """
    states: list[State] = []
    ticks: list[tuple[float, Any]] = []
    for topic, t, data in messages(file):
        if topic == "/slave/state":
            states.append(State(state_pb2.SlaveState.FromString(data)))
        elif topic == "/master/tick":
            ticks.append((t, recording_pb2.ForceTick.FromString(data)))
        elif topic == "/slave/sense":
            step = recording_pb2.SenseStep.FromString(data)
            if step.WhichOneof("step") == "estimate":
                states.append(State(step.estimate.state))
    rows = [[vector(tick.p_M), vector(tick.sent)] for _, tick in ticks]
    pairs = np.array(rows, dtype=np.float64).reshape(-1, 2, 3)
    return Recording(States.of(states), np.array([t for t, _ in ticks]), pairs[:, 0], pairs[:, 1])


def messages(file: str | os.PathLike[str]) -> Iterator[tuple[str, float, bytes]]:
    """Yields (topic, time [s since 1970], data) of all messages of an MCAP file, or of its parts `FILE-0001.mcap`, ..."""
    for data in _parts(file):
        topics: dict[int, str] = {}
        yield from _messages(data, topics)


def attachments(file: str | os.PathLike[str]) -> dict[str, bytes]:
    """The attached files of a recording by name: the scene of a slave's recording, and the files it names."""
    found: dict[str, bytes] = {}
    for data in _parts(file):
        for opcode, record in _records(data):
            if opcode != ATTACHMENT:
                continue
            name, at = _text(record, 16)  # after the two times
            _, at = _text(record, at)  # media type
            length, = struct.unpack_from("<Q", record, at)
            found[name] = bytes(record[at + 8:at + 8 + length])
    return found


def _parts(file: str | os.PathLike[str]) -> Iterator[memoryview]:
    """The records of a file, or of its parts. Raises ValueError: no MCAP file."""
    path = pathlib.Path(file)
    parts = sorted(path.parent.glob(f"{path.stem}-[0-9][0-9][0-9][0-9]{path.suffix}"))
    for part in [path] if path.exists() or not parts else parts:
        data = part.read_bytes()
        if not data.startswith(MAGIC):
            raise ValueError(f"{part}: expected an MCAP file")
        yield memoryview(data)[len(MAGIC):]


def _text(record: memoryview, at: int) -> tuple[str, int]:
    """A text with its length before it, and where the next field begins."""
    length, = struct.unpack_from("<I", record, at)
    return str(record[at + 4:at + 4 + length], "utf-8"), at + 4 + length


def _messages(data: memoryview, topics: dict[int, str]) -> Iterator[tuple[str, float, bytes]]:
    for opcode, record in _records(data):
        if opcode == CHANNEL:
            number, _, length = struct.unpack_from("<HHI", record)
            topics[number] = str(record[8:8 + length], "utf-8")
        elif opcode == MESSAGE:
            channel, _, log_time = struct.unpack_from("<HIQ", record)
            yield topics.get(channel, ""), 1e-9 * log_time, bytes(record[22:])
        elif opcode == CHUNK:
            _, _, size, _, length = struct.unpack_from("<QQQII", record)
            how = str(record[32:32 + length], "utf-8")
            packed = record[32 + length + 8:]
            yield from _messages(memoryview(_unpacked(bytes(packed), size, how)), topics)


def _records(data: memoryview) -> Iterator[tuple[int, memoryview]]:
    at = 0
    while at + 9 <= len(data):
        opcode, length = struct.unpack_from("<BQ", data, at)
        if at + 9 + length > len(data):
            return  # the file was cut
        yield opcode, data[at + 9:at + 9 + length]
        at += 9 + length


@functools.cache
def _zstd() -> ctypes.CDLL:
    """The library. It is searched once, because the search starts other programs."""
    library = ctypes.CDLL(ctypes.util.find_library("zstd") or "libzstd.so.1")
    library.ZSTD_decompress.restype = ctypes.c_size_t
    library.ZSTD_decompress.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t]
    return library


def _unpacked(packed: bytes, size: int, how: str) -> bytes:
    if how == "":
        return packed
    if how != "zstd":
        raise ValueError(f"a chunk is compressed by {how}: expected zstd")
    out = ctypes.create_string_buffer(size)
    if _zstd().ZSTD_decompress(out, size, packed, len(packed)) != size:
        raise ValueError("a chunk is damaged")
    return out.raw
