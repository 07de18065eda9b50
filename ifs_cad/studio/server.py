"""The server of the page: viser's, behind a gate and on this machine only.

viser binds to a port of its own choice when the wanted one is taken, and asks nobody where a
connection comes from. So the socket is made here, and the one function by which viser starts to
listen is handed that socket and a check of every request; should a version of viser listen in
another way, the studio does not start.
"""

from __future__ import annotations

import contextlib
import io
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http import HTTPStatus
from typing import Any

import viser
import websockets.asyncio.server as listening
from websockets.datastructures import Headers
from websockets.http11 import Request, Response
from websockets.typing import Origin

from ifs_cad.errors import InputError, ViewerError
from ifs_cad.studio.access import LOOPBACK, Gate

PORT = 8421
"""Where the studio listens unless told otherwise, if it is free."""

Check = Callable[[Any, Request], Response | None]

_starting = threading.Lock()

__all__ = ["PORT", "StudioServer", "open_server"]


class StudioServer(viser.ViserServer):
    """viser's server without its tunnel to the outside."""

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Refuse: nothing of a design leaves this machine."""
        return None

    def close(self) -> None:
        """Stop listening."""
        with contextlib.redirect_stdout(io.StringIO()):
            self.stop()


def open_server(port: int | None = None) -> tuple[StudioServer, Gate]:
    """Listen on this machine and nowhere else.

    Parameters
    ----------
    port : int, optional
        `PORT` by default, or any free one if that is taken.

    Returns
    -------
    server, gate

    Raises
    ------
    InputError
        Not a port.
    ViewerError
        The port that was asked for is taken, or viser does not listen as it should.
    """
    own = _listen(port)
    gate = Gate(own.getsockname()[1])
    # viser greets on the standard output, with an address that lacks the key
    with _starting, _guarded(own, gate) as guarded, contextlib.redirect_stdout(io.StringIO()):
        server = StudioServer(host=LOOPBACK, port=gate.port, label="ifs-cad studio", verbose=False)
    if guarded != [gate] or server.get_port() != gate.port:
        server.close()
        own.close()
        raise ViewerError(
            f"viser {viser.__version__} does not listen in the way that the studio can guard. "
            "Install the version that it was made for: pip install 'ifs-cad[studio]'."
        )
    return server, gate


def _listen(port: int | None) -> socket.socket:
    if port is not None and not 1 <= port <= 65535:
        raise InputError(f"A port is a number from 1 to 65535, not {port}.")
    try:
        return socket.create_server((LOOPBACK, PORT if port is None else port))
    except OSError as error:
        if port is None:
            return socket.create_server((LOOPBACK, 0))
        raise ViewerError(
            f"Port {port} of this machine cannot be had: {error.strerror or error}. Give another "
            f"one, --port {port + 1 if port < 65535 else PORT}, or leave --port away."
        ) from error


@contextmanager
def _guarded(own: socket.socket, gate: Gate) -> Iterator[list[Gate]]:
    """Make whoever serves websockets within the block do so behind the gate."""
    original = listening.serve
    done: list[Gate] = []

    def serve(handler: Any, host: Any, port: Any, *, process_request: Check, **options: Any) -> Any:
        done.append(gate)
        return original(
            handler,
            sock=own,
            origins=[Origin(origin) for origin in gate.origins],
            process_request=checked(gate, process_request),
            **options,
        )

    listening.serve = serve  # type: ignore[assignment, misc]
    try:
        yield done
    finally:
        listening.serve = original  # type: ignore[misc]


def checked(gate: Gate, inner: Check) -> Check:
    """Return a check of requests that asks the gate before the inner one."""

    def check(connection: Any, request: Request) -> Response | None:
        why = gate.refusal(request.path, request.headers.get_all)
        if why is not None:
            body = f"{why}\n".encode()
            plain = Headers({"Content-Type": "text/plain; charset=utf-8"})
            plain["Content-Length"] = str(len(body))
            return Response(HTTPStatus.FORBIDDEN.value, HTTPStatus.FORBIDDEN.phrase, plain, body)
        response = inner(connection, request)
        if response is not None:
            for name, value in gate.page_headers(request.path).items():
                response.headers[name] = value
        return response

    return check
