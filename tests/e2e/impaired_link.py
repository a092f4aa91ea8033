"""A link between two network namespaces with delay, jitter and loss: a TUN device at each end, and a process that
forwards the packets. `can_impair_links()` returns whether the machine permits such links."""
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

SLAVE_ADDRESS, MASTER_ADDRESS = "10.77.0.1", "10.77.0.2"
QUEUE = 0.2  # [s]
TUNSETIFF, IFF_TUN, IFF_NO_PI, CLONE_NEWNET = 0x400454CA, 0x0001, 0x1000, 0x40000000


def ip(*words):
    subprocess.run(["ip", *words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def can_impair_links():
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
    """Opens a TUN device in `namespace`. Its descriptor is valid in every namespace."""
    enter(namespace)
    device = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(device, TUNSETIFF, struct.pack("16sH22x", b"link0", IFF_TUN | IFF_NO_PI))
    return device


def recorded_delay(file, begin):
    """Returns the one-way delay [s] as a function of time [s]: half of the recorded round trip. `file` has a header,
    then one round trip [ms] per line; each request was sent when the answer before it had arrived. The first request
    used is at the share `begin` of the file."""
    trips = [float(line) / 1000 for line in file.read_text().split()[1:]]
    trips = trips[int(begin * len(trips)):]
    ends = list(itertools.accumulate(trips))
    return lambda t: trips[min(bisect.bisect(ends, t), len(trips) - 1)] / 2


def carry(ends, ready, delay, jitter, loss, seed, rate):
    """Forwards packets in order. The one-way delay is `delay` [s], a function of the time since the start [s], varied
    by up to the share `jitter`; the share `loss` of the packets is dropped. `rate` [bytes/s] limits each direction;
    packets that would wait longer than QUEUE are dropped."""
    with contextlib.suppress(PermissionError):  # keeps other load off the link's timing
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(90))
    dice = random.Random(seed)
    devices = [tun(namespace) for namespace in ends]
    ready.set()
    start = time.monotonic()
    in_transit, count, last = [], 0, {device: 0.0 for device in devices}
    free = dict(last)  # time at which each direction has sent all its packets
    while True:
        wait = max(0.0, in_transit[0][0] - time.monotonic()) if in_transit else None
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
            heapq.heappush(in_transit, (due, count, other, packet))
        while in_transit and in_transit[0][0] <= time.monotonic():
            _, _, device, packet = heapq.heappop(in_transit)
            with contextlib.suppress(OSError):  # a full queue drops the packet
                os.write(device, packet)


class ImpairedLink:
    """`at_slave` and `at_master` are the prefixes of commands that run at the two ends. Several links may exist at the
    same time. `delay` replaces half of `round_trip`: a function of the time since the start, both in s."""

    numbers = itertools.count()

    def __init__(self, round_trip=0.0, jitter=0.0, loss=0.0, seed=1, rate=float("inf"), delay=None):
        number = next(ImpairedLink.numbers)
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
        for end, here, there in zip(self.ends, (SLAVE_ADDRESS, MASTER_ADDRESS), (MASTER_ADDRESS, SLAVE_ADDRESS)):
            ip("-n", end, "address", "add", here, "peer", there, "dev", "link0")
            ip("-n", end, "link", "set", "link0", "up")
            ip("-n", end, "link", "set", "lo", "up")
        return self

    def __exit__(self, *error):
        self.carrier.kill()
        self.carrier.join()
        for end in self.ends:
            ip("netns", "delete", end)
