#!/usr/bin/python3
"""Prints a regular expression of the tests that a change since main touches; nothing if there are none.

usage: tests/changed.py BUILD   BUILD: folder of a finished build, for example build/release

A program of C++ tests is touched if one of its own sources includes a changed file, or a header of a folder in which a
source has changed. Scripts and data are mapped to tests by RULES.
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
ALL = ".*"
# Changed file, the tests that read or run it. What no rule names touches C++ alone.
RULES = [
    (r"^(CMake|cmake/|proto/|\.ci/|tests/(run\.sh|.*CMakeLists\.txt))", ALL),
    (r"\.md$", "links|options_reference|test_promises"),
    (r"^deploy/scenes/", "test_readers|test_promises|e2e_senses"),
    (r"^(deploy/python/|tests/clients/)", "clients_"),
    (r"^(master/station/page/|tests/page/)", "page"),
    (r"^tests/promises/", "test_promises"),
    (r"^tests/contributing/", "contributing"),
    (r"^tests/e2e/", "e2e_"),
    (r"^tests/campaigns/", "^campaigns$"),
    (r"^(slave/(live|service|commands)|master|shared/link)/.*\.(h|cpp)$", "e2e_senses"),
]


def output(*command, folder=ROOT):
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout


def exists(branch):
    return subprocess.run(["git", "rev-parse", "-q", "--verify", branch], cwd=ROOT, capture_output=True).returncode == 0


def changed_files():
    """Returns what differs from main: commits, the working tree, and files that git does not track yet."""
    main = next((branch for branch in ("origin/main", "main") if exists(branch)), "HEAD")
    base = output("git", "merge-base", "HEAD", main).strip()
    return set(output("git", "diff", "--name-only", base).split("\n")
               + output("git", "ls-files", "--others", "--exclude-standard").split("\n")) - {""}


def included_files(build):
    """Returns {program of tests: files of the project that its own objects include}."""
    included, program = {}, None
    for line in output("ninja", "-t", "deps", folder=build).split("\n"):
        if line and not line.startswith(" "):
            found = re.match(r"tests/.*CMakeFiles/(test_\w+)\.dir/", line)
            program = found and found[1]
        elif program and line.strip().startswith(str(ROOT)):
            included.setdefault(program, set()).add(str(pathlib.Path(line.strip()).relative_to(ROOT)))
    return included


def main():
    files = changed_files()
    tests = {test for file in files for pattern, test in RULES if re.search(pattern, file)}
    sources = {file for file in files if file.endswith((".h", ".cpp"))}
    folders = {str(pathlib.Path(file).parent) for file in sources}
    for program, included in included_files(sys.argv[1]).items():
        if sources & included or any(file.endswith(".h") and str(pathlib.Path(file).parent) in folders for file in included):
            tests.add(f"^{program}$")
    print(ALL if ALL in tests else "|".join(sorted(tests)))


if __name__ == "__main__":
    main()
