"""Cost of a start: libraries that a scene does not need are not loaded, and a missing one that it needs is reported."""
import pathlib
import re
import resource
import shutil
import subprocess
import tempfile
import time
import unittest

from programs import BARE, BLOCK, PATIENCE, ROOT, SLAVE, Slave, cpu_seconds, deep, memory, operate, run

# gRPC loads 55 libraries and OpenCV's core 21. imgcodecs, videoio and PCL each load more than all others together.
MAX_LIBRARIES = 100
# Half of the memory after a start with all libraries linked. Most of it is the model and images decoded in advance.
MAX_MEMORY = 60e6  # [bytes]
# Wake-ups per second of a slave without clients. Without idle throttling of arm, watchdog, publisher and acceptor there
# are 3600. Health and acceptor cause 20 each.
MAX_WAKEUPS = 150
ON_DEMAND = ("libopencv_videoio", "libopencv_imgcodecs", "libopencv_calib3d", "libpcl_", "libavcodec", "libgdal")


def recorded(folder):
    """Writes the block's scene with images of its simulated camera as files."""
    done = run(SLAVE, "process", BLOCK, "--out", folder, "--frames")
    assert done.returncode == 0, done.stderr
    scene = folder / "recorded.yaml"
    scene.write_text(pathlib.Path(BLOCK).read_text().replace("source: simulated", 'file: "frames/%06d.png"'))
    return scene


def libraries(pid):
    return {line.split()[-1] for line in pathlib.Path(f"/proc/{pid}/maps").read_text().splitlines() if ".so" in line}


def bare_cpu():
    """Returns the CPU time of an empty Python program, which shows how fast this machine starts programs."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(["/usr/bin/python3", "-c", ""], check=True, env=BARE)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


class Start(unittest.TestCase):
    def test_a_slave_with_images_as_files_loads_little(self):
        with tempfile.TemporaryDirectory() as folder:
            with Slave(recorded(pathlib.Path(folder))) as slave:
                pid = slave.process.pid
                loaded, used, seconds = libraries(pid), 1e6 * memory(pid), cpu_seconds(pid)
        bare = bare_cpu()
        print(f"{len(loaded)} libraries, {used / 1e6:.0f} MB, {seconds:.2f} s of CPU: {seconds / bare:.0f} times a bare python's")
        self.assertLessEqual(len(loaded), MAX_LIBRARIES)
        self.assertLessEqual(used, MAX_MEMORY)
        self.assertEqual([name for name in loaded if pathlib.Path(name).name.startswith(ON_DEMAND)], [])


def wakeups(pid):
    """Returns how often the threads of a process were woken after waiting."""
    return sum(int(re.search(r"^voluntary_ctxt_switches:\s+(\d+)", task.joinpath("status").read_text(), re.M).group(1))
               for task in pathlib.Path(f"/proc/{pid}/task").iterdir())


def cost_of(pid, seconds):
    """Returns CPU time [s] and wake-ups per second, measured over `seconds`."""
    before = cpu_seconds(pid), wakeups(pid)
    time.sleep(seconds)
    return (cpu_seconds(pid) - before[0]) / seconds, (wakeups(pid) - before[1]) / seconds


@deep
class Idle(unittest.TestCase):
    def test_a_slave_that_nobody_reads_rests(self):
        with Slave() as slave:
            pid = slave.process.pid
            time.sleep(2)  # the arm has been stationary for a second
            idle_cpu, idle_wakings = cost_of(pid, 4)
            master = operate(slave.address, "--duration", "6")
            time.sleep(1)
            busy_cpu, busy_wakings = cost_of(pid, 4)
            self.assertEqual(master.wait(timeout=PATIENCE), 0, "and it is there at once for who comes")
            print(f"idle: {100 * idle_cpu:.1f} % of a core, woken {idle_wakings:.0f} times a second; "
                  f"operated: {100 * busy_cpu:.1f} %, {busy_wakings:.0f}")
        self.assertLess(idle_wakings, MAX_WAKEUPS)
        self.assertLess(2 * idle_cpu, busy_cpu)


# Commands, each with the separate library that contains it.
COMMANDS = {"study": "tools", "precompute": "tools", "identify": "tools", "evaluate": "evaluate", "verify": "verify",
            "calibrate": "calibrate"}


class Parts(unittest.TestCase):

    def test_what_is_not_installed_is_reported(self):
        with tempfile.TemporaryDirectory() as folder:
            alone = pathlib.Path(folder, "palpate-slave")
            shutil.copy(SLAVE, alone)
            scene = pathlib.Path(folder, "video.yaml")
            scene.write_text(pathlib.Path(BLOCK).read_text().replace("source: simulated", "file: video.avi"))
            pathlib.Path(folder, "video.avi").write_bytes(b"RIFF")
            for part, command in (("palpate-cameras.so", ("serve", scene, "--listen", "127.0.0.1:0")),
                                  *((f"palpate-{program}", (command,)) for command, program in COMMANDS.items())):
                done = run(alone, *command)
                self.assertEqual(done.returncode, 1, done.stderr)
                self.assertIn(f"{part}, which is not installed next to this program", done.stderr)


class Version(unittest.TestCase):
    def test_the_version_names_the_commit(self):
        printed = run(SLAVE, "--version").stdout.strip()
        self.assertRegex(printed, r"^\d+\.\d+\.\d+(\+[0-9a-f]{7,}(\.changed)?)?$")
        self.assertEqual("+" in printed, (ROOT / ".git").exists() and shutil.which("git") is not None)


if __name__ == "__main__":
    unittest.main(verbosity=2)
