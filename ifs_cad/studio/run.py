"""The command: a studio that runs until it is interrupted."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import Any

from ifs_cad.libraries import load, require
from ifs_cad.studio.session import Session

__all__ = ["Studio", "opened", "run"]


@dataclass(frozen=True)
class Studio:
    """A studio that is being served.

    Attributes
    ----------
    address : str
        What to open in a browser; it holds the key.
    session : Session
    server : StudioServer
    page : StudioPage
    """

    address: str
    session: Session
    server: Any
    page: Any


@contextmanager
def opened(path: str | os.PathLike[str] | None = None, port: int | None = None) -> Iterator[Studio]:
    """Serve a studio within the block.

    Parameters
    ----------
    path : path, optional
        The design file; saving makes it when it does not exist.
    port : int, optional
        Any free one by default.

    Yields
    ------
    Studio

    Raises
    ------
    MissingLibraryError
        viser is not installed.
    InputError
        The file cannot be read.
    ViewerError
        The port is taken.
    """
    require("viser", "the studio", "studio")
    require("filelock", "the studio", "studio")
    with closing(Session(path)) as session:
        server, gate = load("ifs_cad.studio.server").open_server(port)
        try:
            page = load("ifs_cad.studio.page").StudioPage(server, session)
            try:
                yield Studio(gate.address, session, server, page)
            finally:
                page.close()
        finally:
            server.close()


def run(
    path: str | os.PathLike[str] | None = None,
    port: int | None = None,
    say: Callable[[str], None] = print,
) -> None:
    """Serve a studio until Ctrl-C; raises what `opened` raises.

    Parameters
    ----------
    path, port
        As of `opened`.
    say : callable
        Takes what the user has to know.
    """
    with opened(path, port) as studio:
        session = studio.session
        if session.path is not None and not session.path.exists():
            say(f"{session.path} does not exist yet; saving makes it.")
        if session.aside:
            say(session.aside)
        if session.shared:
            say(session.shared)
        for remainder in session.found:
            say(f"A design that was not saved is in {remainder.file}; the page asks.")
        try:
            say(
                f"The studio is open on this machine only:\n\n    {studio.address}\n\n"
                "Ctrl-C ends it."
            )
            threading.Event().wait()
        except KeyboardInterrupt:
            say("")
    if session.snapshot().is_saved:
        say("The studio has ended.")
    else:
        say(f"Not saved; the next start offers it from {session.autosave_file}.")
    for file in session.left_behind:
        say(f"What was not saved before is still in {file}; opening its design offers it.")
