"""Finds or generates the Python stubs of palpate.v1 from the .proto files.

PALPATE_STUBS: folder of the stubs (default: build/python-stubs in the repository).
PALPATE_STUBS_READY: if set, the stubs exist already.
"""
import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROTO = ROOT / "proto"


def generate(out):
    """Generates the stubs in the folder `out`."""
    plugin = shutil.which("grpc_python_plugin")
    if plugin is None:
        sys.exit("grpc_python_plugin is missing: apt-get install protobuf-compiler-grpc")
    out.mkdir(parents=True, exist_ok=True)
    sources = sorted(str(path.relative_to(PROTO)) for path in PROTO.rglob("*.proto"))
    subprocess.run(
        ["protoc", f"-I{PROTO}", f"--python_out={out}", f"--grpc_out={out}",
         f"--plugin=protoc-gen-grpc={plugin}", *sources], check=True)


def load():
    """Returns the modules (teleoperation_pb2, teleoperation_pb2_grpc, state_pb2)."""
    out = pathlib.Path(os.environ.get("PALPATE_STUBS", ROOT / "build" / "python-stubs"))
    if "PALPATE_STUBS_READY" not in os.environ:
        generate(out)
    sys.path.insert(0, str(out))
    from palpate.v1 import state_pb2, teleoperation_pb2, teleoperation_pb2_grpc
    return teleoperation_pb2, teleoperation_pb2_grpc, state_pb2


def add_tls(parser):
    """Adds the option --tls."""
    parser.add_argument("--tls", metavar="DIR", type=pathlib.Path,
                        help="use TLS with ca.pem, cert.pem and key.pem of this folder (deploy/certs)")


def connect(grpc, target, tls=None):
    """Returns a channel to HOST:PORT without a proxy: in plain text, or with the certificates of the folder `tls`."""
    options = [("grpc.enable_http_proxy", 0)]
    if tls is None:
        return grpc.insecure_channel(target, options=options)
    ca, key, certificate = ((tls / name).read_bytes() for name in ("ca.pem", "key.pem", "cert.pem"))
    return grpc.secure_channel(target, grpc.ssl_channel_credentials(ca, key, certificate), options=options)
