#!/usr/bin/env python3
"""Tests of the stand-in for the Haply service. Time is injected; nothing here depends on the machine's speed."""
import base64
import json
import math
import os
import pathlib
import socket
import struct
import subprocess
import sys
import tempfile
import unittest
import urllib.request

HERE = pathlib.Path(__file__).resolve().parent


class Client:
    """A WebSocket client, or one of the control socket."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=20)
        self.file = self.socket.makefile("rb")
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall((f"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                             f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n").encode())
        assert b"101" in self.file.readline()
        while self.file.readline() != b"\r\n":
            pass

    def send(self, text, opcode=1):
        data, mask = text.encode(), os.urandom(4)
        size = bytes([0x80 | len(data)]) if len(data) < 126 else struct.pack(">BH", 0x80 | 126, len(data))
        self.socket.sendall(bytes([0x80 | opcode]) + size + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(data)))

    def receive(self):
        first, size = self.file.read(2)
        if size == 126:
            size = int.from_bytes(self.file.read(2), "big")
        data = self.file.read(size)
        return json.loads(data) if first & 0xF == 1 else data

    def ask(self, force=None, form="vector"):
        commands = {"probe_position": {}} if force is None else {"set_cursor_force": {form: dict(zip("xyz", force))}}
        self.send(json.dumps({"inverse3": [{"device_id": "049D", "commands": commands}]}))
        return self.receive()

    def close(self):
        self.file.close()
        self.socket.close()


class HaplyCase(unittest.TestCase):
    api = "3.5"

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        path = self.folder.name + "/control"
        self.service = subprocess.Popen([sys.executable, HERE / "haply_service.py", "--api", self.api, "--control", path],
                                        stdout=subprocess.PIPE, text=True)
        self.port, self.events_port = map(int, self.service.stdout.readline().split()[-2:])
        self.line = socket.socket(socket.AF_UNIX)
        self.line.connect(path)
        self.replies = self.line.makefile("r")
        self.opened = []
        self.control("clock 0")

    def tearDown(self):
        for client in self.opened:
            client.close()
        self.replies.close()
        self.line.close()
        self.service.terminate()
        self.assertEqual(self.service.wait(20), 0)
        self.service.stdout.close()
        self.folder.cleanup()

    def control(self, *lines):
        for line in lines:
            self.line.sendall((line + "\n").encode())
            reply = self.replies.readline().strip()
            self.assertFalse(reply.startswith("error"), reply)
        return reply

    def connect(self, port=None):
        self.opened.append(Client(port or self.port))
        return self.opened[-1]

    def operator(self):
        client = self.connect()
        client.receive()
        return client

    def http(self, path):
        with urllib.request.urlopen(f"http://127.0.0.1:{self.port}{path}", timeout=20) as answer:
            return json.load(answer)

    def made(self, state):
        return [state["inverse3"][0]["state"]["current_cursor_force"][axis] for axis in "xyz"]

    def place(self, state):
        return [state["inverse3"][0]["state"]["cursor_position"][axis] for axis in "xyz"]

    def check_forms(self, right, wrong):
        self.control("set gain 1")
        client = self.operator()
        self.assertEqual(self.made(client.ask((1, 0, 0), wrong)), [0, 0, 0])
        self.assertEqual(self.made(client.ask((1, 0, 0), right)), [1, 0, 0])
        self.assertTrue(self.http("/version")["project_version"].startswith(self.api))


class HaplyTest(HaplyCase):
    def test_the_first_message_has_all_and_each_message_gets_one_state(self):
        client = self.connect()
        first = client.receive()
        self.assertEqual(first["inverse3"][0]["config"]["filters"]["force_gate"]["gain"], 0.3)
        self.assertTrue(first["inverse3"][0]["status"]["calibrated"])
        self.assertNotIn("config", client.ask()["inverse3"][0])
        for _ in range(3):
            client.send("{}")
        for _ in range(3):
            client.receive()
        client.send('{"session": {"force_render_full_state": {}}}')
        self.assertIn("config", client.receive()["inverse3"][0])
        client.send("ping", 9)
        self.assertEqual(client.receive(), b"ping")
        self.assertEqual(self.control("received"), "5")

    def test_a_constant_force_moves_the_handle_as_its_mass_says(self):
        """Newton: x = f t^2 / 2 m, where f is what the gate lets through."""
        self.control("set dry 0", "set viscosity 0", "set mass 0.2", "set idle 10")
        client = self.operator()
        self.assertEqual(self.made(client.ask((2, 0, 0))), [2 * 0.3, 0, 0])
        self.control("step 0.1")
        x = self.place(client.ask())[0]
        self.assertAlmostEqual(x, 0.6 * 0.1 ** 2 / (2 * 0.2), places=9)

    def test_only_the_form_of_the_version_makes_a_force(self):
        self.check_forms("vector", "values")

    def test_the_device_is_idle_when_messages_stop(self):
        client = self.operator()
        client.ask((1, 0, 0))
        self.control("step 0.1")
        self.assertAlmostEqual(float(self.control("force").split()[0]), 0.3)
        self.control("step 0.01")
        self.assertEqual(self.control("force"), "0.0 0.0 0.0 0")

    def test_the_forces_of_sessions_add_up_and_are_limited(self):
        self.control("set gain 1", "set force_scale 0.5")
        first, second = self.operator(), self.operator()
        second.send('{"session": {"configure": {"profile": {"name": "other"}}}}')
        second.receive()
        first.ask((1, 0, 0))
        self.assertEqual(self.made(second.ask((1, 2, 0))), [1, 1, 0])
        names = [session["profile"]["name"] for session in self.http("/sessions")["sessions"]]
        self.assertEqual(names, ["", "other"])
        self.assertAlmostEqual(math.hypot(*self.made(second.ask((100, 0, 0)))), 10)
        second.send("", 8)
        second.receive()
        while self.control("sessions") != "1":
            pass
        self.assertEqual(self.made(first.ask()), [0.5, 0, 0])

    def test_the_grip_has_orientation_and_buttons(self):
        self.control(f"turn 0 0 {math.pi / 2}", "press 1 1 0.05", "set awake 0")
        client = self.operator()
        self.assertFalse(client.ask()["wireless_verse_grip"][0]["state"]["buttons"]["b"])
        self.control("step 0.06")
        grip = client.ask()["wireless_verse_grip"][0]
        self.assertTrue(grip["state"]["buttons"]["b"])
        self.assertAlmostEqual(grip["state"]["orientation"]["z"], math.sqrt(0.5))
        self.assertAlmostEqual(grip["state"]["orientation"]["w"], math.sqrt(0.5))
        self.assertFalse(grip["status"]["awake"])

    def test_safety_events_are_told_and_the_brake_locks_the_handle(self):
        events, client = self.connect(self.events_port), self.operator()
        self.control("set idle 10")
        client.ask((5, 0, 0))
        self.control("event ebrake_triggered error", "step 0.1")
        event = events.receive()
        self.assertEqual((event["name"], event["level"]), ("device-safety-triggered", "error"))
        self.assertEqual(event["data"]["safety_type"], "ebrake_triggered")
        state = client.ask()
        self.assertEqual((self.made(state), self.place(state)), ([0, 0, 0], [0, 0, 0]))
        self.control("event ebrake_released notice", "step 0.1")
        self.assertGreater(self.place(client.ask())[0], 0)

    def test_a_pulled_plug_empties_the_inventory(self):
        events, client = self.connect(self.events_port), self.operator()
        client.ask((1, 0, 0))
        self.control("unplug")
        self.assertEqual(client.ask((1, 0, 0))["inverse3"], [])
        self.assertEqual(events.receive()["name"], "device-disconnected")
        self.control("replug", "set calibrated 0")
        state = client.ask((1, 0, 0))
        self.assertEqual(self.made(state), [0, 0, 0])
        self.assertFalse(state["inverse3"][0]["status"]["calibrated"])

    def test_a_frozen_service_repeats_its_state_or_is_silent(self):
        client = self.operator()
        self.control("freeze 1", "place 0.01 0 0")
        self.assertEqual(self.place(client.ask()), [0, 0, 0])
        self.control("freeze 2")
        client.send("{}")
        while self.control("received") != "2":
            pass
        self.control("freeze 0")
        self.assertEqual(self.place(client.ask())[0], 0.01)

    def test_a_hand_follows_its_script_and_yields(self):
        """The grip is a spring of 300 N/m: a force of 0.3 N moves the handle 1 mm away from the hand."""
        way = pathlib.Path(self.folder.name) / "way.csv"
        way.write_text("time_s,x,y,z\n0,0,0,0\n0.5,0.02,0,0\n", encoding="utf-8")
        self.control("set gain 1", "set dry 0", "set idle 10", f"follow {way}")
        client = self.operator()
        client.ask((0, 0.3, 0))
        self.control("step 3")
        x, y, _ = self.place(client.ask())
        self.assertAlmostEqual(x, 0.02, places=6)
        self.assertAlmostEqual(y, 0.001, places=6)

    def test_what_is_not_understood_is_told_and_still_answered(self):
        events, client = self.connect(self.events_port), self.operator()
        for text in ("{", "[]", '{"inverse3": [{"device_id": "049D", "commands": {"set_cursor_force": {"vector": {"x": "a"}}}}]}'):
            client.send(text)
            self.assertEqual(self.made(client.receive()), [0, 0, 0])
            self.assertEqual(events.receive()["name"], "session-invalid-message")

    def test_devices_are_listed_over_http(self):
        self.assertEqual(self.http("/3.1/devices")["inverse3"][0]["device_id"], "049D")
        with self.assertRaises(urllib.error.HTTPError) as caught:
            self.http("/nonsense")
        caught.exception.close()


class OlderHaplyTest(HaplyCase):
    api = "3.1"

    def test_version_3_1_has_no_force_gate(self):
        self.assertNotIn("filters", self.connect().receive()["inverse3"][0]["config"])

    def test_only_the_form_of_the_version_makes_a_force(self):
        self.check_forms("values", "vector")


if __name__ == "__main__":
    unittest.main()
