#!/usr/bin/env python3
"""Compares the dashboard of deploy/monitoring with the metrics of a running slave and a running master."""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.parse
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "e2e"))
from programs import BARE, BLOCK, MASTER, PATIENCE, ROOT, Slave, deep, free_port, run, wait_until

FOLDER = ROOT / "deploy/monitoring"
BY_PROMETHEUS = {"instance", "job"}  # labels that Prometheus adds to every series


def fetch(url):
    # No proxy, because it would not reach this machine.
    straight = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        try:
            with straight.open(url, timeout=PATIENCE) as answer:
                return answer.read().decode()
        except OSError:
            time.sleep(0.05)
    raise AssertionError(f"no answer: {url}")


def read_page(text):
    """Parses a page of metrics. Returns {name: {"type": counter or gauge, "labels": {label: values}}}."""
    metrics = {name: {"type": kind, "labels": {}} for name, kind in re.findall(r"^# TYPE (\w+) (\w+)$", text, re.MULTILINE)}
    for name, labels in re.findall(r"^(\w+)(?:\{(.*)\})? \S+$", text, re.MULTILINE):
        for label, value in re.findall(r'(\w+)="([^"]*)"', labels):
            metrics[name]["labels"].setdefault(label, set()).add(value)
    return metrics


def queries():
    """Returns (title, query, legend) of each query in the dashboard."""
    board = json.loads((FOLDER / "grafana/palpate.json").read_text())
    return [(panel["title"], target["expr"], target["legendFormat"]) for panel in board["panels"] for target in panel["targets"]]


def mistakes_in(query, legend, metrics):
    """Returns mistakes of a query: metrics or labels that no page has, a counter shown without rate, or a rate of a
    gauge."""
    known = r"(rate|increase|abs)|(\d+m)|([a-z]+_\w+)"
    found, mistakes, labels = [], [], set(BY_PROMETHEUS)
    for function, _, name in re.findall(known, query):
        if name and name not in metrics:
            mistakes.append(f"{name} is not served")
        elif name:
            found.append(name)
            labels |= set(metrics[name]["labels"])
    for name in found:
        in_rate = re.search(rf"(rate|increase)\({name}\b[^)]*\[\d+m\]\)", query) is not None
        if in_rate != (metrics[name]["type"] == "counter"):
            mistakes.append(f"{name} is a {metrics[name]['type']}")
    mistakes += [f"label {label} is not served" for label in re.findall(r"\{\{(\w+)\}\}", legend) if label not in labels]
    return mistakes or ([] if found else ["no metric"])


class Monitoring(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.ports = free_port(), free_port()
        slave = cls.enterClassContext(Slave(BLOCK, "--metrics", f"127.0.0.1:{cls.ports[0]}"))
        cls.master = subprocess.Popen([MASTER, "connect", slave.address, "--metrics", f"127.0.0.1:{cls.ports[1]}"],
                                      stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=BARE)
        cls.addClassCleanup(cls.master.wait)
        cls.addClassCleanup(cls.master.terminate)
        cls.metrics = {}
        for port in cls.ports:
            cls.metrics |= read_page(fetch(f"http://127.0.0.1:{port}/metrics"))

    def test_each_query_asks_for_metrics_that_are_served(self):
        self.assertGreater(len(queries()), 8)
        for title, query, legend in queries():
            self.assertEqual(mistakes_in(query, legend, self.metrics), [], f"{title}: {query}")

    def test_a_slave_that_nobody_can_operate_has_a_phase(self):
        port = free_port()
        with Slave(ROOT / "deploy/scenes/foam-cube.yaml", "--override", "manipulator=none", "--metrics", f"127.0.0.1:{port}", simulates=False):
            page = fetch(f"http://127.0.0.1:{port}/metrics")
        phases = dict(re.findall(r'^palpate_slave_phase\{phase="(\w+)"\} (\d)$', page, re.MULTILINE))
        self.assertEqual([phase for phase, holds in phases.items() if holds == "1"], ["observing"], phases)

    def test_prometheus_reads_what_the_compose_file_serves(self):
        compose, config = ((FOLDER / name).read_text() for name in ("compose.yaml", "prometheus.yml"))
        ports = {name: re.search(rf"^  {name}:.*?--metrics, \"0.0.0.0:(\d+)\"", compose, re.MULTILINE | re.DOTALL).group(1)
                 for name in ("slave", "master")}
        self.assertEqual(set(re.findall(r'"(\w+:\d+)"', config)), {f"{name}:{port}" for name, port in ports.items()})
        for file in re.findall(r'"\./([\w./]+):', compose):
            self.assertTrue((FOLDER / file).is_file(), file)
        uid = re.search(r"uid: (\w+)", (FOLDER / "grafana/sources.yaml").read_text()).group(1)
        board = json.loads((FOLDER / "grafana/palpate.json").read_text())
        self.assertEqual({panel["datasource"]["uid"] for panel in board["panels"]}, {uid})

    @deep
    def test_prometheus_answers_each_query(self):
        if not shutil.which("prometheus"):
            self.skipTest("no prometheus")
        with tempfile.TemporaryDirectory() as folder:
            config = (FOLDER / "prometheus.yml").read_text().replace("scrape_interval: 5s", "scrape_interval: 1s")
            for name, port, own in zip(("slave", "master"), ("9464", "9465"), self.ports):
                config = config.replace(f"{name}:{port}", f"127.0.0.1:{own}")
            file = pathlib.Path(folder, "prometheus.yml")
            file.write_text(config)
            self.assertEqual(run("promtool", "check", "config", file).returncode, 0)
            address = f"127.0.0.1:{free_port()}"
            server = subprocess.Popen(["prometheus", f"--config.file={file}", f"--storage.tsdb.path={folder}/data", f"--web.listen-address={address}"],
                                      stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.addCleanup(server.wait)
            self.addCleanup(server.terminate)
            fetch(f"http://{address}/-/ready")

            def ask(query):
                return json.loads(fetch(f"http://{address}/api/v1/query?query={urllib.parse.quote(query)}"))["data"]["result"]

            # A rate needs two samples of both programs.
            self.assertTrue(wait_until(lambda: len(ask("count_over_time(up[1m]) > 2")) == 2))
            for title, query, _ in queries():
                self.assertTrue(ask(query), f"{title}: {query} has no series")


if __name__ == "__main__":
    unittest.main(verbosity=2)
