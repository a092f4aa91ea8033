#!/usr/bin/python3
"""Sends the depth images of an OpenNI2 camera, or of a recording (.oni), to a slave: a driver of a depth camera.

usage: feed_openni.py HOST:PORT [RECORDING] [--count N] [--tls DIR]

Needs the Python package `openni` and the library OpenNI2 (Debian: libopenni2-0). The scene needs
`depth: {source: stream}` and the camera's own `unit`: 1 mm or 0.1 mm. A recording is sent in its own time and repeats.
--count: images to send (default 300).

Prints the number of accepted images. Exit code 0: all; 1: not all; 2: unusable arguments.
"""
import argparse
import sys
from collections.abc import Iterator

import numpy as np
import palpate
from openni import openni2


def depths(recording: str | None, count: int) -> Iterator[palpate.Image]:
    """Yields depth images, not mirrored, with the time of their arrival."""
    openni2.initialize()
    device = openni2.Device.open_file(recording.encode()) if recording else openni2.Device.open_any()
    stream = device.create_depth_stream()
    if not recording:
        stream.set_mirroring_enabled(False)
    stream.start()
    for _ in range(count):
        frame = stream.read_frame()
        depth = np.frombuffer(frame.get_buffer_as_uint16(), np.uint16).reshape(frame.height, frame.width)
        yield palpate.Image(depth.copy())
    stream.stop()
    openni2.unload()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("recording", nargs="?")
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--tls", metavar="DIR", help="folder with ca.pem, cert.pem and key.pem")
    arguments = parser.parse_args()
    with palpate.connect(arguments.target, arguments.tls) as slave:
        reply = slave.feed_images(depths(arguments.recording, arguments.count))
    print(f"{reply.samples} of {arguments.count} images accepted")
    return 0 if reply.samples == arguments.count else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except palpate.Error as error:
        sys.exit(f"error: {error}")
