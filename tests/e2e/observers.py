"""A NATS server and observers that subscribe to it, for tests and benchmarks."""
import json
import multiprocessing
import os
import selectors
import shutil
import signal
import socket
import subprocess
import sys
import time

from programs import PATIENCE, ROOT, free_port, wait_until

NATS = shutil.which("nats-server", path="/usr/sbin:/usr/bin:/usr/local/bin")
CONFIGURATION = ROOT / "deploy/nats-server.conf"
NICE = ["nice", "-n", "5"]  # in real use server and observers run on other machines


def require_server():
    """Skips the test if `nats-server` is not installed."""
    if not NATS:
        print("skipped: there is no nats-server (deploy/install.sh tests)")
        sys.exit(77)


class Server:
    """`nats-server` on a free port with the shipped configuration, or with the arguments `words`."""

    def __init__(self, *words):
        self.port, self.words = free_port(), words or ("-c", CONFIGURATION)
        self.url = f"nats://127.0.0.1:{self.port}"
        self.process = None

    def start(self):
        self.process = subprocess.Popen([*NICE, NATS, *self.words, "-a", "127.0.0.1", "-p", str(self.port)],
                                        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        if not wait_until(self.answers):
            raise AssertionError("the NATS server does not answer")
        return self

    def answers(self):
        try:
            connect(self.port).close()
            return True
        except OSError:
            return False

    def kill(self):
        self.process.kill()
        self.process.wait()

    def stall(self):
        self.process.send_signal(signal.SIGSTOP)

    def go_on(self):
        self.process.send_signal(signal.SIGCONT)

    __enter__ = start

    def __exit__(self, *error):
        self.kill()


def connect(port, *subjects, name="observer", login=None, context=None):
    """Returns the socket of a NATS client that has subscribed to `subjects`; `login` has user and password, and `context`
    is that of TLS."""
    line = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
    if not line.recv(1 << 16).startswith(b"INFO "):
        raise ConnectionError("the NATS server closed the connection")
    if context:
        line = context.wrap_socket(line, server_hostname="127.0.0.1")
    words = "".join(f"SUB {subject} {i}\r\n" for i, subject in enumerate(subjects))
    line.sendall(f'CONNECT {json.dumps({"verbose": False, "pedantic": False, "name": name, **(login or {})})}\r\n{words}'.encode())
    return line


def next_message(line, words=b""):
    """Returns (subject, payload) of the next message on a connection."""
    while True:
        head, end, rest = words.partition(b"\r\n")
        if not end:
            words += line.recv(1 << 16)
        elif not head.startswith(b"MSG "):
            words = rest
        elif len(rest) < int(head.split()[-1]):
            words += line.recv(1 << 16)
        else:
            return head.split()[1].decode(), rest[:int(head.split()[-1])]


def observe(port, subject, counts):
    """Keeps one connection per entry of `counts` and counts its messages there. Reconnects when one is closed."""
    ready, head = selectors.DefaultSelector(), b"MSG " + subject.encode() + b" "
    missing = set(range(len(counts)))
    while True:
        for number in list(missing):
            try:
                line = connect(port, subject, name=f"observer {number}")
            except OSError:
                time.sleep(0.1)
                break
            line.setblocking(False)
            ready.register(line, selectors.EVENT_READ, number)
            missing.discard(number)
        for key, _ in ready.select(0.05):
            try:
                data = key.fileobj.recv(1 << 16)
                if b"PING\r\n" in data:
                    key.fileobj.sendall(b"PONG\r\n")
            except BlockingIOError:
                continue
            except OSError:
                data = b""
            counts[key.data] += data.count(head)
            if not data:
                ready.unregister(key.fileobj)
                key.fileobj.close()
                missing.add(key.data)
        time.sleep(0.02)  # so that several messages are read at a time


class Crowd:
    """Observers of one subject, in a separate process."""

    def __init__(self, server, subject, number):
        self.counts = multiprocessing.Array("Q", number, lock=False)
        self.process = multiprocessing.Process(target=self.run, args=(server.port, subject), daemon=True)

    def run(self, port, subject):
        os.nice(5)
        observe(port, subject, self.counts)

    def all_read(self):
        """Waits until each observer has read another message. Returns the time that it took [s]."""
        begun, before = time.monotonic(), list(self.counts)
        if not wait_until(lambda: all(now > then for now, then in zip(self.counts, before))):
            raise AssertionError(f"{sum(now == then for now, then in zip(self.counts, before))} observers read nothing")
        return time.monotonic() - begun

    def __enter__(self):
        self.process.start()
        return self

    def __exit__(self, *error):
        self.process.kill()
        self.process.join()
