"""palpate-slave precompute: a run that is killed and repeated produces the same cache as one run; the slave reads it;
errors are reported."""
import re
import shutil
import signal
import subprocess
import time
import unittest

from programs import BARE, BIN, PATIENCE, ROOT, SLAVE, FolderTest, Slave, deep, run

CUBE = ROOT / "deploy/scenes/foam-cube.yaml"
ENVIRONMENT = {**BARE, "OPENBLAS_NUM_THREADS": "1"}


def box(kind, cells, more=""):
    return ("name: block\nobject:\n"
            f"  geometry: {{box: {{size: [40 mm, 50 mm, 60 mm], cells: {list(cells)}}}}}\n"
            "  material: {young_modulus: 100 kPa, poisson_ratio: 0.4}\n  fixed: {plane: {axis: z, at: 0 mm}}\n"
            f"tool: {{shape: flat, width: 20 mm}}\nmodel: {{kind: {kind}{more}}}\n")


class Precompute(FolderTest):
    def setUp(self):
        super().setUp()
        self.scene = self.out / "scene.yaml"

    def command(self, cache, *options):
        return [SLAVE, "precompute", self.scene, "--override", f"model.cache={cache}", *options]

    def compute(self, cache):
        """Runs precompute. Returns the number of computed groups of columns and their total."""
        done = run(*self.command(cache), env=ENVIRONMENT)
        self.assertEqual(done.returncode, 0, done.stderr)
        printed = re.search(r"fem-green: (\d+) of (\d+) groups computed", done.stdout)
        self.assertTrue(printed, done.stdout)
        return tuple(map(int, printed.groups()))

    @staticmethod
    def contents(cache):
        """Returns the complete files of a cache with their contents."""
        return {file.relative_to(cache): file.read_bytes() for file in cache.rglob("*") if file.is_file() and file.suffix != ".part"}

    def kill(self, cache):
        """Kills a run after it has finished some groups."""
        process = subprocess.Popen(self.command(cache), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL, env=ENVIRONMENT)
        end = time.monotonic() + PATIENCE
        while len(list(cache.rglob("*.col"))) < 3 and process.poll() is None and time.monotonic() < end:
            time.sleep(0.0005)
        process.kill()
        self.assertEqual(process.wait(), -signal.SIGKILL, "it was faster than this test")

    # Reference: the cache of one run, byte by byte.
    def test_a_run_that_is_killed_and_repeated_is_the_cache_of_one_run(self):
        self.scene.write_text(box("fem-green", (12, 12, 12)))
        whole, resumed = self.out / "whole", self.out / "resumed"
        computed, groups = self.compute(whole)
        self.assertEqual(computed, groups)
        self.kill(resumed)
        kept = len(list(resumed.rglob("*.col")))
        self.assertEqual(self.compute(resumed), (groups - kept, groups))
        self.assertEqual(self.contents(resumed), self.contents(whole))
        self.assertEqual(self.compute(resumed), (0, groups))

    # A group that the slave reads is computed again if it is damaged; one that is whole is not touched.
    def test_serve_reads_the_cache(self):
        self.scene = CUBE
        cache = self.out / "cache"
        green = ("--override", f"model={{kind: fem-green, cache: {cache}}}")
        done = run(SLAVE, "precompute", CUBE, *green, env=ENVIRONMENT)
        self.assertEqual(done.returncode, 0, done.stderr)
        files = sorted(cache.rglob("*.col"))
        whole = self.contents(cache)
        data = bytearray(files[3].read_bytes())
        data[100] ^= 1
        files[3].write_bytes(data)
        times = {file: file.stat().st_mtime_ns for file in files}
        with Slave(CUBE, *green):
            pass
        # The local model of the fingertips adds further groups.
        served = self.contents(cache)
        self.assertEqual({name: served.get(name) for name in whole}, whole)
        self.assertEqual([file for file in files if file.stat().st_mtime_ns != times[file]], [files[3]])

    def refuse(self, code, message, *command):
        done = run(*command)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
        self.assertRegex(done.stderr, message)

    def test_errors_name_what_is_accepted(self):
        self.scene.write_text(box("fem-green", (3, 3, 3)))
        cache = self.out / "cache"
        self.refuse(2, "nowhere.yaml", SLAVE, "precompute", self.out / "nowhere.yaml")
        self.refuse(2, "model.kind = fem: expected fem-green",
                    SLAVE, "precompute", self.scene, "--override", "model.kind=fem")
        self.refuse(2, "model.cache: expected a folder", SLAVE, "precompute", self.scene)
        self.refuse(2, "fem-green needs a fixed body",
                    *self.command(cache, "--override", "object.fixed={nodes: [0]}"))
        self.assertFalse(cache.exists())
        cache.write_text("no folder")
        self.refuse(1, "cannot write to the cache", *self.command(cache))


if __name__ == "__main__":
    unittest.main(verbosity=2)
