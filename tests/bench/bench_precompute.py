#!/usr/bin/env python3
"""Memory of palpate-precompute per rank: the largest peak of the ranks with 1, 2 and 4 of them, above that of an empty job,
which is the same program with as many ranks and a box of one cell. Peaks are the largest resident set of each rank's process,
as the kernel tells whoever waits for it. Fails where 2 ranks take more than 0.65 or 4 ranks more than 0.4 of one rank's, or
where their Green's functions differ by more than 1e-9 of the largest one.

fem-green is killed after its first groups of columns, whose memory all others have again. These groups are compared.

tests/bench/bench_precompute.py [--fem-cells X Y Z] [--bem-cells X Y Z]      needs build/release with palpate-precompute, numpy
"""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/e2e"))

MOST = {1: 1.0, 2: 0.65, 4: 0.4}  # of one rank's memory
EQUAL = 1e-9
GROUPS = 8


def report_peak(folder, command):
    """Runs a rank and writes the largest resident set of its process [bytes]."""
    process = subprocess.Popen(command)
    _, status, usage = os.wait4(process.pid, 0)
    pathlib.Path(folder, os.environ["OMPI_COMM_WORLD_RANK"]).write_text(str(1024 * usage.ru_maxrss))
    return os.waitstatus_to_exitcode(status)


def scene(kind, cells):
    return (f"name: block\nobject:\n  geometry: {{box: {{size: {[2e-3 * count for count in cells]}, cells: {list(cells)}}}}}\n"
            "  material: {young_modulus: 100 kPa, poisson_ratio: 0.45}\n  fixed: {plane: {axis: z, at: 0 mm}}\n"
            f"model: {{kind: {kind}}}\n")


class Runs:
    def __init__(self, folder):
        self.folder = folder

    def peaks(self, ranks, kind, cells, cache):
        """(peak of each rank [bytes], seconds, what the program printed)"""
        from mpi_runs import MPI, MPIRUN, PRECOMPUTE
        file = self.folder / "scene.yaml"
        file.write_text(scene(kind, cells))
        peaks = self.folder / "peaks"
        shutil.rmtree(peaks, ignore_errors=True)
        peaks.mkdir()
        begun = time.monotonic()
        done = subprocess.run([MPIRUN, "-n", str(ranks), sys.executable, __file__, "--peak", peaks, PRECOMPUTE, file,
                               "--out", cache], env=MPI, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True, check=True)
        return [int(one.read_text()) for one in peaks.iterdir()], time.monotonic() - begun, done.stdout.splitlines()[0]

    def first_peaks(self, ranks, kind, cells, cache):
        """The same of a run that is killed after its first groups."""
        from mpi_runs import Killed, processes_of
        file = self.folder / "scene.yaml"
        file.write_text(scene(kind, cells))
        begun = time.monotonic()
        run = Killed(ranks, file, "--out", cache)
        while len(list(cache.rglob("*.col"))) < GROUPS:
            if run.process.poll() is not None:
                raise SystemExit("the run ended before it was killed")
            time.sleep(0.1)
        status = [pathlib.Path(f"/proc/{one}/status").read_text() for one in processes_of(run.process.pid)]
        peaks = [1024 * int(text.split("VmHWM:")[1].split()[0]) for text in status if text.startswith("Name:\tpalpate-precomp")]
        run.kill()
        assert len(peaks) == ranks
        return peaks, time.monotonic() - begun, f"{kind}: {' x '.join(map(str, cells))} cells"

    def above_empty(self, ranks, kind, cells, cache):
        empty, *_ = self.peaks(ranks, kind, (1, 1, 1), self.folder / "empty" / str(ranks))
        measured = self.first_peaks if kind == "fem-green" else self.peaks
        full, seconds, said = measured(ranks, kind, cells, cache)
        memory = max(full) - min(empty)
        print(f"{said}\n  {ranks} ranks: peak {max(full) / 1e6:.0f} MB, empty job {min(empty) / 1e6:.0f} MB, "
              f"{seconds:.0f} s; load {os.getloadavg()[0]:.1f}", flush=True)
        return memory


def difference(folder, reference):
    """Of the largest number of each file that both have."""
    from mpi_runs import cached
    found, wanted = cached(folder), cached(reference)
    common = found.keys() & wanted.keys()
    assert len(common) >= GROUPS or found.keys() == wanted.keys()
    return max(abs(found[name] - wanted[name]).max() / (abs(wanted[name]).max() or 1) for name in common)


def measure(kind, cells, folder):
    """Whether all limits hold."""
    runs, good, alone = Runs(folder), True, 0
    for ranks, most in MOST.items():
        cache = folder / f"{kind}-{ranks}"
        memory = runs.above_empty(ranks, kind, cells, cache)
        alone = alone or memory
        worst = difference(cache, folder / f"{kind}-1")
        ratio = memory / alone
        print(f"  {kind}: {memory / 1e6:.0f} MB above the empty job, {ratio:.2f} of one rank's (most {most}), "
              f"largest difference {worst:.1e}", flush=True)
        good = good and ratio <= most and worst < EQUAL
        if ranks > 1:
            shutil.rmtree(cache)
    return good


def main():
    if sys.argv[1:2] == ["--peak"]:
        return report_peak(sys.argv[2], sys.argv[3:])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fem-cells", type=int, nargs=3, default=(80, 80, 10), help="cells of the box of fem-green")
    parser.add_argument("--bem-cells", type=int, nargs=3, default=(12, 12, 12), help="the same for bem3d")
    options = parser.parse_args()
    from mpi_runs import IS_THERE
    if not IS_THERE:
        print("skipped: palpate-precompute or mpirun is missing: deploy/install.sh mpi, then deploy/build.sh release")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        good = [measure(kind, cells, pathlib.Path(folder))
                for kind, cells in (("bem3d", options.bem_cells), ("fem-green", options.fem_cells))]
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())
