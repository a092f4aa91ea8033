"""Hours of operating with everything that happens to a link: what dies, stalls or attacks, at random; memory and descriptors
stay flat, and whoever comes back is served.

  soak.py [--minutes 60] [--seed 1]
"""
import argparse
import fcntl
import multiprocessing
import os
import pathlib
import random
import signal
import subprocess
import sys
import time

from programs import BARE, MASTER, Slave
from untrusted_clients import ATTACKS, answers
from test_untrusted_clients import memory

WARM_UP = 120          # [s] before sizes are taken as what is needed
GROWTH = 32            # [MB] from there on
DESCRIPTORS = 16       # from there on


def descriptors(pid):
    return len(os.listdir(f"/proc/{pid}/fd"))


def resident(pid):
    return int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE") / 1e6


def operate(address):
    return subprocess.Popen([MASTER, "connect", address, "--wait", "60"], stdin=subprocess.DEVNULL,
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=BARE)


def stall(process, seconds):
    process.send_signal(signal.SIGSTOP)
    time.sleep(seconds)
    process.send_signal(signal.SIGCONT)


def attack(address, name, seconds):
    stranger = multiprocessing.Process(target=ATTACKS[name], args=(address, time.monotonic() + seconds))
    stranger.start()
    stranger.join(seconds + 30)
    stranger.kill()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--seed", type=int, default=1)
    a = parser.parse_args()
    dice, begin = random.Random(a.seed), time.monotonic()
    with Slave() as slave:
        host, port = slave.address.split(":")
        fcntl.fcntl(slave.process.stderr, fcntl.F_SETPIPE_SZ, 4096)  # nobody reads its log
        pid, master, known, events = slave.process.pid, operate(slave.address), None, 0
        while time.monotonic() - begin < 60 * a.minutes:
            what = dice.choice(["kill", "leave", "stall hand", "stall slave", *ATTACKS])
            events += 1
            if what in ("kill", "leave"):
                master.send_signal(signal.SIGKILL if what == "kill" else signal.SIGINT)
                master.wait()
                master = operate(slave.address)
            elif what.startswith("stall"):
                stall(master if what == "stall hand" else slave.process, dice.uniform(0.01, 1))
            else:
                attack((host, int(port)), what, 3)
            time.sleep(dice.uniform(1, 5))
            served = answers((host, int(port)), 20)
            sizes = (resident(pid), descriptors(pid))
            print(f"{time.monotonic() - begin:7.0f} s  {what:32} {sizes[0]:5.0f} MB {sizes[1]:4} descriptors  "
                  f"answered in {served or -1:.3f} s", flush=True)
            if slave.process.poll() is not None or master.poll() is not None or served is None:
                print("failed: somebody is gone", file=sys.stderr)
                return 1
            if known is None and time.monotonic() - begin > WARM_UP:
                known = sizes
        master.send_signal(signal.SIGINT)
        master.wait()
        grown = [now - then for now, then in zip(sizes, known or sizes)]
        print(f"{events} events, seed {a.seed}: {grown[0]:+.0f} MB, {grown[1]:+d} descriptors, {memory(pid):.0f} MB at most")
        return int(grown[0] > GROWTH or grown[1] > DESCRIPTORS)


if __name__ == "__main__":
    sys.exit(main())
