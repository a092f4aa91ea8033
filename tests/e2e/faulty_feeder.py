"""A faulty camera driver: faulty_feeder.py flood|garble HOST:PORT. Ends on SIGTERM.

  flood   grey images as fast as the link accepts them
  garble  data that are not images, truncated images, and images with wrong sizes or times, each on a new stream
"""
import itertools
import random
import sys
import time

import grpc
import numpy as np
import palpate
from palpate.v1 import devices_pb2 as devices

WIDTH, HEIGHT = 640, 480


def garbled(draw):
    message = devices.ImageSample(sequence=1, image=devices.Image(
        encoding=draw.randrange(0, 7), data=draw.randbytes(draw.choice([0, 1, 100, 100_000])),
        width=draw.choice([0, 1, WIDTH, 2**31]), height=draw.choice([0, 1, HEIGHT, 2**31])))
    message.sensed_at.FromNanoseconds(time.time_ns())
    if draw.random() < 0.3:
        message.sensed_at.seconds = draw.choice([0, -10**12, 10**12])
    if draw.random() < 0.3:
        message.right.CopyFrom(message.image)
    return message


def main():
    how, target = sys.argv[1:]
    slave = palpate.connect(target)
    draw = random.Random(1)
    while True:
        try:
            if how == "flood":
                slave.feed_images(itertools.repeat(np.zeros((HEIGHT, WIDTH), dtype=np.uint8)))
            else:
                slave.stub.FeedImages(iter([garbled(draw)]), timeout=10)
        except (palpate.Error, grpc.RpcError):
            time.sleep(0.001)


if __name__ == "__main__":
    main()
