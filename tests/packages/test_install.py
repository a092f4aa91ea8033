#!/usr/bin/env python3
"""deploy/install.sh with stand-ins for apt-get and sudo: its messages where it cannot install, and the password prompt
of sudo. Messages of deploy/certs and deploy/build.sh."""
import fcntl
import os
import pathlib
import select
import subprocess
import sys
import tempfile
import termios
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "e2e"))
from programs import BARE, PATIENCE, ROOT, run

INSTALL = ROOT / "deploy/install.sh"
QUESTION = b"[sudo] password for ada: "
SUDO = r"""#!/bin/bash
# The first call asks on the terminal; then the caller is root.
if [ ! -e "$FAKES/asked" ]; then
  printf '[sudo] password for ada: ' >/dev/tty
  read -r answer </dev/tty
  [ "$answer" = secret ] || exit 1
  touch "$FAKES/asked"
fi
FAKE_ID=0 exec "$@"
"""


class Install(unittest.TestCase):
    def setUp(self):
        self.fakes = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.fake("dpkg-query", "exit 1")  # no package is installed
        self.fake("id", 'echo "$FAKE_ID"')
        self.fake("apt-get", "sleep 1; echo pmstatus:cmake:50.0:Unpacking")

    def fake(self, name, script):
        path = self.fakes / name
        path.write_text(script if script.startswith("#!") else f"#!/bin/bash\n{script}\n")
        path.chmod(0o755)

    def environment(self, user):
        # A folder with the tools that the script calls, without sudo.
        tools = self.fakes / "tools"
        tools.mkdir(exist_ok=True)
        for tool in ("bash", "cat", "dirname", "env", "grep", "mktemp", "rm", "sleep", "touch", "tput", "true"):
            (tools / tool).exists() or (tools / tool).symlink_to(pathlib.Path("/usr/bin", tool))
        return {"PATH": f"{self.fakes}:{tools}", "LC_ALL": "C.UTF-8", "FAKE_ID": str(user), "FAKES": str(self.fakes), "TERM": "xterm"}

    def install(self, user=0, before=()):
        return subprocess.run([*before, INSTALL], env=self.environment(user), stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              timeout=PATIENCE, check=False)

    def refusal(self, **how):
        done = self.install(**how)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        return done.stderr.splitlines()[-1]

    def test_what_apt_could_not_do_is_explained(self):
        for says, expected in (
                ("E: Could not get lock /var/lib/dpkg/lock-frontend. It is held by process 7 (apt-get)", "another installation runs: wait"),
                ("E: dpkg was interrupted, you must manually run 'dpkg --configure -a' to correct the problem.", "Run: sudo dpkg --configure -a"),
                ("W: Failed to fetch http://packages.example/debian  Could not resolve 'packages.example'", "check the network"),
                ("E: Unable to locate package clang-16", "/etc/apt/sources.list")):
            self.fake("apt-get", f'[ "$LC_ALL" = C ] && echo "{says}"; [ "$1" = update ] || exit 100')
            with self.subTest(says=says):
                self.assertIn(expected, self.refusal())

    def test_without_sudo_the_command_for_root_is_printed(self):
        self.assertRegex(self.refusal(user=1000), r"Let root run: apt-get update && apt-get install -y .*clang-[0-9]+ cmake")

    def on(self, system, version):
        """Returns the words before a command that let it see another system."""
        release = self.fakes / "os-release"
        release.write_text(f'ID={system}\nVERSION_ID="{version}"\n')
        mount = ["/usr/bin/unshare", "--user", "--map-root-user", "--mount", "/usr/bin/bash", "-c",
                 '/usr/bin/mount --bind "$0" "$(/usr/bin/realpath /etc/os-release)" || exit 77; exec "$1"', release]
        if subprocess.run([*mount, "/bin/true"], capture_output=True, check=False).returncode != 0:
            self.skipTest("no mounts in a namespace")
        return mount

    def test_another_distribution_is_named_with_what_was_tried(self):
        self.assertRegex(self.refusal(before=self.on("fedora", "40")), "this system is 'fedora 40': expected Debian 12 or 13.*--no-install")

    def test_the_compiler_is_that_of_the_system(self):
        self.fake("apt-get", '[ "$1" = update ] || { echo "asked for $*"; exit 100; }')
        for system, version, compiler in (("debian", "12", "clang-16"), ("debian", "13", "clang-19"), ("ubuntu", "24.04", "clang-18")):
            with self.subTest(system=system, version=version):
                done = self.install(before=self.on(system, version))
                self.assertRegex(done.stderr, f"asked for install .* {compiler} cmake")
                self.assertEqual("not tried on this system" in done.stdout, system != "debian")

    def test_the_question_of_sudo_stays_until_it_is_answered(self):
        self.fake("sudo", SUDO)
        ours, its = os.openpty()

        def own_it():
            os.setsid()
            fcntl.ioctl(its, termios.TIOCSCTTY, 0)

        process = subprocess.Popen([INSTALL], env=self.environment(1000), stdin=its, stdout=its, stderr=its, preexec_fn=own_it)
        self.addCleanup(process.kill)
        os.close(its)
        printed = b""
        while QUESTION not in printed:
            printed += os.read(ours, 4096)
        person_thinks = time.monotonic() + 2.5
        while (left := person_thinks - time.monotonic()) > 0:
            if select.select([ours], [], [], left)[0]:
                printed += os.read(ours, 4096)
        self.assertTrue(printed.endswith(QUESTION), printed)
        os.write(ours, b"secret\n")
        try:
            while part := os.read(ours, 4096):
                printed += part
        except OSError:  # the other side of the terminal is closed
            pass
        self.assertEqual(process.wait(timeout=PATIENCE), 0, printed)
        self.assertRegex(printed, rb"install: \d+ packages and their dependencies, in \d+ s")


class Scripts(unittest.TestCase):
    def test_a_ca_whose_making_was_interrupted_is_made_again(self):
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        interrupted = folder / "openssl"
        interrupted.write_text("#!/bin/sh\nwhile [ $# -gt 0 ]; do [ \"$1\" = -keyout ] && : >\"$2\"; shift; done\nkill -KILL 0\n")
        interrupted.chmod(0o700)
        command = [ROOT / "deploy/certs", "ca", folder / "ca"]
        killed = run(*command, env={**BARE, "PATH": f"{folder}:{BARE['PATH']}"}, start_new_session=True)
        self.assertLess(killed.returncode, 0)
        again = run(*command)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertIn("exists", run(*command).stderr)

    def test_a_build_without_an_argument_prints_its_usage(self):
        done = run(ROOT / "deploy/build.sh")
        self.assertEqual(done.returncode, 2)
        self.assertIn("build.sh", done.stderr)
        self.assertNotIn("unbound", done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
