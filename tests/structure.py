#!/usr/bin/env python3
"""Counts of the code's structure: lines, folders, classes, constants, and the path of an image.

structure.py prints the counts structure.py --list  also prints the places behind them

Needs universal-ctags.
"""
import collections
import functools
import json
import pathlib
import re
import shutil
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
PRODUCT = ("shared", "slave", "master")
MAX_LINES, MAX_PARTS = 450, 45
TEST_SUFFIXES = (".h", ".cpp", ".py", ".mjs", ".js", ".sh")
# Code that runs once per sample: estimators and checks.
PER_SAMPLE = ("slave/checks", "slave/contact", "slave/pipeline/camera", "slave/pipeline/fingertips",
              "slave/pipeline/load", "slave/pipeline/local_model", "slave/pipeline/manipulator_agreement",
              "slave/pipeline/points", "slave/pipeline/press", "slave/tactile/localise", "slave/vision/depth",
              "slave/vision/dots", "slave/vision/stereo", "slave/vision/texture")
PER_SAMPLE_FILES = ("slave/pipeline", "slave/tactile", "slave/vision")  # folders without their subfolders
EVIDENCE = re.compile(r"\[(derived|recorded|tuned|paper): ([^\]]{4,})\]|\[(by definition)\]")
UNIT = re.compile(r"\[(?!by definition)[^\]:]+\]")
CONSTANT = re.compile(r"^\s*(?:static |inline )*constexpr (?:double|float|int|long|bool|unsigned|std::(?:size_t|u?int\d+_t|"
                      r"array<[^>]+>)|auto) (k[A-Z]\w*.*)")


def read(path):
    return path.read_text(encoding="utf-8")


def sources(*folders, suffixes=(".h", ".cpp")):
    return sorted(path for folder in folders for path in (ROOT / folder).rglob("*") if path.suffix in suffixes)


def name_of(path):
    return str(path.relative_to(ROOT))


def tags(kinds):
    command = ["ctags", "-R", "--languages=C++", "--langmap=C++:.h.cpp", f"--kinds-C++={kinds}", "--fields=+neKZ",
               "--output-format=json", "-f", "-", *PRODUCT]
    printed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [json.loads(line) for line in printed.splitlines()]


def long_sources(lines):
    return sorted(f"{name_of(path)}: {count}" for path, count in lines.items() if count > MAX_LINES)


def function_lengths():
    """Returns the number of lines of every function that has a body, sorted, each with its position."""
    return sorted((tag["end"] - tag["line"] + 1, f"{tag['path']}:{tag['line']} {tag['name']}")
                  for tag in tags("f") if "end" in tag)


def defined_twice(found):
    """Returns types of the same name and namespace that are defined in two files."""
    places = collections.defaultdict(set)
    for tag in found:
        scope = tag.get("scope", "")
        if tag["kind"] in ("class", "struct", "union") and "__anon" not in scope + tag["name"] and "end" in tag:
            places[f"{scope}::{tag['name']}"].add(tag["path"])
    return sorted(f"{name}: {' '.join(sorted(paths))}" for name, paths in places.items() if len(paths) > 1)


def large_classes(found):
    """Returns classes with more data members and declared methods than MAX_PARTS. Overloads count once; constants,
    constructors, destructors and operators do not."""
    inside = collections.defaultdict(lambda: (set(), set()))
    for tag in found:
        name, own = tag["name"], tag.get("scope", "").split("::")[-1]
        members, methods = inside[(tag["path"], tag.get("scope"))]
        if tag["kind"] == "member" and not re.match("k[A-Z]", name):
            members.add(name)
        elif tag["kind"] in ("prototype", "function") and name != own and not name.startswith(("~", "operator")):
            methods.add(name)
    large = []
    for tag in found:
        if tag["kind"] not in ("class", "struct"):
            continue
        members, methods = inside[(tag["path"], "::".join(filter(None, (tag.get("scope"), tag["name"]))))]
        size = len(members) + len(methods)
        if size > MAX_PARTS:
            large.append((size, f"{tag['path']} {tag['name']}: {len(members)} + {len(methods)}"))
    return [text for _, text in sorted(large, reverse=True)]


def includes(path):
    return re.findall(r'^#include "((?:shared|slave|master)/[^"]+)"', read(path), re.M)


def cycles(files):
    """Returns groups of folders that include each other. A folder and its subfolders are distinct."""
    edges = collections.defaultdict(set)
    for path in files:
        for target in includes(path):
            edges[str(path.parent.relative_to(ROOT))].add(str(pathlib.PurePath(target).parent))

    def reached(start):
        seen, left = set(), [start]
        while left:
            for folder in edges[left.pop()] - seen:
                seen.add(folder)
                left.append(folder)
        return seen

    reach = {folder: reached(folder) for folder in list(edges)}
    groups = {frozenset(other for other in reach if folder in reach[other] and other in reach[folder])
              for folder in reach if any(folder in reach[other] for other in reach[folder] - {folder} if other in reach)}
    return sorted(" ".join(sorted(group)) for group in groups if len(group) > 1)


def per_sample():
    found = sources(*(folder for folder in PER_SAMPLE if (ROOT / folder).exists()))
    return found + [path for folder in PER_SAMPLE_FILES for path in sorted((ROOT / folder).glob("*.*"))
                    if path.suffix in (".h", ".cpp")]


@functools.lru_cache(maxsize=None)
def named_in_tests():
    """Returns the names that evidence may refer to (test sources, tests, rows of the robustness suite), and the text of
    tests and RESULTS."""
    texts = {path: read(path) for path in sources("tests", suffixes=(".h", ".cpp"))}
    rows = " ".join(text for path, text in texts.items() if "robustness" in path.parts)
    names = {path.stem for path in texts} | set(re.findall(r'"([^"\n]+)"', re.sub(r'"\s*\n\s*"', "", rows)))
    for text in texts.values():
        names |= set(re.findall(r"\bTEST(?:_[FP])?\(\s*\w+,\s*(\w+)", text))
    return names, read(ROOT / "tests/RESULTS.md") + " ".join(texts.values())


def has_evidence(comment):
    """Returns whether `comment` has a tag and a unit. `tuned` begins with the name of a test or of a row of the
    robustness suite; `recorded` names a recording that a test reads, or a row of RESULTS."""
    tag = EVIDENCE.search(comment)
    if not tag or tag[3]:
        return bool(tag)
    kind, text = tag[1], re.sub(r"\s+", " ", tag[2])
    names, words = named_in_tests()
    if kind == "tuned" and re.split("[,;:]", text)[0].strip() not in names:
        return False
    if kind == "recorded" and not any(word in words for word in re.findall(r"[A-Za-z]\w*_\w+", text) or [text]):
        return False
    return bool(UNIT.search(comment))


def constants(files):
    """Returns the names of numeric constants, and those without evidence in a comment before or beside them."""
    names, bare = [], []
    for path in files:
        lines = read(path).splitlines()
        for number, line in enumerate(lines):
            match = CONSTANT.match(line)
            if not match:
                continue
            end = number
            while ";" not in lines[end].split("//")[0] and end + 1 < len(lines):
                end += 1
            code = " ".join(one.split("//")[0] for one in lines[number:end + 1])
            found = re.findall(r"\b(k[A-Z]\w*)\s*(?:=(?!=)|\{)", code)
            start = number
            while start > 0 and lines[start - 1].strip().startswith("//"):
                start -= 1
            comment = " ".join(one.split("//", 1)[1].strip() for one in lines[start:end + 1] if "//" in one)
            names += found
            if not has_evidence(comment):
                bare += [f"{name_of(path)}:{number + 1} {name}" for name in found]
    return names, bare


def image_path():
    """Returns the sources that ARCHITECTURE.md links on the path of a camera image to the network, and each of its
    checks."""
    text = read(ROOT / "ARCHITECTURE.md").split("### In the sensing thread")[1]
    table = text.split("### From the network to the device")[0]
    files = re.findall(r"\]\(([^)]+\.h)\)", table)
    checks = [f for f in includes(ROOT / "slave/checks/camera/camera_checks.cpp") if not f.endswith("camera_checks.h")]
    return files + checks


def measure():
    """Returns each count with the positions behind it."""
    product = sources(*PRODUCT)
    lines = {path: read(path).count("\n") for path in product}
    tests = sum(read(path).count("\n") for path in sources("tests", suffixes=TEST_SUFFIXES))
    short = sum(count <= 40 for count in lines.values())
    folder, size = collections.Counter(str(path.parent.relative_to(ROOT)) for path in product).most_common(1)[0]
    functions = function_lengths()
    found = tags("csumpf")
    names, bare = constants(per_sample())
    counted = {
        "product lines": (sum(lines.values()), []),
        "test lines": (tests, []),
        "sources above 450 lines": long_sources(lines),
        "classes above 45 members and methods": large_classes(found),
        "cycles between folders": cycles(product),
        "constants of estimators and checks": (len(names), []),
        "constants without evidence": bare,
        "files on the path of an image": image_path(),
        "sources in the largest folder": (size, [folder]),
        "files of at most 40 lines [%]": (round(100 * short / len(product), 1), []),
        "lines of a function, median": (statistics.median(length for length, _ in functions), []),
        "lines of a function, nine of ten": (functions[int(0.9 * len(functions))][0], [functions[-1][1]]),
        "types defined twice": defined_twice(found),
    }
    modules = collections.Counter()
    for path, count in lines.items():
        modules["lines of " + "/".join(path.relative_to(ROOT).parts[:2])] += count
    table = {name: one if isinstance(one, tuple) else (len(one), one) for name, one in counted.items()}
    return table | {name: (count, []) for name, count in sorted(modules.items()) if not name.endswith((".h", ".cpp"))}


def main():
    if not shutil.which("ctags"):
        sys.exit("structure.py: universal-ctags is missing: apt-get install universal-ctags")
    for name, (count, places) in measure().items():
        print(f"{name:38} {count:>8}")
        if "--list" in sys.argv:
            print(*(f"    {place}" for place in places), sep="\n", end="\n" if places else "")


if __name__ == "__main__":
    main()
