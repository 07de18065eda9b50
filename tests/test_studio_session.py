"""The studio's state as threads share it: gestures, files, what a crash leaves, recomputing."""

from __future__ import annotations

import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from ifs_cad.design_file import presets, read_design, write_design
from ifs_cad.errors import IfsCadError, InputError
from ifs_cad.studio.evaluation import Evaluation, evaluate
from ifs_cad.studio.model import autosave_path
from ifs_cad.studio.recompute import Recomputer
from ifs_cad.studio.session import Session, Snapshot

PLAIN = presets()["figure_17_offset_mesh"]
PATIENCE = 60.0  # seconds


def thicker(thickness: float) -> Any:
    return lambda model: model.set_thickness(thickness)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return write_design(PLAIN, tmp_path / "shell.toml")


@pytest.fixture
def session(path: Path) -> Session:
    return Session(path)


def test_positions_of_a_slider_are_one_step(session: Session) -> None:
    for thickness in (20.0, 25.0, 30.0):
        session.edit(thicker(thickness), "thickness")
    assert session.snapshot().gesture == "thickness"
    session.edit(lambda model: model.set_depth("a", 1), "a depth")
    session.undo()
    assert session.snapshot().design.thickness == 30.0
    session.undo()
    assert session.snapshot().design == PLAIN
    assert not session.undo()
    assert session.redo()
    assert session.redo()
    assert session.snapshot().design.a.depth == 1


def test_a_gesture_ends_when_all_is_quiet(path: Path) -> None:
    session = Session(path, quiet=0.0)
    session.edit(thicker(20.0), "thickness")
    assert session.settle_if_quiet()
    assert session.snapshot().gesture == ""
    assert not session.settle_if_quiet()
    patient = Session(path, quiet=PATIENCE)
    patient.edit(thicker(20.0), "thickness")
    assert not patient.settle_if_quiet()


def test_a_held_mouse_button_is_no_quiet(path: Path) -> None:
    session = Session(path, quiet=0.0)
    session.edit(thicker(20.0), "drag", held=True)
    assert not session.settle_if_quiet()
    session.settle()
    assert session.snapshot().gesture == ""


def test_a_refused_edit_leaves_the_design_and_no_step(session: Session) -> None:
    with pytest.raises(IfsCadError):
        session.edit(thicker(-1.0), "thickness")
    session.settle()
    assert session.snapshot().design == PLAIN
    assert not session.snapshot().can_undo


def test_every_change_is_told(session: Session) -> None:
    heard: list[Snapshot] = []
    session.changed = heard.append
    session.edit(thicker(20.0))
    session.undo()
    session.redo()
    assert [item.design.thickness for item in heard] == [20.0, PLAIN.thickness, 20.0]
    assert [item.can_undo for item in heard] == [True, False, True]


def test_a_new_file_is_made_by_saving(tmp_path: Path) -> None:
    session = Session(tmp_path / "new.toml")
    session.edit(thicker(12.0))
    assert not (tmp_path / "new.toml").exists()
    assert session.save() == tmp_path / "new.toml"
    assert read_design(tmp_path / "new.toml").thickness == 12.0
    assert session.snapshot().is_saved


def test_saving_elsewhere_goes_on_there(session: Session, path: Path) -> None:
    session.edit(thicker(12.0))
    other = path.with_name("other.toml")
    session.save(other)
    session.edit(thicker(13.0))
    session.save()
    assert read_design(path) == PLAIN
    assert read_design(other).thickness == 13.0
    assert session.stem == "other"
    session.edit(thicker(14.0))
    assert session.autosave()
    assert read_design(autosave_path(other)).thickness == 14.0


def test_an_opened_file_can_be_undone_and_the_unsaved_design_is_kept(
    session: Session, path: Path
) -> None:
    other = write_design(replace(PLAIN, thickness=33.0), path.with_name("other.toml"))
    session.edit(thicker(12.0))
    session.open(other)
    assert session.snapshot().design.thickness == 33.0
    assert session.path == other
    assert read_design(autosave_path(path)).thickness == 12.0
    session.undo()
    assert session.snapshot().design.thickness == 12.0


def test_a_broken_file_changes_nothing(session: Session, path: Path) -> None:
    broken = path.with_name("broken.toml")
    broken.write_text("version = 1\nthickness = 'thin'\n")
    with pytest.raises(InputError, match=r"broken\.toml, line 2"):
        session.open(broken)
    assert session.path == path
    assert session.snapshot().design == PLAIN
    with pytest.raises(InputError, match=r"broken\.toml"):
        Session(broken)


def test_what_a_crash_left_is_offered_and_not_written_over(session: Session, path: Path) -> None:
    session.edit(thicker(12.0))
    assert session.autosave()  # and then the machine stops
    after = Session(path)
    assert after.snapshot().design == PLAIN
    assert after.found is not None
    assert after.found.thickness == 12.0
    after.edit(thicker(50.0))
    assert not after.autosave()
    assert read_design(after.autosave_file).thickness == 12.0
    after.take_found()
    assert after.found is None
    assert after.snapshot().design.thickness == 12.0
    after.undo()
    assert after.snapshot().design.thickness == 50.0
    assert after.autosave()


def test_what_a_crash_left_can_be_dropped(session: Session, path: Path) -> None:
    session.edit(thicker(12.0))
    session.autosave()
    after = Session(path)
    after.drop_found()
    assert after.found is None
    assert not after.autosave_file.exists()
    assert Session(path).found is None


def test_nothing_is_offered_after_saving(session: Session, path: Path) -> None:
    session.edit(thicker(12.0))
    session.autosave()
    session.save()
    assert not session.autosave_file.exists()
    assert Session(path).found is None


def test_saving_waits_for_a_decision_about_what_a_crash_left(session: Session, path: Path) -> None:
    session.edit(thicker(12.0))
    session.autosave()
    after = Session(path)
    after.edit(thicker(50.0))
    for target in (None, path.with_name("other.toml")):
        with pytest.raises(InputError, match=r"\.shell\.autosave\.toml that saving would remove"):
            after.save(target)
    assert read_design(after.autosave_file).thickness == 12.0
    assert read_design(path) == PLAIN
    assert not path.with_name("other.toml").exists()
    assert after.path == path
    after.drop_found()
    after.save()
    assert read_design(path).thickness == 50.0
    after.edit(thicker(51.0))
    assert after.autosave()
    assert read_design(after.autosave_file).thickness == 51.0


def test_saving_elsewhere_spares_what_a_crash_left_there(session: Session, path: Path) -> None:
    other = write_design(PLAIN, path.with_name("other.toml"))
    left = write_design(replace(PLAIN, thickness=33.0), autosave_path(other))
    session.edit(thicker(12.0))
    with pytest.raises(InputError, match=r"\.other\.autosave\.toml\. Open .*other\.toml to see it"):
        session.save(other)
    assert read_design(other) == PLAIN
    assert session.path == path
    assert not session.snapshot().is_saved
    assert session.autosave()
    assert read_design(left).thickness == 33.0
    session.open(other)
    assert session.found is not None
    assert session.found.thickness == 33.0
    session.drop_found()
    session.undo()
    session.save(other)
    assert read_design(other).thickness == 12.0


@pytest.mark.parametrize("text", ["version = 99\n", "no TOML"])
def test_an_unreadable_rest_of_a_crash_is_moved_aside(path: Path, text: str) -> None:
    kept = autosave_path(path)
    for name in (".shell.autosave.bad.toml", ".shell.autosave.bad2.toml"):
        kept.write_text(text)
        session = Session(path)
        assert session.snapshot().design == PLAIN
        assert session.found is None
        assert str(path.with_name(name)) in session.aside
        assert path.with_name(name).read_text() == text
        assert not kept.exists()
    session.edit(thicker(12.0))
    assert session.autosave()
    assert Session(path).aside == ""


def test_opening_moves_an_unreadable_rest_aside_unless_the_file_is_broken(
    session: Session, path: Path
) -> None:
    other = path.with_name("other.toml")
    other.write_text("version = 99\n")
    kept = autosave_path(other)
    kept.write_text("version = 99\n")
    with pytest.raises(InputError):
        session.open(other)
    assert kept.exists()
    assert session.aside == ""
    write_design(PLAIN, other)
    session.open(other)
    assert not kept.exists()
    assert ".other.autosave.bad.toml" in session.aside


def test_a_design_without_a_file_is_kept_in_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    session = Session()
    session.edit(thicker(12.0))
    session.autosave()
    again = Session()
    assert again.found is not None
    assert again.found.thickness == 12.0


def snapshot(thickness: float, gesture: str = "") -> Snapshot:
    return Snapshot(replace(PLAIN, thickness=thickness), gesture, False, False, True)


def test_the_newest_state_wins() -> None:
    begun, go_on = threading.Event(), threading.Event()
    computed, shown = [], []

    def compute(design: Any, *, panels: bool, superseded: Any) -> Any:
        computed.append(design.thickness)
        begun.set()
        assert go_on.wait(PATIENCE)
        return None

    worker = Recomputer(lambda now, _: shown.append(now.design.thickness), pytest.fail, compute)
    worker.request(snapshot(1.0))
    assert begun.wait(PATIENCE)
    for thickness in (2.0, 3.0, 4.0):
        worker.request(snapshot(thickness))
    go_on.set()
    assert worker.wait(PATIENCE)
    worker.close()
    assert computed == shown == [1.0, 4.0]


def test_panels_are_made_after_the_gesture() -> None:
    shown: list[Evaluation] = []
    worker = Recomputer(lambda _, seen: shown.append(seen), pytest.fail)
    worker.request(snapshot(10.0, "drag"))
    assert worker.wait(PATIENCE)
    worker.request(snapshot(10.0))
    assert worker.wait(PATIENCE)
    worker.close()
    during, after = shown
    assert during.shell is None
    assert len(during.faces) == len(after.faces)
    assert after.report is not None


def test_a_failure_is_said_and_does_not_end_the_worker() -> None:
    said: list[str] = []
    shown: list[float] = []

    def compute(design: Any, *, panels: bool, superseded: Any) -> Evaluation:
        if design.thickness == 1.0:
            raise RuntimeError("out of luck")
        return evaluate(design, panels=False)

    def show(now: Snapshot, seen: Evaluation) -> None:
        if now.design.thickness == 2.0:
            raise InputError("nothing to see")
        shown.append(now.design.thickness)

    worker = Recomputer(show, said.append, compute)
    for thickness in (1.0, 2.0, 3.0):
        worker.request(snapshot(thickness))
        assert worker.wait(PATIENCE)
    worker.close()
    assert shown == [3.0]
    assert said[0].startswith("This design could not be shown: RuntimeError: out of luck (test_")
    assert said[1] == "nothing to see"
