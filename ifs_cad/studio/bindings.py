"""Controls of the page that show a value of the design and change it.

The session is the only truth: a control that was moved edits the session, and afterwards all
controls are set to what the session says, also when it refused.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ifs_cad.errors import IfsCadError
from ifs_cad.studio.events import on_update
from ifs_cad.studio.model import StudioModel
from ifs_cad.studio.session import Session, Snapshot

Read = Callable[[Snapshot], Any]
"""Gives the value of a control, None to leave it alone."""

Write = Callable[[StudioModel, Any], object]

DECIMALS = 4
"""That boxes show and take."""

__all__ = ["DECIMALS", "Bindings"]


@dataclass(frozen=True)
class _Bound:
    handle: Any
    read: Read


class Bindings:
    """All controls that follow the session.

    Parameters
    ----------
    session : Session
    say : callable
        Takes why an edit was refused; an empty text when it was not.
    """

    def __init__(self, session: Session, say: Callable[[str], None]) -> None:
        self._session = session
        self._say = say
        self._bound: list[_Bound] = []
        self._followers: list[Callable[[Snapshot], None]] = []

    def bind(self, handle: Any, read: Read, write: Write, gesture: str = "") -> None:
        """Let a control show and change a value.

        Parameters
        ----------
        handle : an input of viser
        read, write : callable
        gesture : str, optional
            For sliders and boxes: what they say while they are drawn, or a number is typed, is one
            step of the history.
        """
        # viser lets a box take only as many decimals as its step has
        if isinstance(handle.value, float | tuple):
            handle.precision = max(handle.precision, DECIMALS)
        self._bound.append(_Bound(handle, read))
        on_update(
            handle,
            lambda event: self.edit(lambda model: write(model, event.target.value), gesture),
        )

    def follow(self, follower: Callable[[Snapshot], None]) -> None:
        """Call a function whenever the controls are set."""
        self._followers.append(follower)

    def snapshot(self) -> Snapshot:
        """Return the state of the session."""
        return self._session.snapshot()

    def edit(
        self, change: Callable[[StudioModel], object], gesture: str = "", *, held: bool = False
    ) -> None:
        """Change the design, or say why not."""
        try:
            self._session.edit(change, gesture, held=held)
        except IfsCadError as error:
            self._say(str(error))
            if gesture:  # half a number is often none; what stays one is set back when all is quiet
                return
        else:
            self._say("")
        self.sync()

    def settle(self) -> None:
        """End the gesture that goes on."""
        self._session.settle()
        self.sync()

    def sync(self) -> None:
        """Set all controls to what the session says; on the thread of their events only."""
        snapshot = self._session.snapshot()
        for follower in self._followers:
            follower(snapshot)
        for bound in self._bound:
            value = bound.read(snapshot)
            if value is not None and bound.handle.value != value:
                bound.handle.value = value
