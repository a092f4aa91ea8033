#!/usr/bin/env python3
"""Lists private words in identifiers and comments of the code, and comments that begin with a bare "Of".

words.py [PATH...]   folders or files, default the whole tree
  --most N           exit 1 if there are more than N (default 20)
  --counts           a line per folder in place of a line per word

A word counts alone or as part of an identifier: felt, felt_, kFelt, IsFelt. Names of the wire (FAILED_CHECK_DENT) do not.
"""
import argparse
import collections
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
WORDS = ("felt", "eyes", "said", "told", "dent", "stands")
CODE = (".h", ".cpp", ".proto", ".py", ".sh", ".js", ".mjs")
LOWER = rf"(?<![A-Za-z])(?:{'|'.join(WORDS)})(?![a-z])"
UPPER = rf"(?<![A-Z])(?:{'|'.join(word.capitalize() for word in WORDS)})(?![a-z])"
PRIVATE = re.compile(f"{LOWER}|{UPPER}")
BARE_OF = re.compile(r"(?:^\s*|\s\s)(?://+<?|#)\s*Of\b")


def files(paths):
    listed = subprocess.run(["git", "ls-files", *map(str, paths)], cwd=ROOT, capture_output=True, text=True, check=True)
    return [ROOT / name for name in listed.stdout.splitlines() if name.endswith(CODE) and name != "tests/words.py"]


def words_of(file):
    """(line, word) of each."""
    previous = ""
    for number, line in enumerate(file.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        yield from ((number, found.group()) for found in PRIVATE.finditer(line))
        continues = re.match(r"\s*(//|#)", previous)  # a line of a comment that began before
        if BARE_OF.search(line) and not continues:
            yield number, "Of"
        previous = line


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paths", nargs="*", type=pathlib.Path, metavar="PATH")
    parser.add_argument("--most", type=int, default=20)
    parser.add_argument("--counts", action="store_true")
    options = parser.parse_args()
    counts = collections.Counter()
    for file in files([path.resolve() for path in options.paths] or ["."]):
        name = file.relative_to(ROOT)
        for line, word in words_of(file):
            counts["/".join(name.parts[:2])] += 1
            if not options.counts:
                print(f"{name}:{line}: {word}")
    if options.counts:
        for folder, count in sorted(counts.items()):
            print(f"{count:5} {folder}")
    print(f"{counts.total()} private words, expected at most {options.most}")
    return 1 if counts.total() > options.most else 0


if __name__ == "__main__":
    sys.exit(main())
