#!/usr/bin/python3
"""Runs a campaign: prints a row for each case, then the totals with their 95 % intervals (Wilson).

usage: tests/campaigns/run.py NAME [--seed N] [--count N] [--only WORDS] [--jobs N] [options of the campaign]
       tests/campaigns/run.py NAME --help
       tests/campaigns/run.py --list

Exit codes: 0 the demands of the campaign are met; 1 one is not; 2 unusable arguments; 77 nothing to run here.
Programs: PALPATE_BIN, default build/release/bin.
"""
import importlib
import os
import pathlib
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # threads of BLAS wait by spinning
import campaign  # noqa: E402

NAMES = {path.stem for path in pathlib.Path(__file__).parent.glob("*.py")} - {"run", "campaign", "runners", "cells", "draw", "test_campaign"}


def main():
    name, *arguments = sys.argv[1:] or ["--help"]
    if name == "--list":
        for one in sorted(NAMES):
            print(f"{one:16}{importlib.import_module(one).__doc__.splitlines()[0]}")
        return 0
    if name not in NAMES:
        print(__doc__, file=sys.stderr)
        return 2
    return campaign.run(name, importlib.import_module(name), arguments)


if __name__ == "__main__":
    sys.exit(main())
