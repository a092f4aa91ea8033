"""Stand-in for the package `openni`, as feed_openni.py uses it: a camera 250 mm from a plane, in counts of 0.02 mm."""
import array
import itertools
import random
import time

WIDTH, HEIGHT = 320, 240


class Frame:
    width, height = WIDTH, HEIGHT

    def __init__(self, seed: int) -> None:
        source = random.Random(seed)
        self.depths = array.array("H", (round(12500 + source.gauss(0, 10)) for _ in range(WIDTH * HEIGHT)))

    def get_buffer_as_uint16(self) -> "array.array[int]":
        return self.depths


class DepthStream:
    def __init__(self) -> None:
        self.frames = itertools.cycle([Frame(seed) for seed in range(6)])
        self.is_mirrored, self.is_started = True, False

    def set_mirroring_enabled(self, enabled: bool) -> None:
        self.is_mirrored = enabled

    def start(self) -> None:
        if self.is_mirrored:
            raise RuntimeError("the images are mirrored")
        self.is_started = True

    def read_frame(self) -> Frame:
        if not self.is_started:
            raise RuntimeError("not started")
        time.sleep(1 / 30)
        return next(self.frames)

    def stop(self) -> None:
        self.is_started = False


class Device:
    @classmethod
    def open_any(cls) -> "Device":
        return cls()

    @classmethod
    def open_file(cls, name: bytes) -> "Device":
        raise RuntimeError(f"no recording {name!r}")

    def create_depth_stream(self) -> DepthStream:
        return DepthStream()


def initialize() -> None:
    pass


def unload() -> None:
    pass
