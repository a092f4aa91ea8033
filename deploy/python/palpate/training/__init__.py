"""Training of a fingertip's force networks with PyTorch (paper B, III.A.1 and IV.A). Run `python3 -m palpate.train --help`."""
