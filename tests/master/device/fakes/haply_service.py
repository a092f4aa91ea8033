#!/usr/bin/env python3
"""A stand-in for the Haply inverse service: one Inverse3 with a wireless VerseGrip, over WebSocket and HTTP.

haply_service.py [--port N] [--api 3.1|3.5|bare] [--control PATH]

Prints "listening on PORT" when ready (0: any free port). The WebSocket at PORT sends the full inventory first, and then
one state for each message. A force counts in the form of the API's version only: {"values": {x, y, z}} in 3.1,
{"vector": {x, y, z}} in 3.5. The forces of all sessions add up, in 3.5 times the gain of the force gate.
`bare` behaves like public stand-ins of other projects: no HTTP, no inventory, forces as in 3.1. A session that is
silent for `idle` seconds adds no force.

Each line to the socket at PATH gets one line back:
  set NAME VALUE | place X Y Z | follow FILE.csv | press BUTTON DOWN [AFTER] | unplug | replug | clock NOW | step SECONDS | force
Options: idle [s], gain, max_force [N], calibrated. Buttons: 0 to 2 are a, b and c, 3 is home.
Frame: x right, y away from the user, z up; 0 is the middle of the workspace. The handle follows the script of the
operator's hand, or rests without one.
"""
import argparse
import asyncio
import base64
import bisect
import contextlib
import csv
import hashlib
import json
import math
import signal
import struct
import time

DEVICE, GRIP = "049D", "61576"
NAMES = ("a", "b", "c", "home")


def norm(a):
    return math.sqrt(sum(x * x for x in a))


class Handle:
    def __init__(self):
        self.p, self.v, self.knots, self.since = [0.0] * 3, [0.0] * 3, [], 0.0

    def move_to(self, now):
        """Interpolates between the knots with minimum jerk."""
        self.v = [0.0] * 3
        if not self.knots:
            return
        t = now - self.since
        after = bisect.bisect_right(self.knots, t, key=lambda knot: knot[0])
        if after in (0, len(self.knots)):
            self.p = list(self.knots[-1 if after else 0][1:])
            return
        start, end = self.knots[after - 1], self.knots[after]
        span = end[0] - start[0]
        s = (t - start[0]) / span
        part, rate = s ** 3 * (10 - 15 * s + 6 * s * s), 30 * s * s * (1 - s) ** 2 / span
        way = [b - a for a, b in zip(start[1:], end[1:])]
        self.p, self.v = [a + part * w for a, w in zip(start[1:], way)], [rate * w for w in way]


class Session:
    def __init__(self, number, now):
        self.number, self.force, self.heard, self.full = number, [0.0] * 3, now, True


class Service:
    def __init__(self, api):
        self.api, self.ended, self.sessions = api, 0, {}
        self.options = {"idle": 0.1, "gain": 0.3 if api == "3.5" else 1.0, "max_force": 10.0, "calibrated": 1.0}
        self.handle, self.buttons, self.pressing = Handle(), set(), []
        self.injected, self.time, self.plugged = None, time.monotonic(), True

    def sync(self):
        self.time = time.monotonic() if self.injected is None else self.injected
        self.handle.move_to(self.time)
        for event in [event for event in self.pressing if event[0] <= self.time]:
            self.pressing.remove(event)
            (self.buttons.add if event[2] else self.buttons.discard)(event[1])

    def made(self):
        """Returns the force of the motors: the sum over all sessions that are not idle."""
        if not self.plugged or not self.options["calibrated"]:
            return [0.0] * 3
        active = [s.force for s in self.sessions.values() if self.time - s.heard <= self.options["idle"]]
        total = [sum(f[i] for f in active) * self.options["gain"] for i in range(3)]
        scale = min(1.0, self.options["max_force"] / norm(total)) if norm(total) > 0 else 1.0
        return [scale * f for f in total]

    def state(self, full):
        self.sync()

        def vector(a):
            return dict(zip("xyz", a))
        idle = all(self.time - s.heard > self.options["idle"] or not any(s.force) for s in self.sessions.values())
        ready = bool(self.options["calibrated"])
        arm = {"device_id": DEVICE, "state": {
            "cursor_position": vector(self.handle.p), "cursor_velocity": vector(self.handle.v),
            "current_cursor_force": vector(self.made()), "body_orientation": {"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0},
            "control_domain": "cartesian", "control_mode": "idle" if idle else "force"},
            "status": {"calibrated": ready, "in_use": not idle, "power_supply": True, "ready": ready, "started": True}}
        grip = {"device_id": GRIP, "state": {
            "orientation": {"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0}, "hall": 1, "battery_level": 0.82,
            "buttons": {name: number in self.buttons for number, name in enumerate(NAMES)}},
            "status": {"connected": True, "ready": True, "awake": True}}
        if full:
            arm["config"] = {"type": "inverse3", "handedness": "right", "preset": "defaults", "basis": {"permutation": "XYZ"}}
            if self.api == "3.5":
                arm["config"]["filters"] = {"force_gate": {"gain": self.options["gain"]}, "damping": {"scalar": 0.0}}
            grip["config"] = {"type": "wireless_verse_grip"}
        return {"inverse3": [arm] if self.plugged else [], "verse_grip": [], "wireless_verse_grip": [grip] if self.plugged else []}

    def obey(self, session, text):
        """Executes one message. Unknown devices and commands are ignored."""
        message = json.loads(text)
        session.full = session.full or "force_render_full_state" in message.get("session", {})
        for device in message.get("inverse3", []):
            command = device.get("commands", {}).get("set_cursor_force", {})
            force = command.get("vector" if self.api == "3.5" else "values")
            if device.get("device_id") == DEVICE and isinstance(force, dict):
                session.force = [float(force.get(axis, 0)) for axis in "xyz"]

    def http(self, path):
        if self.api == "bare":
            return None
        number = "3.1.1" if self.api == "3.1" else "3.5.0"
        if path == "/version":
            return {"project_name": "haply-inverse-service", "project_version": number + ".0", "git_tag": number}
        if path == "/sessions":
            return {"sessions": [{"session_id": s.number} for s in self.sessions.values()], "force_scale": 1.0}
        return None

    def command(self, line):
        word, *rest = line.split()
        self.sync()
        if word == "set" and rest[0] in self.options:
            self.options[rest[0]] = float(rest[1])
        elif word == "place":
            self.handle.p = [float(a) for a in rest[:3]]
        elif word == "follow":
            with open(rest[0], newline="", encoding="utf-8") as file:
                self.handle.knots = [tuple(map(float, row[:4])) for row in list(csv.reader(file))[1:]]
            self.handle.since = self.time
        elif word == "press":
            self.pressing.append((self.time + float(rest[2] if len(rest) > 2 else 0), int(rest[0]), rest[1] != "0"))
        elif word in ("unplug", "replug"):
            self.plugged = word == "replug"
            for session in self.sessions.values():
                session.force = [0.0] * 3
        elif word == "clock":
            now = float(rest[0])
            self.handle.since += now - self.time
            for session in self.sessions.values():
                session.heard += now - self.time
            self.injected = self.time = now
        elif word == "step" and self.injected is not None:
            self.injected += float(rest[0])
            self.sync()
        elif word == "force":
            return " ".join(map(repr, self.made()))
        else:
            return "error: not understood: " + line
        return "ok"


def frame(text, opcode=1):
    data = text.encode() if isinstance(text, str) else text
    length = bytes([len(data)]) if len(data) < 126 else struct.pack(">BH", 126, len(data))
    return bytes([0x80 | opcode]) + length + data


async def read_frame(reader):
    """Reads opcode and payload of the next frame. Clients mask their payload."""
    first, second = await reader.readexactly(2)
    length = second & 0x7F
    if length > 125:
        length = int.from_bytes(await reader.readexactly(2 if length == 126 else 8), "big")
    mask = await reader.readexactly(4) if second & 0x80 else bytes(4)
    data = await reader.readexactly(length)
    return first & 0xF, bytes(b ^ mask[i % 4] for i, b in enumerate(data))


async def read_request(reader):
    head = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1").split("\r\n")
    return head[0].split()[1], {key.lower(): value.strip() for key, _, value in (line.partition(":") for line in head[1:])}


def accept(writer, headers):
    key = headers["sec-websocket-key"] + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
    answer = base64.b64encode(hashlib.sha1(key.encode()).digest()).decode()
    writer.write(("HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                  f"Sec-WebSocket-Accept: {answer}\r\n\r\n").encode())


async def messages(reader, writer):
    """Yields text messages until the client disconnects."""
    while True:
        opcode, data = await read_frame(reader)
        if opcode == 8:
            writer.write(frame(data, 8))
            return
        if opcode == 9:
            writer.write(frame(data, 10))
        elif opcode in (1, 2):
            yield data


async def operate(service, reader, writer):
    service.ended += 1
    session = service.sessions[service.ended] = Session(service.ended, service.time)
    try:
        async def send(full):
            writer.write(frame(json.dumps({"session_id": session.number} | service.state(full))))
            await writer.drain()
        if service.api != "bare":
            await send(True)
            session.full = False
        async for text in messages(reader, writer):
            service.sync()
            session.heard = service.time
            with contextlib.suppress(ValueError, AttributeError, TypeError):
                service.obey(session, text)
            await send(session.full)
            session.full = False
    finally:
        del service.sessions[session.number]


def connection(service):
    async def serve(reader, writer):
        try:
            path, headers = await read_request(reader)
            if headers.get("upgrade", "").lower() == "websocket":
                accept(writer, headers)
                await operate(service, reader, writer)
                return
            answer = service.http(path.split("?")[0])
            body = json.dumps(answer if answer is not None else {"ok": False, "error": "no such route"}).encode()
            writer.write(f"HTTP/1.1 {'200 OK' if answer is not None else '404 Not Found'}\r\nContent-Type: application/json\r\n"
                         f"Content-Length: {len(body)}\r\nConnection: close\r\n\r\n".encode() + body)
        except (asyncio.IncompleteReadError, ConnectionError, KeyError, IndexError):
            pass
        finally:
            writer.close()
    return serve


async def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--api", choices=("3.1", "3.5", "bare"), default="3.5")
    parser.add_argument("--control")
    args = parser.parse_args()
    service = Service(args.api)

    async def control(reader, writer):
        while line := await reader.readline():
            try:
                reply = service.command(line.decode().strip())
            except (ValueError, IndexError, OSError) as error:
                reply = f"error: {error}"
            writer.write((reply + "\n").encode())
            await writer.drain()
        writer.close()

    server = await asyncio.start_server(connection(service), "127.0.0.1", args.port)
    controlled = await asyncio.start_unix_server(control, args.control) if args.control else None
    print("listening on", server.sockets[0].getsockname()[1], flush=True)
    stop = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, stop.set)
    await stop.wait()


if __name__ == "__main__":
    asyncio.run(main())
