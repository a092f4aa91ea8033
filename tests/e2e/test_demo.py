"""deploy/demo.sh and palpate-demo work in a folder whose name has spaces, quotes and umlauts. The programs are
stand-ins that accept the options of the real ones."""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import unittest

from programs import BARE, MASTER, PATIENCE, ROOT, SIMULATOR, SLAVE, run

FOLDER = "Ada's \"Versuche\" über Öl, 1"
AS_SLAVE = r"""
case $1 in
  check) [ -f "$2" ] && echo "plan of $2" ;;
  process) [ -f "$2" ] && mkdir -p "${@: -1}" && echo "offline in ${@: -1}" ;;
  serve) [ -f "$2" ] && echo "info $2 with 90 elements" >&2 && echo "listening on 127.0.0.1:9" && trap "kill %1; exit 0" TERM && { sleep 600 & wait; } ;;
esac
"""
# As the real one it takes SIGINT also where bash has made it ignored, in background programs.
AS_SIMULATOR = r"""
[ -f "$1" ] && exec /usr/bin/python3 -c '
import signal
ends = {signal.SIGINT, signal.SIGTERM}
signal.pthread_sigmask(signal.SIG_BLOCK, ends)
print("streaming to 127.0.0.1:9", flush=True)
signal.sigwait(ends)'
"""
AS_MASTER = r"""
while [ $# -gt 0 ]; do
  case $1 in
    --report) printf '"force_error_delay_compensated": {\n  "relative_rms": 0.01\n}\n' >"$2" ;;
    --log) echo t >"$2" ;;
    playback:*) [ -f "${1#playback:}" ] || exit 1 ;;
    --view) trap "kill %1; sleep 0.3; exit 0" INT; echo "view at here"; sleep 600 & wait ;;
  esac
  shift
done
"""
INSERTION = r"""#!/bin/bash
[ -d "$2" ] && [ "$1" != hand ] || touch "$4"
"""


def stand_in(text, program, *commands):
    """Returns `text` as a script that rejects options which `program` does not have."""
    options = {option for command in commands for option in re.findall(r"--[a-z][a-z-]*", run(program, *command, "--help").stdout)}
    return f"""#!/bin/bash
for word in "$@"; do
  case $word in
    {"|".join(sorted(options))}) ;;
    --*) echo "unknown option $word" >&2; exit 2 ;;
  esac
done
{text}"""


class Demo(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / FOLDER
        deploy, self.bin = self.root / "deploy", self.root / "build/release/bin"
        deploy.mkdir(parents=True)
        self.bin.mkdir(parents=True)
        for name in ("demo.sh", "palpate-demo", "progress.sh"):
            shutil.copy(ROOT / "deploy" / name, deploy)
        shutil.copytree(ROOT / "deploy/scenes", deploy / "scenes")
        (self.bin / "palpate-demo").symlink_to(deploy / "palpate-demo")
        programs = {self.bin / "palpate-slave": stand_in(AS_SLAVE, SLAVE, ["check"], ["process"], ["serve"]),
                    self.bin / "palpate-simulator": stand_in(AS_SIMULATOR, SIMULATOR, []),
                    self.bin / "palpate-master": stand_in(AS_MASTER, MASTER, ["connect"]),
                    deploy / "insertion.py": INSERTION, deploy / "install.sh": "#!/bin/sh\n", deploy / "build.sh": "#!/bin/sh\n"}
        for path, text in programs.items():
            path.write_text(text)
            path.chmod(0o755)

    def demo(self, *command, folder):
        done = subprocess.run([str(word) for word in command], cwd=folder, env=BARE, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              timeout=PATIENCE, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        return done.stdout

    def test_the_command_of_the_readme_runs_in_any_clone(self):
        for scene in ("silicone-block", "foam-cube", "zebrafish-embryo"):
            with self.subTest(scene=scene):
                printed = self.demo(self.root / "deploy/demo.sh", "--scene", scene, folder="/")
                self.assertIn(f"plan of {self.root}/deploy/scenes/{scene}.yaml", printed)
                self.assertIn("results of the insertion" if scene == "zebrafish-embryo" else "== passed", printed)
                self.assertTrue((self.root / "build/demo/log.csv").exists())

    def test_ctrl_c_is_the_end_of_a_view(self):
        with subprocess.Popen([self.bin / "palpate-demo", "--view"], cwd=self.root, env=BARE, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, start_new_session=True) as demo:
            while "view at here" not in demo.stdout.readline():
                self.assertIsNone(demo.poll())
            os.killpg(demo.pid, signal.SIGINT)
            _, errors = demo.communicate(timeout=PATIENCE)
        self.assertEqual((demo.returncode, errors), (0, ""))

    def test_it_builds_without_installing(self):
        (self.root / "deploy/install.sh").write_text("#!/bin/sh\nexit 1\n")
        demo = self.root / "deploy/demo.sh"
        self.assertIn("== passed", self.demo(demo, "--no-install", folder="/"))
        self.assertIn("--no-install", self.demo(demo, "--help", folder="/"))
        self.assertNotIn("--no-install", self.demo(self.bin / "palpate-demo", "--help", folder="/"))

    def test_it_starts_in_any_folder(self):
        self.assertIn("== passed", self.demo("./palpate-demo", folder=self.bin))
        self.assertTrue((self.bin / "demo/report.json").exists())
        self.assertIn("== passed", self.demo(self.bin / "palpate-demo", folder=self.root))


if __name__ == "__main__":
    unittest.main(verbosity=2)
