#!/usr/bin/env python3
"""Keeps what a release promises, for test_release.py: keep.py VERSION

Writes tests/release/VERSION: descriptors.binpb, the messages and services of proto/palpate/v1; slave.mcap.xz and session.mcap.xz, what
both programs recorded of one contact of a simulated fingertip; kept.json, what this release finds in them.
Programs: PALPATE_BIN, default build/release/bin.
"""
import json
import lzma
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "e2e"))
from programs import MASTER, ROOT, SLAVE, Slave, run

from found import in_session, in_slave


def write_descriptors(file):
    protos = sorted((ROOT / "proto/palpate/v1").glob("*.proto"))
    subprocess.run(["protoc", f"-I{ROOT / 'proto'}", "--include_imports", f"--descriptor_set_out={file}", *map(str, protos)], check=True)


def record(folder):
    """One contact, 5 mm deep, after the baseline of the fingertip."""
    shutil.copytree(ROOT / "deploy/scenes", folder / "scenes")
    shutil.copytree(ROOT / "deploy/fingertips", folder / "fingertips")
    with Slave(folder / "scenes/foam-bar.yaml", "--record", folder / "slave.mcap") as slave:
        time.sleep(1)
        done = run(MASTER, "connect", slave.address, "--duration", "5", "--record", folder / "session.mcap")
        if done.returncode != 0:
            sys.exit(done.stderr)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    out = HERE / sys.argv[1]
    out.mkdir(exist_ok=True)
    write_descriptors(out / "descriptors.binpb")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        record(folder)
        kept = {"slave": in_slave(folder / "slave.mcap"), "session": in_session(folder / "session.mcap")}
        for file in ("slave.mcap", "session.mcap"):
            (out / f"{file}.xz").write_bytes(lzma.compress((folder / file).read_bytes(), preset=9))
    (out / "kept.json").write_text(json.dumps(kept, indent=1) + "\n")
    print(json.dumps(kept))


if __name__ == "__main__":
    main()
