#!/usr/bin/env python3
"""What watchers of pictures and meshes cost the states: runs in threes, with a client that reads both as fast as they come,
in moves of a stated error, between two without one, which tell the noise. All of it over a line of a given width that they
share, first come, first served. Prints the age of the states at the master, round trips, and what the meshes took.

tests/bench/bench_bulk.py [--threes N] [--seconds S] [--scene NAME] [--fine] [--mbit M]      needs build/release, grpcio
"""
import argparse
import collections
import json
import pathlib
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time

from bench_view import ROOT, finer
from programs import MASTER, PACKAGE, Slave

sys.path.insert(0, str(PACKAGE))
import grpc  # noqa: E402
import palpate  # noqa: E402
from palpate.v1 import teleoperation_pb2 as messages  # noqa: E402

KEPT = 64 << 10  # that the line holds at most before whoever sends must wait [bytes]


class Line:
    """Passes connections on to `target`, what goes back to whoever asked at `mbit` altogether, in the order in which it comes."""

    def __init__(self, target, mbit):
        host, port = target.rsplit(":", 1)
        self.target, self.rate = (host, int(port)), mbit * 1e6 / 8
        self.server = socket.create_server(("127.0.0.1", 0))
        self.address = "127.0.0.1:%d" % self.server.getsockname()[1]
        self.queue, self.held, self.changed = collections.deque(), 0, threading.Condition()
        for work in (self._accept, self._send):
            threading.Thread(target=work, daemon=True).start()

    def _accept(self):
        while True:
            near, _ = self.server.accept()
            far = socket.create_connection(self.target)
            for end in (near, far):
                end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            threading.Thread(target=self._up, args=(near, far), daemon=True).start()
            threading.Thread(target=self._down, args=(far, near), daemon=True).start()

    @staticmethod
    def _up(near, far):
        try:
            while data := near.recv(1 << 16):
                far.sendall(data)
        except OSError:
            pass
        far.close()

    def _down(self, far, near):
        try:
            while data := far.recv(1500):
                with self.changed:
                    self.changed.wait_for(lambda: self.held < KEPT)
                    self.queue.append((near, data))
                    self.held += len(data)
                    self.changed.notify_all()
        except OSError:
            pass
        near.close()

    def _send(self):
        due = time.monotonic()
        while True:
            with self.changed:
                self.changed.wait_for(lambda: self.queue)
                near, data = self.queue.popleft()
            due = max(due, time.monotonic()) + len(data) / self.rate
            time.sleep(max(0, due - time.monotonic()))
            try:
                near.sendall(data)
            except OSError:
                pass
            with self.changed:
                self.held -= len(data)
                self.changed.notify_all()


class Watcher:
    """Reads meshes and pictures of `address` while it lives."""

    def __init__(self, address):
        self.bytes, self.meshes, self.pictures, self.worst = 0, 0, 0, 0.0
        stub = palpate.connect(address).stub
        self.streams = [stub.WatchMesh(messages.WatchMeshRequest(max_rate_hz=30, relative_error=1e-4)),
                        stub.WatchVideo(messages.WatchVideoRequest(max_rate_hz=60, overlays=True))]
        for stream, take in zip(self.streams, (self._mesh, self._picture)):
            threading.Thread(target=self._read, args=(stream, take), daemon=True).start()

    @staticmethod
    def _read(stream, take):
        try:
            for message in stream:
                take(message)
        except grpc.RpcError:
            pass

    def _mesh(self, mesh):
        self.meshes += 1
        self.worst = max(self.worst, mesh.moves.error)
        if not mesh.rest:  # the topology comes once
            self.bytes += mesh.ByteSize()

    def _picture(self, _):
        self.pictures += 1

    def close(self):
        for stream in self.streams:
            stream.cancel()


def session(address, seconds, watched):
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder, "report.json")
        watcher = Watcher(address) if watched else None
        subprocess.run([MASTER, "connect", address, "--duration", str(seconds), "--report", report], check=True, capture_output=True)
        if watcher:
            watcher.close()
        return json.loads(report.read_text()), watcher


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--threes", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--scene", default="silicone-block")
    parser.add_argument("--fine", action="store_true", help="heart-target with 5376 triangles, two eyes")
    parser.add_argument("--mbit", type=float, default=20)
    chosen = parser.parse_args()
    scene = "heart-target" if chosen.fine else chosen.scene
    threes = []
    with tempfile.TemporaryDirectory() as folder:
        finely = ["--override", f"object.geometry.mesh={finer(folder)}"] if chosen.fine else []
        with Slave(ROOT / f"deploy/scenes/{scene}.yaml", *finely) as slave:
            line = Line(slave.address, chosen.mbit)
            for _ in range(chosen.threes):
                threes.append([])
                for watched in (False, True, False):
                    report, watcher = session(line.address, chosen.seconds, watched)
                    threes[-1].append(report)
                    bulk = (f"  {watcher.meshes} meshes, {8e-6 * watcher.bytes / chosen.seconds:.2f} Mbit/s, off by {watcher.worst:.1e} m, "
                            f"{watcher.pictures} pictures" if watcher else "")
                    print(f"{'watched' if watched else 'alone  '}  age {report['state_age_us']}  round trip {report['rtt_us']}{bulk}", flush=True)
    for kind in ("state_age_us", "rtt_us"):
        for share in ("p50", "p99"):
            figures = [[report[kind][share] for report in three] for three in threes]
            print(f"{kind:12} {share}: {statistics.median(b for _, b, _ in figures):9.0f} us watched, "
                  f"{statistics.median(x for a, _, c in figures for x in (a, c)):9.0f} us alone; of two alone up to x {max(max(a, c) / min(a, c) for a, _, c in figures):.2f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
