#!/usr/bin/python3
"""Observes a slave, using only the .proto files: states, and the deformed boundary if there is one.

usage: watch.py HOST:PORT [--states N] [--tls DIR]

Prints the number of received and skipped states, and the last forces of the fingertips if there are
several. Exit code 0: the sequence increased throughout and the messages are well-formed; 1: otherwise.
"""
import argparse
import math

import grpc

import palpate_stubs

messages, services, states = palpate_stubs.load()


def numbers(vector):
    return vector.x, vector.y, vector.z


def words(finger):
    """Contact and force of a fingertip, as text."""
    touch = "in contact" if finger.in_contact else "free"
    force = f"{math.hypot(*numbers(finger.force)):.4f} N" if finger.HasField("force") else "force unknown"
    return f"{touch}, {force}, {states.Validity.Name(finger.validity)}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("--states", type=int, default=100)
    palpate_stubs.add_tls(parser)
    arguments = parser.parse_args()

    channel = palpate_stubs.connect(grpc, arguments.target, arguments.tls)
    stub = services.TeleoperationStub(channel)
    status = stub.GetStatus(messages.GetStatusRequest(), timeout=10)
    stream = stub.WatchState(messages.WatchStateRequest(max_rate_hz=100), timeout=60)
    first, last, sensed, wrong = None, 0, set(), []
    for count, state in enumerate(stream, start=1):
        first = first or state.sequence
        if state.sequence <= last:
            wrong.append(f"sequence {state.sequence} after {last}")
        last = state.sequence
        sensed.add(state.sensed_at.ToNanoseconds())
        if len(state.fingers) < 2 and len(state.SerializeToString()) > 256:
            wrong.append(f"state {last} is {len(state.SerializeToString())} bytes long")
        if count == arguments.states:
            stream.cancel()
            break
    mesh_stream = stub.WatchMesh(messages.WatchMeshRequest(), timeout=10)
    mesh = next(mesh_stream)
    mesh_stream.cancel()
    if len(mesh.positions) != len(mesh.rest) or not mesh.elements:
        wrong.append("the first mesh has no topology, or positions that do not fit it")
    for number, finger in enumerate(state.fingers, start=1):
        if finger.HasField("force") and not all(map(math.isfinite, numbers(finger.force))):
            wrong.append(f"the force of finger {number} is not a number")
        print(f"finger {number}: {words(finger)}")
    skipped = last - first + 1 - arguments.states
    print(f"phase {states.Phase.Name(status.phase)}: {arguments.states} states, {skipped} skipped, "
          f"{len(sensed)} samples, {len(mesh.positions) // 3} nodes")
    for problem in wrong:
        print(f"error: {problem}")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
