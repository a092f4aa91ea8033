#!/usr/bin/env python3
"""Measures the effect of observers behind a NATS server on the operator, and what the observers receive. Server and
observers run on this machine, with nice 5.

  bench_observers.py [--threes N] [--seconds S] [--observers N] [--restarts N]   needs nats-server

Operator: groups of three runs, one with observers of a slave between two without server and publishing. Prints command
ages at the slave, and the longest time for which a processor did not run even the most urgent thread, as on a virtual
machine without its share.
Restart: the server is killed and restarted. Prints the seconds from its first answer until every observer has read a
state again.
"""
import argparse
import contextlib
import multiprocessing
import os
import pathlib
import statistics
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "e2e"))
from observers import Crowd, Server, require_server  # noqa: E402
from programs import BLOCK, Slave, cpu_seconds  # noqa: E402
from test_crowd import session  # noqa: E402

STATES = "palpate.silicone-block.state"


def watch_processor(processor, longest):
    """Records the longest time in which the processor did not run an urgent thread [s]; 0 without the privilege."""
    os.sched_setaffinity(0, {processor})
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(90))
    last = time.monotonic()
    while True:
        time.sleep(0.002)
        last, before = time.monotonic(), last
        longest.value = max(longest.value, last - before)


@contextlib.contextmanager
def watched_processors():
    """Measures the longest such time of each processor."""
    longest = {i: multiprocessing.Value("d", 0) for i in os.sched_getaffinity(0)}
    processes = [multiprocessing.Process(target=watch_processor, args=pair, daemon=True) for pair in longest.items()]
    for process in processes:
        process.start()
    try:
        yield longest.values()
    finally:
        for process in processes:
            process.kill()
            process.join()


def operated(slave, a, folder):
    """Command age p99 [us], number of holds of the operator, the slave's share of a core, and the longest time without
    processor [s]."""
    used, begun = cpu_seconds(slave.process.pid), time.monotonic()
    with watched_processors() as longest:
        seen = session(slave, a.seconds, folder)
    return *seen, (cpu_seconds(slave.process.pid) - used) / (time.monotonic() - begun), max(value.value for value in longest)


def alone(a, folder):
    with Slave() as slave:
        return operated(slave, a, folder)


def observed(a, folder):
    with Server() as server, Slave(BLOCK, "--publish", server.url) as slave, Crowd(server, STATES, a.observers) as crowd:
        crowd.all_read()
        before, begun = list(crowd.counts), time.monotonic()
        seen = operated(slave, a, folder)
        passed = time.monotonic() - begun
        rates = [(now - then) / passed for now, then in zip(crowd.counts, before)]
        return *seen, min(rates), max(rates)


def operator(a, folder):
    threes, shares = [], []
    for _ in range(a.threes):
        before, beside, after = alone(a, folder), observed(a, folder), alone(a, folder)
        threes.append((before[0], beside[0], after[0]))
        shares.append(beside[2] - (before[2] + after[2]) / 2)
        print(f"command age p99 {before[0] / 1e3:.2f}, {after[0] / 1e3:.2f} ms alone, {beside[0] / 1e3:.2f} ms beside {a.observers} observers; "
              f"held {before[1]}, {after[1]} alone, {beside[1]} beside; a processor stood still for {1e3 * before[3]:.0f}, {1e3 * after[3]:.0f} ms "
              f"alone, {1e3 * beside[3]:.0f} ms beside; {beside[4]:.1f} to {beside[5]:.1f} states/s each; "
              f"load {os.getloadavg()[0]:.1f}", flush=True)
    ratios = sorted(2 * b / (c + d) for c, b, d in threes)
    noise = max(max(c, d) / min(c, d) for c, _, d in threes)
    print(f"operator: ratio median {statistics.median(ratios):.2f}, {ratios[0]:.2f} to {ratios[-1]:.2f}; of two alone up to {noise:.2f}; "
          f"publishing: {100 * statistics.median(shares):.1f} % of a core, {100 * min(shares):.1f} to {100 * max(shares):.1f} %")


def restart(a):
    took = []
    server = Server()
    with server, Slave(BLOCK, "--publish", server.url), Crowd(server, STATES, a.observers) as crowd:
        crowd.all_read()
        for _ in range(a.restarts):
            server.kill()
            time.sleep(1)
            server.start()
            took.append(crowd.all_read())
    print(f"restart: {a.observers} observers read again after {min(took):.2f} to {max(took):.2f} s, median {statistics.median(took):.2f} s")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--threes", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--observers", type=int, default=200)
    parser.add_argument("--restarts", type=int, default=5)
    a = parser.parse_args()
    require_server()
    restart(a)
    with tempfile.TemporaryDirectory() as folder:
        operator(a, pathlib.Path(folder))


if __name__ == "__main__":
    main()
