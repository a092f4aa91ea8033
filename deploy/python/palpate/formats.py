"""Detects from a file's first bytes formats that Palpate does not read, and states how to convert them."""
from __future__ import annotations

import os
import re

TABLE = "save the table as CSV"
MODULE = "convert the PyTorch module that it was made of"
FORMATS = (
    (rb"PK\x03\x04[\s\S]{26}(?:\[Content_Types\]|_rels/|xl/|docProps/)", "a workbook (.xlsx)", TABLE),
    (rb"PK\x03\x04[\s\S]{26}mimetype", "a workbook (.ods)", TABLE),
    (rb"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "a workbook (.xls)", TABLE),
    (rb"PAR1", "a Parquet file", TABLE),
    (rb"ARROW1|FEA1", "an Arrow or Feather file", TABLE),
    (rb"\x93NUMPY", "a NumPy array (.npy)", "write it by numpy.savetxt, with a header and delimiter=\",\""),
    (rb"PK\x03\x04[\s\S]{26}[^/]{1,80}\.npy", "NumPy arrays (.npz)", "write them by numpy.savetxt, with a header and delimiter=\",\""),
    (rb"PK\x03\x04[\s\S]{26}(?:metadata\.json|config\.json|model\.weights\.h5)", "a Keras network (.keras)",
     "write its weights by torch.save"),
    (rb"TDSm", "a LabVIEW file (.tdms)", TABLE),
    (rb"\x89HDF\r\n\x1a\n", "an HDF5 file", "write its arrays as CSV, or weights by torch.save"),
    (rb"MATLAB 5\.0 MAT-file", "a MATLAB file", "write its arrays by writematrix as CSV"),
    (rb"\x89MCAP0\r\n", "an MCAP recording", "export it: python3 -m palpate.export FILE.mcap OUT"),
    (rb"SQLite format 3\x00", "an SQLite database, such as a rosbag2 .db3", "ros2 bag convert writes MCAP"),
    (rb"#ROSBAG", "a bag of ROS 1", "rosbags-convert or mcap convert writes MCAP"),
    (rb"\x28\xb5\x2f\xfd", "a file compressed by zstd", "zstd -d unpacks it"),
    (rb"\x1f\x8b", "a file compressed by gzip", "gunzip unpacks it"),
    (rb"\x08[\x03-\x0f][\x12\x1a\x22\x2a\x32\x3a\x42]", "an ONNX network", MODULE),
    (rb"[\s\S]{4}TFL3", "a TensorFlow Lite network", "write its weights by torch.save"),
    (rb"[\s\S]{8}\{\"", "a safetensors file", "load it into the module, and save that one's state_dict by torch.save"),
    (rb"\x89PNG|\xff\xd8\xff|II\*\x00|MM\x00\*|BM[\s\S]{4}\x00\x00\x00\x00", "an image", ""),
    (rb"%PDF", "a PDF document", ""),
    (rb"\s*<(?:\?xml|!DOCTYPE|html)", "an XML or HTML document", ""),
)


def what_is(file: str | os.PathLike[str]) -> str:
    """Returns for example `a workbook (.xlsx): save the table as CSV`. Empty: unknown, unreadable, or text."""
    try:
        with open(file, "rb") as stream:
            begin = stream.read(512)
    except OSError:
        return ""
    for pattern, name, advice in FORMATS:
        if re.match(pattern, begin):
            return f"{name}: {advice}" if advice else name
    return ""
