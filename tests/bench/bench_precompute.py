#!/usr/bin/env python3
"""Memory of palpate-precompute per rank: the largest peak of the ranks with 1, 2 and 4 of them, above that of an empty job,
which is the same program with as many ranks and a box of one cell. Peaks are the largest resident set of each rank's process,
as the kernel tells whoever waits for it. Fails where 2 ranks take more than 0.65 or 4 ranks more than 0.4 of one rank's, or
where their Green's functions differ by more than 1e-9 of the largest one.

fem-green computes all groups of columns with one rank. Several ranks get all but the last of them as an interrupted run would
have left them: the factor, which needs the memory, is their own, and so are the last groups.

tests/bench/bench_precompute.py [--fem-cells N] [--bem-cells N]      needs build/release with palpate-precompute, numpy
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
LAST_GROUPS = 8


def report_peak(folder, command):
    """Runs a rank and writes the largest resident set of its process [bytes]."""
    process = subprocess.Popen(command)
    _, status, usage = os.wait4(process.pid, 0)
    pathlib.Path(folder, os.environ["OMPI_COMM_WORLD_RANK"]).write_text(str(1024 * usage.ru_maxrss))
    return os.waitstatus_to_exitcode(status)


def scene(kind, cells):
    return (f"name: block\nobject:\n  geometry: {{box: {{size: [40 mm, 40 mm, 40 mm], cells: [{cells}, {cells}, {cells}]}}}}\n"
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

    def above_empty(self, ranks, kind, cells, cache):
        empty, *_ = self.peaks(ranks, kind, 1, self.folder / "empty" / str(ranks))
        full, seconds, said = self.peaks(ranks, kind, cells, cache)
        memory = max(full) - min(empty)
        print(f"{said}\n  {ranks} ranks: peak {max(full) / 1e6:.0f} MB, empty job {min(empty) / 1e6:.0f} MB, "
              f"{seconds:.0f} s; load {os.getloadavg()[0]:.1f}", flush=True)
        return memory


def without_last_groups(cache, copy):
    """A cache of fem-green as an interrupted run leaves it."""
    for file in cache.rglob("*.col"):
        target = copy / file.relative_to(cache)
        target.parent.mkdir(parents=True, exist_ok=True)
        os.link(file, target)
    for file in sorted(copy.rglob("*.col"), key=lambda one: int(one.stem))[-LAST_GROUPS:]:
        file.unlink()


def difference(folder, reference):
    """Of the largest number, file by file."""
    from mpi_runs import numbers_in
    worst = 0
    for file in reference.rglob("*.*"):
        if file.is_file() and not os.path.samefile(file, folder / file.relative_to(reference)):
            wanted = numbers_in(file)
            worst = max(worst, abs(numbers_in(folder / file.relative_to(reference)) - wanted).max() / abs(wanted).max())
    return worst


def measure(kind, cells, folder):
    """Whether all limits hold."""
    runs, good, alone = Runs(folder), True, 0
    for ranks, most in MOST.items():
        cache = folder / f"{kind}-{ranks}"
        if kind == "fem-green" and ranks > 1:
            without_last_groups(folder / f"{kind}-1", cache)
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
    parser.add_argument("--fem-cells", type=int, default=30, help="cells along each side of the box of fem-green")
    parser.add_argument("--bem-cells", type=int, default=12, help="the same for bem3d")
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
