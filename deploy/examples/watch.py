#!/usr/bin/python3
"""Observes a slave: states, fingertips, and the deformed boundary. Observing cannot move the tool.

usage: watch.py HOST:PORT [--states N] [--tls DIR]

Prints the number of received and skipped states. Exit code 0: the sequence increased throughout; 1: otherwise.
"""
import argparse
import itertools
import sys

import numpy as np
import palpate


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("--states", type=int, default=100)
    parser.add_argument("--tls", metavar="DIR", help="folder with ca.pem, cert.pem and key.pem")
    arguments = parser.parse_args()
    with palpate.connect(arguments.target, arguments.tls) as slave:
        phase = palpate.Phase(slave.status().phase)
        states = list(itertools.islice(slave.states(rate=100, seconds=60), arguments.states))
        mesh = next(slave.meshes(seconds=10))
    for number, finger in enumerate(states[-1].fingertips, start=1):
        touch = "in contact" if finger.in_contact else "free"
        print(f"finger {number}: {touch}, {np.linalg.norm(finger.force):.4f} N, {finger.validity.name}")
    steps = np.diff([state.sequence for state in states])
    print(f"phase {phase.name}: {len(states)} states, {(steps - 1).sum()} skipped, {len(palpate.States.of(states))} samples, "
          f"{len(mesh.positions)} nodes")
    return 0 if (steps > 0).all() and mesh.rest.shape == mesh.positions.shape else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except palpate.Error as error:
        sys.exit(f"error: {error}")
