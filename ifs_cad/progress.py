"""How far a long computation has come, for whoever wants to know.

Library code calls `report`; nothing happens unless a caller further up has asked to be told with
`listening`. A *stage* is what the user sees: "panels", "writing shell.step".
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Callback = Callable[[str, int, int | None], None]
"""Takes the stage, how much of it is done, and of how much (None: not known)."""


def _ignore(stage: str, done: int, total: int | None) -> None:
    pass


_callback: ContextVar[Callback] = ContextVar("progress", default=_ignore)


def report(stage: str, done: int = 0, total: int | None = None) -> None:
    """Tell how far a stage has come.

    Parameters
    ----------
    stage : str
        What is being done, in words for the user.
    done, total : int
        Steps done and steps there are; without a total only the stage is known.
    """
    _callback.get()(stage, done, total)


@contextmanager
def listening(callback: Callback) -> Iterator[None]:
    """Pass every report made within the block, on this thread, to a callback."""
    token = _callback.set(callback)
    try:
        yield
    finally:
        _callback.reset(token)
