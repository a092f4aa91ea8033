#!/usr/bin/env python3
"""The container without a container engine: its root is assembled in a bare Debian by the instructions of the second stage
of deploy/Dockerfile, and started by chroot: as its user, with a read-only root, by its command and by those of the compose file.

Needs what test_packages.py needs, and python3-yaml; else it skips (77).
"""
import json
import pathlib
import re
import shutil
import sys
import tempfile
import time
import unittest

from bare_debian import ROOT, BareDebian, two_networks
from test_packages import build, reason_to_skip


def second_stage():
    """Returns {instruction: its last text} of the second stage of the Dockerfile."""
    text = (ROOT / "deploy/Dockerfile").read_text().replace("\\\n", " ")
    stage = re.split(r"^FROM ", text, flags=re.MULTILINE)[-1]
    return dict(line.split(" ", 1) for line in stage.splitlines()[1:] if re.match(r"[A-Z]+ ", line))


class Container(unittest.TestCase):
    def test_its_root_runs_read_only_without_root_and_with_the_compose_file(self):
        image = second_stage()
        compose = yaml.safe_load((ROOT / "deploy/monitoring/compose.yaml").read_text())["services"]
        scratch = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        build(scratch / "packages", "0.1.0~test")
        with BareDebian(scratch / "bare/root") as self.root, two_networks() as (self.net, _):
            shutil.copytree(scratch / "packages", self.root.folder / "packages")
            self.root.must("sh", "-c", f"export {image['ARG']}; {image['RUN']}")
            self.user, self.env = image["USER"], dict([image["ENV"].split("=")])
            self.assertNotEqual(self.user, "root")
            with self.subTest("by its own command"):
                self.own_command(image)
            with self.subTest("by the compose file"):
                self.composed(compose, json.loads(image["ENTRYPOINT"]))

    def where(self, read_only=True):
        return {"user": self.user, "net": self.net, "env": self.env, "read_only": read_only}

    def own_command(self, image):
        probe = json.loads(re.search(r"CMD (\[.*\])", image["HEALTHCHECK"]).group(1))
        # The state folder is a volume.
        command = [word for word in json.loads(image["CMD"]) if word not in ("--state-dir", "/var/lib/palpate-slave")]
        with self.root.serving(*json.loads(image["ENTRYPOINT"]), *command, **self.where()):
            self.assertEqual(self.root.must(*probe, **self.where()), "SERVING\n")
        self.assertNotEqual(self.root.run(*probe, "--wait", "0.5", **self.where())[0], 0)
        self.assertNotEqual(self.root.run("touch", "/var/lib/palpate-slave/file", **self.where())[0], 0, "the root is read-only")

    def composed(self, compose, entrypoint):
        certs, slave, master = (compose[name] for name in ("certs", "slave", "master"))
        self.assertTrue(all(service["read_only"] for service in (certs, slave, master)))
        (self.root.folder / "etc/hosts").write_text("127.0.0.1 localhost slave\n")
        # Volumes are folders of the root that belong to the user and are writable.
        self.root.must(*certs["entrypoint"], *certs["command"], **self.where(read_only=False))
        with self.root.serving(*entrypoint, *slave["command"], **self.where(read_only=False)):
            self.assertEqual(self.root.must(*slave["healthcheck"]["test"][1:], **self.where()), "SERVING\n")
            with self.root.started(*master["entrypoint"], *master["command"], **self.where()) as process:
                page = self.metrics("127.0.0.1:9465")
                self.assertIn("palpate_master_connected 1", page)
                self.assertIn("palpate_slave_info", self.metrics("127.0.0.1:9464"))
                self.assertIsNone(process.poll(), "the master serves its page until it is stopped")

    def metrics(self, address):
        host, port = address.split(":")
        for _ in range(100):
            code, page = self.root.run("bash", "-c", f"exec 3<>/dev/tcp/{host}/{port}; printf 'GET /metrics HTTP/1.0\\r\\n\\r\\n' >&3; cat <&3",
                                       **self.where())
            if code == 0 and "connected 0" not in page:
                return page
            time.sleep(0.1)
        raise AssertionError(f"{address}: {page}")


if __name__ == "__main__":
    why = reason_to_skip()
    try:
        import yaml
    except ImportError:
        why = "needs python3-yaml"
    if why:
        print(f"skipped: {why}")
        sys.exit(77)
    unittest.main(verbosity=2)
