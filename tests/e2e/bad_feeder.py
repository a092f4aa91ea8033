"""A camera's driver that goes wrong: bad_feeder.py flood|garble HOST:PORT. Ends on SIGTERM.

flood: grey pictures as fast as the line takes them; garble: bytes that are no picture, cut ones, of other sizes, of
other times, each on a stream of its own.
"""
import itertools
import random
import sys
import time

import feed_pictures
import grpc
import palpate_stubs

messages, services, states = palpate_stubs.load()
from palpate.v1 import devices_pb2 as devices  # noqa: E402: made by palpate_stubs


def flood():
    picture = devices.CameraPicture(encoding=devices.CameraPicture.ENCODING_GREY8, width=WIDTH, height=HEIGHT,
                                    data=bytes(WIDTH * HEIGHT))
    for sequence in itertools.count(1):
        yield feed_pictures.sample(sequence, picture)


def garbled(draw):
    message = feed_pictures.sample(1, devices.CameraPicture(
        encoding=draw.randrange(0, 7), data=draw.randbytes(draw.choice([0, 1, 100, 100_000])),
        width=draw.choice([0, 1, WIDTH, 2**31]), height=draw.choice([0, 1, HEIGHT, 2**31])))
    if draw.random() < 0.3:
        message.sensed_at.seconds = draw.choice([0, -10**12, 10**12])
    if draw.random() < 0.3:
        message.right.CopyFrom(message.picture)
    return message


def main():
    how, target = sys.argv[1:]
    stub = services.TeleoperationStub(palpate_stubs.connect(grpc, target))
    draw = random.Random(1)
    while True:
        try:
            stub.FeedPictures(flood() if how == "flood" else iter([garbled(draw)]), timeout=10)
        except grpc.RpcError:
            time.sleep(0.001)


if __name__ == "__main__":
    WIDTH, HEIGHT = 640, 480
    main()
