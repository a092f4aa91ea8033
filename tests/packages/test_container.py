#!/usr/bin/env python3
"""The container without a container engine: its root is assembled in a bare Debian by the instructions of the second stage
of deploy/Dockerfile, and started by chroot: as its user, with a read-only root, by its command.

Needs what test_packages.py needs; else it skips (77).
"""
import json
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

from bare_debian import ROOT, BareDebian, two_networks
from test_packages import build, reason_to_skip


def second_stage():
    """Returns {instruction: its last text} of the second stage of the Dockerfile."""
    text = (ROOT / "deploy/Dockerfile").read_text().replace("\\\n", " ")
    stage = re.split(r"^FROM ", text, flags=re.MULTILINE)[-1]
    return dict(line.split(" ", 1) for line in stage.splitlines()[1:] if re.match(r"[A-Z]+ ", line))


class Container(unittest.TestCase):
    def test_its_root_runs_read_only_and_without_root(self):
        image = second_stage()
        scratch = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        build(scratch / "packages", "0.1.0~test")
        with BareDebian(scratch / "bare/root") as self.root, two_networks() as (self.net, _):
            shutil.copytree(scratch / "packages", self.root.folder / "packages")
            self.root.must("sh", "-c", f"export {image['ARG']}; {image['RUN']}")
            self.user, self.env = image["USER"], dict([image["ENV"].split("=")])
            self.assertNotEqual(self.user, "root")
            self.own_command(image)

    def where(self):
        return {"user": self.user, "net": self.net, "env": self.env, "read_only": True}

    def own_command(self, image):
        probe = json.loads(re.search(r"CMD (\[.*\])", image["HEALTHCHECK"]).group(1))
        # The state folder is a volume.
        command = [word for word in json.loads(image["CMD"]) if word not in ("--state-dir", "/var/lib/palpate-slave")]
        with self.root.serving(*json.loads(image["ENTRYPOINT"]), *command, **self.where()):
            self.assertEqual(self.root.must(*probe, **self.where()), "SERVING\n")
            self.root.must("/usr/bin/palpate-master", "connect", "127.0.0.1:50051", "--duration", "1", **self.where())
        self.assertNotEqual(self.root.run(*probe, "--wait", "0.5", **self.where())[0], 0)
        self.assertNotEqual(self.root.run("touch", "/var/lib/palpate-slave/file", **self.where())[0], 0, "the root is read-only")


if __name__ == "__main__":
    why = reason_to_skip()
    if why:
        print(f"skipped: {why}")
        sys.exit(77)
    unittest.main(verbosity=2)
