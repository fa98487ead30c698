"""The web server of the page, on a port of its own."""

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import rich

from prp_gym.checks import whole
from prp_gym.errors import PortError
from prp_gym.extras import check

if TYPE_CHECKING:
    import viser

_LARGEST_PORT = 65535


@contextmanager
def serving(host: str, port: int, label: str) -> Iterator["viser.ViserServer"]:
    """A web server for the time of the context; afterwards its port is free again.

    Args:
        host: address on which it listens; 127.0.0.1 is reached from this machine alone.
        port: port, 0 for any that is free.
        label: title of the page.

    Raises:
        MissingPackageError: viser is not installed.
        InvalidValueError: a port that is not a whole number from 0 to 65535.
        PortError: a port that is in use or not allowed, or an address that this machine does not have.
    """
    whole("port", port, 0, _LARGEST_PORT)
    check("viser")
    _require_free(host, port)
    server = _start(host, port, label)
    try:
        if port and server.get_port() != port:  # taken since; the library went on to another one
            raise PortError(host, port, "it is in use")
        yield server
    finally:
        with _quietly():
            server.stop()


def _start(host: str, port: int, label: str) -> "viser.ViserServer":
    import viser

    with _quietly():
        return viser.ViserServer(host=host, port=port, label=label, verbose=False)


@contextmanager
def _quietly() -> Iterator[None]:
    """Leave out what the library prints of its own accord; the command says its address itself."""
    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = before


def _require_free(host: str, port: int) -> None:
    """Refuse a port on which this process cannot listen.

    Raises:
        PortError: such a port, or such an address.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except (OSError, UnicodeError) as error:
            raise PortError(host, port, getattr(error, "strerror", None) or str(error)) from None
