"""palpate-precompute: the same as the slave's own computation, whatever the number of ranks; killed and resumed; errors."""
import pathlib
import shutil
import sys
import tempfile
import time
import unittest

from programs import IS_DEEP, PATIENCE, SLAVE, run

try:
    import numpy
    import mpi_runs
    from mpi_runs import MPI, MPIRUN, PRECOMPUTE, Killed, cached, precompute, processes_of, sections
    IS_THERE = mpi_runs.IS_THERE
except ImportError:
    IS_THERE = False

EQUAL = 1e-9  # of the largest number
SIZE = (0.04, 0.05, 0.06)  # [m]
FIXED = "fixed: {plane: {axis: z, at: 0 mm}}"


def scene_text(kind, cells, fixed=FIXED, model=""):
    return (f"name: block\nobject:\n  geometry: {{box: {{size: {[f'{1000 * s:g} mm' for s in SIZE]}, cells: {list(cells)}}}}}\n"
            f"  material: {{young_modulus: 100 kPa, poisson_ratio: 0.45}}\n  {fixed}\n"
            f"model: {{kind: {kind}{model}}}\n").replace("'", "")


def surface_nodes(cells):
    """Nodes of the box's skin that are not fixed."""
    for i in range(cells[0] + 1):
        for j in range(cells[1] + 1):
            for k in range(1, cells[2] + 1):
                if i in (0, cells[0]) or j in (0, cells[1]) or k == cells[2]:
                    yield [index / count * side for index, count, side in zip((i, j, k), cells, SIZE)]


def mixed(value, word):
    value = (value ^ word) * 0x9E3779B97F4A7C15 % 2**64
    return value ^ value >> 32


def double_columns(folder):
    """Doubles what a cache of fem-green has, with the checksums that belong to it."""
    for file in folder.rglob("*.col"):
        data = bytearray(file.read_bytes())
        numbers = 2 * numpy.frombuffer(bytes(data), numpy.float64, offset=40)
        checksum = 0xCBF29CE484222325
        for word in numbers.view(numpy.uint64).tolist():
            checksum = (checksum ^ word) * 0x100000001B3 % 2**64
            checksum ^= checksum >> 29
        data[32:40] = checksum.to_bytes(8, "little")
        data[40:] = numbers.tobytes()
        file.write_bytes(data)


def double_blocks(folder):
    """The same for bem3d."""
    for file in folder.glob("*.greens"):
        data = bytearray(file.read_bytes())
        at, blocks = list(sections(file))[1]
        numbers = 2 * blocks
        checksum = mixed(int.from_bytes(data[at + 8:at + 16], "little") + 1, len(numbers))
        for word in numbers.view(numpy.uint64).tolist():
            checksum = mixed(checksum, word)
        data[at + 24:at + 32] = checksum.to_bytes(8, "little")
        data[at + 32:at + 32 + 8 * len(numbers)] = numbers.tobytes()
        file.write_bytes(data)


class Precompute(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.out = pathlib.Path(self.folder.name)

    def scene(self, *arguments, **options):
        file = self.out / "scene.yaml"
        file.write_text(scene_text(*arguments, **options))
        return file

    def compute(self, ranks, scene, cache):
        done = precompute(ranks, scene, "--out", cache)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def solve(self, scene, cache, table, rows):
        """The slave's answers: displacements [m]."""
        kind = "loads" if ",fx," in table else "contacts"
        (self.out / "in.csv").write_text(table + "\n" + "\n".join(rows) + "\n")
        done = run(SLAVE, "solve", scene, "--override", f"model.cache={cache}", f"--{kind}", self.out / "in.csv",
                   "--out", self.out / "out.csv")
        self.assertEqual(done.returncode, 0, done.stderr)
        return numpy.genfromtxt(self.out / "out.csv", delimiter=",", names=True, usecols=range(1, 10))

    def expect_equal(self, folder, reference):
        found, wanted = cached(folder), cached(reference)
        self.assertEqual(found.keys(), wanted.keys())
        self.assertTrue(any(numbers.any() for numbers in wanted.values()))
        worst = max(abs(found[name] - wanted[name]).max() / (abs(wanted[name]).max() or 1) for name in wanted)
        print(f"{folder.name}: {len(wanted)} files, {sum(map(len, wanted.values()))} numbers, largest difference {worst:.1e}")
        self.assertLess(worst, EQUAL)

    # Reference: the slave, which factorises with other programs (LAPACK, the sequential MUMPS) in another order.
    def test_any_number_of_ranks_computes_what_the_slave_computes(self):
        cells = (5, 6, 7)
        pushed = [f"{n},{x},{y},{z},1e-4,0,0,0" for n, (x, y, z) in enumerate(surface_nodes(cells))]
        balanced = ["1,0,0,0.06,0,0,0,0"]  # the only one that needs no second load opposite to it
        more = (("fem-green", {"model": ", element: tet10"}, pushed), ("bem3d", {"fixed": ""}, balanced)) if IS_DEEP else ()
        for name, options, contacts in (("fem-green", {}, pushed), ("bem3d", {}, pushed), *more):
            with self.subTest(name=name, **options):
                scene = self.scene(name, cells, **options)
                folder = self.out / "".join(filter(str.isalnum, name + str(options)))
                table = "case,x,y,z,fx,fy,fz,width" if contacts is balanced else "case,x,y,z,dx,dy,dz,width"
                self.solve(scene, folder / "slave", table, contacts)
                for ranks in (1, 2, 4) if IS_DEEP else (2, 4):
                    said = self.compute(ranks, scene, folder / f"{ranks} ranks")
                    self.assertIn(f"ranks: {ranks},", said)
                    self.expect_equal(folder / f"{ranks} ranks", folder / "slave")

    # Reference: a cache whose Green's functions are twice as large. Whoever computes them does not see it.
    def test_the_slave_answers_from_the_cache_without_computing(self):
        for kind, double in (("fem-green", double_columns), ("bem3d", double_blocks)):
            with self.subTest(kind=kind):
                scene, cache = self.scene(kind, (3, 3, 3)), self.out / kind
                self.compute(2, scene, cache)
                load = ("case,x,y,z,fx,fy,fz,width", ["1,0.02,0.025,0.06,1e-3,2e-3,-1e-3,0"])
                once = self.solve(scene, cache, *load)
                double(cache)
                files = {file: file.stat().st_mtime_ns for file in cache.rglob("*")}
                twice = self.solve(scene, cache, *load)
                for axis in ("dx", "dy", "dz"):
                    self.assertAlmostEqual(float(twice[axis] / once[axis]), 2, 12)
                self.assertEqual(files, {file: file.stat().st_mtime_ns for file in cache.rglob("*")})

    def kill_when(self, ranks, scene, cache, condition):
        """Starts a run and kills it once `condition` holds. Of a run that was faster than this test the cache is restored."""
        before = self.out / "before"
        for _ in range(5):
            shutil.rmtree(before, ignore_errors=True)
            if cache.exists():
                shutil.copytree(cache, before)
            killed = Killed(ranks, scene, "--out", cache)
            end = time.monotonic() + PATIENCE
            while not condition() and killed.process.poll() is None and time.monotonic() < end:
                time.sleep(0.0005)
            ended = killed.process.poll()
            running = killed.kill()
            if ended is None:
                self.assertGreater(running, ranks, "mpirun and its ranks")
                self.assertEqual(processes_of(killed.process.pid), [])
                return
            shutil.rmtree(cache)
            if before.exists():
                shutil.copytree(before, cache)
        self.fail("no run was slow enough to be killed")

    def test_fem_green_is_killed_and_resumed(self):
        scene, cache, whole = self.scene("fem-green", (12, 12, 12)), self.out / "cache", self.out / "whole"
        self.compute(1, scene, whole)
        self.kill_when(2, scene, cache, lambda: len(list(cache.rglob("*.col"))) >= 10)
        kept = sorted(cache.rglob("*.col"))
        damaged = kept[3]
        data = bytearray(damaged.read_bytes())
        data[100] ^= 1
        damaged.write_bytes(data)
        written = {file: file.stat().st_mtime_ns for file in kept}
        groups = len(list(whole.rglob("*.col")))
        said = self.compute(2, scene, cache)
        self.assertIn(f"{groups - len(kept) + 1} of {groups} groups computed", said)
        changed = [file for file in kept if file.stat().st_mtime_ns != written[file]]
        self.assertEqual(changed, [damaged])
        self.expect_equal(cache, whole)
        self.assertIn(f" 0 of {groups} groups computed", self.compute(4, scene, cache))

    # Other numbers of ranks take over what was kept.
    def test_bem3d_is_killed_and_resumed_at_factor_and_columns(self):
        scene, cache, whole = self.scene("bem3d", (8, 8, 8)), self.out / "cache", self.out / "whole"
        self.compute(1, scene, whole)
        n = 3 * 12 * 8 * 8
        inputs, block, panel = 32 + 8 * (4 + 4 * n), 32 + 8 * 256 * (n + 1), 32 + 8 * 192 * n

        def partial():
            return next(cache.glob("*.partial"), None) if cache.exists() else None

        def has(size):
            return lambda: (file := partial()) is not None and file.stat().st_size >= size

        # Of the last part that is there the checksum may be missing: it is written last.
        self.kill_when(2, scene, cache, has(inputs + 3 * block))
        kept = partial().read_bytes()[:inputs + 2 * block]
        self.kill_when(4, scene, cache, has(inputs + n * (8 * n + 8) + 32 * 9 + 3 * panel))
        self.assertEqual(partial().read_bytes()[:len(kept)], kept)
        said = self.compute(1, scene, cache)
        self.assertRegex(said, r" 0 of 9 blocks of the factor and ([1-9]|10) of 12 of columns computed")
        self.assertIsNone(partial())
        self.expect_equal(cache, whole)
        self.assertIn("all in the cache", self.compute(2, scene, cache))

    def refuse(self, code, message, command):
        """Ends with this code and one message."""
        done = run(*command, env=MPI)
        said = [line for line in done.stderr.splitlines() if line.startswith("palpate-precompute: ")]
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertEqual(len(said), 1, done.stderr)
        self.assertRegex(said[0], message)

    def test_errors_end_all_ranks_with_one_message(self):
        good, cache = self.scene("bem3d", (3, 3, 3)), self.out / "cache"
        three = [MPIRUN, "-n", "3", PRECOMPUTE]
        self.refuse(2, "nowhere.yaml", [*three, self.out / "nowhere.yaml", "--out", cache])
        self.refuse(2, "model.kind = fem: accepted is fem-green or bem3d",
                    [*three, good, "--out", cache, "--override", "model.kind=fem"])
        self.refuse(2, "no cache: accepted is a folder", [*three, good])
        self.refuse(2, "fem-green needs a fixed body",
                    [*three, good, "--out", cache, "--override", "model.kind=fem-green",
                     "--override", "object.fixed={plane: {axis: z, at: 0 mm}, components: z}"])
        alone = [MPIRUN, "-n", "1", PRECOMPUTE]
        self.refuse(2, "rank 1: .*nowhere.yaml",
                    [*alone, good, "--out", cache, ":", "-n", "1", PRECOMPUTE, self.out / "nowhere.yaml", "--out", cache])
        self.refuse(2, "the ranks read different inputs",
                    [*alone, good, "--out", cache, ":", "-n", "1", PRECOMPUTE, good, "--out", cache,
                     "--override", "object.material.poisson_ratio=0.3"])
        cache.write_text("no folder")
        for kind in ("bem3d", "fem-green"):
            self.refuse(1, "cannot write to the cache", [*three, good, "--out", cache, "--override", f"model.kind={kind}"])


if __name__ == "__main__":
    if not IS_THERE:
        print("skipped: palpate-precompute, mpirun or numpy is missing: deploy/install.sh mpi")
        sys.exit(77)
    unittest.main(verbosity=2)
