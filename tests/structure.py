#!/usr/bin/env python3
"""How the house is built, counted: folders, files, functions, lines, and types defined twice.

structure.py          prints the table; exit 1 where a count is above what is accepted
structure.py --tighten  writes what was counted to structure.json, where it is lower than what stands there

Accepted is the target, or where the tree is not there yet, what structure.json says it has reached: never worse.
Needs universal-ctags; without it: exit 77.
"""
import collections
import json
import pathlib
import shutil
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
REACHED = pathlib.Path(__file__).with_suffix(".json")
PRODUCT = ("shared", "slave", "master")
TARGETS = {
    "sources in the largest folder": 30,
    "files of at most 40 lines [%]": 22,
    "lines of a function, median": 8,
    "lines of a function, nine of ten": 25,
    "product lines": 82000,
    "types defined twice": 0,
}


def line_count(path):
    return path.read_text(encoding="utf-8").count("\n")


def tags(folders, kinds):
    """What ctags finds, as dictionaries with path, line, end, scope."""
    command = ["ctags", "-R", "--languages=C++", "--langmap=C++:.h.cpp", f"--kinds-C++={kinds}", "--fields=+neKZ",
               "--output-format=json", "-f", "-", *folders]
    said = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [json.loads(line) for line in said.splitlines()]


def largest_folder(files):
    sizes = collections.Counter(file.parent.relative_to(ROOT) for file in files)
    folder, size = max(sizes.items(), key=lambda item: item[1])
    return size, str(folder)


def function_lengths(folders):
    """Lines of every function that has a body, the longest last, each with its name."""
    found = [(tag["end"] - tag["line"] + 1, f"{tag['path']}:{tag['line']} {tag['name']}")
             for tag in tags(folders, "f") if "end" in tag]
    return sorted(found)


def defined_twice(folders):
    """Types of one name in one named namespace, defined in two files: two meanings of one word to the linker."""
    places = collections.defaultdict(set)
    for tag in tags(folders, "csu"):
        scope = tag.get("scope", "")
        if "__anon" not in scope and "__anon" not in tag["name"] and "end" in tag:
            places[f"{scope}::{tag['name']}"].add(tag["path"])
    return {name: sorted(paths) for name, paths in places.items() if len(paths) > 1}


def measure():
    """Each count with what it was counted on."""
    files = [file for folder in PRODUCT for file in (ROOT / folder).rglob("*") if file.suffix in (".h", ".cpp")]
    lines = {file: line_count(file) for file in files}
    short = sum(count <= 40 for count in lines.values())
    size, folder = largest_folder(files)
    functions = function_lengths(PRODUCT)
    lengths = [length for length, _ in functions]
    twice = defined_twice(PRODUCT)
    return {
        "sources in the largest folder": (size, folder),
        "files of at most 40 lines [%]": (round(100 * short / len(files), 1), f"{short} of {len(files)}"),
        "lines of a function, median": (statistics.median(lengths), f"{len(lengths)} functions"),
        "lines of a function, nine of ten": (lengths[int(0.9 * len(lengths))], f"the longest: {functions[-1][1]}"),
        "product lines": (sum(lines.values()), ", ".join(PRODUCT)),
        "types defined twice": (len(twice), "; ".join(f"{n}: {' '.join(p)}" for n, p in twice.items()) or "none"),
    }


def judge(count, target, reached):
    if count <= target:
        return "good"
    return "not yet" if reached is not None and count <= reached else "WORSE"


def main():
    if not shutil.which("ctags"):
        print("skipped: universal-ctags is missing (apt-get install universal-ctags)")
        return 77
    reached = json.loads(REACHED.read_text()) if REACHED.exists() else {}
    counted = measure()
    bad = False
    for name, (count, on) in counted.items():
        verdict = judge(count, TARGETS[name], reached.get(name))
        bad = bad or verdict == "WORSE"
        print(f"{name:34} {count:>8} target {TARGETS[name]:>6}  {verdict:8} {on}")
    if sys.argv[1:] == ["--tighten"]:
        still = {name: min(count, reached.get(name, count)) for name, (count, _) in counted.items()
                 if count > TARGETS[name]}
        REACHED.write_text(json.dumps(still, indent=1) + "\n")
        return 0
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
