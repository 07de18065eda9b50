"""A model on the screen: the OCP viewer, in a browser or in VS Code.

Two programs can show it:

- the standalone viewer, ``python -m ocp_viewer``, a page in a browser (package ``ocp_viewer``);
- the extension "OCP CAD Viewer" of VS Code (package ``ocp_vscode``).

Both speak one protocol, and the packages share one client, so whichever is installed serves
either. The client drops a model silently when nobody looks; here a model counts as shown only
when the page has reported it back. The viewer asks no one who they are (a page from elsewhere
that can reach it could make it write files), so only viewers on this machine are spoken to.
"""

from __future__ import annotations

import contextlib
import io
import json
import logging
import os
import socket
import time
import warnings
from collections.abc import Iterator
from datetime import datetime
from importlib.util import find_spec
from types import ModuleType
from typing import Any

import cadquery as cq

from ifs_cad.elements.colouring import Colouring
from ifs_cad.elements.explosion import Explode
from ifs_cad.errors import InputError, MissingLibraryError, ViewerError
from ifs_cad.libraries import require
from ifs_cad.view._assembly import MATERIAL, Group, View, parts, view_of, viewable
from ifs_cad.view._viewer_model import graft, is_plain

HOSTS = ("127.0.0.1", "localhost")
DEFAULT_PORT = 3939  # of both viewers
CLIENTS = ("ocp_viewer", "ocp_vscode")
LISTEN_SECONDS = 0.5
ANSWER_SECONDS = 3.0
RELAY_SECONDS = 3.0  # within which a viewer passes even a large model on to an open page
POLL_SECONDS = 0.05

_UNHEARD = logging.getLogger(f"{__name__}.line")
_UNHEARD.disabled = True  # a line that breaks off is asked anew, which is no one's trouble

_shown: dict[str, cq.Assembly] = {}  # by `show_object`, in this process
_cameras: set[int] = set()  # ports of viewers that were given a camera from here


def show(
    thing: Any,
    name: str = "shell",
    *,
    colour: str | Colouring = MATERIAL,
    explode: Explode = 0.0,
    exact: bool = False,
    keep_camera: bool = False,
    port: int | None = None,
    host: str = "127.0.0.1",
    timeout: float = 30.0,
) -> None:
    """Show a model in a running OCP viewer; return when the page has reported it.

    The page reports a model once it is in its tree. Without a graphics card the first frame may
    follow some seconds later.

    Panels and planks that `to_assembly` made are sent as flat faces, with addresses and holes as
    lines on them, which takes a fraction of a second. Everything else, and all of it with `exact`,
    is triangulated by the viewer's client; it measures only what came that way. The protocol of the
    viewers replaces the whole model each time: no part of it can be sent alone.

    Parameters
    ----------
    thing : cadquery.Assembly, cadquery.Workplane, cadquery.Shape, Shell, Vault or WireFrame
        Names, nesting and colours of an assembly appear in the viewer's tree.
    name : str
        Root of that tree. The time is added to it, to tell this call from the others.
    colour : str or Colouring
        "material", a quantity of `colouring` or values of one's own. The legend is a column of
        coloured fields beside the model, with their values beside them and in the tree.
    explode : float or sequence of float
        How far sub-assemblies move apart, see `explosion`.
    exact : bool
        Send the solids as they are cut, with pockets and holes.
    keep_camera : bool
        Leave the camera where it is, from the second time on.
    port : int, optional
        Where the viewer listens; without it, the environment variable ``OCP_PORT`` or 3939.
    host : str
        127.0.0.1 or localhost: only a viewer on this machine is spoken to.
    timeout : float, seconds
        How long the page may take to report the model back.

    Raises
    ------
    InputError
        A thing that cannot be looked at, a port that is none, or a host that is not this machine.
    MissingLibraryError
        No viewer is installed.
    ViewerError
        No viewer listens, or no page is open in it; the message says what to run.
    """
    if host not in HOSTS:
        raise InputError(
            f"A viewer is only spoken to on this machine ({' or '.join(HOSTS)}), not on {host!r}."
        )
    viewer = _Viewer(_port(port))
    client = _client()
    begins = viewer.expect_listening()  # before a colour is computed, which may take its time
    view = view_of(thing, colour, explode)
    now = datetime.now().time().isoformat(timespec="milliseconds")
    title = f"{name.replace('/', '-')} {now}"
    assembly, stand_ins = (view.assembly, {}) if exact else _with_stand_ins(view)
    camera = {"reset_camera": client.Camera.KEEP} if keep_camera else {}
    # a page opened anew has the camera of its splash screen, and the viewer does not tell
    if begins or viewer.port not in _cameras:
        camera = {"reset_camera": client.Camera.RESET}
    with _captured_output() as said, _grafting(client, stand_ins):
        try:
            client.set_port(viewer.port, HOSTS[0])
            client.show(assembly, names=[title], progress="", **camera)
        except Exception as error:
            raise ViewerError(f"The viewer's client failed on {name!r}: {error}") from error
    viewer.expect_shown(title, timeout, said.getvalue())
    _cameras.add(viewer.port)


def show_object(
    thing: Any, name: str | None = None, options: dict[str, Any] | None = None, **kwargs: Any
) -> None:
    """Show a part script's result, for scripts that nobody gave a `show_object`.

    CQ-editor and CQGI (so `ifs-cad build` too) put their own `show_object` into a script; plain
    ``python part.py`` and VS Code do not. This one has their signature. What one run shows is on
    the page together, as in CQ-editor. Without a viewer the script goes on: one line on stdout says
    what would have been shown and how to start a viewer.

    Parameters
    ----------
    thing : cadquery.Assembly, cadquery.Workplane, cadquery.Shape, Shell, Vault or WireFrame
    name : str, optional
        A name shown again replaces what had it before.
    options, **kwargs
        Accepted because other hosts do, and ignored: colours belong to the assembly.

    Raises
    ------
    InputError
        A thing that cannot be looked at.
    """
    name = name or f"object {len(_shown) + 1}"
    assembly = viewable(thing)
    _shown[name] = assembly
    together = cq.Assembly(name="together")
    for each, shown in _shown.items():
        together.add(shown, name=each)
    try:
        if len(_shown) == 1:
            show(assembly, name)
        else:
            show(together, " + ".join(_shown))
    except (ViewerError, MissingLibraryError) as reason:
        count = len(parts(assembly))
        print(f"{name}: {count} part{'s' * (count != 1)}, not previewed. {reason}")


def _with_stand_ins(view: View) -> tuple[cq.Assembly, dict[str, Group]]:
    """Return an assembly with a box in the place of each group that is drawn from its arrays."""
    plain = {id(group.assembly): group for group in view.groups if is_plain(group)}
    stand_ins: dict[str, Group] = {}

    def replaced(assembly: cq.Assembly) -> cq.Assembly:
        group = plain.get(id(assembly))
        if group is None:
            made = cq.Assembly(
                assembly.obj, loc=assembly.loc, name=assembly.name, color=assembly.color
            )
            for child in assembly.children:
                copied = replaced(child)
                copied.parent = made
                made.children.append(copied)
                made.objects.update(copied.objects)
            return made
        name = f"stand-in-{len(stand_ins)}"
        stand_ins[name] = group
        solids = group.elements.solids
        points = solids.vertices + group.shifts[solids.solid_of_vertex]
        low, high = points.min(axis=0), points.max(axis=0)
        length, width, height = (high - low).tolist()
        box = cq.Solid.makeBox(length, width, height, cq.Vector(*low.tolist()))
        return cq.Assembly(box, loc=assembly.loc, name=name)

    return (replaced(view.assembly), stand_ins) if plain else (view.assembly, {})


@contextlib.contextmanager
def _grafting(client: ModuleType, stand_ins: dict[str, Group]) -> Iterator[None]:
    """Let the client send groups drawn from their arrays in the place of what stands in for them.

    The client makes of the rest what it always does, settings and camera too; only what it hands
    to its connection is changed.
    """
    if not stand_ins:
        yield
        return
    of_client = client.show.__self__
    session, comms = of_client.config.session, of_client.comms
    send = session.send_data

    def send_grafted(message: dict[str, Any], timeit: bool = False) -> Any:
        data = message["data"]
        for name, group in stand_ins.items():
            if not graft(data["shapes"], group, name, data["instances"]):
                raise ViewerError(f"{name} is missing in what the client sends.")
        return send(message, timeit=timeit)

    def send_no_shapes(_: Any, timeit: bool = False) -> None:
        """Measure nothing rather than what stood in."""

    session.send_data, comms.send_backend = send_grafted, send_no_shapes
    try:
        yield
    finally:
        del session.send_data, comms.send_backend


class _Viewer:
    """A viewer at a port of this machine, as seen through its protocol."""

    def __init__(self, port: int) -> None:
        self.port = port
        self.place = f"{HOSTS[0]}:{port}"
        self.how_to_look = (
            f"open http://{self.place}/viewer in a browser, or in VS Code run the command "
            '"OCP CAD Viewer: Open viewer".'
        )

    def expect_listening(self) -> bool:
        """Return whether a viewer still shows its splash screen; ViewerError if none answers."""
        try:
            socket.create_connection((HOSTS[0], self.port), LISTEN_SECONDS).close()
        except OSError as error:
            raise ViewerError(
                f"No viewer listens on {self.place}. Start one with: {_start_command(self.port)}, "
                f"and {self.how_to_look}"
            ) from error
        answer = self.ask("config")
        if "_splash" not in answer:
            other = self.port + 1 if self.port != 65535 else DEFAULT_PORT
            raise ViewerError(
                f"What listens on {self.place} is not an OCP viewer. Start one on another port, "
                f"{_start_command(other)}, and say so here by port={other} or OCP_PORT={other}."
            )
        return bool(answer["_splash"])

    def expect_shown(self, title: str, timeout: float, said: str) -> None:
        """Raise ViewerError unless the page reports a model of this title in time."""
        sent = time.monotonic()
        while (waited := time.monotonic() - sent) < timeout:
            if self._shows(title):
                return
            # a viewer drops its splash screen when it first passes a model on to a page
            if waited > RELAY_SECONDS and self.ask("config").get("_splash"):
                break
            time.sleep(POLL_SECONDS)
        lines = said.strip().splitlines()
        remark = f" The viewer's client said: {lines[-1]}" if lines else ""
        raise ViewerError(
            f"The viewer on {self.place} did not show the model within {waited:.0f} s: no page "
            f"seems to be open. To look, {self.how_to_look}{remark}"
        )

    def _shows(self, title: str) -> bool:
        states = self.ask("status").get("text", {}).get("states", {})
        return any(title in path for path in states)

    def ask(self, question: str) -> dict[str, Any]:
        """Return the viewer's answer to "config" or "status"; {} when none comes."""
        from websockets.exceptions import WebSocketException  # comes with the viewer's client
        from websockets.sync.client import connect

        try:
            with connect(
                f"ws://{self.place}",
                proxy=None,
                open_timeout=ANSWER_SECONDS,
                close_timeout=0.1,
                logger=_UNHEARD,
            ) as line:
                line.send(f"C:{json.dumps(question)}")
                answer = json.loads(line.recv(timeout=ANSWER_SECONDS))
        except (OSError, ValueError, WebSocketException):
            return {}
        return answer if isinstance(answer, dict) else {}


def _start_command(port: int) -> str:
    return f"python -m ocp_viewer --host {HOSTS[0]} --port {port}"


def _port(port: int | None) -> int:
    given = os.environ.get("OCP_PORT", DEFAULT_PORT) if port is None else port
    try:
        number = int(given)
    except ValueError:
        number = 0
    if not 0 < number < 65536:
        raise InputError(f"A port is a number from 1 to 65535, got {given!r}.")
    return number


def _client() -> ModuleType:
    """Import the client that is installed."""
    installed = next((name for name in CLIENTS if find_spec(name)), CLIENTS[0])
    return require(installed, "the preview", extra="view")


@contextlib.contextmanager
def _captured_output() -> Iterator[io.StringIO]:
    """Keep what the client prints and warns; its failures show in the page's silence."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield said
