#!/usr/bin/python3
"""Observes every slave that publishes on a NATS server, without a library for NATS.

usage: watch_nats.py [HOST:PORT] [--seconds S]

Prints the number of received states and the newest force of each slave. Exit code 0: states arrived; 1: otherwise.
"""
import argparse
import socket
import sys
import time
from collections import Counter
from collections.abc import Iterator

import numpy as np
import palpate
from palpate.v1 import state_pb2


def payloads(server: str, subject: str, seconds: float) -> Iterator[tuple[str, bytes]]:
    """Yields subject and payload of the messages that arrive within `seconds`. NATS's protocol consists of lines of text."""
    host, port = server.rsplit(":", 1)
    end = time.monotonic() + seconds
    with socket.create_connection((host, int(port)), timeout=5) as line, line.makefile("rb") as lines:
        line.sendall(f'CONNECT {{"verbose": false, "pedantic": false, "name": "watch_nats.py"}}\r\nSUB {subject} 1\r\n'.encode())
        while time.monotonic() < end:
            words = lines.readline().split()
            if not words or words[0] == b"-ERR":
                raise ConnectionError("the NATS server closed the connection " + b" ".join(words).decode())
            if words[0] == b"PING":
                line.sendall(b"PONG\r\n")
            elif words[0] == b"MSG":
                yield words[1].decode(), lines.read(int(words[-1]) + 2)[:-2]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("server", nargs="?", default="127.0.0.1:4222", metavar="HOST:PORT")
    parser.add_argument("--seconds", type=float, default=2)
    arguments = parser.parse_args()
    counts: Counter[str] = Counter()
    newest = {}
    for subject, payload in payloads(arguments.server, "palpate.*.state", arguments.seconds):
        slave = subject.split(".")[1]
        counts[slave] += 1
        newest[slave] = palpate.State(state_pb2.SlaveState.FromString(payload))
    for slave, state in sorted(newest.items()):
        print(f"{slave}: {counts[slave]} states, {np.linalg.norm(state.force):.4f} N, {state.validity.name}")
    return 0 if newest else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except OSError as error:
        sys.exit(f"error: {error}")
