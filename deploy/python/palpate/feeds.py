"""Samples that drivers of cameras and fingertips send."""
from __future__ import annotations

import dataclasses
import pathlib
import time
from typing import Any, Iterable, Iterator, Sequence, TypeVar, Union

import numpy as np
import numpy.typing as npt

from palpate.state import Array
from palpate.v1 import devices_pb2, state_pb2

Item = TypeVar("Item")
# Grey (8 or 16 bit) or blue, green, red (8 bit) pixels; or a PNG or JPEG file, as its path or its bytes.
Pixels = Union["npt.NDArray[np.uint8]", "npt.NDArray[np.uint16]", pathlib.Path, bytes]


@dataclasses.dataclass
class Image:
    """An image, a stereo pair or a depth image. Times are in seconds since 1970 on this machine's clock, of the middle of the exposure."""
    left: Pixels
    right: Pixels | None = None
    t: float | None = None  # None: now
    right_t: float | None = None  # None: as `t`


@dataclasses.dataclass
class TactileSample:
    """Readings of one fingertip."""
    finger: str  # its name in the scene
    electrodes: Sequence[float] | Array  # or channels, in the order of the sensor, as many as the scene has
    pressure: Sequence[float] = ()  # static, then dynamic [counts]
    t: float | None = None  # [s since 1970], this machine's clock; None: now
    position: Sequence[float] | Array | None = None  # origin of frame F in S [m]; None: it follows the manipulator
    orientation: Sequence[float] | Array = ()  # rotation of F in S, w x y z; with `position` only
    unit: str = ""  # unit of the channels; rejected if it is not the scene's. Empty: not stated


def paced(items: Iterable[Item], rate: float) -> Iterator[Item]:
    """Yields `items` at `rate` [Hz]."""
    due = time.monotonic()
    for item in items:
        yield item
        due = max(due + 1 / rate, time.monotonic())
        time.sleep(max(0.0, due - time.monotonic()))


def replayed(samples: Iterable[TactileSample], hurry: bool = False) -> Iterator[TactileSample]:
    """Yields recorded samples with their times shifted to the present, at the pace of the recording unless `hurry`."""
    start, first = time.time(), None
    for sample in samples:
        recorded = 0.0 if sample.t is None else sample.t
        first = recorded if first is None else first
        due = start + recorded - first
        if not hurry:
            time.sleep(max(0.0, due - time.time()))
        yield dataclasses.replace(sample, t=due)


def set_time(timestamp: Any, t: float | None) -> None:
    """Sets a timestamp of protobuf; None: now."""
    timestamp.FromNanoseconds(time.time_ns() if t is None else round(1e9 * t))


def set_vector(message: Any, numbers: Sequence[float] | Array) -> None:
    message.x, message.y, message.z = (float(number) for number in numbers)


def encoded(image: Pixels) -> devices_pb2.Image:
    """The message of one image."""
    kinds = devices_pb2.Image
    if isinstance(image, (pathlib.Path, bytes)):
        data = image if isinstance(image, bytes) else image.read_bytes()
        is_png = data.startswith(b"\x89PNG")
        return kinds(encoding=kinds.ENCODING_PNG if is_png else kinds.ENCODING_JPEG, data=data)
    encodings = {("uint8", 2): kinds.ENCODING_GREY8, ("uint8", 3): kinds.ENCODING_BGR8, ("uint16", 2): kinds.ENCODING_GREY16}
    encoding = encodings.get((image.dtype.name, image.ndim))
    if encoding is None or (image.ndim == 3 and image.shape[2] != 3):
        raise ValueError(f"an array of {image.dtype} with shape {image.shape}: expected uint8 or uint16 with rows and "
                         "columns, or uint8 with rows, columns and 3 channels")
    pixels = image.astype("<u2") if image.dtype.name == "uint16" else image
    return kinds(encoding=encoding, width=image.shape[1], height=image.shape[0], data=pixels.tobytes())


def image_samples(images: Iterable[Image | Pixels]) -> Iterator[devices_pb2.ImageSample]:
    """The messages of FeedImages."""
    for sequence, item in enumerate(images, start=1):
        image = item if isinstance(item, Image) else Image(item)
        message = devices_pb2.ImageSample(sequence=sequence, image=encoded(image.left))
        set_time(message.sensed_at, image.t)
        if image.right is not None:
            message.right.CopyFrom(encoded(image.right))
            if image.right_t is not None:
                set_time(message.right_sensed_at, image.right_t)
        yield message


def tactile(samples: Iterable[TactileSample]) -> Iterator[state_pb2.TactileSample]:
    """The messages of FeedTactile."""
    for sequence, sample in enumerate(samples, start=1):
        message = state_pb2.TactileSample(sequence=sequence, finger=sample.finger, electrodes=[float(x) for x in sample.electrodes],
                                          pressure=[float(x) for x in sample.pressure],
                                          orientation=[float(x) for x in sample.orientation], unit=sample.unit)
        set_time(message.sensed_at, sample.t)
        if sample.position is not None:
            set_vector(message.p_S_finger, sample.position)
        yield message
