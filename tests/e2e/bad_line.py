"""A line between two network namespaces that delays, shakes and loses packets: a TUN device at each end, and a process that
carries what comes. For tests: `permitted()` tells whether the machine lets one."""
import bisect
import contextlib
import ctypes
import fcntl
import heapq
import itertools
import multiprocessing
import os
import random
import select
import struct
import subprocess
import time

SLAVE_AT, MASTER_AT = "10.77.0.1", "10.77.0.2"
QUEUE = 0.2  # [s]
TUNSETIFF, IFF_TUN, IFF_NO_PI, CLONE_NEWNET = 0x400454CA, 0x0001, 0x1000, 0x40000000


def ip(*words):
    subprocess.run(["ip", *words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def permitted():
    name = f"palpate-try-{os.getpid()}"
    try:
        ip("netns", "add", name)
        ip("netns", "delete", name)
        return os.access("/dev/net/tun", os.R_OK | os.W_OK)
    except (OSError, subprocess.CalledProcessError):
        return False


def enter(namespace):
    with open(f"/var/run/netns/{namespace}") as at:
        if ctypes.CDLL(None, use_errno=True).setns(at.fileno(), CLONE_NEWNET) != 0:
            raise OSError(ctypes.get_errno(), "setns")


def tun(namespace):
    """A TUN device in `namespace`: its descriptor works from anywhere."""
    enter(namespace)
    device = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(device, TUNSETIFF, struct.pack("16sH22x", b"line", IFF_TUN | IFF_NO_PI))
    return device


def recorded_delay(file, begin):
    """The delay one way [s] over time [s], from recorded round trips in ms, one a line below a header. The first request left
    at the share `begin` of the file, each other one when the answer before it had come. Half of a round trip is each way's."""
    trips = [float(line) / 1000 for line in file.read_text().split()[1:]]
    trips = trips[int(begin * len(trips)):]
    ends = list(itertools.accumulate(trips))
    return lambda t: trips[min(bisect.bisect(ends, t), len(trips) - 1)] / 2


def carry(ends, ready, delay, jitter, loss, seed, rate):
    """One way each `delay` [s] at a time since the start [s], shaken by up to the share `jitter`, in order; the share `loss`
    never comes. A line of `rate` [bytes/s] each way keeps what it cannot carry yet for QUEUE, and loses the rest."""
    with contextlib.suppress(PermissionError):  # the line, not what else the machine does
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(90))
    dice = random.Random(seed)
    devices = [tun(namespace) for namespace in ends]
    ready.set()
    start = time.monotonic()
    on_their_way, count, last = [], 0, {device: 0.0 for device in devices}
    free = dict(last)  # when the line has carried what it has
    while True:
        wait = max(0.0, on_their_way[0][0] - time.monotonic()) if on_their_way else None
        for device in select.select(devices, [], [], wait)[0]:
            packet = os.read(device, 65536)
            if dice.random() < loss:
                continue
            other = devices[1 - devices.index(device)]
            now = time.monotonic()
            if free[other] - now > QUEUE:
                continue
            free[other] = max(free[other], now) + len(packet) / rate
            due = max(last[other], free[other] + delay(now - start) * (1 + jitter * dice.uniform(-1, 1)))
            last[other] = due
            count += 1
            heapq.heappush(on_their_way, (due, count, other, packet))
        while on_their_way and on_their_way[0][0] <= time.monotonic():
            _, _, device, packet = heapq.heappop(on_their_way)
            with contextlib.suppress(OSError):  # a queue that is full loses it
                os.write(device, packet)


class BadLine:
    """`at_slave` and `at_master` go before the commands of the two sides. Several may run beside each other. `delay` replaces
    half of `round_trip`: a function of the time since the start, both in s."""

    numbers = itertools.count()

    def __init__(self, round_trip=0.0, jitter=0.0, loss=0.0, seed=1, rate=float("inf"), delay=None):
        number = next(BadLine.numbers)
        self.ends = [f"palpate-{os.getpid()}-{number}-{side}" for side in ("slave", "master")]
        self.at_slave, self.at_master = (["ip", "netns", "exec", end] for end in self.ends)
        self.ready = multiprocessing.Event()
        self.carrier = multiprocessing.Process(
            target=carry, daemon=True,
            args=(self.ends, self.ready, delay or (lambda _: round_trip / 2), jitter, loss, seed, rate))

    def __enter__(self):
        for end in self.ends:
            ip("netns", "add", end)
        self.carrier.start()
        self.ready.wait(10)
        for end, here, there in zip(self.ends, (SLAVE_AT, MASTER_AT), (MASTER_AT, SLAVE_AT)):
            ip("-n", end, "address", "add", here, "peer", there, "dev", "line")
            ip("-n", end, "link", "set", "line", "up")
            ip("-n", end, "link", "set", "lo", "up")
        return self

    def __exit__(self, *error):
        self.carrier.kill()
        self.carrier.join()
        for end in self.ends:
            ip("netns", "delete", end)
