"""Client of a Palpate slave: messages and stubs of palpate.v1, and a channel to a slave.

    import palpate
    from palpate.v1 import teleoperation_pb2 as messages, teleoperation_pb2_grpc as services

    slave = services.TeleoperationStub(palpate.channel("127.0.0.1:50051"))
    for state in slave.WatchState(messages.WatchStateRequest(max_rate_hz=2)):
        print(state.force, state.sigma, state.validity)
"""
import pathlib

import grpc

__all__ = ["channel"]


def channel(target, tls=None):
    """Returns a channel to HOST:PORT without a proxy: in plain text, or with ca.pem, cert.pem and key.pem of the folder `tls`."""
    options = [("grpc.enable_http_proxy", 0)]
    if tls is None:
        return grpc.insecure_channel(target, options=options)
    ca, key, certificate = ((pathlib.Path(tls) / name).read_bytes() for name in ("ca.pem", "key.pem", "cert.pem"))
    return grpc.secure_channel(target, grpc.ssl_channel_credentials(ca, key, certificate), options=options)
