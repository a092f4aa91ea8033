"""What a call can raise."""
from __future__ import annotations

import contextlib
from typing import Any, Generic, Iterator, TypeVar

import grpc

from palpate.v1 import errors_pb2


Message = TypeVar("Message")


class Error(Exception):
    """A call that the slave rejected, or a lost connection.

    `code` is the gRPC status code, `reason` the name of an ErrorReason in errors.proto (empty: none), and `details` the
    sentence of the slave.
    """

    def __init__(self, code: str, details: str, reason: str = "") -> None:
        super().__init__(code, details, reason)  # the arguments with which pickle makes it again
        self.code = code
        self.details = details
        self.reason = reason

    def __str__(self) -> str:
        return f"{self.code}: {self.details}"


class LeaseHeld(Error):
    """Another client operates, or the operator was evicted. `details` names the holder."""


class Interrupted(Error):
    """The tool does not follow: the slave holds it, or an emergency stop is latched. Engage again to continue."""


class Source(Generic[Message]):
    """Iterates over messages for gRPC. gRPC hides an exception of the iterator; `raised` keeps it."""

    def __init__(self, messages: Iterator[Message]) -> None:
        self._messages = messages
        self.raised: Exception | None = None

    def __iter__(self) -> Iterator[Message]:
        try:
            yield from self._messages
        except Exception as error:
            self.raised = error
            raise


def reason_of(error: Any) -> str:
    """The ErrorReason of an error of gRPC, without its prefix. Empty: none."""
    for key, value in error.trailing_metadata() or ():
        if key == "grpc-status-details-bin":
            for detail in errors_pb2.ErrorStatus.FromString(value).details:
                if detail.type_url == "type.googleapis.com/google.rpc.ErrorInfo":
                    return str(errors_pb2.ErrorInfo.FromString(detail.value).reason)
    return ""


@contextlib.contextmanager
def translated(source: Source[Any] | None = None) -> Iterator[None]:
    """Raises Error in place of the errors of gRPC, or what `source` raised."""
    try:
        yield
    except grpc.RpcError as error:
        if source is not None and source.raised is not None:
            raise source.raised from None
        raise Error(error.code().name, error.details() or "", reason_of(error)) from None
