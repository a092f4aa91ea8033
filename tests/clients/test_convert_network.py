"""Conversion of force networks: `python3 -m palpate.convert_network`. Needs the built Python client (PYTHONPATH) and PyTorch."""
import contextlib
import io
import json
import pathlib
import sys
import tempfile
import unittest
import zipfile

try:
    import numpy as np
    import torch
    from palpate import convert_network
except ImportError as missing:
    print(f"skipped: {missing}: deploy/install.sh training")
    sys.exit(77)

AUTHORS = pathlib.Path(__file__).resolve().parents[3] / "shared/data/seed001_biotac_lstm"


class Finger(torch.nn.Module):
    """Recurrent layers, and a linear layer whose activation is a function of the forward pass."""

    def __init__(self, kind):
        super().__init__()
        self.recurrent = kind(21, 8, 2, batch_first=True)
        self.hidden, self.last = torch.nn.Linear(8, 6), torch.nn.Linear(6, 3)

    def forward(self, x):
        states, _ = self.recurrent(x)
        return self.last(torch.relu(self.hidden(states[:, -1])))


class Skipping(torch.nn.Module):
    """A sum of two paths, whose layers do not follow each other."""

    def __init__(self):
        super().__init__()
        self.a, self.b, self.c = torch.nn.Linear(19, 19), torch.nn.Linear(19, 3), torch.nn.Linear(19, 3)

    def forward(self, x):
        return self.b(torch.relu(self.a(x))) + self.c(x)


class Touching:
    """Makes a file when it is unpickled, as code in a pickle can do anything."""

    def __init__(self, file):
        self.file = str(file)

    def __reduce__(self):
        return open, (self.file, "w")


class ConvertTest(unittest.TestCase):
    def setUp(self):
        torch.manual_seed(1)
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def convert(self, source, *arguments):
        """Exit code, the network or None, and what was printed."""
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            code = convert_network.main([str(source), "--out", str(self.folder / "out"), *map(str, arguments)])
        file = self.folder / "out/network.json"
        return code, json.loads(file.read_text()) if file.exists() else None, printed.getvalue()

    def saved(self, module):
        torch.save(module, self.folder / "finger.pt")
        return self.folder / "finger.pt"

    def refusal(self, module, *arguments):
        code, network, printed = self.convert(self.saved(module), *arguments)
        self.assertEqual((code, network), (2, None), printed)
        return printed

    def test_recurrent_modules_become_layers_of_the_same_name(self):
        code, network, printed = self.convert(self.saved(Finger(torch.nn.LSTM)), "--trust", "--activation", "relu", "--window", "30")
        self.assertEqual(code, 0, printed)
        self.assertEqual((network["architecture"], network["window"], len(network["lstm"])), ("rnn_21", 30, 2))
        self.assertEqual(np.array(network["lstm"][0]["kernel"]).shape, (29, 32))
        self.assertEqual(network["dense"][0]["activation"], "relu")

    def test_feed_forward_modules_keep_their_weights_and_activations(self):
        module = torch.nn.Sequential(torch.nn.Linear(19, 5), torch.nn.ELU(), torch.nn.Dropout(), torch.nn.Linear(5, 4),
                                     torch.nn.Sigmoid(), torch.nn.Linear(4, 3))
        code, network, printed = self.convert(self.saved(module), "--input-scale", "100", "--learnt-force", "2")
        self.assertEqual(code, 0, printed)
        self.assertEqual([layer.get("activation") for layer in network["dense"]], ["elu", "sigmoid", None])
        self.assertEqual((network["architecture"], network["window"], network["learnt_force"]), ("dnn_19", 1, 2))
        self.assertEqual(network["input"]["scale"], [100] * 19)
        weights = np.array(network["dense"][0]["kernel"], np.float32)
        np.testing.assert_array_equal(weights, module[0].weight.detach().numpy().T)

    def test_a_forward_pass_with_other_functions_is_found_by_the_comparison(self):
        self.assertIn("differs from PyTorch", self.refusal(Finger(torch.nn.LSTM), "--trust"))

    def test_layers_that_do_not_follow_each_other_are_refused(self):
        self.assertIn("c takes 19 inputs and b gives 3: the forward pass is not the sequence of the layers",
                      self.refusal(Skipping(), "--trust"))

    def test_no_code_of_a_file_runs_without_trust(self):
        touched = self.folder / "touched"
        printed = self.refusal(Touching(touched))
        self.assertIn("open, whose forward pass is code", printed)
        self.assertIn("--trust", printed)
        self.assertFalse(touched.exists())
        self.assertIn("Finger, whose forward pass is code", self.refusal(Finger(torch.nn.LSTM)))
        torch.save(Touching(touched), self.folder / "state.pt")
        code, _, printed = self.convert("torch.nn:Identity", "--state", self.folder / "state.pt")
        self.assertEqual(code, 2)
        self.assertIn("state.pt: cannot be loaded", printed)
        self.assertFalse(touched.exists())

    def test_a_network_of_another_sensor_has_what_the_training_found_of_its_channels(self):
        linear = torch.nn.Linear
        module = torch.nn.Sequential(linear(15, 32), torch.nn.ReLU(), linear(32, 3))
        self.assertIn("--sensor DIR", self.refusal(module))
        trained = {"inputs": 15, "unit": "uT", "noise": 0.5, "drift": 0.01, "channels": {"expectation": [[0.0] * 15] * 15}}
        for inputs, left_out, sigma, words in ((16, "", (1, 1, 1), "takes 15 inputs, and the sensor has 16 channels"),
                                               (15, "channels", (1, 1, 1), "channels is missing: expected a network of palpate.train"),
                                               (15, "", (0, 0, 0), "expected --sigma X Y Z")):
            network = {key: value for key, value in {**trained, "inputs": inputs}.items() if key != left_out}
            (self.folder / "network.json").write_text(json.dumps(network))
            self.assertIn(words, self.refusal(module, "--sensor", self.folder, "--sigma", *sigma))
        (self.folder / "network.json").write_text(json.dumps(trained))
        code, network, printed = self.convert(self.saved(module), "--sensor", self.folder, "--sigma", "0.1", "0.1", "0.2")
        self.assertEqual(code, 0, printed)
        self.assertEqual((network["architecture"], network["sigma"]), ("dnn_15", [0.1, 0.1, 0.2]))
        self.assertEqual({key: network[key] for key in ("unit", "noise", "drift", "channels")},
                         {key: trained[key] for key in ("unit", "noise", "drift", "channels")})

    def test_files_of_other_programs_are_named(self):
        for name, content, expected in (("net.onnx", b"\x08\x07\x12\x07pytorch", "an ONNX network: convert the PyTorch module"),
                                        ("net.h5", b"\x89HDF\r\n\x1a\n", "an HDF5 file"),
                                        ("net.safetensors", (70).to_bytes(8, "little") + b'{"a":{}}', "a safetensors file")):
            (self.folder / name).write_bytes(content)
            code, _, printed = self.convert(self.folder / name)
            self.assertEqual(code, 2)
            self.assertIn(expected, printed)
        with zipfile.ZipFile(self.folder / "net.keras", "w") as archive:
            archive.writestr("metadata.json", "{}")
        code, _, printed = self.convert(self.folder / "net.keras")
        self.assertEqual(code, 2)
        self.assertIn("a Keras network (.keras): write its weights by torch.save", printed)
        torch.save(torch.nn.Linear(19, 3).state_dict(), self.folder / "weights.pt")
        code, _, printed = self.convert(self.folder / "weights.pt")
        self.assertEqual(code, 2)
        self.assertRegex(printed, r"holds a state_dict \(weight, bias\).*--state \S*weights\.pt")
        torch.jit.script(torch.nn.Linear(19, 3)).save(str(self.folder / "scripted.pt"))
        code, _, printed = self.convert(self.folder / "scripted.pt")
        self.assertEqual(code, 2)
        self.assertIn("a TorchScript module", printed)

    def test_what_cannot_be_converted_is_named(self):
        linear = torch.nn.Linear
        broken = torch.nn.Sequential(linear(21, 4), torch.nn.Tanh(), linear(4, 3))
        broken[0].weight.data[2, 1] = float("nan")
        self.assertIn("0.weight[2, 1] is not a finite number", self.refusal(broken))
        self.assertIn("takes 17 inputs: a fingertip has 21 signals or 19", self.refusal(torch.nn.Sequential(linear(17, 3))))
        self.assertIn("1: Softmax is not accepted",
                      self.refusal(torch.nn.Sequential(linear(21, 4), torch.nn.Softmax(1), linear(4, 3))))
        code, _, printed = self.convert(self.folder / "missing.pt")
        self.assertEqual(code, 2)
        self.assertIn("missing.pt: cannot be loaded by PyTorch", printed)

    @unittest.skipUnless(AUTHORS.exists(), "needs ../shared/data/seed001_biotac_lstm")
    def test_the_authors_weights_are_converted_exactly(self):
        code, network, printed = self.convert(AUTHORS / "biotac_rnn21")
        self.assertEqual(code, 0, printed)
        self.assertEqual((network["architecture"], network["window"], network["learnt_force"]), ("rnn_21", 50, 1.0))
        tensors = json.loads((AUTHORS / "biotac_rnn21/tensors.json").read_text())
        for k in (1, 2):
            name = f"layer{k}/layer{k}/BasicLSTMCell/Linear/"
            for key, tensor in (("kernel", "Matrix"), ("bias", "Bias")):
                expected = np.array(tensors[name + tensor]["data"], np.float32)
                np.testing.assert_array_equal(np.array(network["lstm"][k - 1][key], np.float32).ravel(), expected)
        code, _, printed = self.convert(AUTHORS / "force_sensor_rnn13_20")
        self.assertEqual(code, 2)
        self.assertIn("13 inputs", printed)


if __name__ == "__main__":
    unittest.main(verbosity=2)
