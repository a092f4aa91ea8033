#!/usr/bin/python3
"""Sends images to a slave at the rate of a camera: a camera driver.

usage: feed_images.py HOST:PORT [LEFT ...] [--right RIGHT ...] [--rate HZ] [--size WxH] [--loop] [--check] [--tls DIR]

LEFT, RIGHT: PNG or JPEG files, the left and right images of pairs; a depth image is a PNG of 16 bit. Without files
thirty grey images of --size (default 64x48) are sent. The scene needs a camera with `source: stream`.
--loop: repeat the images. --check: also send half an image, which must be rejected with an explanation.

Prints the number of accepted images. Exit code 0: all; 1: not all; 2: unusable arguments.
"""
import argparse
import itertools
import pathlib
import sys

import numpy as np
import palpate


def images(left: list[pathlib.Path], right: list[pathlib.Path], size: str) -> list[palpate.Image]:
    """The images of the files, or grey ones whose brightness rises with the column."""
    if not left:
        width, height = (int(number) for number in size.split("x"))
        row = np.arange(width)
        return [palpate.Image(np.tile((row + level).astype(np.uint8), (height, 1))) for level in range(30)]
    return [palpate.Image(a, b) for a, b in itertools.zip_longest(left, right)]


def is_rejected_with_an_explanation(slave: palpate.Slave) -> bool:
    try:
        slave.feed_images([b"\x89PNG half an image"])
    except palpate.Error as error:
        print(f"half an image: {error.details}")
        return error.code == "INVALID_ARGUMENT" and "expected" in error.details
    return False


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("left", nargs="*", type=pathlib.Path)
    parser.add_argument("--right", nargs="+", type=pathlib.Path, default=[])
    parser.add_argument("--rate", type=float, default=30)
    parser.add_argument("--size", default="64x48", metavar="WxH")
    parser.add_argument("--loop", action="store_true")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--tls", metavar="DIR", help="folder with ca.pem, cert.pem and key.pem")
    arguments = parser.parse_args()
    if arguments.right and len(arguments.right) != len(arguments.left):
        parser.error(f"{len(arguments.left)} left and {len(arguments.right)} right images: expected the same count of both")
    sending = images(arguments.left, arguments.right, arguments.size)
    repeated = itertools.cycle(sending) if arguments.loop else sending
    with palpate.connect(arguments.target, arguments.tls) as slave:
        reply = slave.feed_images(palpate.paced(repeated, arguments.rate))
        print(f"{reply.samples} of {len(sending)} images accepted, {reply.dropped} pairs dropped")
        explained = not arguments.check or is_rejected_with_an_explanation(slave)
    return 0 if explained and reply.samples == len(sending) else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except palpate.Error as error:
        sys.exit(f"error: {error}")
