"""Runs the cells of the notebooks in deploy/python, and the commands of its README. Needs PYTHONPATH."""
import contextlib
import io
import json
import pathlib
import re
import sys
import unittest
import warnings

import numpy as np

try:
    import matplotlib
    import palpate._core  # noqa: F401
except ImportError as missing:
    print(f"skipped: {missing}: deploy/install.sh tests")
    sys.exit(77)

matplotlib.use("Agg")
ROOT = pathlib.Path(__file__).resolve().parents[2]


def run(code, names):
    out = io.StringIO()
    with contextlib.redirect_stdout(out), warnings.catch_warnings():
        warnings.simplefilter("error")
        exec(code, names)
    return out.getvalue()


class NotebookTest(unittest.TestCase):
    def test_from_a_mesh_to_a_plot_with_its_band(self):
        notebook = json.loads((ROOT / "deploy/python/notebooks/force_of_a_mesh.ipynb").read_text())
        self.assertEqual((notebook["nbformat"], len(notebook["cells"])), (4, 10))
        names = {}
        for cell in notebook["cells"]:
            if cell["cell_type"] == "code":
                self.assertEqual(cell["outputs"], [])
                run("".join(cell["source"]), names)
        force, band, depth = names["force"], names["band"], names["depth"]
        self.assertTrue(names["answer"].valid.all())
        self.assertTrue(np.all(np.diff(force) > 0) and np.all(band > 0) and np.all(band < force))
        # A disc of radius a on a half-space needs the force 2 E a d / (1 - nu^2); on a layer of 1.5 diameters it needs
        # more. The rounded top is touched by a part of it at first.
        half_space = 2 * 60e3 * 0.01 * depth / (1 - 0.3**2)
        self.assertTrue(np.all(force[6:] > 0.95 * half_space[6:]) and np.all(force < 2 * half_space))
        lines = names["axes"].get_lines()
        np.testing.assert_array_equal(lines[0].get_ydata(), force)

    def test_the_lines_of_the_readme_print_a_force(self):
        text = (ROOT / "README.md").read_text(encoding="utf-8")
        blocks = re.findall(r"```python\n(.*?)```", text, re.S)
        self.assertEqual(len(blocks), 1)
        self.assertEqual(len(blocks[0].splitlines()), 6)
        self.assertRegex(run(blocks[0], {}), r"^\[.*-1\.[0-9]+\s*\] valid\n$")


if __name__ == "__main__":
    unittest.main()
