"""What a call can raise."""
from __future__ import annotations

import contextlib
from typing import Any, Generic, Iterator, TypeVar

import grpc


Message = TypeVar("Message")


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


class Source(Generic[Message]):
    """Messages for gRPC, which hides an error of what makes them. `raised` keeps it."""

    def __init__(self, messages: Iterator[Message]) -> None:
        self._messages = messages
        self.raised: Exception | None = None

    def __iter__(self) -> Iterator[Message]:
        try:
            yield from self._messages
        except Exception as error:
            self.raised = error
            raise


@contextlib.contextmanager
def translated(source: Source[Any] | None = None) -> Iterator[None]:
    """Raises Error in place of the errors of gRPC, or what `source` raised."""
    try:
        yield
    except grpc.RpcError as error:
        if source is not None and source.raised is not None:
            raise source.raised from None
        raise Error(error.code().name, error.details() or "") from None
