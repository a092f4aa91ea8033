#!/usr/bin/python3
"""Operates a slave, using only the .proto files: moves the tool into contact and reads the force.

usage: operate.py HOST:PORT [--down MM ...] [--tls DIR]

Engages, approaches by the first --down (6 mm) and indents by the second (3 mm) within 1.5 s, holds,
and retreats. Prints the peak force. Exit code 0: the force opposed the motion, the sequence
increased throughout, and the stream ended with OK; 1: otherwise; 2: unusable arguments.
"""
import argparse
import queue
import threading
import time

import grpc

import palpate_stubs

PERIOD = 0.004  # [s] between commands
APPROACH, HOLD = 1.5, 0.5  # [s]

messages, services, states = palpate_stubs.load()


class Hand:
    """Simulated operator: an iterator over the commands of one contact, read by gRPC."""

    def __init__(self, depth):
        self.depth = depth  # [m]
        self.engaged_from = None
        self.outbox = queue.Queue()
        self.sequence = 0

    def put(self, y, velocity, engaged):
        self.sequence += 1
        command = states.OperatorCommand(sequence=self.sequence, epoch=1, engaged=engaged)
        command.sent_at.GetCurrentTime()
        command.p_M.y = y
        command.velocity.y = velocity
        if self.sequence == 1:
            command.operator_name = "operate.py"
        self.outbox.put(command)

    def press(self):
        """Down by `depth` in APPROACH seconds, hold, up again, disengage."""
        start = time.monotonic()
        speed = self.depth / APPROACH
        total = 2 * APPROACH + HOLD
        while (t := time.monotonic() - start) < total:
            if t < APPROACH:
                y, velocity = -speed * t, -speed
            elif t < APPROACH + HOLD:
                y, velocity = -self.depth, 0.0
            else:
                y, velocity = -speed * (total - t), speed
            self.put(y, velocity, True)
            time.sleep(PERIOD)
        self.put(0.0, 0.0, False)
        time.sleep(0.1)
        self.outbox.put(None)

    def __iter__(self):
        return iter(self.outbox.get, None)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("--down", type=float, nargs=2, default=[6.0, 3.0], metavar="MM",
                        help="approach and indentation at the tool [mm]")
    palpate_stubs.add_tls(parser)
    arguments = parser.parse_args()

    channel = palpate_stubs.connect(grpc, arguments.target, arguments.tls)
    stub = services.TeleoperationStub(channel)
    scene = stub.GetScene(messages.GetSceneRequest(), timeout=10)
    mapping = scene.operator
    hand = Hand(sum(arguments.down) * 1e-3 / mapping.position_scale)
    moving = threading.Thread(target=hand.press, daemon=True)

    stream = stub.Operate(iter(hand), timeout=60)
    moving.start()
    count, last, peak, wrong = 0, 0, 0.0, []
    for state in stream:
        count += 1
        if state.sequence <= last:
            wrong.append(f"sequence {state.sequence} after {last}")
        last = state.sequence
        if state.HasField("force") and state.validity in (
                states.VALIDITY_VALID, states.VALIDITY_EXTRAPOLATED):
            peak = max(peak, state.force.y, key=abs)
    if stream.code() != grpc.StatusCode.OK:
        wrong.append(f"ended with {stream.code()}: {stream.details()}")
    if peak <= 0:
        wrong.append(f"peak force {peak} N along y does not oppose the motion")
    print(f"{scene.name}: {count} states, {hand.sequence} commands, peak force {peak:.4f} N")
    for problem in wrong:
        print(f"error: {problem}")
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
