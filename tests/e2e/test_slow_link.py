"""On a link that is too slow for states, commands and datagrams together, datagrams yield to the stream: the stream is
not cut, and the operator keeps control."""
import json
import pathlib
import subprocess
import tempfile
import unittest

from impaired_link import SLAVE_ADDRESS, ImpairedLink, can_impair_links
from programs import BARE, BLOCK, MASTER, PATIENCE, SLAVE, Slave

SECONDS = 12


@unittest.skipUnless(can_impair_links(), "no network namespaces or no TUN device here")
class SlowLink(unittest.TestCase):
    def operate(self, rate):
        with tempfile.TemporaryDirectory() as folder, ImpairedLink(0.05, rate=rate) as link:
            report = pathlib.Path(folder) / "report.json"
            with Slave(command=[*link.at_slave, SLAVE, "serve", BLOCK, "--listen", f"{SLAVE_ADDRESS}:50051", "--insecure"]):
                subprocess.run([*link.at_master, MASTER, "connect", f"{SLAVE_ADDRESS}:50051", "--insecure", "--duration", str(SECONDS),
                                "--report", report], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, env=BARE, check=True,
                               timeout=SECONDS + PATIENCE)
            return json.loads(report.read_text())

    def test_the_stream_lives_beside_datagrams(self):
        # [bytes/s]; the stream alone sends 90e3. Without rate control a link of 60e3 cut it three times.
        for rate in (60e3, 30e3):
            with self.subTest(rate=rate):
                printed = self.operate(rate)
                self.assertEqual(printed["reconnects"], 0)
                self.assertGreater(printed["states_by_datagram"], 0)
                self.assertGreater(printed["seconds_in"].get("FOLLOWING", 0), 0.5)


if __name__ == "__main__":
    unittest.main()
