"""Hypothesis profiles, a worker for jobs, and a browser for the tests that look at pages.

HYPOTHESIS_PROFILE=ci repeats the same examples on every run, HYPOTHESIS_PROFILE=thorough takes many
more where a test leaves their number open.
"""

import os
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import settings
from kept_worker import KeptWorker, own_session
from screens import NoScreenError, headless_browser

from ifs_cad.workflow import supervise

# No deadline: a first call may import the CAD kernel, which takes seconds.
settings.register_profile("default", deadline=None, max_examples=50)
settings.register_profile("ci", settings.get_profile("default"), derandomize=True, print_blob=True)
settings.register_profile("thorough", deadline=None, max_examples=1000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "default"))


@pytest.fixture(scope="session", autouse=True)
def jobs_of_one_worker() -> Iterator[None]:
    """Let all jobs be done by one process, but for tests that ask for `own_worker`."""
    worker = KeptWorker()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(supervise, "session", worker.session)
        yield
    worker.end()


@pytest.fixture
def own_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give each job a process of its own, as users get it."""
    monkeypatch.setattr(supervise, "session", own_session)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Chromium without a screen, as Playwright sees it; for a module, as its loop bars others."""
    try:
        with headless_browser() as browser:
            yield browser
    except NoScreenError as error:
        pytest.skip(str(error))
