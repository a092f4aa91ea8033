"""Every mutex that a real-time thread of either program locks inherits priority."""
import pathlib
import subprocess
import tempfile
import unittest

from programs import BIN, MASTER, ROOT, SLAVE, Slave, run

SCENES = ROOT / "deploy/scenes"
WATCH = BIN / "mutex_watch.so"
SECONDS = "4"


def functions(program):
    """Returns start address and name of each function of `program`, sorted."""
    listed = subprocess.run(["nm", "-C", "--defined-only", program], capture_output=True, text=True, check=True).stdout
    parts = (line.split(" ", 2) for line in listed.splitlines())
    return sorted((int(part[0], 16), part[2]) for part in parts if len(part) == 3 and part[1] in "tTwW")


def names(program, offsets):
    known = functions(program)
    return sorted({max((one for one in known if one[0] < offset), default=(0, hex(offset)))[1] for offset in offsets})


class Mutexes(unittest.TestCase):
    def watched(self, scene):
        """Returns the names of functions that lock a mutex without priority inheritance, in slave and master."""
        with tempfile.TemporaryDirectory() as folder:
            at = pathlib.Path(folder)
            preload = ["env", f"LD_PRELOAD={WATCH}", f"MUTEX_WATCH={at / 'watch'}"]
            with Slave(command=[*preload, SLAVE, "serve", SCENES / f"{scene}.yaml", "--listen", "127.0.0.1:0"]) as slave:
                run(*preload, MASTER, "connect", slave.address, "--duration", SECONDS, "--record", at / "session.mcap").check_returncode()
            found = []
            for program in (SLAVE, MASTER):
                files = list(at.glob(f"watch-{pathlib.Path(program).name}-*"))
                self.assertTrue(files, f"{program} wrote no list")
                found += names(program, {int(line, 16) for file in files for line in file.read_text().split()})
            return found

    def test_a_camera_and_its_operator(self):
        self.assertEqual(self.watched("silicone-block"), [])

    def test_fingertips_and_their_operator(self):
        self.assertEqual(self.watched("foam-cube"), [])


if __name__ == "__main__":
    unittest.main()
