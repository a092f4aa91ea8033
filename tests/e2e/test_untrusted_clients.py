"""A slave that is attacked while an operator uses it keeps running, needs little memory, executes the emergency stop,
and accepts new clients at once afterwards.

  test_untrusted_clients.py [--seconds 2] [--only REGEX]    prints a table; --seconds 30 for the figures of SECURITY.md
"""
import argparse
import fcntl
import multiprocessing
import pathlib
import re
import signal
import sys
import tempfile
import time

from programs import PATIENCE, Slave, memory, operate, read_json, wait_until
from tick_log import times_held, whole_rows
from untrusted_clients import ATTACKS, Stopper, answers

MAX_MEMORY = 300       # [MB]
ATTACKERS = 2           # processes


def stolen():
    """Returns the processor time that the host gave to other machines, and all processor time so far."""
    times = [int(word) for word in pathlib.Path("/proc/stat").read_text().splitlines()[0].split()[1:9]]
    return times[7], sum(times)


def held(log):
    """Returns how often the operator was held or disconnected between the first FOLLOWING and the emergency stop, and
    the age of the oldest state in that time [s]."""
    ticks = whole_rows(log)
    states = [row["state"] for row in ticks]
    first = states.index("FOLLOWING")
    last = states.index("ESTOP") if "ESTOP" in states else len(states)
    return times_held(states[first:last]), max(float(row["age_s"]) for row in ticks[first:last])


def attack(name, seconds, out):
    with Slave() as slave:
        host, port = slave.address.split(":")
        address = (host, int(port))
        # The pipe of its log is full at once, because nothing reads it.
        fcntl.fcntl(slave.process.stderr, fcntl.F_SETPIPE_SZ, 4096)
        log, report = out / "log.csv", out / "report.json"
        log.unlink(missing_ok=True)
        master = operate(slave.address, "--duration", "600", "--log", log, "--report", report)
        if not wait_until(lambda: any(row["state"] == "FOLLOWING" for row in whole_rows(log)[-50:])):
            raise AssertionError("nobody follows")
        stopper, stolen_before = Stopper(address), stolen()
        end = time.monotonic() + seconds
        attackers = [multiprocessing.Process(target=ATTACKS[name], args=(address, end + 60))
                     for _ in range(ATTACKERS if name in ATTACKS else 0)]
        for one in attackers:
            one.start()
        stopper.wait(end)
        stops = []
        for _ in range(20):
            stops.append(stopper.stop())
            time.sleep(0.02)
        for one in attackers:
            one.kill()
            one.join()
        answered = answers(address, PATIENCE)
        master.send_signal(signal.SIGINT)
        master.wait(timeout=PATIENCE)
        printed = read_json(report)
        kept, passed = (b - a for a, b in zip(stolen_before, stolen()))
        return {"alive": slave.process.poll() is None, "memory": memory(slave.process.pid, "VmHWM"), "answered": answered,
                "stop": sorted(stops)[len(stops) // 2], "stop_max": max(stops), "held": held(log),
                "reconnects": printed["reconnects"], "trouble": printed["trouble"],
                "stolen": kept / passed}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=2)
    parser.add_argument("--only", default="")
    a = parser.parse_args()
    wrong = []
    print(f"{'':34}  alive  MB max  answers s  stop ms, max   held, oldest ms  reconnects  time the host took")
    with tempfile.TemporaryDirectory() as folder:
        for name in ["nobody", *ATTACKS]:
            if not re.search(a.only, name):
                continue
            saw = attack(name, a.seconds, pathlib.Path(folder))
            print(f"{name:34}  {saw['alive']!s:5}  {saw['memory']:6.0f}  {saw['answered'] or -1:9.3f}"
                  f"  {1e3 * saw['stop']:7.1f} {1e3 * saw['stop_max']:6.1f}  {saw['held'][0]:5d}  {1e3 * saw['held'][1]:9.0f}  {saw['reconnects']:10d}"
                  f"  {100 * saw['stolen']:.1f} % {saw['trouble']}", flush=True)
            wrong += [f"{name}: {words}" for words, is_so in [
                ("the slave died", not saw["alive"]), ("does not respond", saw["answered"] is None),
                (f"{saw['memory']:.0f} MB", saw["memory"] > MAX_MEMORY)] if is_so]
    print("\n".join(wrong), file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
