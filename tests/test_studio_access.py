"""Who can speak to the studio: its own page on this machine, with the key, and nobody else."""

from __future__ import annotations

import socket
import sys
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from ifs_cad.errors import InputError, ViewerError
from ifs_cad.studio.access import Gate

viser = pytest.importorskip("viser", reason="the studio's page is not installed (extra 'studio')")
client = pytest.importorskip("websockets.sync.client")
InvalidStatus = pytest.importorskip("websockets.exceptions").InvalidStatus
server_module = pytest.importorskip("ifs_cad.studio.server")

LISTENING = "0A"  # the state of a socket in /proc/net/tcp
LOOPBACK = "0100007F"  # 127.0.0.1, as it is written there


@pytest.fixture(scope="module")
def gate() -> Iterator[Gate]:
    server, gate = server_module.open_server()
    yield gate
    server.close()


def cookie(gate: Gate) -> str:
    return gate.page_headers(f"/?key={gate.key}")["Set-Cookie"].partition(";")[0]


def get(gate: Gate, path: str, **headers: str) -> tuple[int, Any, str]:
    request = urllib.request.Request(f"http://127.0.0.1:{gate.port}{path}", headers=headers)
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    try:
        with opener.open(request, timeout=30) as answer:
            return answer.status, answer.headers, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.headers, error.read().decode()


def connect(gate: Gate, origin: str | None, headers: dict[str, str]) -> bytes:
    """Open a websocket as a page does and return the first message."""
    with client.connect(
        f"ws://127.0.0.1:{gate.port}",
        origin=origin,
        additional_headers=headers,
        subprotocols=[f"viser-v{viser.__version__}"],
        max_size=None,
    ) as connection:
        message: bytes = connection.recv(timeout=30)
        return message


def test_the_own_page_is_served_and_heard(gate: Gate) -> None:
    status, headers, text = get(gate, f"/?key={gate.key}")
    assert status == 200
    assert "<html" in text
    kept = headers["Set-Cookie"].partition(";")[0]
    assert get(gate, "/", Cookie=kept)[0] == 200
    for origin in (f"http://127.0.0.1:{gate.port}", f"http://localhost:{gate.port}"):
        assert connect(gate, origin, {"Cookie": kept})


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "http://127.0.0.1:9", "http://127.0.0.1", "null", "file://", None],
)
def test_a_page_of_another_origin_cannot_connect(gate: Gate, origin: str | None) -> None:
    """Even with the cookie, which a browser sends from any port of this machine."""
    with pytest.raises(InvalidStatus) as refused:
        connect(gate, origin, {"Cookie": cookie(gate)})
    assert refused.value.response.status_code == 403


def test_two_origins_are_none(gate: Gate) -> None:
    own = f"http://127.0.0.1:{gate.port}"
    with pytest.raises(InvalidStatus):
        connect(gate, "http://evil.example", {"Cookie": cookie(gate), "Origin": own})


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1", "[::1]:{port}"]
)
def test_a_name_that_was_made_to_lead_here_is_refused(gate: Gate, host: str) -> None:
    """As a page does after DNS rebinding: its own name is host and origin."""
    named = host.format(port=gate.port)
    with socket.create_connection(("127.0.0.1", gate.port), timeout=30) as raw:
        raw.sendall(
            f"GET / HTTP/1.1\r\nHost: {named}\r\nOrigin: http://{named}\r\n"
            f"Cookie: {cookie(gate)}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
            "Sec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        answer = raw.recv(4096).decode()
    assert answer.startswith("HTTP/1.1 403")
    assert get(gate, f"/?key={gate.key}", Host=named)[0] == 403


@pytest.mark.parametrize(
    "path", ["/", "/?key=", "/?key=guess", "/?key=guess&key=guess", "/index.html"]
)
def test_without_the_key_nothing_is_served(gate: Gate, path: str) -> None:
    status, _, text = get(gate, path)
    assert status == 403
    assert "ends with a key" in text
    assert gate.key not in text
    for headers in ({}, {"Cookie": cookie(gate) + "x"}, {"Cookie": "a=b; c"}):
        with pytest.raises(InvalidStatus):
            connect(gate, f"http://127.0.0.1:{gate.port}", headers)


def test_no_other_page_may_show_ours(gate: Gate) -> None:
    _, headers, _ = get(gate, f"/?key={gate.key}")
    assert headers["X-Frame-Options"] == "DENY"
    assert headers["Content-Security-Policy"] == "frame-ancestors 'none'"
    assert "Access-Control-Allow-Origin" not in headers
    assert {"HttpOnly", "SameSite=Strict"} <= set(headers["Set-Cookie"].split("; "))


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_nothing_listens_beyond_this_machine(gate: Gate) -> None:
    listening = []
    for table in ("tcp", "tcp6"):
        rows = Path("/proc/net", table).read_text().splitlines()[1:]
        for row in map(str.split, rows):
            address, _, port = row[1].partition(":")
            if row[3] == LISTENING and int(port, 16) == gate.port:
                listening.append(address)
    assert listening == [LOOPBACK]


def test_a_port_that_is_taken_is_an_error_that_names_another(gate: Gate) -> None:
    with pytest.raises(ViewerError, match=f"Port {gate.port} .* --port {gate.port + 1}"):
        server_module.open_server(gate.port)


def test_without_a_wish_another_port_is_found(gate: Gate) -> None:
    server, other = server_module.open_server()
    try:
        assert other.port != gate.port
        assert get(other, f"/?key={other.key}")[0] == 200
        assert get(other, f"/?key={gate.key}")[0] == 403
    finally:
        server.close()


@pytest.mark.parametrize("port", [0, -1, 65536])
def test_a_port_that_is_none_is_refused(port: int) -> None:
    with pytest.raises(InputError, match="from 1 to 65535"):
        server_module.open_server(port)


def test_a_viser_that_listens_in_another_way_is_not_started(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    import websockets.asyncio.server as listening

    serve, closed = listening.serve, []

    class Unguarded:
        """Begins to listen by a function that it took before."""

        def __init__(self, **_: Any) -> None:
            assert listening.serve is not serve

        def get_port(self) -> int:
            return 1

        def close(self) -> None:
            closed.append(self)

    monkeypatch.setattr(server_module, "StudioServer", Unguarded)
    with pytest.raises(ViewerError, match="in the way that the studio can guard"):
        server_module.open_server()
    assert len(closed) == 1
    assert listening.serve is serve


def test_the_tunnel_to_the_outside_is_shut() -> None:
    server, _ = server_module.open_server()
    try:
        assert server.request_share_url() is None
        assert server._share_tunnel is None
    finally:
        server.close()
