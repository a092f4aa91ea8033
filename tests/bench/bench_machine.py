#!/usr/bin/env python3
"""Measures the processor time and memory of each shipped scene: a session of slave, simulator and master on one and on
two cores.

bench_machine.py [SCENE...] all shipped scenes without arguments; needs taskset (util-linux)
  --seconds S=12                 length of each session
  --cores LIST=0,0-1             sets of processors, as taskset writes them

Programs: PALPATE_BIN (default build/release/bin). Prints a row per scene and set, in Markdown.
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/e2e"))
from programs import BIN, cpu_seconds, memory, read_json  # noqa: E402

START_S = 300  # [s] longest start of a slave or a simulator
HEAD = "| scene | cores | age of a force: p50, p99 | slave: cores | simulator: cores | slave, simulator, master: MB | missed ticks | force error |"


class Program:
    """A program in the background, limited to a set of processors."""

    def __init__(self, cores, folder, name, *words):
        self.output = folder / f"{name}.txt"
        with open(self.output, "w", encoding="utf-8") as output:
            self.process = subprocess.Popen(["taskset", "-c", cores, BIN / f"palpate-{name}", *words], stdout=output, stderr=output)

    def wait_for(self, pattern):
        end = time.monotonic() + START_S
        while time.monotonic() < end and self.process.poll() is None:
            if found := re.search(pattern, self.output.read_text(encoding="utf-8"), re.MULTILINE):
                return found.group(1)
            time.sleep(0.1)
        raise RuntimeError(f"{pattern}: not printed in {self.output.read_text(encoding='utf-8')[-500:]}")

    def stop(self):
        self.process.terminate()
        self.process.wait()


def overrides(scene, folder):
    if scene != "liver-press":
        return []
    mesh = folder / "liver-press.msh"
    subprocess.run([ROOT / "deploy/scenes/make_liver.py", "--tets", "5000", "--out", mesh], check=True, stdout=subprocess.DEVNULL)
    return ["--override", f"object.geometry.mesh={mesh}"]


def session(scene, cores, seconds, folder):
    """Runs a session and returns its row."""
    file, own = ROOT / f"deploy/scenes/{scene}.yaml", overrides(scene, folder)
    slave = Program(cores, folder, "slave", "serve", file, "--listen", "127.0.0.1:0", *own)
    simulator = None
    try:
        address = slave.wait_for(r"^listening on (\S+)")
        simulator = Program(cores, folder, "simulator", file, "--slave", address, *own)
        simulator.wait_for(r"^(streaming to) ")
        before = cpu_seconds(slave.process.pid), cpu_seconds(simulator.process.pid), time.monotonic()
        master = Program(cores, folder, "master", "connect", address, "--duration", str(seconds),
                         "--report", folder / "report.json")
        master_mb = 0
        while master.process.poll() is None:
            try:
                master_mb = max(master_mb, memory(master.process.pid, "VmHWM"))
            except (OSError, TypeError):  # the process has just ended
                break
            time.sleep(0.2)
        master.process.wait()
        elapsed = time.monotonic() - before[2]
        used = [(cpu_seconds(program.process.pid) - start) / elapsed for program, start in zip((slave, simulator), before)]
        max_mb = [memory(slave.process.pid, "VmHWM"), memory(simulator.process.pid, "VmHWM"), master_mb]
    finally:
        slave.stop()
        if simulator:
            simulator.stop()
    report = read_json(folder / "report.json")
    error = report.get("force_error_delay_compensated") or {}
    age, relative = report["state_age_us"], error.get("relative_rms")
    return (f"| {scene} | {cores} | {age['p50'] / 1e3:.0f}, {age['p99'] / 1e3:.0f} ms | {used[0]:.2f} | {used[1]:.2f} | "
            f"{', '.join(f'{value:.0f}' for value in max_mb)} | {report['missed']} of {report['ticks']} | "
            f"{f'{100 * relative:.1f} %' if relative is not None else '-'} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    parser.add_argument("--seconds", type=float, default=12)
    parser.add_argument("--cores", default="0,0-1")
    options = parser.parse_args()
    print(HEAD + "\n" + "|---" * 8 + "|")
    for scene in options.scenes or sorted(path.stem for path in (ROOT / "deploy/scenes").glob("*.yaml")):
        for cores in options.cores.split(","):
            with tempfile.TemporaryDirectory() as folder:
                print(session(scene, cores, options.seconds, pathlib.Path(folder)), flush=True)
    print(f"load of the last minute: {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
    return 0


if __name__ == "__main__":
    sys.exit(main())
