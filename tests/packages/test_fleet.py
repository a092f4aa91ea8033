#!/usr/bin/env python3
"""Fleets: runs the commands of the Kubernetes manifests as the containers do, and ten slaves by the systemd
template."""
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "e2e"))
from programs import BARE, BLOCK, MASTER, ROOT, SLAVE, Slave, run, wait_until

MANIFESTS = ROOT / "deploy/fleet/kubernetes.yaml"
UNIT = ROOT / "deploy/palpate-slave.service"
ROBOTS = [f"robot{i:02}" for i in range(1, 11)]


class Manifests(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        try:
            import yaml
        except ImportError:
            raise unittest.SkipTest("no python3-yaml (deploy/install.sh tests)") from None
        cls.documents = list(yaml.safe_load_all(MANIFESTS.read_text()))

    def test_the_manifests_are_of_one_namespace(self):
        kinds = [(document["apiVersion"], document["kind"]) for document in self.documents]
        self.assertEqual(kinds, [("v1", "Namespace"), ("apps/v1", "DaemonSet"), ("apps/v1", "Deployment")])
        self.assertEqual({document["metadata"]["namespace"] for document in self.documents[1:]}, {self.documents[0]["metadata"]["name"]})

    def test_mounts_and_selectors_name_what_there_is(self):
        for document in self.documents[1:]:
            spec = document["spec"]
            pod = spec["template"]["spec"]
            labels = spec["template"]["metadata"]["labels"]
            self.assertLessEqual(spec["selector"]["matchLabels"].items(), labels.items())
            volumes = {volume["name"] for volume in pod["volumes"]}
            mounted = {mount["name"] for container in pod["initContainers"] + pod["containers"] for mount in container["volumeMounts"]}
            self.assertEqual(mounted, volumes)

    def containers(self, kind):
        """Returns {name: container} of one document."""
        pod = next(document for document in self.documents if document["kind"] == kind)["spec"]["template"]["spec"]
        return {container["name"]: container for container in pod["initContainers"] + pod["containers"]}

    def test_the_commands_serve_probe_and_operate(self):
        """Mounts are folders of the test; the network is that of this machine."""
        scratch = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        certs = ROOT / "deploy/certs"
        run(certs, "ca", scratch / "ca")
        run(certs, "slave", scratch / "ca", scratch / "slave", "robots", "127.0.0.1", "robot01", "localhost")
        for role in ("observer", "operator"):
            run(certs, role, scratch / "ca", scratch / role, role)
        (scratch / "etc").mkdir()
        (scratch / "state").mkdir()
        shutil.copy(BLOCK, scratch / "etc/scene.yaml")

        def words(container, program, secret, **changed):
            """Returns the command line of a container whose mounts are in `scratch`."""
            text = [*container.get("command", [program]), *container.get("args", [])]
            mounts = {"/etc/palpate": "etc", "/var/lib/palpate-slave": "state", "/secret": secret, "/tls": f"tls-{secret}", "/probe-tls": "tls-observer"}
            places = {"/usr/bin/palpate-slave": SLAVE, "/usr/bin/palpate-master": MASTER, **changed}
            for mount in container["volumeMounts"]:
                place = mounts.get(mount["mountPath"])
                if place:
                    (scratch / place).mkdir(exist_ok=True)
                    text = [re.sub(rf"^{mount['mountPath']}(?=/|$)", str(scratch / place), word) for word in text]
            return [places.get(word, word) for word in text]

        slave_pod, master_pod = self.containers("DaemonSet"), self.containers("Deployment")
        for pod, name, secret in ((slave_pod, "key", "slave"), (slave_pod, "probe-key", "observer"), (master_pod, "key", "operator")):
            done = run(*words(pod[name], None, secret))
            self.assertEqual(done.returncode, 0, done.stderr)
        container = slave_pod["slave"]
        with Slave(command=words(container, SLAVE, "slave", **{"0.0.0.0:50051": "0.0.0.0:0"}), simulates=False) as slave:
            here = "127.0.0.1:" + slave.address.split(":")[-1]
            for probe in ("startupProbe", "readinessProbe"):
                health = words({**container, "command": container[probe]["exec"]["command"], "args": []}, None, "slave", **{"127.0.0.1:50051": here})
                self.assertEqual(health[1], "health")
                self.assertTrue(wait_until(lambda asked=health: run(*asked).stdout == "SERVING\n"))
            master = words(master_pod["master"], None, "operator", **{"robot01:50051": here, "127.0.0.1:8080": "127.0.0.1:0", "127.0.0.1:9465": "127.0.0.1:0"})
            with subprocess.Popen(master, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=BARE) as process:
                printed = next((line for line in process.stdout if f"connected to {here}" in line), "")
                process.terminate()
                process.stdout.read()
            self.assertTrue(printed, "the master did not connect")
        self.assertEqual(run(*health, "--wait", "0.5").returncode, 1, "nobody serves any more")


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

    def test_scripts_without_an_argument_print_their_usage(self):
        for script in ("deploy/build.sh", "deploy/fleet/robot_unit.sh"):
            done = run(ROOT / script)
            self.assertEqual(done.returncode, 2, script)
            self.assertIn(pathlib.Path(script).name, done.stderr)
            self.assertNotIn("unbound", done.stderr)


class Robots(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        made = run(ROOT / "deploy/fleet/robot_unit.sh", UNIT)
        self.assertEqual(made.returncode, 0, made.stderr)
        self.unit = made.stdout

    def test_the_template_differs_from_the_unit_by_the_robot_alone(self):
        changed = set(self.unit.splitlines()) - set(UNIT.read_text().splitlines())
        self.assertEqual(changed, {"Description=Palpate slave of %i", "EnvironmentFile=/etc/palpate/robots/%i.conf",
                                   "StateDirectory=palpate-slave/%i"})

    @unittest.skipUnless(shutil.which("systemd-analyze"), "no systemd-analyze")
    def test_systemd_accepts_it(self):
        template = self.folder / "palpate-slave@.service"
        # systemd looks for the program where the package installs it.
        template.write_text(self.unit.replace("/usr/bin/palpate-slave", "/bin/true"))
        done = run("systemd-analyze", "verify", "--man=no", "--recursive-errors=no", self.folder / "palpate-slave@robot01.service")
        self.assertNotIn("palpate", done.stderr)
        self.assertEqual(done.returncode, 0, done.stderr)
        template.write_text(self.unit)
        done = run("systemd-analyze", "security", "--offline=true", "--threshold=30", template)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def command_of(self, robot):
        """Returns (command line, environment) of the unit, as systemd reads it."""
        text = self.unit.replace("%i", robot)
        lines = re.findall(r"^Environment=(\w+)=(.*)$", text, re.MULTILINE)
        file = self.folder / pathlib.Path(re.search(r"^EnvironmentFile=(/.*)$", text, re.MULTILINE).group(1)).name
        lines += re.findall(r"^(\w+)=(.*)$", file.read_text(), re.MULTILINE)
        variables = {name: value.strip('"') for name, value in lines}
        state = self.folder / re.search(r"^StateDirectory=(.*)$", text, re.MULTILINE).group(1)
        state.mkdir(parents=True)
        command = []
        for word in re.search(r"^ExecStart=(.*)$", text, re.MULTILINE).group(1).split():
            whole, split = re.fullmatch(r"\$\{(\w+)\}", word), re.fullmatch(r"\$(\w+)", word)
            command += [variables[whole[1]]] if whole else shlex.split(variables.get(split[1], "")) if split else [word]
        return [SLAVE if word == "/usr/bin/palpate-slave" else word for word in command], {**BARE, "STATE_DIRECTORY": str(state)}

    def test_ten_slaves_serve_each_its_robot(self):
        scene = pathlib.Path(BLOCK).read_text()
        slaves = []
        for robot in ROBOTS:
            (self.folder / f"{robot}.yaml").write_text(scene.replace("name: silicone-block", f"name: {robot}"))
            # Limits the load of ten simulated cameras on one test machine.
            (self.folder / f"{robot}.conf").write_text(f'SCENE={self.folder}/{robot}.yaml\nLISTEN=127.0.0.1:0\nOPTIONS="--override sense.camera.rate=10"\n')
        for robot in ROBOTS:
            command, environment = self.command_of(robot)
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment)
            self.addCleanup(process.wait)
            self.addCleanup(process.stdout.close)
            self.addCleanup(process.kill)
            slaves.append(process)
        addresses = [slave.stdout.readline().removeprefix("listening on ").strip() for slave in slaves]
        self.assertEqual(len(set(addresses)), len(ROBOTS), addresses)
        for address in addresses:
            self.assertTrue(wait_until(lambda asked=address: run(SLAVE, "health", asked).stdout == "SERVING\n"), address)
        slaves[0].kill()
        slaves[0].wait()
        self.assertEqual(run(SLAVE, "health", addresses[0], "--wait", "0.5").returncode, 1)
        self.assertEqual(run(SLAVE, "health", addresses[1]).stdout, "SERVING\n", "the others go on")


if __name__ == "__main__":
    unittest.main(verbosity=2)
