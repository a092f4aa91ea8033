"""Compares measured with estimated forces of a file: python3 -m palpate.verify FILE [FILE OF THE ESTIMATE]

  python3 -m palpate.verify forces.csv --measured Fz --estimated pred --measured-unit g
  python3 -m palpate.verify run.mcap --measured /ft_sensor/wrench --estimated /palpate/wrench
  python3 -m palpate.verify sensor_bag/ estimate.mcap --html card.html

FILE is
  CSV      one row per instant with both forces, below a header with the names of the columns. A unit in brackets behind a name,
           "Fz [N]", is no part of the name, and converts the column
  Parquet  the same, where pyarrow is installed
  MCAP, a database .db3 or a folder of rosbag2: topics of WrenchStamped, Wrench or ContactWrench. --measured and --estimated
           name the topics; they may be left out where FILE has one each. The topics are joined by time: the measured force is
           linear between its messages.

Prints a table of verdicts and what is likely wrong. Exit code 0: all that was tested is right; 1: something is wrong or not
decided; 2: the file cannot be used.
"""
from __future__ import annotations

import argparse
import html
import json
import pathlib
import sys
import tempfile
from typing import Any

from palpate.comparison import Comparison, verify_forces, verify_table
from palpate.wrench_topics import Forces, is_bag, join, read_topics

COLUMNS = {
    "measured": "columns of the measured force along x, y, z: A,B,C, with - for none; one name is z. Of a bag a topic",
    "estimated": "the same of the estimated force",
    "time": "column of the time, default t. Without one the rows are taken in their order",
    "sigma": "column of the standard deviation, in the unit of the estimate, default sigma",
    "validity": "column of the validity: valid, 1 or true; default validity",
    "measured_unit": "unit of the measured force, default N; g is the weight of a gram",
    "estimated_unit": "unit of the estimated force, default N",
    "time_unit": "unit of the time, default s",
}
PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title><style>
body {{ font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em }}
table {{ border-collapse: collapse }} td, th {{ text-align: left; padding: .3em 1em .3em 0; border-bottom: 1px solid #ccc }}
.right {{ color: #17662e }} .wrong {{ color: #b00020; font-weight: bold }}
</style></head><body><h1>{title}</h1>
{cards}<p>{version}</p></body></html>
"""


def page_of(comparison: Comparison) -> str:
    """Returns the report as one self-contained HTML page."""
    report = comparison.report
    cards = []
    for card in report["cards"]:
        name = f"Fingertip {card['finger']}" if card["finger"] else "Tool"
        rows = "".join(f"<tr><td>{html.escape(key)}</td><td class=\"{html.escape(line['verdict'].split()[0])}\">"
                       f"{html.escape(line['verdict'])}</td><td>{html.escape(line['text'] or line['remark'])}</td></tr>\n"
                       for key, line in card["lines"].items())
        causes = "".join(f"<li>{html.escape(cause)}</li>\n" for cause in card["likely_wrong"])
        cards.append(f"<h2>{html.escape(name)}: {'passes' if card['passes'] else 'does not pass'}, {card['states']} states under "
                     f"load</h2>\n<table><tr><th>quantity</th><th>verdict</th><th>value, with its interval of 95 %</th></tr>\n{rows}"
                     f"</table>\n" + (f"<h3>Likely wrong</h3><ul>{causes}</ul>\n" if causes else ""))
    return PAGE.format(title=html.escape(f"Forces of {report['source']}"), cards="\n".join(cards),
                       version=html.escape(f"Palpate {report['version']}"))


def compare(files: list[pathlib.Path], columns: dict[str, str]) -> Comparison:
    """Compares the forces of a table, or the topics of one or two bags. Raises ValueError."""
    for file in files:
        if not file.exists():
            raise ValueError(f"{file}: no such file")
    if len(files) == 1 and not is_bag(files[0]):
        if files[0].suffix == ".parquet":
            return _of_parquet(files[0], columns)
        return verify_table(files[0], **columns)
    foreign = [f"--{name.replace('_', '-')}" for name in columns if name not in ("measured", "estimated")]
    if foreign:
        raise ValueError(f"{foreign[0]}: expected with a table only; a wrench is in newtons and has its own time")
    measured = _topic(files[0], columns.get("measured"), "--measured", columns.get("estimated") if len(files) == 1 else None)
    estimated = _topic(files[-1], columns.get("estimated"), "--estimated", measured.topic if len(files) == 1 else None)
    if measured.frame != estimated.frame:
        print(f"frames {measured.frame or '(none)'} and {estimated.frame or '(none)'}: the forces are compared as they are",
              file=sys.stderr)
    joined = join(measured, estimated)
    return verify_forces(**joined, source=" and ".join(dict.fromkeys(file.name for file in files)))


def _topic(file: pathlib.Path, wanted: str | None, option: str, other: str | None) -> Forces:
    if not is_bag(file):
        raise ValueError(f"{file}: expected MCAP or rosbag2, as the other file")
    topics = read_topics(file)
    if wanted is not None:
        if wanted in topics:
            return topics[wanted]
        raise ValueError(f"{option} = {wanted}: expected a topic of {file}: {', '.join(topics)}")
    left = [topic for topic in topics if topic != other]
    if len(left) != 1:
        raise ValueError(f"{option} = (missing): expected a topic of {file}: {', '.join(topics)}")
    return topics[left[0]]


def _of_parquet(file: pathlib.Path, columns: dict[str, str]) -> Comparison:
    """Converts Parquet to CSV, so that names and units are read by the same code."""
    try:
        from pyarrow import csv, parquet
    except ImportError:
        raise ValueError(f"{file}: pyarrow, which reads Parquet, is not installed: expected CSV") from None
    with tempfile.TemporaryDirectory(prefix="palpate-") as folder:
        table = pathlib.Path(folder) / f"{file.stem}.csv"
        csv.write_csv(parquet.read_table(file), table)
        return verify_table(table, **columns)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="palpate.verify", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=pathlib.Path, metavar="FILE", help="one file, or the measured and the estimated one")
    for name, meaning in COLUMNS.items():
        parser.add_argument(f"--{name.replace('_', '-')}", metavar="UNIT" if name.endswith("unit") else "NAME", help=meaning)
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write the report as JSON")
    parser.add_argument("--html", type=pathlib.Path, metavar="FILE", help="write the report as one page")
    options = parser.parse_args(arguments)
    if len(options.files) > 2:
        parser.error("expected one file, or the measured and the estimated one")
    columns: dict[str, Any] = {name: getattr(options, name) for name in COLUMNS if getattr(options, name) is not None}
    try:
        comparison = compare(options.files, columns)
        for out, text in ((options.json, json.dumps(comparison.report, indent=2) + "\n"), (options.html, page_of(comparison))):
            if out is not None:
                out.write_text(text, encoding="utf-8")
    except (OSError, ValueError) as error:
        print(f"palpate.verify: {error}", file=sys.stderr)
        return 2
    print(comparison.text, end="")
    return 0 if comparison.passes else 1


if __name__ == "__main__":
    sys.exit(main())
