#!/usr/bin/python3
"""Operates a slave: moves the tool into contact, holds, and retreats.

usage: operate.py HOST:PORT [--down MM] [--speed MM/S] [--tls DIR]

--down: along -y from the home position [mm], default 9: in the silicone block 6 mm of air and 3 mm of indentation.
Prints the peak force. Exit code 0: the force opposed the motion; 1: otherwise.
"""
import argparse
import sys

import numpy as np
import palpate


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("--down", type=float, default=9, metavar="MM")
    parser.add_argument("--speed", type=float, default=6, metavar="MM/S")
    parser.add_argument("--tls", metavar="DIR", help="folder with ca.pem, cert.pem and key.pem")
    arguments = parser.parse_args()
    down, speed = np.array([0, -1e-3 * arguments.down, 0]), 1e-3 * arguments.speed
    with palpate.connect(arguments.target, arguments.tls) as slave, slave.operate("operate.py") as tool:
        pressing = tool.move_by(down, speed)
        held = tool.hold(0.5)
        tool.move_by(-down, speed)
        name = slave.scene().name
    forces = np.concatenate([pressing.force, held.force])[:, 1]
    peak = np.nanmax(forces, initial=0)
    print(f"{name}: {len(forces)} samples, peak force {peak:.4f} N")
    return 0 if peak > 0 else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except palpate.Error as error:
        sys.exit(f"error: {error}")
