#!/usr/bin/env python3
"""Checks links and names of the Markdown files against the tree.

links.py [FILE...]   prints FILE:LINE: NAME: what is expected; exit 1 if there is one

Links: the file exists, and so does the heading. Names in backticks: sources and folders, programs of tests, types, options,
scene keys. Options of programs also in blocks of commands, by deploy/options.md. The keys are those of deploy/scenes/README.md.
"""
import fnmatch
import functools
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
CODE_FILE = r"(?:h|cpp|py|sh|mjs|js|proto|patch|cmake|md|html)"
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
TICKS = re.compile(r"`([^`]+)`")
FENCE = re.compile(r"^\s*(```|~~~)")
PROGRAM = re.compile(r"palpate-(slave|master|simulator)(?: +([a-z]+))?(.*)")
DATA_FILE = re.compile(r"\.(csv|json|svg|yaml|txt|mcap|vtu|png|pcd|veg|node|log|conf|pem|service|pc|so|webp|onnx)$")
# An option of docker; a folder that an example of CONTRIBUTING makes.
OTHERS = {"--build-arg", "slave/mechanics/half_space"}


def read(path):
    return path.read_text(encoding="utf-8", errors="replace")


@functools.lru_cache(maxsize=None)
def tree():
    """Returns all files and folders, relative to the root."""
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT, capture_output=True,
                            text=True, check=False).stdout.splitlines()
    files = [name for name in listed if (ROOT / name).is_file()] or [
        str(path.relative_to(ROOT)) for path in ROOT.rglob("*")
        if path.is_file() and not {"build", ".git", "node_modules"} & set(path.relative_to(ROOT).parts)]
    return set(files) | {str(folder) for name in files for folder in pathlib.PurePath(name).parents}


@functools.lru_cache(maxsize=None)
def words():
    """Returns identifiers and options in all files except Markdown, and names of files without suffix."""
    text = " ".join(read(ROOT / name) for name in tree() if (ROOT / name).is_file() and
                    re.search(rf"\.({CODE_FILE[3:-1]}|txt|yaml|json|service|rules|yml)$|^deploy/(certs|palpate-demo)", name)
                    and not name.endswith(".md"))
    return set(re.findall(r"\w+|--[a-z][\w-]*", text)) | {pathlib.PurePath(name).stem for name in tree()}


@functools.lru_cache(maxsize=None)
def keys():
    return set(re.findall(r"^\| `([a-z_A-Z.]+)` \|", read(ROOT / "deploy/scenes/README.md"), re.M))


@functools.lru_cache(maxsize=None)
def options():
    """Returns the options of each command, for example {"palpate-slave serve": {"--listen", ...}}."""
    sections = re.split(r"^## ", read(ROOT / "deploy/options.md"), flags=re.M)[1:]
    return {text.split("\n", 1)[0]: {"--help", "--version"} | set(re.findall(r"`(--[a-z][\w-]*)`", text)) for text in sections}


def anchors(path):
    found, fenced = [], False
    for line in read(path).splitlines():
        fenced ^= bool(FENCE.match(line))
        if re.match(r"#+ ", line) and not fenced:
            title = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", line.lstrip("# "))
            slug = re.sub(r"[^\w\- ]", "", title.strip().lower()).replace(" ", "-")
            found.append(f"{slug}-{found.count(slug)}" if slug in found else slug)
    return found


def link_error(page, target):
    if re.match(r"[a-z]+:", target):
        return None
    name, _, anchor = target.partition("#")
    path = pathlib.Path(os.path.normpath(page.parent / name)) if name else page
    if not path.exists():
        return "no such file"
    return f"no such heading in {path.name}" if anchor and path.suffix == ".md" and anchor not in anchors(path) else None


def command_error(text):
    """Returns an error for an option that the program of a command line does not have."""
    match = PROGRAM.search(text)
    command = match and f"palpate-{match[1]} {match[2] or ''}".strip()
    command = f"palpate-{match[1]}" if match and command not in options() else command
    if command not in options():
        return None
    rest = re.split(r"[|;&>]| -- ", match[3])[0]
    wrong = set(re.findall(r"(?<=\s)--[a-z][\w-]*", rest)) - options()[command]
    return f"{command} has no option {' '.join(sorted(wrong))}" if wrong else None


def name_error(blocks, name):
    """Returns the error of a name in backticks, or None; `blocks` are the command and file blocks of its page."""
    if name in OTHERS | keys() or "NAME" in name:
        return None
    if re.fullmatch(r"[\w./*-]+\." + CODE_FILE, name):
        known = any(fnmatch.fnmatch("/" + path, "*/" + name.removeprefix("../").removeprefix("./")) for path in tree())
        return None if known or name in blocks else "no such file"
    if re.match(r"(slave|master|shared|tests|deploy|proto)/[\w./*-]+$", name):
        return None if any(fnmatch.fnmatch(path, name.rstrip("/")) for path in tree()) else "no such file or folder"
    if re.fullmatch(r"(test|bench|fuzz)_\w+|\w+_(test|cases)", name):
        return None if name in words() else "no such test"
    if re.fullmatch(r"([A-Z][a-z0-9]+){2,}", name):
        return None if name in words() else "no such type"
    if re.match(r"--[a-z]", name):
        option = re.match(r"--[a-z][\w-]*", name)[0]
        return None if option in words() or any(option in known for known in options().values()) else "no such option"
    if re.match(r"(serve|process|solve|check|study|precompute|identify|evaluate|verify|calibrate|train|keys|health) ", name):
        return command_error("palpate-slave " + name)
    if re.match(r"(connect|replay|doctor|evict|devices) ", name):
        return command_error("palpate-master " + name)
    if PROGRAM.match(name):
        return command_error(name)
    parts = {part for key in keys() for part in key.split(".")[:-1]}
    if re.fullmatch(r"[a-z_*]+(\.[a-z_*]+)+", name) and name.split(".")[0] in parts and not DATA_FILE.search(name):
        pattern = re.compile(r"(^|\.)" + re.escape(name).replace(r"\*", r"\w+") + "$")
        return None if any(pattern.search(key) for key in keys()) else "no such scene key"
    return None


def errors(path):
    page, fenced, command = read(path), False, ""
    blocks = "".join(re.findall(r"^ *```.*?^ *```", page, re.M | re.S))
    for number, line in enumerate(page.splitlines(), 1):
        if FENCE.match(line):
            fenced, command = not fenced, ""
        elif fenced:
            command += line.rstrip("\\")
            if not line.endswith("\\"):
                if error := command_error(command):
                    yield f"{number}: {error}"
                command = ""
        else:
            yield from (f"{number}: {target}: {error}" for target in LINK.findall(line) if (error := link_error(path, target)))
            yield from (f"{number}: {name}: {error}" for name in TICKS.findall(line) if (error := name_error(blocks, name)))


def main():
    pages = [pathlib.Path(name).resolve() for name in sys.argv[1:]] or [ROOT / n for n in sorted(tree()) if n.endswith(".md")]
    found = [f"{path.relative_to(ROOT)}:{error}" for path in pages for error in errors(path)]
    print("\n".join(found + [f"{len(pages)} pages, {len(found)} errors"]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
