#!/usr/bin/env python3
"""Measures the prose of Markdown files against limits, and lists private words in the code. Run by hand; no test runs it.

style.py              checks every tracked *.md file of the repository, and all code
style.py FILE...      checks these *.md files

Prose is paragraphs and list items. Code blocks, headings, tables, pictures and comments are not counted.
Prints one line per file, then FILE:LINE: MESSAGE for each violation. Exit 1 if there is any.
"""
import argparse
import pathlib
import re
import subprocess
import sys
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parents[1]
ROOT_MARK = "CMakePresets.json"  # file beside the README that has its own limits
CODE_FILES = (".h", ".cpp", ".proto", ".py", ".sh", ".js", ".mjs")
# Private words, alone or as part of an identifier: felt, felt_, kFelt, IsFelt.
WORDS = ("felt", "eyes", "said", "told", "dent", "stands")
PRIVATE = re.compile(rf"(?<![A-Za-z])(?:{'|'.join(WORDS)})(?![a-z])|(?<![A-Z])(?:{'|'.join(word.capitalize() for word in WORDS)})(?![a-z])")
HOME_MADE = ("told", "anew", "two eyes", "put right", "silently wrong", "let go")


class Limits(NamedTuple):
    words: int  # largest number of words of prose
    average: float  # words per sentence
    longest: int  # largest number of words of a sentence
    cell: int = 25  # largest number of words of a table cell
    total: int = sys.maxsize  # largest number of words with tables, headings and code blocks


README_LIMITS = Limits(words=800, average=16, longest=35, total=1000)
LIMITS = Limits(words=2500, average=18, longest=40)
GENERATED_LIMITS = LIMITS._replace(words=sys.maxsize)


class Block(NamedTuple):
    line: int
    text: str


class Sentence(NamedTuple):
    line: int
    words: int
    text: str


class Parts(NamedTuple):
    prose: list  # paragraphs and list items
    rows: list  # rows of tables
    titles: list


# ---- lines to blocks

FENCE = re.compile(r"^\s*(?:>\s*)*(?:(?:[-*+]|\d+[.)])\s+)?(`{3,}|~{3,})")
ITEM = re.compile(r"^\s*(?:[-*+]|\d+[.)])\s+")
HEADING = re.compile(r"^ {0,3}#{1,6}(\s|$)")
UNDERLINE = re.compile(r"^ {0,3}(=+|-{2,})\s*$")
RULE = re.compile(r"^ {0,3}([-*_])(\s*\1){2,}\s*$")
REFERENCE = re.compile(r"^ {0,3}\[[^\]]+\]:\s*\S+")


def without_fences(lines):
    """Returns the lines outside code fences as (number, text). A fence becomes an empty line."""
    close = None
    for number, line in enumerate(lines, 1):
        fence = FENCE.match(line)
        if close:
            if fence and line.strip(" \t>").startswith(close) and not line.strip(" \t>" + close[0]):
                close = None
        elif fence:
            close = fence.group(1)
        else:
            yield number, line
            continue
        yield number, ""


def without_comments(text):
    return re.sub(r"<!--.*?-->", lambda found: "\n" * found.group().count("\n"), text, flags=re.DOTALL)


class _Splitter:
    """Collects lines into blocks."""

    def __init__(self):
        self.parts = Parts([], [], [])
        self._lines = []
        self._start = 0
        self._in_list = False

    def end(self):
        if self._lines:
            self.parts.prose.append(Block(self._start, "\n".join(self._lines)))
        self._lines = []

    def take(self, number, line):
        line = re.sub(r"^( {0,3}>\s?)+", "", line)
        bare = line.strip()
        if not bare:
            self.end()
        elif HEADING.match(line):
            self.end()
            self._in_list = False
            self.parts.titles.append(Block(number, bare.strip("#").strip()))
        elif UNDERLINE.match(line) and self._lines and not self._in_list:
            self.parts.titles.append(Block(self._start, " ".join(self._lines)))
            self._lines = []
        elif RULE.match(line) or REFERENCE.match(line):
            self.end()
        elif bare.startswith("|"):
            self.end()
            self.parts.rows.append(Block(number, bare))
        else:
            self._take_prose(number, line, bare)

    def _take_prose(self, number, line, bare):
        item = ITEM.match(line)
        if item:
            self.end()
            self._in_list = True
            bare = line[item.end():].strip()
        elif not self._lines:
            if not line.startswith((" ", "\t")):
                self._in_list = False
            elif not self._in_list and line.startswith(("    ", "\t")):
                return  # an indented code block
        if not self._lines:
            self._start = number
        self._lines.append(bare)


def parts_of(text):
    splitter = _Splitter()
    outside = "\n".join(line for _, line in without_fences(text.splitlines()))
    for number, line in enumerate(without_comments(outside).splitlines(), 1):
        splitter.take(number, line)
    splitter.end()
    return splitter.parts


# ---- blocks to sentences

CODE = re.compile(r"(?<!`)(`+)(?!`)(.+?)(?<!`)\1(?!`)", re.DOTALL)
HIDDEN = str.maketrans(".!?[]()<>*|", "".join(chr(0xE000 + index) for index in range(11)))
SHOWN = {hidden: letter for letter, hidden in HIDDEN.items()}
NEVER_AN_END = {"e.g.", "i.e.", "cf.", "vs.", "fig.", "figs.", "eq.", "eqs.", "sec.", "ref.", "approx.", "ca.", "resp.", "dr.", "prof."}
END_BEFORE_CAPITAL = {"etc.", "al.", "no.", "vol.", "pp.", "p.", "min.", "max."}
INITIALS = re.compile(r"([A-Z]\.-?)+")
END = re.compile(r"[.!?][\"'”’)\]*_]*\s+")


def hide_code(text):
    """Removes backticks of code spans and hides characters in them that mark sentences or links."""
    return CODE.sub(lambda found: found.group(2).strip().translate(HIDDEN), text)


def without_links(text):
    """Removes pictures and tags, and replaces links by their text."""
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text)
    text = re.sub(r"\[([^\]]*)\](\([^)]*\)|\[[^\]]*\])", r"\1", text)
    return re.sub(r"</?[a-zA-Z][^<>:]*>", "", text)


def plain(text):
    return without_links(hide_code(text))


def is_word(token):
    return any(letter.isalnum() or "\ue000" <= letter <= "\uf8ff" for letter in token)


def count_words(text):
    return sum(is_word(token) for token in text.split())


def ends_here(before, after):
    """Returns whether the full stop at the end of `before` ends a sentence."""
    tokens = before.split()
    last = tokens[-1].lstrip("(\"'*_[“")
    if last.lower() in NEVER_AN_END:
        return False
    if last.lower() in END_BEFORE_CAPITAL:
        return after[:1].isupper()
    if INITIALS.fullmatch(last):  # initials of a name, but not as in "papers A and B."
        previous = tokens[-2] if len(tokens) > 1 else ","
        listed = previous == "and" and len(tokens) > 2 and len(tokens[-3].strip(",")) == 1
        return listed or not (previous.endswith(",") or previous.lower() in ("and", "&", "by") or INITIALS.fullmatch(previous))
    return True


def sentences_of(block):
    text = plain(block.text)
    start = 0
    for found in list(END.finditer(text)) + [None]:
        end = found.end() if found else len(text)
        if found and not ends_here(text[start:end], text[end:]):
            continue
        sentence = text[start:end]
        if count_words(sentence):
            leading = len(sentence) - len(sentence.lstrip())
            yield Sentence(block.line + text.count("\n", 0, start + leading), count_words(sentence), sentence.strip())
        start = end


def simple_sentences(text):
    """Splits into sentences by a simpler, common rule: a full stop before white space ends one, as do empty lines and
    list items; lines that start with | # - ` or ! are left out."""
    kept = []
    for number, line in without_fences(text.splitlines()):
        if line.startswith(("|", "#", "-", "`", "!")):
            continue
        if kept and (not line.strip() or ITEM.match(line)):
            yield simple_sentence(kept)
            kept = []
        for piece in re.split(r"(?<=[.!?])\s+", line.strip()):
            if piece:
                kept.append((number, piece))
            if piece.endswith((".", "!", "?")):
                yield simple_sentence(kept)
                kept = []
    if kept:
        yield simple_sentence(kept)


def simple_sentence(pieces):
    text = " ".join(piece for _, piece in pieces)
    return Sentence(pieces[0][0], len(text.split()), text)


def cells_of(row):
    """Returns the cells of a table row as text; none for the row under the header."""
    text = plain(row.text).replace("\\|", "/").strip("|")
    cells = [cell.strip() for cell in text.split("|")]
    return [] if all(re.fullmatch(r":?-+:?", cell) for cell in cells) else cells


# ---- the measure of a text

class Measure(NamedTuple):
    words: int
    sentences: int
    longest: Sentence
    cell: Block
    home_made: list  # line and home-made phrase

    @property
    def average(self):
        return self.words / self.sentences if self.sentences else 0


def home_made_of(parts):
    pattern = re.compile(r"\b(" + "|".join(phrase.replace(" ", r"\s+") for phrase in HOME_MADE) + r")\b", re.IGNORECASE)
    found = []
    for block in sorted(parts.prose + parts.rows + parts.titles):
        text = CODE.sub(lambda code: re.sub(r"\S", "~", code.group()), block.text)
        text = re.sub(r"\]\([^)]*\)", "]", text)
        found += [Block(block.line + text.count("\n", 0, hit.start()), " ".join(hit.group().split())) for hit in pattern.finditer(text)]
    return found


def sentences_in(parts):
    return [sentence for block in parts.prose for sentence in sentences_of(block)]


def measure(text):
    parts = parts_of(text)
    sentences = sentences_in(parts)
    cells = [Block(row.line, cell) for row in parts.rows for cell in cells_of(row)]
    return Measure(
        words=sum(sentence.words for sentence in sentences),
        sentences=len(sentences),
        longest=max([*sentences, *simple_sentences(text)], key=lambda sentence: sentence.words, default=Sentence(1, 0, "")),
        cell=max(cells, key=lambda block: count_words(block.text), default=Block(1, "")),
        home_made=home_made_of(parts))


def beginning(block, words=8):
    text = block.text.translate(SHOWN).split()
    return " ".join(text[:words]) + (" ..." if len(text) > words else "")


def limits_for(path, text):
    if path.name == "README.md" and (path.parent / ROOT_MARK).exists():
        return README_LIMITS
    return GENERATED_LIMITS if "generated by" in text.split("\n", 1)[0] else LIMITS


def violations(text, limits):
    """Returns the violations as (line, message)."""
    found = measure(text)
    bad = []
    if found.words > limits.words:
        bad.append((1, f"{found.words} words of prose: expected at most {limits.words}"))
    if len(text.split()) > limits.total:
        bad.append((1, f"{len(text.split())} words with tables: expected at most {limits.total}"))
    if found.average > limits.average:
        bad.append((1, f"{found.average:.1f} words per sentence: expected at most {limits.average}"))
    parts = parts_of(text)
    long = {sentence.line: sentence for sentence in sorted([*simple_sentences(text), *sentences_in(parts)], key=lambda one: one.words)
            if sentence.words > limits.longest}
    bad += [(line, f'a sentence of {sentence.words} words: expected at most {limits.longest}: "{beginning(sentence)}"')
            for line, sentence in long.items()]
    bad += [(row.line, f'a table cell of {count_words(cell)} words: expected at most {limits.cell}: "{beginning(Block(row.line, cell))}"')
            for row in parts.rows for cell in cells_of(row) if count_words(cell) > limits.cell]
    bad += [(block.line, f'"{block.text}" is home-made: use the standard term') for block in found.home_made]
    return sorted(bad)


def report(name, found):
    return (f'{name}: {found.words} words, {found.average:.1f} per sentence, longest {found.longest.words} '
            f'(line {found.longest.line}: "{beginning(found.longest)}"), table cell {count_words(found.cell.text)}'
            + (f" (line {found.cell.line})" if found.cell.text else "")
            + (f", home-made {len(found.home_made)}" if found.home_made else ""))


def check(paths):
    bad = []
    for path in paths:
        text = path.read_text(encoding="utf-8")
        name = path.resolve()
        name = name.relative_to(ROOT) if name.is_relative_to(ROOT) else path
        print(report(name, measure(text)))
        bad += [f"{name}:{line}: {message}" for line, message in violations(text, limits_for(path.resolve(), text))]
    for message in bad:
        print(message)
    print(f"{len(paths)} files, {len(bad)} violations")
    return 1 if bad else 0


def private_words():
    """Yields FILE:LINE: WORD for each private word in the code."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    for name in listed:
        if name.endswith(CODE_FILES) and name != "tests/style.py":
            for number, line in enumerate((ROOT / name).read_text(encoding="utf-8", errors="replace").splitlines(), 1):
                for found in PRIVATE.finditer(line):
                    yield f"{name}:{number}: {found.group()}"


def tracked():
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode == 0 and listed.stdout:
        return [ROOT / line for line in listed.stdout.splitlines() if (ROOT / line).exists()]
    return sorted(path for path in ROOT.rglob("*.md") if not {"build", "node_modules"} & set(path.relative_to(ROOT).parts))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=pathlib.Path, metavar="FILE")
    options = parser.parse_args()
    result = check(options.files or tracked())
    if not options.files:
        for line in private_words():
            print(line)
    return result


if __name__ == "__main__":
    sys.exit(main())
