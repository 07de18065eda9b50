"""One worker process for all jobs of a test run, so that the kernel is loaded once.

It is the same worker behind the same protocol; only its life is longer. What ends it in a real
session (an interruption, its death) ends it here too, and the next job gets another. Tests of the
life of workers take real sessions, by the fixture `own_worker`.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from unittest import mock

from ifs_cad.errors import IfsCadError, WorkerError
from ifs_cad.workflow import supervise

# a worker begins where its parent is: this one follows to where the parent of each job is
START = """\
import os, sys
sys.path[:] = sys.argv[1:]
from ifs_cad.workflow import worker
worker.JOBS["go to"] = lambda folder: os.chdir(folder) or {}
worker.main()
"""


own_session = supervise.session


class _Whoever(supervise.Listener):
    """Passes what it hears on to the listener of the present job."""

    def __init__(self) -> None:
        super().__init__()
        self.now = supervise.Listener()

    def stage(self, name: str, done: int, total: int | None) -> None:
        self.now.stage(name, done, total)

    def text(self, line: str, stream: str) -> None:
        self.now.text(line, stream)

    def idle(self) -> None:
        self.now.idle()


class KeptWorker:
    """A worker that is started when it is first needed."""

    def __init__(self) -> None:
        self._life = contextlib.ExitStack()
        # a worker dies with the thread that started it, and a job's own thread ends with the job
        self._starter = ThreadPoolExecutor(1)
        self._listener = _Whoever()
        self._do: supervise.Job | None = None

    @contextlib.contextmanager
    def session(self, listener: supervise.Listener) -> Iterator[supervise.Job]:
        """Stand in for `supervise.session`."""
        if self._do is None:
            with mock.patch.object(supervise, "START", START):
                begun = self._starter.submit(self._life.enter_context, own_session(self._listener))
                self._do = begun.result()
        self._listener.now = listener
        try:
            self._do("go to", {"folder": os.getcwd()})
            yield self._do
        except WorkerError:
            self.end()
            raise
        except IfsCadError:
            raise
        except BaseException:
            self.end()
            raise

    def end(self) -> None:
        """Kill the worker."""
        self._do = None
        self._life.close()
