"""An evaluation that nobody waits for any more ends early, and is not shown."""

from __future__ import annotations

import threading
from typing import Any

import pytest

from ifs_cad.design_file import presets
from ifs_cad.studio.evaluation import SupersededError, evaluate
from ifs_cad.studio.recompute import Recomputer
from ifs_cad.studio.session import Snapshot

PATIENCE = 60.0
DESIGN = presets()["figure_17_offset_mesh"]


def test_panels_are_given_up_between_their_parts_and_the_surface_never() -> None:
    asked: list[int] = []

    def superseded_at(last: int) -> Any:
        asked.clear()
        return lambda: asked.append(1) or len(asked) == last

    assert evaluate(DESIGN, superseded=superseded_at(0)).shell is not None
    parts = len(asked)
    assert parts > 1
    for last in range(1, parts + 1):
        with pytest.raises(SupersededError):
            evaluate(DESIGN, superseded=superseded_at(last))
        assert len(asked) == last
    surface = evaluate(DESIGN, panels=False, superseded=lambda: True)
    assert len(surface.faces) > 0


def test_a_superseded_state_is_not_shown_and_the_next_one_is() -> None:
    begun, shown = threading.Event(), []

    def compute(design: Any, *, panels: bool, superseded: Any) -> Any:
        if design == "first":
            begun.set()
            end = threading.Event()
            while not superseded():
                end.wait(0.01)
            raise SupersededError
        return design

    worker = Recomputer(lambda _, seen: shown.append(seen), pytest.fail, compute)
    try:
        worker.request(Snapshot("first", "", False, False, True))  # type: ignore[arg-type]
        assert begun.wait(PATIENCE)
        worker.request(Snapshot("second", "", False, False, True))  # type: ignore[arg-type]
        assert worker.wait(PATIENCE)
    finally:
        worker.close()
    assert shown == ["second"]
