"""A line that carries less than states, commands and datagrams want: datagrams yield, the stream lives, the hand is let on."""
import json
import pathlib
import subprocess
import tempfile
import unittest

from bad_line import SLAVE_AT, BadLine, permitted
from programs import BARE, BLOCK, MASTER, PATIENCE, SLAVE, Slave

SECONDS = 12


@unittest.skipUnless(permitted(), "no network namespaces or no TUN device here")
class ThinLine(unittest.TestCase):
    def operate(self, rate):
        with tempfile.TemporaryDirectory() as folder, BadLine(0.05, rate=rate) as line:
            report = pathlib.Path(folder) / "report.json"
            with Slave(command=[*line.at_slave, SLAVE, "serve", BLOCK, "--listen", f"{SLAVE_AT}:50051", "--insecure"]):
                subprocess.run([*line.at_master, MASTER, "connect", f"{SLAVE_AT}:50051", "--insecure", "--duration", str(SECONDS),
                                "--report", report], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, env=BARE, check=True,
                               timeout=SECONDS + PATIENCE)
            return json.loads(report.read_text())

    def test_the_stream_lives_beside_datagrams(self):
        for rate in (60e3, 30e3):  # [bytes/s]; the stream alone takes 90, without a pace 60 cut it three times in these seconds
            with self.subTest(rate=rate):
                printed = self.operate(rate)
                self.assertEqual(printed["reconnects"], 0)
                self.assertGreater(printed["states_by_datagram"], 0)
                self.assertGreater(printed["seconds_in"].get("FOLLOWING", 0), 0.5)


if __name__ == "__main__":
    unittest.main()
