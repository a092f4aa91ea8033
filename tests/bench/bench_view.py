#!/usr/bin/env python3
"""What the operator's page costs the haptic loop: runs in pairs, without the page and with a client that reads all that the
page is sent as fast as it comes. No browser: its software rendering would take the cores.

tests/bench/bench_view.py [--pairs N] [--seconds S] [--scene NAME]      needs build/release
"""
import argparse
import json
import os
import pathlib
import re
import socket
import statistics
import subprocess
import sys
import tempfile
import threading

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/e2e"))
from programs import MASTER, Slave  # noqa: E402


class Reader(threading.Thread):
    """Reads the WebSocket until it ends, and counts."""

    def __init__(self, address):
        super().__init__(daemon=True)
        host = re.fullmatch(r"http://([^/]+)/", address)[1]
        name, port = host.rsplit(":", 1)
        self.line = socket.create_connection((name, int(port)))
        self.line.sendall((f"GET /ws HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                           "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n").encode())
        self.bytes = 0

    def run(self):
        try:
            while data := self.line.recv(1 << 16):
                self.bytes += len(data)
        except OSError:
            pass


def session(slave, seconds, view):
    """The report of one run, and the bytes that the page was sent."""
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder, "report.json")
        command = [MASTER, "connect", slave.address, "--duration", str(seconds), "--report", str(report)]
        program = subprocess.Popen(command + (["--view"] if view else []), stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, text=True)
        reader = None
        for line in program.stdout:
            if view and reader is None and (found := re.search(r"view at (\S+)", line)):
                reader = Reader(found[1])
                reader.start()
        program.wait()
        return json.loads(report.read_text()), reader.bytes if reader else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=6)
    parser.add_argument("--scene", default="silicone-block")
    chosen = parser.parse_args()
    taken = {False: [], True: []}
    with Slave(ROOT / f"deploy/scenes/{chosen.scene}.yaml") as slave:
        for pair in range(chosen.pairs):
            for view in ((False, True) if pair % 2 == 0 else (True, False)):
                report, sent = session(slave, chosen.seconds, view)
                taken[view].append(report)
                print(f"{'page   ' if view else 'no page'}  wake {report['wake_us']}  compute {report['compute_us']}  "
                      f"missed {report['missed']} (bare {report['bare_loop']['missed']})  "
                      f"{sent / 1e6 / chosen.seconds:.2f} MB/s", flush=True)
    print(f"\n{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}; medians of {chosen.pairs} pairs of {chosen.seconds:g} s, {chosen.scene}")
    for kind, share in (("compute_us", "p50"), ("compute_us", "p99"), ("wake_us", "p50"), ("wake_us", "p99")):
        without, with_page = (statistics.median(report[kind][share] for report in taken[view]) for view in (False, True))
        pairs = [b[kind][share] / a[kind][share] for a, b in zip(taken[False], taken[True]) if a[kind][share] > 0]
        print(f"{kind:10} {share}: {without:8.2f} us without, {with_page:8.2f} us with; ratio of pairs {statistics.median(pairs):.3f} "
              f"({min(pairs):.3f} to {max(pairs):.3f})")


if __name__ == "__main__":
    main()
