"""Kills, stops or disconnects the slave repeatedly under one master: measures how soon the force ends, and that motion
resumes only after an engagement.

  deaths.py [--times 20] [--only TEXT]    20 repetitions take five minutes; 1000 take a night

A delay is the time from the last state, which arrived at or before the event, to the last tick with a force, without
the time that the machine kept from the loop.
Exit code 1: a delay exceeds 100 ms plus the 99.9th percentile of the lateness of a bare loop; motion resumed without an
engagement; or memory or descriptors of the master grew.
"""
import argparse
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

from delayed_link import DelayedLink
from programs import BLOCK, PATIENCE, SLAVE, Slave, memory, operate, read_json, wait_until
from tick_log import Log

MAX_DELAY, PRESSED, GROWTH = 0.100, 0.3, 16  # [s], [N], [MB]
HERE = pathlib.Path(__file__).resolve().parent


class Bench:
    """A slave behind a link. The slave can be killed and restarted at its address."""

    def __init__(self):
        self.slave = Slave()
        self.slave.__enter__()
        self.link = DelayedLink(self.slave.address, 0)
        self.link.__enter__()

    def kill(self):
        self.slave.process.kill()
        self.slave.process.communicate()

    def restart(self):
        self.slave = Slave(command=[SLAVE, "serve", BLOCK, "--listen", self.slave.address])
        self.slave.__enter__()

    def signal(self, which):
        self.slave.process.send_signal(which)

    def close(self):
        self.link.__exit__()
        self.slave.__exit__()


EVENTS = {
    "kill -9": (Bench.kill, Bench.restart),
    "SIGSTOP": (lambda bench: bench.signal(signal.SIGSTOP), lambda bench: bench.signal(signal.SIGCONT)),
    "cut": (lambda bench: bench.link.cut(), lambda bench: None),
}


def repeat(name, times, folder):
    event, undo = EVENTS[name]
    bench, log = Bench(), Log(folder / "log.csv")
    log.file.unlink(missing_ok=True)
    bare = subprocess.Popen(["/usr/bin/python3", HERE / "bare_loop.py"], stdout=subprocess.PIPE, text=True)
    master = operate(bench.link.address, "--log", log.file, "--report", folder / "report.json")
    delays, costs = [], []
    try:
        for _ in range(times):
            if not wait_until(lambda: log.newest_force() > PRESSED):
                raise AssertionError(f"{name}: nobody presses after {len(delays)} events; a minute of {log.states()}")
            at = time.monotonic()
            event(bench)
            if not wait_until(lambda: log.fell_silent(at) is not None):
                raise AssertionError(f"{name}: the hand is not let go")
            delays.append(log.oldest_rendered(at))
            undo(bench)
            costs.append((memory(master.pid), len(os.listdir(f"/proc/{master.pid}/fd"))))
        wait_until(lambda: log.newest_force() > PRESSED)
        master.send_signal(signal.SIGINT)
        master.wait(timeout=PATIENCE)
        bare.send_signal(signal.SIGTERM)
        return delays, costs, float(bare.stdout.readline()), read_json(folder / "report.json")
    finally:
        for process in (master, bare):
            process.kill()
            process.wait()
        bench.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--only", default="")
    a = parser.parse_args()
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        for name in [one for one in EVENTS if a.only in one]:
            delays, costs, late, report = repeat(name, a.times, pathlib.Path(folder))
            early = costs[min(3, len(costs) - 1)]
            print(f"{name}: {len(delays)} times, no force after at most {1e3 * sorted(delays)[len(delays) // 2]:.0f} ms (worst "
                  f"{1e3 * max(delays):.0f}, bare loop late by {1e3 * late:.1f}), {report['epochs']} engagements, master "
                  f"{early[0]:.0f} to {costs[-1][0]:.0f} MB, {early[1]} to {costs[-1][1]} descriptors", flush=True)
            wrong += [f"{name}: {what}" for what, is_so in [
                ("too late", max(delays) > MAX_DELAY + late), ("went on without an engagement", report["epochs"] <= a.times),
                ("memory", costs[-1][0] > early[0] + GROWTH), ("descriptors", costs[-1][1] > early[1] + 3)] if is_so]
    print("\n".join(wrong), file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
