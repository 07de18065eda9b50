"""Reactions to what happens on the page, all on the one thread that hears it, in order.

viser runs plain functions on many threads at once, but awaits coroutines one after the other.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Reaction = Callable[[Any], None]
"""Takes the event of viser."""

__all__ = ["on_click", "on_drag", "on_trigger", "on_update", "on_upload"]


def on_click(handle: Any, react: Reaction) -> None:
    """React to a button, or to a click on something in the scene."""
    handle.on_click(_in_order(react))


def on_drag(handle: Any, react: Reaction) -> None:
    """React to something in the scene that is dragged with the left button."""
    handle.on_drag("left")(_in_order(react))


def on_trigger(command: Any, react: Reaction) -> None:
    """React to a command, by its key or chosen by its name."""
    command.on_trigger(_in_order(react))


def on_update(handle: Any, react: Reaction) -> None:
    """React to an input that a user changed; not when it was set from here."""

    def by_user(event: Any) -> None:
        if event.client is not None:
            react(event)

    handle.on_update(_in_order(by_user))


def on_upload(handle: Any, react: Reaction) -> None:
    """React to a file that arrived."""
    handle.on_upload(_in_order(react))


def _in_order(react: Reaction) -> Callable[[Any], Any]:
    async def awaited(event: Any) -> None:
        react(event)

    return awaited
