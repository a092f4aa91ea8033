#!/usr/bin/env python3
"""Makes small seed inputs for the fuzzers: seeds.py FOLDER makes FOLDER/TARGET/* and FOLDER/TARGET.dict.

Where a target reads several kinds of files, the first byte of an input says which (see fuzz_TARGET.cpp).
"""
import json
import pathlib
import random
import re
import struct
import subprocess
import sys
import tempfile
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
NODES = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
TRIANGLES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]


def write(folder, target, name, content, kind=None):
    if isinstance(content, str):
        content = content.encode()
    (folder / target).mkdir(parents=True, exist_ok=True)
    (folder / target / name).write_bytes((b"" if kind is None else bytes([kind])) + content)


def dictionary(folder, target, words):
    def quoted(word):
        return '"' + "".join(c if c.isascii() and c.isalnum() or c in " _-:.,$*[]{}/<>=&" else f"\\x{ord(c):02x}" for c in word) + '"'
    (folder / f"{target}.dict").write_text("".join(quoted(w) + "\n" for w in sorted(set(words))))


def strings_of(*patterns):
    """Returns the keywords that readers compare with: short string literals of their sources."""
    words = set()
    for pattern in patterns:
        for source in ROOT.glob(pattern):
            words.update(re.findall(r'"([A-Za-z_$*<][\w./$*-]{1,24})"', source.read_text()))
    return words


def lines(rows, first=""):
    return "".join(first + " ".join(map(str, row)) + "\n" for row in rows)


def numbered(rows, start=1, behind=""):
    return "".join(f"{i} {' '.join(map(str, row))}{behind}\n" for i, row in enumerate(rows, start))


def scenes(folder):
    for scene in sorted((ROOT / "deploy" / "scenes").glob("*.yaml")):
        write(folder, "scene", scene.name, scene.read_bytes(), 0)
        write(folder, "scene", scene.stem + ".solve.yaml", scene.read_bytes(), 1)
    write(folder, "scene", "aliases", "a: &a [1, 2]\nb: &b {c: *a, d: *a}\n<<: *b\n", 0)
    units = ["mm", "um", "kPa", "MPa", "deg", "Hz", "px", "N/m", "&a", "*a", "<<: ", "{", "}", "[", "]", ": ", "1e308"]
    dictionary(folder, "scene", strings_of("slave/scene/*.cpp") | set(units))


def meshes(folder):
    def facet(triangle):
        corners = "".join("vertex " + " ".join(map(str, NODES[i])) + "\n" for i in triangle)
        return f"facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n"
    write(folder, "mesh", "ascii.stl", "solid a\n" + "".join(map(facet, TRIANGLES)) + "endsolid a\n", 0)
    binary = b" " * 80 + struct.pack("<I", len(TRIANGLES))
    for triangle in TRIANGLES:
        binary += struct.pack("<12fH", 0, 0, 0, *(float(x) for i in triangle for x in NODES[i]), 0)
    write(folder, "mesh", "binary.stl", binary, 0)
    head = ("ply\nformat {} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 4\nproperty list uchar int vertex_indices\nend_header\n")
    write(folder, "mesh", "ascii.ply", head.format("ascii") + lines(NODES) + lines(TRIANGLES, "3 "), 1)
    for name, order in (("little", "<"), ("big", ">")):
        body = b"".join(struct.pack(order + "3f", *p) for p in NODES)
        body += b"".join(struct.pack(order + "B3i", 3, *t) for t in TRIANGLES)
        write(folder, "mesh", name + ".ply", head.format(f"binary_{name}_endian").encode() + body, 1)
    nodes = f"$Nodes\n4\n{numbered(NODES)}$EndNodes\n"
    write(folder, "mesh", "2.msh", f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{nodes}"
          "$Elements\n1\n1 4 2 0 1 1 2 3 4\n$EndElements\n", 2)
    write(folder, "mesh", "4.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
          f"$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n{lines(NODES)}$EndNodes\n"
          "$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n", 2)
    write(folder, "mesh", "a.node", f"4 3 0 0\n{numbered(NODES)}%%\n1 4 0\n1 1 2 3 4\n", 3)
    dictionary(folder, "mesh", strings_of("slave/mesh/files/*.cpp") | {"%%\n", "1e308", "2147483647", "-1"})


def tables(folder):
    names = ",".join(f"E{i}" for i in range(1, 20))
    row = ",".join(["10"] * 19)
    write(folder, "csv", "contacts", "case,x,y,width\nA,0.1,0.2,\nB,1e-3,+2,0.01\n", 0)
    write(folder, "csv", "recording", f"t,{names},pac0,pdc\n0,{row},1,2\n0.01,{row},1,2\n", 1)
    write(folder, "csv", "two-fingers", "t," + ",".join(f"{f}_E{i}" for f in ("rf", "th") for i in range(1, 20)) +
          f"\n0,{row},{row}\n", 1)
    write(folder, "csv", "layout", "".join(f"E{i},-{i},0,-3,0,0.6,-0.8\n" for i in range(1, 20)), 2)
    write(folder, "csv", "contour", "x,y\n0,0\n1,0\n1,1\n", 3)
    write(folder, "csv", "poses", f"t,{names},x,y,z,qw,qx,qy,qz\n0,{row},0,0,0,1,0,0,0\n1,{row},0,0,1,1,0,0,0\n", 1)
    write(folder, "csv", "hand", "time_s,x,y,z\n0,0,0,0\n0.5,0.1,0,0\n", 4)
    dictionary(folder, "csv", ["case", "width", "rel_time_s", "timestamp", "finger", "pac0", "pac1", "pdc", "E19", "fx",
                               "nan", "inf", "1e999", "#", ",", "\n", "\ufeff".encode().decode("latin-1")])


def images(folder):
    def chunk(name, content):
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    def png(width, height, depth, colour, channels):
        row = b"\0" + bytes(width * channels * depth // 8)
        return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)) +
                chunk(b"IDAT", zlib.compress(row * height)) + chunk(b"IEND", b""))
    write(folder, "image", "grey.png", png(8, 4, 8, 0, 1))
    write(folder, "image", "deep.png", png(8, 4, 16, 6, 4))
    write(folder, "image", "a.pgm", b"P5 4 2 255\n" + bytes(8))
    write(folder, "image", "a.ppm", b"P6 2 2 255\n" + bytes(12))
    write(folder, "image", "a.bmp", b"BM" + struct.pack("<IHHIIiiHHIIiiII", 70, 0, 0, 54, 40, 2, 2, 1, 24, 0, 16, 0, 0,
                                                          0, 0) + bytes(16))
    write(folder, "image", "a.tif", b"II*\0" + struct.pack("<IH", 12, 0) + bytes(8))
    write(folder, "image", "a.jpg", b"\xff\xd8\xff\xe0\0\x10JFIF\0\1\1\0\0\1\0\1\0\0\xff\xd9")
    dictionary(folder, "image", ["IHDR", "IDAT", "IEND", "PLTE", "JFIF", "P5", "P2", "II*", "MM"])


def networks(folder):
    layer = {"kernel": [[0.5] * 2] * 19, "bias": [0.1, 0.2]}
    write(folder, "network", "dense", json.dumps({"palpate_force_network": 1, "architecture": "dnn_19", "activation": "tanh",
                                                  "dense": [layer], "gain": 1, "sigma": [0.1, 0.1, 0.1]}))
    dictionary(folder, "network", strings_of("slave/tactile/network/*_file.cpp", "slave/tactile/network/network_weights.cpp"))


def rigs(folder):
    lens = ("image_width: 640, image_height: 480, camera_matrix: {data: [800, 0, 320, 0, 800, 240, 0, 0, 1]}, "
            "distortion_coefficients: {data: [0, 0.1, 0, 0, 0]}")
    write(folder, "rig", "pair", f"left: &l {{{lens}}}\nright: *l\nR: {{data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}}\n"
          "T: {data: [-0.06, 0, 0]}\nrms_px: 0.2\n")
    write(folder, "rig", "one", "%YAML:1.0\n---\n" + "{" + lens + "}\n")
    dictionary(folder, "rig", strings_of("slave/vision/stereo/rig_file.cpp") | {"!!opencv-matrix", "plumb_bob", "1e-320"})


def messages(folder):
    messages = {
        "OperatorCommand": (0, "sequence: 3 epoch: 1 engaged: true p_M { x: 0.01 y: 0.02 z: 0 } sent_at { seconds: 1700000000 }"),
        "SlaveState": (1, "sequence: 4 sensed_at { seconds: 1700000000 } force { x: 1 y: 0 z: 0 }"),
        "TactileSample": (2, "electrodes: [" + ", ".join(["10"] * 19) + "] sensed_at { seconds: 1700000000 }"),
        "SetParametersRequest": (3, ""), "SetModelRequest": (4, ""), "SurfacePatch": (5, "epoch: 1"),
        "PatchLaw": (6, "epoch: 1 revision: 1"), "WatchStateRequest": (7, "max_rate: 30")}
    for name, (kind, text) in messages.items():
        # If a field was renamed, the seed is an empty message.
        encoded = subprocess.run(["protoc", f"--proto_path={ROOT}/proto", f"--encode=palpate.v1.{name}",
                                  "palpate/v1/teleoperation.proto"], input=text.encode(), capture_output=True)
        write(folder, "wire", name, encoded.stdout, kind)
        if encoded.returncode != 0:
            print(f"seeds: {name} is empty: {encoded.stderr.decode().strip()}", file=sys.stderr)


def certificates(folder):
    with tempfile.TemporaryDirectory() as made:
        ca, out = pathlib.Path(made) / "ca", pathlib.Path(made) / "anna"
        certs = ROOT / "deploy" / "certs"
        for call in (["ca", ca], ["operator", ca, out, "anna"]):
            subprocess.run([certs, *call], check=True, capture_output=True)
        cert, key = ((out / f"{name}.pem").read_bytes() for name in ("cert", "key"))
    write(folder, "certificate", "cert", cert, 0)
    write(folder, "certificate", "name", "palpate://operator/anna", 1)
    write(folder, "certificate", "usable", cert + key, 2)
    dictionary(folder, "certificate", strings_of("slave/service/roles.cpp") | {"palpate://", "URI:"})


def sequences(folder):
    draw = random.Random(1)
    for target in ("hand", "arm", "datagram"):
        for number in range(8):
            write(folder, target, f"drawn-{number}", draw.randbytes(300))


def recordings(folder):
    def text(word):
        return struct.pack("<I", len(word)) + word

    def record(kind, content):
        return struct.pack("<BQ", kind, len(content)) + content
    schema = record(3, struct.pack("<H", 1) + text(b"A") + text(b"protobuf") + text(b"schema"))
    channel = record(4, struct.pack("<HH", 1, 1) + text(b"/a") + text(b"protobuf") + text(b""))
    message = record(5, struct.pack("<HIQQ", 1, 1, 7, 7) + b"data")
    records = schema + channel + message
    magic = b"\x89MCAP0\r\n"
    header = record(1, text(b"") + text(b"seed"))
    chunk = record(6, struct.pack("<QQQI", 7, 7, len(records), zlib.crc32(records)) + text(b"") +
                   struct.pack("<Q", len(records)) + records)
    note = record(12, text(b"made") + text(text(b"by") + text(b"us")))
    attached = struct.pack("<QQ", 1, 0) + text(b"a.yaml") + text(b"text") + struct.pack("<Q", 3) + b"a: "
    attachment = record(9, attached + struct.pack("<I", zlib.crc32(attached)))
    end = record(15, bytes(4))
    write(folder, "mcap", "whole", magic + header + chunk + note + attachment + end + record(2, bytes(20)) + magic, 0)
    write(folder, "mcap", "loose", magic + header + records + end, 0)
    write(folder, "mcap", "records", records, 1)
    write(folder, "mcap", "tactile", b"\x08\x01", 2)
    write(folder, "mcap", "tick", b"\x0a\x05\x0d\0\0\x80?", 3)
    dictionary(folder, "mcap", ["zstd", "lz4", "protobuf", magic.decode("latin-1")])


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: seeds.py FOLDER")
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for make in (scenes, meshes, tables, images, networks, rigs, recordings, messages, certificates, sequences):
        make(folder)


if __name__ == "__main__":
    main()
