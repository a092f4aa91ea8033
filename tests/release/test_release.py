#!/usr/bin/env python3
"""Clients and recordings of each release keep working: what keep.py kept of it, against the present programs and .proto files."""
import copy
import json
import lzma
import pathlib
import sys
import tempfile
import threading
import time
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "e2e"))
import grpc
from google.protobuf import descriptor_pool, message_factory
from programs import BLOCK, MASTER, Slave, run

import wire
from found import in_session, in_slave
from keep import write_descriptors

RELEASES = sorted(file.parent for file in HERE.glob("*/kept.json"))
SERVICE = "palpate.v1.Teleoperation"
PERIOD = 0.004  # [s] between commands


class OldClient:
    """Calls a slave with the messages and the service of kept descriptors, and nothing of the present ones."""

    def __init__(self, descriptors, address):
        self.pool = descriptor_pool.DescriptorPool()
        for file in descriptors.file:  # imports first
            self.pool.Add(file)
        self.methods = self.pool.FindServiceByName(SERVICE).methods_by_name
        self.channel = grpc.insecure_channel(address, options=[("grpc.enable_http_proxy", 0)])

    def message(self, name):
        return message_factory.MessageFactory(self.pool).GetPrototype(self.pool.FindMessageTypeByName(f"palpate.v1.{name}"))

    def call(self, name, request, kind="unary_unary"):
        answer = message_factory.MessageFactory(self.pool).GetPrototype(self.methods[name].output_type)
        method = getattr(self.channel, kind)(f"/{SERVICE}/{name}", request_serializer=lambda each: each.SerializeToString(),
                                             response_deserializer=answer.FromString)
        return method(request, timeout=30)

    def press(self, depth, stop):
        """Commands of a contact: down by `depth` [m] within 1.5 s, then held until `stop`."""
        start, sequence = time.monotonic(), 0
        while not stop.is_set():
            sequence += 1
            t = min(1, (time.monotonic() - start) / 1.5)
            command = self.message("OperatorCommand")(sequence=sequence, epoch=1, engaged=True)
            command.sent_at.GetCurrentTime()
            command.p_M.y = -depth * t
            yield command
            time.sleep(PERIOD)


class Release(unittest.TestCase):
    def test_there_is_a_release_to_keep(self):
        self.assertTrue(RELEASES)

    def test_no_field_value_or_call_was_changed_or_removed(self):
        with tempfile.TemporaryDirectory() as name:
            now = pathlib.Path(name, "now.binpb")
            write_descriptors(now)
            for folder in RELEASES:
                self.assertEqual(wire.breaks(wire.read(folder / "descriptors.binpb"), wire.read(now)), [])

    def test_a_change_or_removal_is_found(self):
        for folder in RELEASES:
            old = wire.read(folder / "descriptors.binpb")
            self.assertEqual(wire.breaks(old, old), [])
            number = next(i for i, file in enumerate(old.file) if file.name.endswith("/state.proto"))

            def changed(change):
                new = copy.deepcopy(old)
                change(new.file[number])
                return wire.breaks(old, new)

            def of_state(file):
                return next(each for each in file.message_type if each.name == "SlaveState")

            self.assertTrue(changed(lambda file: of_state(file).field.pop()))
            self.assertTrue(changed(lambda file: setattr(of_state(file).field[0], "number", 999)))
            self.assertTrue(changed(lambda file: setattr(of_state(file).field[0], "type", 1)))
            self.assertTrue(changed(lambda file: setattr(of_state(file).field[0], "label", 3)))
            self.assertTrue(changed(lambda file: setattr(of_state(file).field[0], "name", "other")))
            self.assertTrue(changed(lambda file: file.enum_type[0].value.pop()))
            self.assertTrue(changed(lambda file: file.message_type.remove(of_state(file))))
            self.assertEqual(changed(lambda file: of_state(file).field.add(name="new", number=999, type=1, label=1)), [])

    def test_a_client_operates_the_present_slave(self):
        for folder in RELEASES:
            with Slave(BLOCK) as slave:
                client = OldClient(wire.read(folder / "descriptors.binpb"), slave.address)
                scene = client.call("GetScene", client.message("GetSceneRequest")())
                self.assertEqual(scene.name, "silicone-block")
                self.assertTrue(client.call("GetStatus", client.message("GetStatusRequest")()).HasField("started_at"))
                stop, peak, last = threading.Event(), 0, 0
                # 6 mm to the surface and 3 mm into it, as deploy/examples/operate.py.
                commands = client.press(9e-3 / scene.operator.position_scale, stop)
                states = client.call("Operate", commands, "stream_stream")
                end = time.monotonic() + 4
                for state in states:
                    self.assertGreater(state.sequence, last)
                    last = state.sequence
                    if state.validity == 1:  # VALIDITY_VALID
                        peak = max(peak, state.force.y)
                    if time.monotonic() > end:
                        break
                stop.set()
                states.cancel()
                watched = client.call("WatchState", client.message("WatchStateRequest")(), "unary_stream")
                self.assertGreater(next(watched).sequence, last)
                watched.cancel()
                client.channel.close()
            # 3 mm of 5 mm, which take 2.37 N; see tests/e2e/test_session.py.
            self.assertGreater(peak, 0.8)
            self.assertLess(peak, 2.0)

    def test_recordings_are_processed_replayed_and_exported(self):
        for folder in RELEASES:
            kept = json.loads((folder / "kept.json").read_text())
            with tempfile.TemporaryDirectory() as name:
                files = {}
                for what in ("slave", "session"):
                    files[what] = pathlib.Path(name, f"{what}.mcap")
                    files[what].write_bytes(lzma.decompress((folder / f"{what}.mcap.xz").read_bytes()))
                now, then = in_slave(files["slave"]), kept["slave"]
                self.assertEqual((now["states"], now["with_force"]), (then["states"], then["with_force"]))
                # Computed again: a later release may estimate better, by what the old one said that it did not know.
                self.assertLess(abs(now["peak_N"] - then["peak_N"]), then["sigma_N"])
                # Not computed, but read.
                self.assertEqual(in_session(files["session"]), kept["session"])
                self.assertEqual(run(MASTER, "replay", files["session"], "--speed", "4").returncode, 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
