"""A slave under load beside an operator: idle, pinging, sending and watching clients.

  test_load.py [--seconds 5] [--only REGEX]    prints a table; --seconds 60 or 30 for the figures of tests/RESULTS.md

Columns: resident memory 3 s after the load; p99 of the period at which samples are solved, without and with the load; longest time
until a new client has a status; p99 of the time of Stop; how often the operator was in HOLD or disconnected; whether it kept the lease.
Fails if the slave ends, a new client has no answer, or the operator loses the lease.
"""
import argparse
import collections
import contextlib
import multiprocessing
import pathlib
import re
import signal
import socket
import ssl
import sys
import tempfile
import threading
import time

from programs import BLOCK, PACKAGE, PATIENCE, Slave, make_certificates, memory, operate, read_json, wait_until

sys.path.insert(0, str(PACKAGE))
import grpc
import palpate
from palpate.v1 import teleoperation_pb2 as messages
from tick_log import times_held, whole_rows
from untrusted_clients import DATA, OURS, PING, PREFACE, SETTINGS, WINDOW_UPDATE, answers, call, frame, message

PERIOD = 0.01        # between the messages of a connection [s]
RATE = 220e3         # data rate of a connection that sends commands [bytes/s]
GREETING = PREFACE + frame(SETTINGS, 0, 0)
COMMAND = message(b"\x08\x01" + b"\x72\x5a" + b"x" * 90)  # the sequence, and a field that this version does not know

def connection(address, source, context=None):
    line = socket.create_connection(address, timeout=5, source_address=(source, 0))
    line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    if context:
        line = context.wrap_socket(line, server_hostname=address[0])
    line.setblocking(False)
    return line

class Connection:
    """A connection that never blocks: data that does not fit is sent later, and meanwhile no more is added."""

    def __init__(self, *where, first):
        self.socket, self.left = connection(*where), first
        self.is_open = True
        self.send(b"")

    def send(self, words):
        self.left = self.left or words
        try:
            self.left = self.left[self.socket.send(self.left) if self.left else 0:]
        except (BlockingIOError, ssl.SSLWantWriteError):
            pass
        except OSError:
            self.is_open = False

    def drain(self):
        try:
            while data := self.socket.recv(1 << 16):
                self.acknowledge(data)
            self.is_open = False
        except (BlockingIOError, ssl.SSLWantReadError):
            pass
        except OSError:
            self.is_open = False

    def acknowledge(self, data):
        """Acknowledges the settings frame, which is the first one."""
        if data[3:4] == bytes([SETTINGS]) and not data[4] & 1 and not self.left:
            self.send(frame(SETTINGS, 1, 0))


def crowd(address, count, sources, first, again, every, context=None):
    """Keeps `count` connections that begin with `first` and send `again()` every `every` seconds. Replaces those that
    end."""
    lines, due, n = [], time.monotonic(), 0
    while True:
        end = time.monotonic() + PERIOD
        while len(lines) < count and time.monotonic() < end:
            with contextlib.suppress(OSError):
                lines.append(Connection(address, sources[n % len(sources)], context, first=first))
                n += 1
        if time.monotonic() >= due:
            due += every
            words = again()
            for line in lines:
                line.send(words)
        for line in lines:
            line.drain()
        lines = [line for line in lines if line.is_open]
        time.sleep(max(0.0, min(due, end) - time.monotonic()))


def five(count):
    return ["127.0.0.1"] if count == 1 else [f"127.0.0.{i + 1}" for i in range(count)]

def idle(count, sources):
    return lambda address, _: crowd(address, count, five(sources), b"", lambda: b"", 1)

def pinging(count, sources):
    ping = frame(PING, 0, 0, b"12345678")
    return lambda address, _: crowd(address, count, five(sources), GREETING, lambda: ping, 2)

def one_stream(address, _):
    words = b"".join(frame(DATA, 0, 1, COMMAND) for _ in range(int(RATE * PERIOD / (9 + len(COMMAND)))))
    crowd(address, 110, five(1), GREETING + call(1, OURS + "Operate", ends=False), lambda: words, PERIOD)

def many_streams(address, _):
    """As one_stream, but each command opens a new stream."""
    streams = collections.Counter()

    def calls():
        streams["next"] += 2
        size, words, stream = 0, [], 1 + 2 * 400 * streams["next"]
        while size < RATE * PERIOD:
            words.append(call(stream, OURS + "Operate", COMMAND))
            size, stream = size + len(words[-1]), stream + 2
        return b"".join(words)
    crowd(address, 110, five(1), GREETING, calls, PERIOD)

def observers(address, certificates):
    context = ssl.create_default_context(cafile=certificates / "observer/ca.pem")
    context.load_cert_chain(certificates / "observer/cert.pem", certificates / "observer/key.pem")
    context.set_alpn_protocols(["h2"])

    wide = PREFACE + frame(SETTINGS, 0, 0, b"\0\4\x3f\xff\xff\xff") + frame(WINDOW_UPDATE, 0, 0, (2**30).to_bytes(4, "big"))
    crowd(address, 60, five(1), wide + call(1, OURS + "WatchState"), lambda: b"", 1, context)

LOADS = {
    **{f"{count} {name} from {sources}": make(count, sources) for count in (134, 512, 1100)
       for name, make in (("idle", idle), ("pinging", pinging)) for sources in (1, 5)},
    "110 x 220 kB/s, one Operate each": one_stream,
    "110 x 220 kB/s, Operate again and again": many_streams,
    "60 observers with certificates": observers,
}

class Periods:
    """Times between the solutions of successive samples, by WatchTrace."""

    def __init__(self, stub):
        self.times, self.trouble = [], ""
        request = messages.WatchTraceRequest(max_rate=10)
        self.call = stub.WatchTrace(request)
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        try:
            for update in self.call:
                for s in update.samples:
                    self.times.append(s.sensed_at.seconds + 1e-9 * s.sensed_at.nanos + s.solved)
        except grpc.RpcError as error:
            self.trouble = error.details()

    def p99(self, begin, end):
        """Returns the 99th percentile and the maximum of the periods between the samples number `begin` and `end`
        [s]."""
        times = self.times[begin:end]
        gaps = sorted(b - a for a, b in zip(times, times[1:]))
        return gaps[int(0.99 * (len(gaps) - 1))] if gaps else float("nan"), gaps[-1] if gaps else float("nan")

def connected(address, certificates):
    return palpate.connect(address, certificates and certificates / "admin")

def time_to_status(address, certificates, patience):
    """Returns the time until a new client has the status [s]; None: not within `patience`."""
    start = time.monotonic()
    if not certificates:
        host, port = address.split(":")
        return answers((host, int(port)), patience)
    with connected(address, certificates) as slave:
        try:
            slave.stub.GetStatus(messages.GetStatusRequest(), timeout=patience, wait_for_ready=True)
            return time.monotonic() - start
        except grpc.RpcError:
            return None

def measure_under_load(name, load, seconds, folder):
    certificates = folder if load is observers else None
    if certificates:
        make_certificates(folder, "operator", "observer", "admin")
    secure = ["--tls", certificates / "slave"] if certificates else []
    with Slave(BLOCK, *secure, tls=certificates) as slave:
        host, port = slave.address.split(":")
        log, report = folder / "log.csv", folder / "report.json"
        secure = ["--tls", certificates / "operator"] if certificates else []
        master = operate(slave.address, "--duration", "600", "--log", log, "--report", report, *secure)

        def states():
            return [row["state"] for row in whole_rows(log)]
        if not wait_until(lambda: "FOLLOWING" in states()[-50:]):
            raise AssertionError("nobody follows")
        watching = connected(slave.address, certificates)
        stub, periods = watching.stub, Periods(watching.stub)
        time.sleep(5)
        quiet, began = len(periods.times), len(states())
        loading = multiprocessing.Process(target=load, args=((host, int(port)), certificates), daemon=True)
        loading.start()
        end, answered = time.monotonic() + seconds, []
        while time.monotonic() < end:
            time.sleep(min(2, seconds / 4))
            answered.append(time_to_status(slave.address, certificates, PATIENCE))
        loaded = len(periods.times)
        held = times_held(states()[began:])
        stops = []
        for _ in range(100):
            start = time.monotonic()
            stub.Stop(messages.StopRequest(reason="test"), timeout=PATIENCE)
            stops.append(time.monotonic() - start)
            time.sleep(0.01)
        loading.kill()
        loading.join()
        time.sleep(3)
        alive = slave.process.poll() is None
        status = stub.GetStatus(messages.GetStatusRequest(), timeout=PATIENCE)
        resident = memory(slave.process.pid)
        watching.close()
        master.send_signal(signal.SIGINT)
        master.wait(timeout=PATIENCE)
        printed = read_json(report)
        (p_quiet, _), (p_load, gap) = periods.p99(0, quiet), periods.p99(quiet, loaded)
        return {"alive": alive, "memory": resident, "quiet": p_quiet, "load": p_load, "gap": gap,
                "answered": None if None in answered else max(answered), "stop": sorted(stops)[98], "held": held,
                "kept": printed["reconnects"] == 0, "trouble": periods.trouble, "alarms": list(status.alarms)}

def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--only", default="")
    a = parser.parse_args()
    wrong = []
    print(f"{'':40}  alive  MB after  period p99 ms: quiet  load  ratio  largest  newcomer s  stop p99 ms  holds  lease")
    for name, load in LOADS.items():
        if not re.search(a.only, name):
            continue
        with tempfile.TemporaryDirectory() as folder:
            saw = measure_under_load(name, load, a.seconds, pathlib.Path(folder))
        print(f"{name:40}  {saw['alive']!s:5}  {saw['memory']:8.0f}  {1e3 * saw['quiet']:20.1f}  {1e3 * saw['load']:4.1f}  "
              f"{saw['load'] / saw['quiet']:5.2f}  {1e3 * saw['gap']:7.1f}  {saw['answered'] or -1:10.3f}  {1e3 * saw['stop']:11.1f}  "
              f"{saw['held']:5d}  {'kept' if saw['kept'] else 'lost'} {saw['trouble']}", flush=True)
        wrong += [f"{name}: {words}" for words, is_so in [
            ("the slave ended", not saw["alive"]), ("a new client has no answer", saw["answered"] is None),
            ("the operator lost the lease", not saw["kept"])] if is_so]
    print("\n".join(wrong), file=sys.stderr)
    return 1 if wrong else 0

if __name__ == "__main__":
    sys.exit(main())
