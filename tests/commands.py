#!/usr/bin/env python3
"""Runs the ```sh, ```bash and ```python blocks of the README files and guides, as a reader would type them.

commands.py [FILE...]   every block that is not slow; without FILE: README.md, deploy/guides/*.md, README.md of the folders
  --full                slow blocks, too
  --budget SECONDS      blocks that would start later than that are skipped

The blocks of one file run in order in one bash with `set -euo pipefail`, in a scratch copy of the repository. Python
blocks run there by /usr/bin/python3. Background jobs last until the end of the file or until a block fails, which ends
the bash; the next block begins a new one. build/release/bin is PALPATE_BIN (default: that of the repository).

A comment on the line before a fence excludes its block: <!-- not run: REASON --> always, <!-- slow --> without --full.
Blocks that call deploy/demo.sh or tests/run.sh are excluded, because both run by themselves.
Prints a line per block and `N passed, N failed, N skipped`. Exit 1 if a block failed.
"""
import argparse
import contextlib
import os
import pathlib
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parents[1]
BIN = pathlib.Path(os.environ.get("PALPATE_BIN", ROOT / "build/release/bin")).resolve()
OUTPUT = pathlib.Path(os.environ.get("PALPATE_TEST_OUTPUT", ROOT / "build"))
PATIENCE, SLOW_PATIENCE = 600, 3600  # [s] after which a block counts as hung: normal, slow
STOP_PATIENCE = 3  # [s]
MARK_AS_SLOW = 8  # [s]
OUTPUT_LINES = 40  # of a failing block

FENCE = re.compile(r"^(\s*)(`{3,}|~{3,})\s*([\w-]*)")
COMMENT = re.compile(r"^\s*<!--\s*(.*?)\s*-->\s*$")
OWN_COMMANDS = re.compile(r"(?:^|[\s;&|(])(?:\./)?(deploy/demo\.sh|tests/run\.sh)(?=$|[\s;&|)])", re.MULTILINE)


class CommandBlock(NamedTuple):
    line: int  # line number of its first command
    text: str
    notes: tuple  # comments before it
    language: str = "sh"


def blocks_of(text):
    """Returns the command blocks of a Markdown text."""
    lines = text.splitlines()
    blocks, number = [], 0
    while number < len(lines):
        fence = FENCE.match(lines[number])
        if not fence:
            number += 1
            continue
        indent, mark, language = fence.groups()
        first = number + 1
        end = first
        while end < len(lines) and not re.match(rf"^\s*{re.escape(mark)}{mark[0]}*\s*$", lines[end]):
            end += 1
        if language in ("sh", "bash", "python"):
            body = [line[len(indent):] if line.startswith(indent) else line.lstrip() for line in lines[first:end]]
            blocks.append(CommandBlock(first + 1, "\n".join(body) + "\n", notes_before(lines, number), language))
        number = end + 1
    return blocks


def notes_before(lines, number):
    notes = []
    while number > 0 and (comment := COMMENT.match(lines[number - 1])):
        notes.append(comment.group(1))
        number -= 1
    return tuple(reversed(notes))


def reason_to_skip(block, full):
    """Returns the reason why a block is not run, or None. Raises ValueError for a mark that has no reason."""
    for note in block.notes:
        if note.startswith("not run"):
            reason = note.removeprefix("not run").lstrip(":").strip()
            if not reason:
                raise ValueError("<!-- not run: REASON --> has no reason")
            return reason
    if OWN_COMMANDS.search(block.text):
        return "calls the README's commands"
    if "slow" in block.notes and not full:
        return "slow: run with --full"
    return None


# ---- running

class Scratch:
    """A copy of the repository whose build/ holds the programs and nothing else."""

    def __init__(self, root, folder, programs):
        self.folder, self.programs = folder, programs
        listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=root,
                                capture_output=True, text=True, check=False)
        names = listed.stdout.split("\0")[:-1] if listed.returncode == 0 else [
            str(file.relative_to(root)) for file in root.rglob("*")
            if file.is_file() and file.relative_to(root).parts[0] not in ("build", ".git")]
        for name in names:
            if (root / name).is_file():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(root / name, folder / name)
        folder.mkdir(parents=True, exist_ok=True)

    def renew(self):
        """Removes what the blocks of a file have written before those of the next file run."""
        shutil.rmtree(self.folder / "build", ignore_errors=True)
        (self.folder / "build/release").mkdir(parents=True)
        (self.folder / "build/release/bin").symlink_to(self.programs)


def is_running(group):
    """Returns whether a process group has a process that is no zombie."""
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, _, its_group = stat.read_text().rpartition(")")[2].split()[:3]
            if int(its_group) == group and state != "Z":
                return True
    return False


def end_group(group):
    """Ends the remaining processes of a group: SIGTERM, then SIGKILL."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(group, signal.SIGTERM)
        end = time.monotonic() + STOP_PATIENCE
        while is_running(group) and time.monotonic() < end:
            time.sleep(0.05)
        os.killpg(group, signal.SIGKILL)


class Shell:
    """A bash that runs the blocks of one file. Its jobs are in its process group and write to its output."""

    def __init__(self, scratch):
        # Makes the Python package available as if pip had installed it.
        environment = os.environ | {"PATH": "/usr/bin:/bin:" + os.environ.get("PATH", ""), "PALPATE_BIN": str(scratch.programs),
                                    "PYTHONPATH": str(scratch.programs.parent / "python")}
        self.block = scratch.folder.with_name("block")
        self.output = tempfile.TemporaryFile()
        self.done, write_end = os.pipe()
        self.process = subprocess.Popen(["bash", "-s"], cwd=scratch.folder, env=environment, stdin=subprocess.PIPE, text=True,
                                        stdout=self.output, stderr=subprocess.STDOUT, pass_fds=[write_end], start_new_session=True)
        self.write(f"done={write_end}; set -aeuo pipefail")
        os.close(write_end)

    def write(self, command):
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()

    def run(self, block, patience):
        """Runs a block. Returns (exit code or None if it hung, output, seconds)."""
        self.block.write_text(block.text)
        begun, start = time.monotonic(), self.output.seek(0, os.SEEK_END)
        run = "/usr/bin/python3" if block.language == "python" else "source"
        self.write(f"{run} '{self.block}' </dev/null; jobs >/dev/null; echo >&$done")  # `jobs` resets the job numbers
        code = self.wait(begun + patience)
        self.output.seek(start)
        return code, self.output.read().decode(errors="replace"), time.monotonic() - begun

    def wait(self, deadline):
        """Waits for a block. Returns 0 when it is done, the exit code if the block ended the bash, None at the
        deadline."""
        while time.monotonic() < deadline:
            ended = self.process.poll()  # tested before the pipe, which jobs may keep open
            if select.select([self.done], [], [], 0 if ended is not None else 0.1)[0] and os.read(self.done, 1):
                return 0
            if ended is not None:
                return ended
        return None

    def end(self):
        end_group(self.process.pid)
        self.process.wait()
        os.close(self.done)
        self.output.close()


def indented(text):
    return "".join(f"    {line}\n" for line in text.splitlines())


class Runner:
    def __init__(self, scratch, full, budget):
        self.scratch, self.full, self.budget = scratch, full, budget
        self.begun = time.monotonic()
        self.counts = {"passed": 0, "failed": 0, "skipped": 0}
        self.shell = None

    def report(self, place, outcome, text):
        self.counts[outcome] += 1
        print(f"{place}: {outcome}{text}", flush=True)

    def run_file(self, name, text):
        self.scratch.renew()
        for block in blocks_of(text):
            self.run(f"{name}:{block.line}", block)
        self.end_shell()

    def end_shell(self):
        if self.shell:
            self.shell.end()
        self.shell = None

    def run(self, place, block):
        try:
            reason = reason_to_skip(block, self.full)
        except ValueError as error:
            self.report(place, "failed", f": {error}")
            return
        if reason is None and self.budget is not None and time.monotonic() - self.begun > self.budget:
            reason = f"the budget of {self.budget:g} s is used up"
        if reason is not None:
            self.report(place, "skipped", f": {reason}")
            return
        is_slow = "slow" in block.notes
        self.shell = self.shell or Shell(self.scratch)
        code, output, seconds = self.shell.run(block, SLOW_PATIENCE if is_slow else PATIENCE)
        if code == 0:
            note = "; mark it <!-- slow -->" if seconds > MARK_AS_SLOW and not is_slow else ""
            self.report(place, "passed", f" in {seconds:.1f} s{note}")
            return
        self.end_shell()
        why = f"no end after {seconds:.0f} s" if code is None else f"exit code {code}"
        last = "\n".join(output.splitlines()[-OUTPUT_LINES:])
        self.report(place, "failed", f": {why}\n  block:\n{indented(block.text)}  output:\n{indented(last)}".rstrip())

    def summary(self):
        print(", ".join(f"{count} {outcome}" for outcome, count in self.counts.items()))
        return 1 if self.counts["failed"] else 0


def default_files():
    guides = sorted((ROOT / "deploy/guides").glob("*.md"))
    folders = [path for top in ("deploy", "proto", "slave", "master", "shared", "tests")
               for path in sorted((ROOT / top).rglob("README.md")) if "node_modules" not in path.parts]
    return list(dict.fromkeys([ROOT / "README.md", *guides, *folders]))


def name_of(path):
    path = path.resolve()
    return path.relative_to(ROOT) if path.is_relative_to(ROOT) else path


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=pathlib.Path, metavar="FILE")
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--budget", type=float, metavar="SECONDS")
    options = parser.parse_args()
    if not (BIN / "palpate-slave").exists():
        print(f"skipped: there is no {BIN}/palpate-slave (./deploy/demo.sh builds it, or set PALPATE_BIN)")
        return 77
    OUTPUT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="commands-", dir=OUTPUT, ignore_cleanup_errors=True) as folder:
        runner = Runner(Scratch(ROOT, pathlib.Path(folder) / "palpate", BIN), options.full, options.budget)
        for path in options.files or default_files():
            runner.run_file(name_of(path), path.read_text(encoding="utf-8"))
        return runner.summary()


if __name__ == "__main__":
    sys.exit(main())
