#!/usr/bin/python3
"""Feeds a slave with images at the rate of a camera, with only the .proto files: a template of a driver.

usage: feed_pictures.py HOST:PORT [LEFT ...] [--right RIGHT ...] [--rate HZ] [--loop] [--check]

LEFT, RIGHT: PNG or JPEG files, the left and right images of pairs; depth is a PNG of 16 bit. Without files it
sends thirty raw grey images of 64 x 48 px. The camera of the scene needs `source: stream`.
--loop: repeats the files. --check: also sends an incomplete image on a separate stream, which must be rejected
with a reason.

Prints the number of accepted images. Exit code 0: all; 1: not all; 2: unusable arguments.
"""
import argparse
import itertools
import pathlib
import sys
import time

import grpc

import palpate_stubs

messages, services, states = palpate_stubs.load()
from palpate.v1 import devices_pb2 as devices  # noqa: E402: made by palpate_stubs

WIDTH, HEIGHT = 64, 48


def picture(path):
    data = pathlib.Path(path).read_bytes()
    is_png = data.startswith(b"\x89PNG")
    encoding = devices.CameraPicture.ENCODING_PNG if is_png else devices.CameraPicture.ENCODING_JPEG
    return devices.CameraPicture(encoding=encoding, data=data)


def grey(level):
    return devices.CameraPicture(encoding=devices.CameraPicture.ENCODING_GREY8, width=WIDTH, height=HEIGHT,
                                 data=bytes((level + column) % 256 for column in range(WIDTH)) * HEIGHT)


def sample(sequence, left, right=None):
    message = devices.PictureSample(sequence=sequence, picture=left)
    if right is not None:
        message.right.CopyFrom(right)
    message.sensed_at.FromNanoseconds(time.time_ns())
    return message


def pictures(arguments):
    """Yields (left, right or None)."""
    if not arguments.left:
        return [(grey(level), None) for level in range(30)]
    rights = arguments.right or [None] * len(arguments.left)
    if len(rights) != len(arguments.left):
        sys.exit(f"{len(arguments.left)} left and {len(rights)} right images: accepted is as many of each")
    return ((picture(a), picture(b) if b else None) for a, b in zip(arguments.left, rights))


def paced(pairs, rate):
    due = time.monotonic()
    for sequence, (left, right) in enumerate(pairs, start=1):
        yield sample(sequence, left, right)
        due = max(due + 1 / rate, time.monotonic())
        time.sleep(max(0.0, due - time.monotonic()))


def is_refused_in_words(stub):
    half = grey(0)
    half.data = half.data[:len(half.data) // 2]
    try:
        stub.FeedPictures(iter([sample(1, half)]), timeout=10)
    except grpc.RpcError as error:
        print(f"incomplete image: {error.details()}")
        return error.code() == grpc.StatusCode.INVALID_ARGUMENT and "accepted is" in error.details()
    return False


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("left", nargs="*")
    parser.add_argument("--right", nargs="+")
    parser.add_argument("--rate", type=float, default=30)
    parser.add_argument("--loop", action="store_true")
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()

    stub = services.TeleoperationStub(palpate_stubs.connect(grpc, arguments.target))
    pairs = pictures(arguments)
    sent = 0

    def counted():
        nonlocal sent
        for message in paced(itertools.cycle(pairs) if arguments.loop else pairs, arguments.rate):
            sent += 1
            yield message

    try:
        reply = stub.FeedPictures(counted())
    except grpc.RpcError as error:
        print(f"wrong: {error.code().name}: {error.details()}")
        return 1
    print(f"{reply.samples} of {sent} images accepted, {reply.dropped} pairs dropped")
    refused = not arguments.check or is_refused_in_words(stub)
    return 0 if refused and sent > 0 and reply.samples == sent else 1


if __name__ == "__main__":
    raise SystemExit(main())
