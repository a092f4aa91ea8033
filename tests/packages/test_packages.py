#!/usr/bin/env python3
"""Installs, runs, upgrades and removes the Debian packages in a minimal Debian, as a laboratory engineer would.

Needs root, debootstrap, lintian, network namespaces and a Debian archive; else it skips (77). PALPATE_BIN: the built programs.
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from bare_debian import BIN, ROOT, BareDebian, must, processor_seconds, two_networks

OLD, NEW = "0.1.0~test1", "0.1.0~test2"
PROGRAMS = ("palpate-slave", "palpate-master")


def build(folder, version):
    must(ROOT / "deploy/package.sh", "--built", "--version", version, "--out", folder)


def package(folder, name):
    return next(folder.glob(f"{name}_*.deb"))


def change_conffile(deb, name):
    """Changes /etc/palpate/NAME in a package, as a later release may do."""
    with tempfile.TemporaryDirectory() as folder:
        must("dpkg-deb", "-R", deb, folder)
        with open(pathlib.Path(folder, "etc/palpate", name), "a") as file:
            file.write("# another line of the new release\n")
        must("dpkg-deb", "--root-owner-group", "-Zgzip", "-b", folder, deb)


class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.old, cls.new = cls.scratch / "old", cls.scratch / "new"
        cls.old.mkdir()
        (cls.old / "measurements.csv").write_text("1,2\n")
        build(cls.old, OLD)
        build(cls.new, NEW)

    def test_what_was_in_the_folder_of_the_packages_stays(self):
        self.assertEqual((self.old / "measurements.csv").read_text(), "1,2\n")

    def test_lintian_reports_no_errors(self):
        reported = must("lintian", "--fail-on", "error", "--tag-display-limit", "0", *sorted(self.new.glob("*.deb")))
        print(reported)

    def test_sums_and_bill_of_materials_name_every_package(self):
        must("sha256sum", "--check", "SHA256SUMS", cwd=self.new)
        bill = json.loads((self.new / f"palpate_{NEW}.cdx.json").read_text())
        by_name = {each["name"]: each for each in bill["components"]}
        for deb in self.new.glob("*.deb"):
            reported = by_name[deb.name.split("_")[0]]
            self.assertEqual(reported["hashes"][0]["content"], must("sha256sum", deb).split()[0])
        # A loaded, a header-only and an npm library.
        for name in ("libgrpc++1.51", "libopencv-core406", "libc6", "libeigen3-dev", "three"):
            self.assertTrue(by_name[name]["version"], name)
        loaded = must("ldd", BIN / "palpate-slave")
        for library in re.findall(r"=> (/\S+)", loaded):
            owner = subprocess.run(["dpkg", "-S", os.path.realpath(library)], capture_output=True, text=True, check=False).stdout
            if owner:
                self.assertIn(owner.split(":")[0], by_name, f"{library} is loaded and not in the bill")

    def test_a_client_in_cpp_builds_against_palpate_dev_alone(self):
        prefix = self.scratch / "dev"
        must("dpkg-deb", "-x", package(self.new, "palpate-dev"), prefix)
        # The files that the package installs into /usr are relocated for the test.
        must("cmake", "-S", ROOT / "tests/packages/client", "-B", self.scratch / "client", f"-DCMAKE_PREFIX_PATH={prefix}/usr",
             "-DCMAKE_CXX_COMPILER=g++")
        must("cmake", "--build", self.scratch / "client")
        with subprocess.Popen([BIN / "palpate-slave", "serve", ROOT / "deploy/scenes/silicone-block.yaml", "--listen", "127.0.0.1:0"],
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as slave:
            address = slave.stdout.readline().removeprefix("listening on ").strip()
            reported = must(self.scratch / "client/client", address)
            slave.terminate()
        self.assertRegex(reported, r"^silicone-block: 50 states, the last with validity \d")

    def test_installed_run_upgraded_and_removed_in_a_bare_debian(self):
        with BareDebian(self.scratch / "bare/root") as debian, two_networks() as (slave_net, master_net):
            self.assertNotEqual(debian.run("sh", "-c", "command -v cc c++ gcc g++ clang python3")[0], 0, "no compiler, no Python")
            for name in ("old", "new"):
                shutil.copytree(getattr(self, name), debian.folder / "srv" / name)
            debian.must("apt-get", "update")
            self.install_and_demo(debian)
            self.service(debian)
            self.two_networks(debian, slave_net, master_net)
            self.python(debian)
            self.upgrade(debian)
            self.removal(debian)

    def install(self, debian, folder, *names, options=()):
        return debian.must("sh", "-c", "apt-get install -y " + " ".join([*options, *(f"/srv/{folder}/{name}_*.deb" for name in names)]))

    def install_and_demo(self, debian):
        self.assertEqual(debian.palpate_files(), [])
        before = processor_seconds()
        self.install(debian, "old", "palpate-slave")
        code, reported = debian.run("palpate-slave", "demo")
        self.assertEqual(code, 1)
        self.assertIn("apt install palpate-master", reported)
        self.install(debian, "old", *PROGRAMS)
        installed = processor_seconds()
        reported = debian.must("palpate-slave", "demo", "--out", "/tmp/demo")
        self.assertRegex(reported, r"== passed: force error \d+\.\d % of the peak")
        report = json.loads((debian.folder / "tmp/demo/report.json").read_text())
        self.assertGreater(report["force_peak_N"], 1.5)  # a 5 mm press has 2.37 N, see tests/e2e
        print(f"processor time: {installed - before:.0f} s to install, {processor_seconds() - installed:.0f} s for the demo")
        complete = "source /usr/share/bash-completion/completions/palpate-slave; COMP_CWORD=$0 COMP_WORDS=(\"$@\"); _palpate_slave; echo ${COMPREPLY[*]}"
        self.assertEqual(debian.must("bash", "-c", complete, "1", "palpate-slave", "he"), "health\n")
        self.assertEqual(debian.must("bash", "-c", complete, "2", "palpate-slave", "health", "--w"), "--wait\n")
        self.assertIn("COMMANDS", debian.must("sh", "-c", "gzip -dc /usr/share/man/man1/palpate-slave.1.gz"))

    def unit_command(self, debian, unit="system/palpate-slave"):
        """Returns the unit's command line with the values of its configuration file."""
        text = (debian.folder / f"usr/lib/systemd/{unit}.service").read_text()
        file = re.search(r"^EnvironmentFile=-(/\S+)$", text, re.MULTILINE).group(1)
        command = re.search(r"^ExecStart=(.*)$", text, re.MULTILINE).group(1)
        return ["sh", "-c", f". {file}; exec {command}"]

    def service(self, debian):
        with debian.serving(*self.unit_command(debian), user="palpate") as address:
            self.assertEqual(address, "127.0.0.1:50051")
            self.assertEqual(debian.must("palpate-slave", "health", user="palpate"), "SERVING\n")
            reported = debian.must("timeout", "--preserve-status", "4", *self.unit_command(debian, "user/palpate-master"), user="palpate")
            self.assertIn("connected to 127.0.0.1:50051", reported)
            self.assertIn("http://127.0.0.1:8080", reported)
        code, reported = debian.run("palpate-slave", "health", "--wait", "0.5")
        self.assertEqual(code, 1, "nobody serves any more")
        self.assertIn("127.0.0.1:50051", reported)

    def two_networks(self, debian, slave_net, master_net):
        debian.must("sh", "-c", "cd /srv && palpate-certs ca ca && palpate-certs slave ca /etc/palpate/tls lab-slave 10.77.0.1 && "
                    "palpate-certs operator ca operator ada && chown -R palpate /etc/palpate/tls && "
                    "sed -i 's#^LISTEN=.*#LISTEN=10.77.0.1:50051#; s#^OPTIONS=.*#OPTIONS=\"--tls /etc/palpate/tls\"#' /etc/palpate/slave.conf")
        with debian.serving(*self.unit_command(debian), user="palpate", net=slave_net):
            health = ("palpate-slave", "health", "10.77.0.1:50051")
            self.assertEqual(debian.must(*health, "--tls", "/srv/operator", net=master_net), "SERVING\n")
            self.assertEqual(debian.run(*health, "--insecure", "--wait", "2", net=master_net)[0], 1, "plain text is refused")
            debian.must("palpate-master", "connect", "10.77.0.1:50051", "--tls", "/srv/operator", "--duration", "5",
                        "--report", "/tmp/tls.json", net=master_net)
        report = json.loads((debian.folder / "tmp/tls.json").read_text())
        self.assertGreater(report["force_peak_N"], 1.5)
        self.assertGreater(report["states"], 100)

    def python(self, debian):
        self.install(debian, "old", "python3-palpate")
        # The Python lines of the README need no slave.
        lines = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.S)[0]
        self.assertRegex(debian.must("python3", "-c", lines), r"\] valid\n$")
        debian.must("python3", "-m", "palpate.verify", "--help")
        with debian.serving("palpate-slave", "serve", "/usr/share/palpate/scenes/silicone-block.yaml", "--listen", "127.0.0.1:0") as address:
            debian.must("python3", "-c", f"import palpate\nwith palpate.connect('{address}') as slave:\n"
                        "    print(next(iter(slave.states(seconds=10))).message.sequence)")

    def upgrade(self, debian):
        conf = debian.folder / "etc/palpate/slave.conf"
        kept = conf.read_text()
        change_conffile(package(debian.folder / "srv/new", "palpate-slave"), "slave.conf")
        keep = ("-o", "Dpkg::Options::=--force-confdef", "-o", "Dpkg::Options::=--force-confold")
        self.install(debian, "new", *PROGRAMS, "python3-palpate", options=keep)
        for name in (*PROGRAMS, "python3-palpate"):
            self.assertEqual(debian.must("dpkg-query", "-W", "-f", "${Version}", name), NEW)
        self.assertEqual(conf.read_text(), kept)
        self.assertIn("another line", (debian.folder / "etc/palpate/slave.conf.dpkg-dist").read_text())
        self.assertNotIn("another line", (debian.folder / "etc/palpate/master.conf").read_text())
        debian.must("sh", "-c", "palpate-slave check /usr/share/palpate/scenes/silicone-block.yaml >/dev/null")

    def removal(self, debian):
        state = debian.folder / "var/lib/palpate-slave"
        state.mkdir()
        (state / "stop").touch()
        shutil.rmtree(debian.folder / "srv")
        shutil.rmtree(debian.folder / "tmp/demo")
        debian.must("apt-get", "remove", "-y", *PROGRAMS, "python3-palpate")
        own = [f"/etc/palpate/tls/{name}.pem" for name in ("ca", "cert", "key")]
        kept = ["/etc/palpate", "/etc/palpate/tls", *own, *(f"/etc/palpate/{name}" for name in ("master.conf", "slave.conf", "slave.conf.dpkg-dist"))]
        self.assertEqual([file for file in debian.palpate_files() if not file.startswith("/var/lib/palpate-slave")], sorted(kept),
                         "configuration files stay, and nothing else")
        debian.must("apt-get", "purge", "-y", *PROGRAMS)
        self.assertEqual(debian.palpate_files(), sorted(["/etc/palpate", "/etc/palpate/tls", *own]), "a purge leaves only what the engineer made")


def reason_to_skip():
    if os.geteuid() != 0:
        return "needs root"
    for tool in ("debootstrap", "lintian", "ip", "cpack"):
        if not shutil.which(tool):
            return f"needs {tool}"
    if subprocess.run(["ip", "netns", "add", f"palpate-probe-{os.getpid()}"], capture_output=True, check=False).returncode:
        return "network namespaces are not permitted here"
    subprocess.run(["ip", "netns", "delete", f"palpate-probe-{os.getpid()}"], check=False)
    return None


if __name__ == "__main__":
    why = reason_to_skip()
    if why:
        print(f"skipped: {why}")
        sys.exit(77)
    unittest.main(verbosity=2)
