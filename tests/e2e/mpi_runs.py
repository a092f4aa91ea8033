"""palpate-precompute under MPI, and what it leaves in a cache."""
import os
import pathlib
import shutil
import signal
import subprocess

import numpy

from programs import BARE, BIN, PATIENCE

PRECOMPUTE = str(BIN / "palpate-precompute")
MPIRUN = shutil.which("mpirun", path="/usr/bin:/bin")
# More ranks than processors, as root, in a container: what a test machine needs. Ranks that wait leave the processor.
MPI = BARE | {"HOME": os.environ.get("HOME", "/"), "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
              "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_mpi_yield_when_idle": "1",
              "OMPI_MCA_btl_vader_single_copy_mechanism": "none"}
IS_THERE = MPIRUN is not None and pathlib.Path(PRECOMPUTE).exists()

HEADER = 40  # of a column file [bytes]
SECTION = 32  # before the numbers of a section [bytes]


def command(ranks, scene, *arguments):
    return [MPIRUN, "-n", str(ranks), PRECOMPUTE, str(scene), *map(str, arguments)]


def precompute(ranks, scene, *arguments, timeout=5 * PATIENCE):
    return subprocess.run(command(ranks, scene, *arguments), stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=timeout, env=MPI)


def sections(file):
    """(offset, numbers) of each section of a .greens or .partial file."""
    data, at = file.read_bytes(), 0
    while at < len(data):
        count = int(numpy.frombuffer(data, numpy.uint64, 4, at)[2])
        yield at, numpy.frombuffer(data, numpy.float64, count, at + SECTION)
        at += SECTION + 8 * count


def numbers_in(file):
    """The Green's functions of one file of a cache."""
    if file.suffix == ".col":
        return numpy.frombuffer(file.read_bytes(), numpy.float64, offset=HEADER)
    return numpy.concatenate([numbers for _, numbers in sections(file)][1:3])  # blocks, reactions


def cached(folder):
    """{name: numbers} of a cache."""
    return {str(file.relative_to(folder)): numbers_in(file) for file in sorted(folder.rglob("*")) if file.is_file()}


def processes_of(session):
    """What runs in a session: mpirun and its ranks."""
    found = []
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == session and fields[0] != "Z":
            found.append(int(stat.parent.name))
    return found


class Killed:
    """A run that SIGKILL ends, mpirun and all ranks together."""

    def __init__(self, ranks, scene, *arguments):
        self.process = subprocess.Popen(command(ranks, scene, *arguments), stdin=subprocess.DEVNULL,
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=MPI,
                                        start_new_session=True)

    def kill(self):
        """How many processes it took."""
        killed = 0
        while running := processes_of(self.process.pid):
            for one in running:
                try:
                    os.kill(one, signal.SIGKILL)
                    killed += 1
                except ProcessLookupError:
                    pass
        self.process.wait()
        return killed
