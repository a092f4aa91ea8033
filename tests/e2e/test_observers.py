"""Observers behind a NATS server: the example; each kind of message; a server that dies, stalls or is absent; clients that
do not read.
"""
import contextlib
import signal
import ssl
import sys
import unittest

from observers import CONFIGURATION, Crowd, Server, connect, next_message, require_server
from programs import BARE, BLOCK, MASTER, PACKAGE, PATIENCE, ROOT, FolderTest, Slave, make_certificates, operate, run, wait_until
from test_crowd import session

sys.path.insert(0, str(PACKAGE))
from palpate.v1 import state_pb2, telemetry_pb2

OBSERVERS, SLAVES = 200, 3
TRIES = 5
STATES = "palpate.silicone-block.state"
FLOOD = b"PUB palpate.flood.state 65536\r\n" + bytes(65536) + b"\r\n"
EXAMPLE = ROOT / "deploy/examples/watch_nats.py"


def publishing(server, *more, **how):
    return Slave(BLOCK, "--publish", server.url, *more, **how)


def flood_until(server, condition):
    """Publishes as fast as a reader can read, until `condition()` is true. A client that does not read soon falls
    behind."""
    with connect(server.port) as line:
        def goes_on():
            for _ in range(20):
                line.sendall(FLOOD)
            return condition()
        return wait_until(goes_on)


class Observers(FolderTest):
    def test_the_example_shows_many_slaves(self):
        def shown():
            done = run("/usr/bin/python3", EXAMPLE, f"127.0.0.1:{server.port}", "--seconds", "1", env={**BARE, "PYTHONPATH": str(PACKAGE)})
            self.assertEqual(done.returncode, 0, done.stderr)
            return done.stdout

        names = {f"block-{i}" for i in range(SLAVES)}
        with Server() as server, contextlib.ExitStack() as slaves:
            for name in names:
                slaves.enter_context(publishing(server, "--override", f"name={name}", "--override", "sense.camera.rate=5Hz"))
            # A slave without a manipulator publishes as well.
            slaves.enter_context(Slave(ROOT / "deploy/scenes/foam-cube.yaml", "--publish", server.url, "--override", "manipulator=none",
                                       simulates=False))
            self.assertTrue(wait_until(lambda: shown().count(" 0.0000 N, VALID") == SLAVES), shown())
            self.assertEqual({line.split(":")[0] for line in shown().splitlines()}, names | {"foam-cube"})
            self.assertNotIn("foam-cube: 0 states", shown())

    def test_an_observer_sees_the_force_of_a_contact(self):
        with Server() as server, publishing(server) as slave, connect(server.port, STATES) as line:
            def newest():
                return state_pb2.SlaveState.FromString(next_message(line)[1])

            self.assertTrue(wait_until(lambda: newest().validity == state_pb2.VALIDITY_VALID), "states arrive before the contact")
            master = operate(slave.address)
            self.addCleanup(master.kill)
            # A busy machine may hold the tool: the operator engages again.
            self.assertTrue(wait_until(lambda: (state := newest()).phase == state_pb2.PHASE_FOLLOWING and abs(state.force.y) > 0.1))
            master.send_signal(signal.SIGINT)
            self.assertEqual(master.wait(timeout=PATIENCE), 0)

    def test_each_kind_is_a_message_of_the_protocol(self):
        with Server() as server, publishing(server):
            def message(kind, parsed):
                with connect(server.port, f"palpate.silicone-block.{kind}") as line:
                    parsed.ParseFromString(next_message(line)[1])
                return parsed

            # The first messages may precede the first image.
            self.assertTrue(wait_until(lambda: message("state", state_pb2.SlaveState()).validity == state_pb2.VALIDITY_VALID))
            self.assertTrue(wait_until(lambda: message("status", telemetry_pb2.Status()).samples > 0))
            mesh = message("mesh", state_pb2.MeshState())  # a late subscriber also gets the topology
            self.assertEqual((len(mesh.elements) // mesh.nodes_per_element, len(mesh.positions)), (180, len(mesh.rest)))
            self.assertTrue(message("image", state_pb2.ImageState()).jpeg.startswith(b"\xff\xd8"))

    def test_a_password_and_tls_are_used_and_a_wrong_one_is_reported(self):
        make_certificates(self.out)
        files = self.out / "slave"
        server = Server("--user", "ada", "--pass", "secret", "--tls", "--tlscert", files / "cert.pem", "--tlskey", files / "key.pem",
                        "--tlscacert", files / "ca.pem")
        url = server.url.replace("nats://", "tls://ada:secret@")

        def publisher(at):
            return Slave(BLOCK, "--publish", at, "--tls", files, tls=self.out)

        login = {"user": "ada", "pass": "secret"}
        context = ssl.create_default_context(cafile=files / "ca.pem")
        with server, publisher(url) as slave:
            with connect(server.port, STATES, login=login, context=context) as line:
                self.assertEqual(next_message(line)[0], STATES)
            for wrong_url, why in ((url.replace("secret", "guess"), "Authorization Violation"),
                                   (url.replace("127.0.0.1", "localhost"), "hostname mismatch")):
                with publisher(wrong_url) as refused:
                    log = next((line for line in refused.process.stderr if "no connection to the NATS server" in line), "")
                    self.assertIn(why, log)
                    refused.stop()
                    self.assertNotRegex(log + refused.log, "guess|secret")
            self.assertEqual(slave.stop(), 0)
            self.assertNotIn("secret", slave.log)

    def test_observers_return_after_the_server_was_killed_and_started_again(self):
        server = Server()
        with server, publishing(server) as slave, Crowd(server, STATES, OBSERVERS) as crowd:
            crowd.all_read()
            server.kill()
            server.start()
            print(f"{OBSERVERS} observers read again {crowd.all_read():.2f} s after the restart")
            self.assertEqual(slave.stop(), 0)
            self.assertGreaterEqual(slave.log.count("connected to the NATS server"), 2, slave.log)

    def test_an_observer_that_does_not_read_is_cut_off_and_others_go_on(self):
        log = self.out / "nats.log"
        log.touch()
        with Server("-c", CONFIGURATION, "-l", log) as server, publishing(server) as slave, Crowd(server, STATES, 1) as crowd, \
                connect(server.port, "palpate.>", name="sloth"):
            crowd.all_read()
            self.assertTrue(flood_until(server, lambda: '"sloth" - Slow Consumer Detected' in log.read_text()), log.read_text())
            crowd.all_read()
            self.assertEqual(slave.stop(), 0)
            self.assertEqual(slave.log.count("connected to the NATS server"), 1, slave.log)

    def test_what_is_too_large_for_the_server_is_not_published_and_reported(self):
        small = self.out / "small.conf"
        small.write_text("max_payload: 4KB\n")
        with Server("-c", small) as server, publishing(server) as slave, Crowd(server, STATES, 1) as crowd:
            for _ in range(30):
                crowd.all_read()
            self.assertEqual(slave.stop(), 0)
        self.assertIn("palpate.silicone-block.image is not published", slave.log)

    def test_an_absent_or_stalled_server_stops_nothing(self):
        server = Server()
        with publishing(server) as slave:
            run(MASTER, "connect", slave.address, "--duration", "1").check_returncode()
            with server, Crowd(server, STATES, 1) as crowd:
                crowd.all_read()
                server.stall()
                # A busy machine may hold an operator once; a slave that waits for the server would hold it every time.
                self.assertTrue(any(session(slave, 4, self.out)[1] == 0 for _ in range(TRIES)))
                server.go_on()
                crowd.all_read()
                server.stall()
                self.assertEqual(slave.stop(), 0)
                server.go_on()
            self.assertIn("no connection to the NATS server", slave.log)


if __name__ == "__main__":
    require_server()
    unittest.main(verbosity=2)
