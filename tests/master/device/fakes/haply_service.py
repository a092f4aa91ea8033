#!/usr/bin/env python3
"""A stand-in for the Haply inverse service: one Inverse3 with a wireless VerseGrip, over WebSocket and HTTP.

haply_service.py [--port N] [--events-port N] [--api 3.1|3.5|bare] [--control PATH]

Prints "listening on PORT EVENTS_PORT" when ready (0: any free port). The WebSocket at PORT sends the full inventory
first, and then one state for each message. A force counts in the form of the API's version only: {"values": {x, y, z}}
in 3.1, {"vector": {x, y, z}} in 3.5. The forces of all sessions add up, times force_scale and, in 3.5, the gain of the force gate.
`bare` is as public stand-ins of other projects are: no HTTP, no inventory, forces as in 3.1.
A session that sends nothing for `idle` seconds adds none. Each line to the socket at PATH gets one line back, as for
`fake_command` in fakes.h, and besides:
  event TYPE LEVEL    a safety event; ebrake_triggered locks the handle until ebrake_released
  sessions            how many are connected
  received            how many messages came
Options: mass [kg], viscosity [N s/m], dry [N], half [m] of the workspace, grip_stiffness [N/m], grip_damping [N s/m], idle [s], gain,
force_scale, max_force [N], calibrated, awake, battery. Buttons: 0 to 2 are a, b and c, 3 is home.
Frame: x right, y away from the user, z up; 0 is the middle of the workspace. freeze 1 repeats the state, freeze 2 answers nothing.
"""
import argparse
import asyncio
import base64
import bisect
import csv
import hashlib
import json
import math
import signal
import struct
import time

STEP = 0.001  # longest step of the handle's integration [s]
DEVICE, GRIP = "049D", "61576"
NAMES = ("a", "b", "c", "home")


def norm(a):
    return math.sqrt(sum(x * x for x in a))


class Handle:
    """A point mass with friction that an operator's hand may hold: as in fakes.h."""

    def __init__(self, options):
        self.options, self.p, self.v = options, [0.0] * 3, [0.0] * 3
        self.knots, self.since, self.repeat = [], 0.0, False

    def hand(self, now):
        """Where the operator's hand is, and its velocity; None: it holds nothing."""
        if not self.knots:
            return None
        t = now - self.since
        if self.repeat and self.knots[-1][0] > 0:
            t %= self.knots[-1][0]
        after = bisect.bisect_right(self.knots, t, key=lambda knot: knot[0])
        if after in (0, len(self.knots)):
            return self.knots[-1 if after else 0][1:], (0, 0, 0)
        start, end = self.knots[after - 1], self.knots[after]
        span = end[0] - start[0]
        s = (t - start[0]) / span
        part, rate = s ** 3 * (10 - 15 * s + 6 * s * s), 30 * s * s * (1 - s) ** 2 / span
        way = [b - a for a, b in zip(start[1:], end[1:])]
        return [a + part * w for a, w in zip(start[1:], way)], [rate * w for w in way]

    def step(self, now, h, force):
        o, viscosity, hand = self.options, self.options["viscosity"], self.hand(now)
        if hand and math.isinf(o["grip_stiffness"]):
            self.p, self.v = list(hand[0]), list(hand[1])
            return
        if hand:
            viscosity += o["grip_damping"]
            force = [f + o["grip_stiffness"] * (t - p) + o["grip_damping"] * r
                     for f, t, p, r in zip(force, hand[0], self.p, hand[1])]
        free = [v + h / o["mass"] * f for v, f in zip(self.v, force)]
        lost = h * o["dry"] / o["mass"]
        kept = (1 - lost / norm(free)) / (1 + h * viscosity / o["mass"]) if norm(free) > lost else 0
        for i in range(3):
            before, self.v[i] = self.v[i], kept * free[i]
            self.p[i] += h / 2 * (before + self.v[i])
            if abs(self.p[i]) > o["half"]:
                self.p[i], self.v[i] = math.copysign(o["half"], self.p[i]), 0.0


class Session:
    def __init__(self, number, now):
        self.number, self.force, self.heard, self.name, self.full = number, [0.0] * 3, now, "", True


class Service:
    def __init__(self, api):
        self.api = api
        self.watchers, self.ended = set(), 0
        self.reset()
        self.sessions = {}

    def reset(self):
        self.options = {"mass": 0.15, "viscosity": 0.5, "dry": 0.05, "half": 0.12, "grip_stiffness": 300.0, "grip_damping": 3.0,
                        "idle": 0.1, "gain": 0.3 if self.api == "3.5" else 1.0, "force_scale": 1.0, "max_force": 10.0,
                        "calibrated": 1.0, "awake": 1.0, "battery": 0.82}
        self.handle, self.turn, self.buttons, self.pressing = Handle(self.options), [0.0] * 3, set(), []
        self.injected, self.time, self.plugged, self.frozen, self.braked = None, time.monotonic(), True, 0, False
        self.shown, self.log, self.received = None, [], 0

    # Time and forces.
    def sync(self):
        until = time.monotonic() if self.injected is None else self.injected
        while self.time < until:
            h = min(STEP, until - self.time)
            if self.braked:
                self.handle.v = [0.0] * 3
            else:
                self.handle.step(self.time, h, self.made())
            self.time = until if until - self.time <= STEP else self.time + h
            for event in [event for event in self.pressing if event[0] <= self.time]:
                self.pressing.remove(event)
                (self.buttons.add if event[2] else self.buttons.discard)(event[1])

    def made(self):
        """What the motors make of the forces of all sessions that are not idle."""
        if self.braked or not self.plugged or not self.options["calibrated"]:
            return [0.0] * 3
        active = [s.force for s in self.sessions.values() if self.time - s.heard <= self.options["idle"]]
        total = [sum(f[i] for f in active) * self.options["force_scale"] * self.options["gain"] for i in range(3)]
        scale = min(1.0, self.options["max_force"] / norm(total)) if norm(total) > 0 else 1.0
        return [scale * f for f in total]

    # What is reported.
    def orientation(self):
        angle = norm(self.turn)
        part = math.sin(angle / 2) / angle if angle > 0 else 0
        return dict(zip("xyz", (part * a for a in self.turn)), w=math.cos(angle / 2))

    def state(self, full):
        self.sync()
        if self.frozen and self.shown and not full:
            return self.shown
        def vector(a):
            return dict(zip("xyz", a))
        made = self.made()
        idle = all(self.time - s.heard > self.options["idle"] or not any(s.force) for s in self.sessions.values())
        arm = {"device_id": DEVICE, "state": {
            "cursor_position": vector(self.handle.p), "cursor_velocity": vector(self.handle.v),
            "current_cursor_force": vector(made), "body_orientation": {"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0},
            "control_domain": "cartesian", "control_mode": "idle" if idle else "force"},
            "status": {"calibrated": bool(self.options["calibrated"]), "in_use": not idle, "power_supply": True,
                       "ready": bool(self.options["calibrated"]), "started": True}}
        grip = {"device_id": GRIP, "state": {
            "orientation": self.orientation(), "hall": 1, "battery_level": self.options["battery"],
            "buttons": {name: number in self.buttons for number, name in enumerate(NAMES)}},
            "status": {"connected": True, "ready": bool(self.options["awake"]), "awake": bool(self.options["awake"])}}
        if full:
            arm["config"] = {"type": "inverse3", "handedness": "right", "gravity_compensation": {"enabled": True, "scaling_factor": 1.0},
                             "torque_scaling": {"enabled": True}, "preset": "defaults", "basis": {"permutation": "XYZ"}}
            if self.api == "3.5":
                arm["config"]["filters"] = {"force_gate": {"gain": self.options["gain"]}, "damping": {"scalar": 0.0}}
            grip["config"] = {"type": "wireless_verse_grip"}
        arms = [arm] if self.plugged else []
        self.shown = {"inverse3": arms, "verse_grip": [], "wireless_verse_grip": [grip] if self.plugged else []}
        return self.shown

    def obey(self, session, text):
        """What one message changes. Devices and commands that it does not know are passed over."""
        message = json.loads(text)
        wish = message.get("session", {})
        session.full = session.full or "force_render_full_state" in wish
        session.name = wish.get("configure", {}).get("profile", {}).get("name", session.name)
        for device in message.get("inverse3", []):
            command = device.get("commands", {}).get("set_cursor_force", {})
            force = command.get("vector" if self.api == "3.5" else "values")
            if device.get("device_id") != DEVICE or not isinstance(force, dict) or self.frozen:
                continue
            session.force = [float(force.get(axis, 0)) for axis in "xyz"]
            self.log.append((self.time, session.number, *session.force))

    def http(self, path):
        if self.api == "bare":
            return None
        number = "3.1.1" if self.api == "3.1" else "3.5.0"
        if path == "/version":
            return {"project_name": "haply-inverse-service", "project_version": number + ".0", "git_tag": number,
                    "git_describe": number, "git_branch": "main"}
        if path in ("/devices", "/3.1/devices"):
            return self.state(True)
        if path == "/sessions":
            return {"sessions": [{"session_id": s.number, "profile": {"name": s.name}} for s in self.sessions.values()],
                    "force_scale": self.options["force_scale"]}
        return None

    # Events and control.
    async def tell(self, name, level, data, words):
        event = json.dumps({"name": name, "category": "device", "level": level, "data": data, "message": words})
        for writer in list(self.watchers):
            writer.write(frame(event))

    async def command(self, line):
        word, *rest = line.split()
        numbers = [float(a) for a in rest if a.replace(".", "").replace("-", "").replace("e", "").isdigit()]
        self.sync()
        if word == "set" and rest[0] in self.options:
            self.options[rest[0]] = float(rest[1])
        elif word == "place":
            self.handle.p, self.handle.v = numbers[:3], [0.0] * 3
        elif word == "turn":
            self.turn = numbers[:3]
        elif word == "follow":
            with open(rest[0], newline="", encoding="utf-8") as file:
                self.handle.knots = [tuple(map(float, row[:4])) for row in list(csv.reader(file))[1:]]
            self.handle.since, self.handle.repeat = self.time, rest[1:] == ["repeat"]
        elif word == "release":
            self.handle.knots = []
        elif word == "press":
            self.pressing.append((self.time + (numbers[2] if len(numbers) > 2 else 0), int(numbers[0]), numbers[1] != 0))
        elif word in ("unplug", "replug"):
            self.plugged = word == "replug"
            for session in self.sessions.values():
                session.force = [0.0] * 3
            await self.tell("device-connected" if self.plugged else "device-disconnected", "info" if self.plugged else "warning",
                            {"device_family": "inverse", "device_id": DEVICE}, "")
        elif word == "freeze":
            self.state(False)
            self.frozen = int(numbers[0])
        elif word == "event":
            self.braked = rest[0] == "ebrake_triggered" or self.braked and rest[0] != "ebrake_released"
            name = "device-busy" if rest[0] == "device-busy" else "device-safety-triggered"
            await self.tell(name, rest[1], {"device_family": "inverse", "device_id": DEVICE, "safety_type": rest[0]}, "")
        elif word == "clock":
            self.handle.since += numbers[0] - self.time
            self.pressing = [(event[0] + numbers[0] - self.time, *event[1:]) for event in self.pressing]
            for session in self.sessions.values():
                session.heard += numbers[0] - self.time
            self.injected = self.time = numbers[0]
        elif word == "step" and self.injected is not None:
            self.injected += numbers[0]
            self.sync()
        elif word == "reset":
            self.reset()
        elif word == "force":
            return " ".join(map(repr, self.made())) + f" {int(any(self.made()))}"
        elif word == "handle":
            return " ".join(map(repr, self.handle.p + self.handle.v))
        elif word == "sessions":
            return str(len(self.sessions))
        elif word == "received":
            return str(self.received)
        else:
            return "error: not understood: " + line
        return "ok"


def frame(text, opcode=1):
    data = text.encode() if isinstance(text, str) else text
    length = bytes([len(data)]) if len(data) < 126 else struct.pack(">BH", 126, len(data))
    return bytes([0x80 | opcode]) + length + data


async def read_frame(reader):
    """Opcode and payload of the next frame; clients mask theirs."""
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
    """Text messages until the client leaves."""
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
            service.received += 1
            if service.frozen == 2:
                continue
            service.sync()
            session.heard = service.time
            try:
                service.obey(session, text)
            except (ValueError, AttributeError, TypeError) as error:
                await service.tell("session-invalid-message", "error", {"session_id": session.number}, str(error))
            await send(session.full)
            session.full = False
    finally:
        service.sync()
        del service.sessions[session.number]


def connection(service, events):
    async def serve(reader, writer):
        try:
            path, headers = await read_request(reader)
            if headers.get("upgrade", "").lower() == "websocket":
                accept(writer, headers)
                if not events:
                    await operate(service, reader, writer)
                    return
                service.watchers.add(writer)
                async for _ in messages(reader, writer):
                    pass
            answer = None if events else service.http(path.split("?")[0])
            body = json.dumps(answer if answer is not None else {"ok": False, "error": "no such route"}).encode()
            writer.write(f"HTTP/1.1 {'200 OK' if answer is not None else '404 Not Found'}\r\nContent-Type: application/json\r\n"
                         f"Content-Length: {len(body)}\r\nConnection: close\r\n\r\n".encode() + body)
        except (asyncio.IncompleteReadError, ConnectionError, KeyError, IndexError):
            pass
        finally:
            service.watchers.discard(writer)
            writer.close()
    return serve


async def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--events-port", type=int, default=0)
    parser.add_argument("--api", choices=("3.1", "3.5", "bare"), default="3.5")
    parser.add_argument("--control")
    args = parser.parse_args()
    service = Service(args.api)

    async def control(reader, writer):
        while line := await reader.readline():
            try:
                reply = await service.command(line.decode().strip())
            except (ValueError, IndexError, OSError) as error:
                reply = f"error: {error}"
            writer.write((reply + "\n").encode())
            await writer.drain()
        writer.close()

    servers = [await asyncio.start_server(connection(service, events), "127.0.0.1", port)
               for events, port in ((False, args.port), (True, args.events_port))]
    if args.control:
        servers.append(await asyncio.start_unix_server(control, args.control))
    print("listening on", *(server.sockets[0].getsockname()[1] for server in servers[:2]), flush=True)
    stop = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, stop.set)
    await stop.wait()


if __name__ == "__main__":
    asyncio.run(main())
