#!/usr/bin/python3
"""Sends tactile samples to a slave at the rate of a recording, using only the .proto files.

usage: feed_tactile.py HOST:PORT [RECORDING.csv] [--finger NAME ...] [--hurry] [--check] [--tls DIR]

The recording has a header with a time in seconds (rel_time_s, time_s, t or timestamp) and NAME_E1 to
NAME_E19, NAME_pdc, NAME_pac0 for each finger (without NAME_ for a single finger). Without a
recording every finger rests for half a second. Fingers: by default all fingers of the scene.
--hurry: as fast as possible. --check: also send a sample with 18 electrodes on a separate stream,
which must be rejected with an explanation.

Prints the number of accepted samples. Exit code 0: all; 1: not all; 2: unusable arguments.
"""
import argparse
import csv
import sys
import time

import grpc

import palpate_stubs

ELECTRODES = 19
CLOCKS = ("rel_time_s", "time_s", "t", "timestamp")

messages, services, states = palpate_stubs.load()


def columns_of(header, finger):
    """Columns of the electrodes of `finger` and of its pressures pdc, pac0, if present."""
    named = f"{finger}_E1" in header
    prefix = f"{finger}_" if named else ""
    names = [f"{prefix}E{i}" for i in range(1, ELECTRODES + 1)]
    missing = [name for name in names if name not in header]
    if missing:
        sys.exit(f"the recording has no {missing[0]}: accepted is {names[0]} to {names[-1]}")
    pressures = []
    for name in (f"{prefix}pdc", f"{prefix}pac0"):
        if name not in header:
            break
        pressures.append(header.index(name))
    return [header.index(name) for name in names], pressures


def read(path, fingers):
    """Yields (t [s], finger, electrodes, pressures)."""
    with open(path, newline="", encoding="ascii") as file:
        rows = csv.reader(line for line in file if not line.startswith("#"))
        header = next(rows)
        clock = next((header.index(name) for name in CLOCKS if name in header), None)
        if clock is None:
            sys.exit(f"the recording has no time: accepted is one of {', '.join(CLOCKS)}")
        columns = {finger: columns_of(header, finger) for finger in fingers}
        for row in rows:
            for finger, (electrodes, pressures) in columns.items():
                yield (float(row[clock]), finger, [float(row[i]) for i in electrodes],
                       [float(row[i]) for i in pressures])


def rest(fingers):
    """Half a second without contact."""
    for i in range(50):
        for finger in fingers:
            yield 0.01 * i, finger, [3000.0 + k for k in range(ELECTRODES)], [2000.0, 1800.0]


def sample(sequence, t, finger, electrodes, pressures):
    message = states.TactileSample(sequence=sequence, finger=finger, electrodes=electrodes,
                                   pressure=pressures)
    message.sensed_at.FromNanoseconds(round(1e9 * t))
    return message


def paced(rows, hurry):
    """Messages with the recording's timestamps, shifted to the present."""
    start, first = time.time(), None
    for sequence, (t, *rest_of_row) in enumerate(rows, start=1):
        first = t if first is None else first
        due = start + t - first
        if not hurry:
            time.sleep(max(0.0, due - time.time()))
        yield sample(sequence, due, *rest_of_row)


def is_refused_in_words(stub, finger):
    try:
        short = sample(1, time.time(), finger, [0.0] * (ELECTRODES - 1), [])
        stub.FeedTactile(iter([short]), timeout=10)
    except grpc.RpcError as error:
        print(f"18 electrodes: {error.details()}")
        return error.code() == grpc.StatusCode.INVALID_ARGUMENT and "accepted is" in error.details()
    return False


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("recording", nargs="?")
    parser.add_argument("--finger", action="append", dest="fingers")
    parser.add_argument("--hurry", action="store_true")
    parser.add_argument("--check", action="store_true")
    palpate_stubs.add_tls(parser)
    arguments = parser.parse_args()

    stub = services.TeleoperationStub(palpate_stubs.connect(grpc, arguments.target, arguments.tls))
    scene = stub.GetScene(messages.GetSceneRequest(), timeout=10)
    fingers = arguments.fingers or [fingertip.name for fingertip in scene.fingertips]
    if not fingers:
        sys.exit(f"{scene.name} has no fingertips")
    rows = read(arguments.recording, fingers) if arguments.recording else rest(fingers)
    sent = 0

    def counted():
        nonlocal sent
        for message in paced(rows, arguments.hurry):
            sent += 1
            yield message

    try:
        reply = stub.FeedTactile(counted())
    except grpc.RpcError as error:
        print(f"error: {error.code().name}: {error.details()}")
        return 1
    print(f"{scene.name}: {reply.samples} of {sent} samples of {', '.join(fingers)} accepted")
    refused = not arguments.check or is_refused_in_words(stub, fingers[0])
    return 0 if refused and sent > 0 and reply.samples == sent else 1


if __name__ == "__main__":
    raise SystemExit(main())
