#!/usr/bin/env python3
"""What the operator's page costs the haptic loop: runs in threes, with a client that reads all that the page is sent as fast
as it comes between two without a page, which tell the noise. No browser: its software rendering would take the cores.
Fails where the page changes a tick by more than the noise does.

tests/bench/bench_view.py [--threes N] [--seconds S] [--scene NAME] [--fine]      needs build/release
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


def finer(folder):
    """The target's mesh with ten times as many triangles, by the script that made it."""
    script = (ROOT / "deploy/scenes/heart-target.py").read_text()
    changed = script.replace("RINGS, AROUND = 9, 32", "RINGS, AROUND = 28, 96")
    assert changed != script
    path = pathlib.Path(folder, "fine.py")
    path.write_text(changed)
    subprocess.run([sys.executable, path], check=True)
    return path.with_suffix(".ply")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--threes", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--scene", default="silicone-block")
    parser.add_argument("--fine", action="store_true", help="heart-target with 5376 triangles, two eyes")
    chosen = parser.parse_args()
    scene = "heart-target" if chosen.fine else chosen.scene
    threes = []
    with tempfile.TemporaryDirectory() as folder:
        finely = ["--override", f"object.geometry.mesh={finer(folder)}"] if chosen.fine else []
        with Slave(ROOT / f"deploy/scenes/{scene}.yaml", *finely) as slave:
            for _ in range(chosen.threes):
                threes.append([])
                for view in (False, True, False):
                    report, sent = session(slave, chosen.seconds, view)
                    threes[-1].append(report)
                    print(f"{'page   ' if view else 'no page'}  wake {report['wake_us']}  compute {report['compute_us']}  "
                          f"missed {report['missed']} (bare {report['bare_loop']['missed']})  "
                          f"{sent / 1e6 / chosen.seconds:.2f} MB/s", flush=True)
    print(f"\n{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}; {chosen.threes} threes of {chosen.seconds:g} s each, {scene}")
    held = True
    for kind, share in (("compute_us", "p50"), ("compute_us", "p99"), ("wake_us", "p50"), ("wake_us", "p99")):
        figures = [[report[kind][share] for report in three] for three in threes]
        page = statistics.median(2 * b / (a + c) for a, b, c in figures)
        noise = max(max(a, c) / min(a, c) for a, _, c in figures)
        held = held and page <= noise
        print(f"{kind:10} {share}: {statistics.median(b for _, b, _ in figures):8.2f} us with the page, "
              f"{statistics.median(x for a, _, c in figures for x in (a, c)):8.2f} us without: ratio {page:.3f}, "
              f"of two without up to {noise:.3f}")
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
