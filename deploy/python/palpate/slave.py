"""Connection to a slave."""
from __future__ import annotations

import os
import pathlib
import time
from types import TracebackType
from typing import Any, Iterable, Iterator

import grpc
import numpy as np

from palpate.arm import Arm, ArmDriver, Exchange
from palpate.errors import Error, LeaseHeld, Source, translated
from palpate.feeds import Image, Pixels, TactileSample, image_samples, tactile
from palpate.operator import Operator
from palpate.state import Mesh, State, States, Validity, seconds as seconds_of
from palpate.v1 import devices_pb2, scene_pb2, telemetry_pb2, teleoperation_pb2 as pb
from palpate.v1 import teleoperation_pb2_grpc

TIMEOUT = 10.0  # [s] longest wait for the reply to a request
# A link that is cut is silent: without keepalive a stream on it would wait for ever. After 1 s without data the client
# sends a ping, and after 10 s without its answer every call ends with an error.
KEEPALIVE = [("grpc.keepalive_time_ms", 1000), ("grpc.keepalive_timeout_ms", 10000), ("grpc.http2.max_pings_without_data", 0),
             ("grpc.use_local_subchannel_pool", 1)]


def connect(address: str, tls: str | os.PathLike[str] | None = None) -> Slave:
    """Connects to the slave at HOST:PORT.

    In plain text, or with TLS: `tls` is the folder with ca.pem, cert.pem and key.pem that deploy/certs wrote. The
    connection is made by the first call.
    """
    options = [("grpc.enable_http_proxy", 0), ("grpc.max_receive_message_length", 64 << 20), *KEEPALIVE]
    if tls is None:
        return Slave(grpc.insecure_channel(address, options=options))
    ca, key, certificate = ((pathlib.Path(tls) / name).read_bytes() for name in ("ca.pem", "key.pem", "cert.pem"))
    return Slave(grpc.secure_channel(address, grpc.ssl_channel_credentials(ca, key, certificate), options=options))


class Slave:
    """A connected slave. Every call raises `Error` if the slave rejects it or cannot be reached.

    `stub` has all calls of palpate.v1, for what this class does not offer.
    """

    def __init__(self, channel: Any) -> None:
        self.channel = channel
        self.stub = teleoperation_pb2_grpc.TeleoperationStub(channel)  # type: ignore[no-untyped-call]

    def close(self) -> None:
        """Closes the connection."""
        self.channel.close()

    def __enter__(self) -> Slave:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    # ---- description and status

    def scene(self) -> scene_pb2.SceneDescription:
        """What is modelled, and in `capabilities` workspace, degrees of freedom, rates and limits."""
        with translated():
            return self.stub.GetScene(pb.GetSceneRequest(), timeout=TIMEOUT)  # type: ignore[no-any-return]

    def status(self) -> telemetry_pb2.Status:
        """Phase, validity, operator, rates and alarms."""
        with translated():
            return self.stub.GetStatus(pb.GetStatusRequest(), timeout=TIMEOUT)  # type: ignore[no-any-return]

    def reset(self, known: telemetry_pb2.Status | None = None) -> telemetry_pb2.Status:
        """Clears the emergency stop that the status `known` shows: `slave.reset(slave.status())`.

        A stop that was requested after `known` stays, and the call raises `Error`, as it does for a stop without `known`.
        While nothing is stopped, tool, object and baseline are detected again.
        """
        request = pb.ResetRequest(stops=known.stops if known else 0)
        with translated():
            return self.stub.Reset(request, timeout=TIMEOUT)  # type: ignore[no-any-return]

    def stop(self, reason: str = "") -> telemetry_pb2.Status:
        """Emergency stop, latched until `reset`."""
        with translated():
            return self.stub.Stop(pb.StopRequest(reason=reason), timeout=TIMEOUT)  # type: ignore[no-any-return]

    # ---- watching

    def states(self, rate: float = 0, seconds: float | None = None, details: bool = False) -> Iterator[State]:
        """Yields the newest state, at most `rate` per second [Hz] (0: every new one), for `seconds` or until the loop ends.

        Needs no lease and cannot move the tool. A slow reader skips states. `details` adds the moment, and what each
        check measured.
        """
        stream = self.stub.WatchState(pb.WatchStateRequest(max_rate=rate, details=details), timeout=seconds)
        try:
            for message in stream:
                yield State(message)
        except grpc.RpcError as error:
            if seconds is None or error.code() != grpc.StatusCode.DEADLINE_EXCEEDED:
                raise Error(error.code().name, error.details() or "") from None
        finally:
            stream.cancel()

    def record(self, seconds: float, rate: float = 0) -> States:
        """Watches for `seconds` and returns all samples as arrays."""
        return States.of(self.states(rate, seconds))

    def meshes(self, rate: float = 0, seconds: float | None = None) -> Iterator[Mesh]:
        """Yields the newest deformed boundary, at most `rate` per second [Hz] (0: 30)."""
        stream = self.stub.WatchMesh(pb.WatchMeshRequest(max_rate=rate), timeout=seconds)
        elements, rest = np.zeros((0, 2), dtype=np.int64), np.zeros((0, 3))
        try:
            for message in stream:
                if len(message.rest) > 0:
                    elements = np.array(message.elements, dtype=np.int64).reshape(-1, message.nodes_per_element)
                    rest = np.array(message.rest, dtype=np.float64).reshape(-1, 3)
                positions = np.array(message.positions, dtype=np.float64).reshape(-1, 3)
                yield Mesh(seconds_of(message.sensed_at), elements, rest, positions, Validity(message.validity))
        except grpc.RpcError as error:
            if seconds is None or error.code() != grpc.StatusCode.DEADLINE_EXCEEDED:
                raise Error(error.code().name, error.details() or "") from None
        finally:
            stream.cancel()

    # ---- operating

    def operate(self, name: str, wait: float = 0) -> Operator:
        """Takes the lease under `name`, and waits up to `wait` seconds for it. Raises LeaseHeld if another client has it."""
        end = time.monotonic() + wait
        while True:
            try:
                return Operator(self.stub, name)
            except LeaseHeld:
                if time.monotonic() > end:
                    raise
                time.sleep(min(1.0, max(0.0, end - time.monotonic())))

    # ---- drivers

    def feed_images(self, images: Iterable[Image | Pixels]) -> devices_pb2.FeedImagesReply:
        """Sends images, pairs or depth images until `images` ends; `paced` gives them a rate.

        The scene's camera needs `source: stream`. Returns how many were accepted.
        """
        source = Source(image_samples(images))
        with translated(source):
            return self.stub.FeedImages(iter(source))  # type: ignore[no-any-return]

    def feed_fingertips(self, samples: Iterable[TactileSample]) -> int:
        """Sends readings of fingertips until `samples` ends; `replayed` gives recorded ones their pace.

        The scene's fingertips need `source: stream`. Returns how many were accepted.
        """
        source = Source(tactile(samples))
        with translated(source):
            return int(self.stub.FeedTactile(iter(source)).samples)

    def drive(self, arm: Arm, rate: float = 250, seconds: float | None = None, name: str = "") -> Exchange:
        """Drives the manipulator `arm` with `rate` reports per second [Hz], for `seconds` or until the slave ends.

        The scene needs `manipulator: {source: stream}`. Returns the numbers of reports and targets.
        """
        return ArmDriver(arm, rate, seconds, name).run(self.stub)
