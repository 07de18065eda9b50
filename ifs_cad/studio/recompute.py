"""Computing what the page shows, in a thread of its own.

A mouse moves faster than panels can be made, so there is no queue: the newest state wins, and those
that came while another was computed are never computed at all.
"""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable

from ifs_cad.errors import IfsCadError
from ifs_cad.studio.evaluation import Evaluation, SupersededError, evaluate
from ifs_cad.studio.session import Snapshot

Show = Callable[[Snapshot, Evaluation], None]

__all__ = ["Recomputer"]


class Recomputer:
    """A thread that evaluates the newest snapshot.

    Without panels while a gesture goes on, with everything after it.

    Parameters
    ----------
    show : callable
        Takes the snapshot and what it looks like. Called in the thread.
    failed : callable
        Takes a text when evaluating or showing fails for a reason that is not the design's. The
        thread goes on with the next snapshot.
    compute : callable
        As `evaluate`; what it raises when it is superseded is passed over.
    """

    def __init__(
        self,
        show: Show,
        failed: Callable[[str], None],
        compute: Callable[..., Evaluation] = evaluate,
    ) -> None:
        self._show = show
        self._failed = failed
        self._compute = compute
        self._newest: Snapshot | None = None
        self._ended = False
        self._busy = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._work, name="recompute", daemon=True)
        self._thread.start()

    def request(self, snapshot: Snapshot) -> None:
        """Take this snapshot next, instead of one that was not begun yet."""
        with self._changed:
            self._newest = snapshot
            self._changed.notify_all()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until nothing is left to do, and tell whether that came to pass.

        Parameters
        ----------
        timeout : float, seconds, optional
        """
        with self._changed:
            return self._changed.wait_for(lambda: not self._busy and self._newest is None, timeout)

    def close(self) -> None:
        """End the thread, after what it is computing."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()
        self._thread.join(timeout=10.0)

    def _work(self) -> None:
        while (snapshot := self._next()) is not None:
            try:
                panels = not snapshot.gesture
                evaluation = self._compute(
                    snapshot.design, panels=panels, superseded=self._is_superseded
                )
                self._show(snapshot, evaluation)
            except SupersededError:
                continue
            except Exception as error:
                self._failed(_words(error))

    def _is_superseded(self) -> bool:
        return self._newest is not None

    def _next(self) -> Snapshot | None:
        with self._changed:
            self._busy = False
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._ended or self._newest is not None)
            if self._ended:
                return None
            snapshot, self._newest = self._newest, None
            self._busy = True
            return snapshot


def _words(error: Exception) -> str:
    if isinstance(error, IfsCadError):
        return str(error)
    where = traceback.extract_tb(error.__traceback__)[-1]
    place = f"{where.filename.rpartition('/')[2]}, line {where.lineno}"
    return f"This design could not be shown: {type(error).__name__}: {error} ({place})."
