#!/usr/bin/env python3
"""The rows of RESULTS.md: the command of each, its commit, and whether its code has changed since.

usage: tests/results.sh            lists the rows
       tests/results.sh ROW...     runs the commands of these rows and writes what they measure into RESULTS.md
       tests/results.sh --check    fails if a row is older than its code and not marked, or marked without reason
       tests/results.sh --mark     sets and removes these marks

A row is the figures above a block of commands. The line after the block names the row, the commit at which it was measured, and the
folders whose code its figures depend on:

    Row `moving-object`: commit 0123abcd, code slave/vision slave/pipeline.

A mark is the word "Old." at its end. Changes of comments, layout, file names and names in the code do not make a row old.
The output of the commands is kept in build/results/ROW.txt. Figures that no command prints in a fixed form are entered by hand.
"""
import collections
import functools
import hashlib
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGE = ROOT / "tests/RESULTS.md"
ROW = re.compile(r"^Row `([a-z0-9-]+)`: commit ([0-9a-f]{8}), code ([^.]+)\.( Old\.)?$")
CODE = {".h", ".cpp", ".py", ".js", ".mjs", ".proto", ".sh", ".yaml"}
SKIPPED = 77  # exit code for ctest
TOKEN = re.compile(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|[A-Za-z_]\w*|[\d.]+[\w.]*|\S')
COMMENT = {"c": re.compile(r"//[^\n]*|/\*.*?\*/", re.S), "sh": re.compile(r"(?m)(?<![\w$\"'])#[^\n]*")}
WORDS = set("""if else for while do switch case default break continue return const constexpr static inline struct class enum public private
template typename using namespace auto void bool int double float true false nullptr new delete this throw try catch virtual override final
not and or in is lambda def import from with as None True False min max abs sqrt exp log sin cos norm""".split())


def git(*arguments, data=None):
    done = subprocess.run(["git", "-C", str(ROOT), *arguments], capture_output=True, input=data)
    return done.stdout if done.returncode == 0 else None


class Row:
    def __init__(self, match, line, commands):
        self.name, self.commit, folders, mark = match.groups()
        self.folders, self.is_marked, self.line, self.commands = folders.split(), mark is not None, line, commands

    def text(self):
        return f"Row `{self.name}`: commit {self.commit}, code {' '.join(self.folders)}.{' Old.' if self.is_marked else ''}"


def read_rows():
    rows, block, commands = [], None, ""
    for number, line in enumerate(PAGE.read_text().splitlines()):
        if line.startswith("```"):
            commands, block = ("", []) if block is None else ("\n".join(block), None)
        elif block is not None:
            block.append(line)
        elif match := ROW.match(line):
            rows.append(Row(match, number, commands))
    return rows


def blobs(commit, folders):
    listed = git("ls-tree", "-r", commit, "--", *folders)
    if listed is None:
        print(f"commit {commit} of RESULTS.md is not in this clone")
        sys.exit(SKIPPED)
    entries = (line.split("\t") for line in listed.decode().splitlines())
    return collections.Counter((info.split()[2], pathlib.Path(path).suffix) for info, path in entries
                               if pathlib.Path(path).suffix in CODE)


@functools.cache
def meaning(blob, suffix):
    return digest(git("cat-file", "blob", blob).decode(errors="replace"), suffix)


def digest(text, suffix):
    """Returns a digest of code that comments, layout and names do not change: each name is replaced by the number of
    its first use."""
    text = re.sub(r'(?m)^\s*(#include.*|#pragma once)$', "", text)
    text = COMMENT["c" if suffix in (".h", ".cpp", ".js", ".mjs", ".proto") else "sh"].sub("", text)
    names = {}
    tokens = (token if not re.match(r"[A-Za-z_]", token) or token in WORDS else f"n{names.setdefault(token, len(names))}"
              for token in TOKEN.findall(text))
    return hashlib.sha1(" ".join(tokens).encode()).hexdigest()


def is_old(row):
    then, now = blobs(row.commit, row.folders), blobs("HEAD", row.folders)
    gone, new = then - now, now - then
    if gone.total() != new.total():
        return True
    return (collections.Counter(meaning(*blob) for blob in gone.elements()) !=
            collections.Counter(meaning(*blob) for blob in new.elements()))


def write(rows):
    lines = PAGE.read_text().splitlines()
    for row in rows:
        lines[row.line] = row.text()
    PAGE.write_text("\n".join(lines) + "\n")


def percent(share):
    return f"{100 * share:.1f} %" if share < 0.0995 else f"{100 * share:.0f} %"


def offline_accuracy():
    """Returns the last column of the table of scenes, from the summaries that `process` wrote."""
    text = PAGE.read_text()
    for file in sorted((ROOT / "build/results").glob("*/summary.json")):
        error = json.loads(file.read_text())["force_error"]
        shares = f"{percent(error['rms_N'] / error['true_peak_N'])}, {percent(error['peak_N'] / error['true_peak_N'])}"
        text = re.sub(rf"(?m)^(\| {file.parent.name} \|.*\|)[^|]*\|$", rf"\g<1> {shares} |", text)
    PAGE.write_text(text)


FIGURES = {"accuracy-offline": offline_accuracy}  # rows whose figures are entered automatically


def measure(row):
    changed = git("status", "--porcelain", "--", *row.folders).decode()
    if changed:
        sys.exit(f"{row.name}: uncommitted changes of its code:\n{changed}expected a commit to measure")
    output = ROOT / f"build/results/{row.name}.txt"
    output.parent.mkdir(parents=True, exist_ok=True)
    print(f"{row.name}: {output.relative_to(ROOT)}\n{row.commands}", flush=True)
    with output.open("w") as file:
        if subprocess.run(["bash", "-ec", row.commands], cwd=ROOT, stdout=file, stderr=subprocess.STDOUT).returncode != 0:
            sys.exit(f"{row.name}: a command failed, see {output}")
    if row.name in FIGURES:
        FIGURES[row.name]()
    else:
        print(f"{row.name}: enter its figures in RESULTS.md by hand")
    row.commit, row.is_marked = git("rev-parse", "HEAD").decode()[:8], False


def main():
    wanted, rows = sys.argv[1:], read_rows()
    if wanted in (["-h"], ["--help"]):
        print(__doc__)
    elif wanted and not wanted[0].startswith("-"):
        for name in wanted:
            row = next((row for row in rows if row.name == name), None)
            if row is None:
                sys.exit(f"{name}: expected one of {' '.join(row.name for row in rows)}")
            measure(row)
            write([row])
    elif wanted in ([], ["--check"], ["--mark"]):
        wrong = []
        for row in rows:
            old = is_old(row)
            if old != row.is_marked:
                wrong.append(row)
            if not wanted:
                print(f"{row.name:24} {row.commit} {'old' if old else 'new'}  {' '.join(row.folders)}")
        if wanted == ["--mark"]:
            for row in wrong:
                row.is_marked = not row.is_marked
            write(wrong)
        if wanted == ["--check"] and wrong:
            for row in wrong:
                print(f"tests/RESULTS.md:{row.line + 1}: row {row.name}: {'marked as old, which it is not' if row.is_marked else 'its code has changed since it was measured'}")
            sys.exit("measure it again with tests/results.sh ROW, or mark it with tests/results.sh --mark")
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
