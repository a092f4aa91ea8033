"""Observers behind a NATS server: the table of a fleet; a server that dies, stalls or is absent; clients that do not
read.
"""
import contextlib
import signal
import sys
import unittest

from observers import Crowd, Server, Watch, connect, next_message, require_server
from programs import BLOCK, MASTER, PACKAGE, PATIENCE, ROOT, FolderTest, Slave, make_certificates, operate, run, wait_until
from test_crowd import session

sys.path.insert(0, str(PACKAGE))
from palpate.v1 import state_pb2, telemetry_pb2

OBSERVERS, FLEET = 200, 3
TRIES = 5
STATES = "palpate.silicone-block.state"
FLOOD = b"PUB palpate.flood.state 65536\r\n" + bytes(65536) + b"\r\n"


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
    def test_one_watch_shows_many_slaves(self):
        names = {f"block-{i}" for i in range(FLEET)}
        with Server() as server, Watch(server, self.out) as watch, contextlib.ExitStack() as slaves:
            for name in sorted(names):
                slaves.enter_context(publishing(server, "--override", f"name={name}", "--override", "sense.camera.rate=5Hz"))
            valid = {}
            self.assertTrue(wait_until(lambda: valid.update({name: line for name, line in watch.newest().items()
                                                             if line["validity"] == "valid" and not line["alarms"]}) or names <= valid.keys()),
                            f"seen: {watch.newest()}")
            # A slave without a manipulator is listed as well.
            slaves.enter_context(Slave(ROOT / "deploy/scenes/foam-cube.yaml", "--publish", server.url, "--override", "manipulator=none",
                                       simulates=False))
            self.assertTrue(wait_until(lambda: watch.newest().get("foam-cube", {}).get("phase") == "observing"), watch.news.read_text())
            self.assertTrue(wait_until(lambda: names <= watch.newest().keys()))
        for line in valid.values():
            self.assertEqual(line["force_N"], 0)  # without contact
            self.assertEqual(line["phase"], "ready")
            self.assertGreaterEqual(line["age_s"], 0)

    def test_a_watch_shows_the_force_of_a_contact_and_a_slave_that_is_gone(self):
        with Server() as server, Watch(server, self.out) as watch:
            with publishing(server) as slave:
                self.assertTrue(wait_until(watch.newest), "the slave is seen before it is touched")
                master = operate(slave.address)
                self.addCleanup(master.kill)
                # A busy machine may hold the tool: the operator engages again.
                self.assertTrue(wait_until(lambda: any(line["force_N"] and line["phase"] == "following" for line in watch.seen())))
                master.send_signal(signal.SIGINT)
                self.assertEqual(master.wait(timeout=PATIENCE), 0)
            self.assertTrue(wait_until(lambda: watch.newest()["silicone-block"]["validity"] == "silent"))
            self.assertIsNone(watch.newest()["silicone-block"]["force_N"])
            table = run(MASTER, "watch", server.url, "--duration", "0.5")
            self.assertEqual((table.returncode, table.stdout.split()[:2]), (0, ["slave", "force"]))

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
        make_certificates(self.out, "observer")
        files = self.out / "slave"
        server = Server("--user", "ada", "--pass", "secret", "--tls", "--tlscert", files / "cert.pem", "--tlskey", files / "key.pem",
                        "--tlscacert", files / "ca.pem")
        server.url = server.url.replace("nats://", "tls://ada:secret@")
        with server, publishing(server, "--tls", files, tls=self.out) as slave, Watch(server, self.out, "watch", "--tls", self.out / "observer") as watch:
            self.assertTrue(wait_until(watch.newest), watch.news.read_text())
            for url, wrong in ((server.url.replace("secret", "guess"), "Authorization Violation"),
                               (server.url.replace("127.0.0.1", "localhost"), "hostname mismatch")):
                done = run(MASTER, "watch", url, "--tls", self.out / "observer", "--duration", "1")
                self.assertEqual(done.returncode, 1)
                self.assertIn(wrong, done.stderr)
                self.assertNotIn("guess", done.stderr)
            self.assertEqual(slave.stop(), 0)
            self.assertNotIn("secret", slave.log + watch.news.read_text())

    def test_observers_return_after_the_server_was_killed_and_started_again(self):
        server = Server()
        with server, publishing(server) as slave, Crowd(server, STATES, OBSERVERS) as crowd, Watch(server, self.out) as watch:
            crowd.all_read()
            self.assertTrue(wait_until(watch.newest))
            server.kill()
            count = len(watch.seen())
            self.assertTrue(wait_until(lambda: watch.newest()["silicone-block"]["validity"] == "silent"))
            server.start()
            print(f"{OBSERVERS} observers read again {crowd.all_read():.2f} s after the restart")
            self.assertTrue(wait_until(lambda: any(line["validity"] == "valid" for line in watch.seen()[count + 1:])))
            self.assertEqual(slave.stop(), 0)
            self.assertGreaterEqual(slave.log.count("connected to the NATS server"), 2, slave.log)

    def test_a_consumer_that_does_not_read_is_cut_off_and_reported(self):
        with Server() as server, publishing(server) as slave, Watch(server, self.out) as reader, \
                Watch(server, self.out, "stopped") as stopped, connect(server.port, "palpate.>", name="sloth"):
            self.assertTrue(wait_until(lambda: reader.newest() and stopped.newest()))
            stopped.process.send_signal(signal.SIGSTOP)
            try:
                cut = ["the NATS server cut off sloth", "the NATS server cut off palpate-master watch"]
                self.assertTrue(flood_until(server, lambda: all(words in reader.news.read_text() for words in cut)),
                                reader.news.read_text())
            finally:
                stopped.process.send_signal(signal.SIGCONT)
            # The stopped client reports the loss, reconnects and continues. Other clients are not affected.
            self.assertTrue(wait_until(lambda: stopped.news.read_text().count("connected to the NATS server") >= 2),
                            stopped.news.read_text())
            self.assertIn("this program stood still", stopped.news.read_text())
            count = len(stopped.seen())
            self.assertTrue(wait_until(lambda: any(line["validity"] == "valid" for line in stopped.seen()[count:])))
            self.assertTrue(wait_until(lambda: reader.newest()["flood"]["validity"] == "silent"))
            self.assertEqual(slave.stop(), 0)
            for words in cut:
                self.assertIn(words, slave.log)

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
