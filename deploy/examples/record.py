#!/usr/bin/python3
"""Keeps the forces of a slave as NumPy arrays: one row per sample with time, tip, force, sigma and validity.

usage: record.py HOST:PORT FILE.npz [--seconds S] [--tls DIR]
       record.py FILE.mcap FILE.npz              from a recording of palpate-master or palpate-slave

Prints the number of samples, how many are valid, and the largest valid force. Exit code 0: there are samples; 1: none.
"""
import argparse
import pathlib
import sys

import palpate


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source", help="HOST:PORT or FILE.mcap")
    parser.add_argument("file", help="FILE.npz")
    parser.add_argument("--seconds", type=float, default=4)
    parser.add_argument("--tls", metavar="DIR", help="folder with ca.pem, cert.pem and key.pem")
    arguments = parser.parse_args()
    if pathlib.Path(arguments.source).is_file():
        states = palpate.read_recording(arguments.source).states
    else:
        with palpate.connect(arguments.source, arguments.tls) as slave:
            states = slave.record(arguments.seconds)
    states.save(arguments.file)
    share = states.valid.mean() if len(states) else 0
    print(f"{len(states)} samples, {share:.0%} valid, peak {states.peak:.3f} N")
    return 0 if len(states) else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (palpate.Error, OSError, ValueError) as error:
        sys.exit(f"error: {error}")
