"""What a call can raise."""
from __future__ import annotations

import contextlib
from typing import Iterator

import grpc


class Error(Exception):
    """A call that the slave rejected, or a lost connection. `code` is the gRPC status code, `details` the sentence of the slave."""

    def __init__(self, code: str, details: str) -> None:
        super().__init__(f"{code}: {details}")
        self.code = code
        self.details = details


class LeaseHeld(Error):
    """Another client operates, or the operator was evicted. `details` names the holder."""


class Interrupted(Error):
    """The tool does not follow: the slave holds it, or an emergency stop is latched. Engage again to continue."""


@contextlib.contextmanager
def translated(kind: type[Error] = Error) -> Iterator[None]:
    """Raises `kind` in place of the errors of gRPC."""
    try:
        yield
    except grpc.RpcError as error:
        raise kind(error.code().name, error.details() or "") from None
