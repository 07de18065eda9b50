"""The studio's state as threads share it: gestures, files, what a crash leaves, recomputing."""

from __future__ import annotations

import os
import subprocess
import sys
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

pytest.importorskip("filelock", reason="the studio is not installed (extra 'studio')")

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


def crash(session: Session) -> None:
    """End as a process does that is killed: the system lets go of its locks, no more."""
    session.autosave()
    session.close()


def thickness_in(file: Path) -> float:
    return read_design(file).thickness


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


def test_a_step_back_does_not_cross_an_opened_file(session: Session, path: Path) -> None:
    other = write_design(replace(PLAIN, thickness=33.0), path.with_name("other.toml"))
    session.edit(thicker(12.0))
    session.open(other)
    assert session.snapshot().design.thickness == 33.0
    assert session.path == other
    assert thickness_in(autosave_path(path)) == 12.0
    assert session.left_behind == [autosave_path(path)]
    assert not session.undo()
    session.save()
    assert thickness_in(other) == 33.0
    session.open(path)
    (found,) = session.found
    assert found.design.thickness == 12.0


def test_another_design_does_not_take_the_place_of_the_open_file(
    session: Session, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(path.parent)
    session.edit(thicker(12.0))
    session.take(replace(PLAIN, thickness=33.0))
    assert session.path is None
    assert session.snapshot().design.thickness == 33.0
    assert thickness_in(autosave_path(path)) == 12.0
    session.autosave()
    assert thickness_in(autosave_path("untitled.toml")) == 33.0
    session.undo()
    assert session.snapshot().design.thickness == 12.0
    with pytest.raises(InputError, match=r"shell\.toml exists\. Press once more"):
        session.save(path)
    assert read_design(path) == PLAIN
    session.save(path)
    assert thickness_in(path) == 12.0
    assert session.left_behind == []
    assert not autosave_path(path).exists(), "what it held is saved"


def test_a_design_that_was_taken_is_saved_under_a_name_of_its_own(
    session: Session, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(path.parent)
    session.edit(thicker(12.0))
    session.take(replace(PLAIN, thickness=33.0))
    assert session.save() == Path("untitled.toml")
    assert thickness_in(Path("untitled.toml")) == 33.0
    assert read_design(path) == PLAIN
    assert session.left_behind == [autosave_path(path)]


def test_a_file_that_was_changed_meanwhile_is_replaced_when_asked_twice(
    session: Session, path: Path
) -> None:
    write_design(replace(PLAIN, title="by hand"), path)
    session.edit(thicker(12.0))
    for between in (lambda: session.edit(thicker(13.0)), session.undo, session.withdraw):
        with pytest.raises(InputError, match=r"shell\.toml was changed on disk .* Save again"):
            session.save()
        between()
    with pytest.raises(InputError, match="changed on disk"):
        session.save()
    write_design(replace(PLAIN, title="again by hand"), path)
    with pytest.raises(InputError, match="changed on disk"):
        session.save()
    assert read_design(path).title == "again by hand"
    session.save()
    assert read_design(path) == session.snapshot().design
    session.edit(thicker(14.0))
    session.save()
    assert thickness_in(path) == 14.0


def test_a_file_that_appeared_meanwhile_is_not_replaced_at_once(tmp_path: Path) -> None:
    session = Session(tmp_path / "new.toml")
    session.edit(thicker(12.0))
    write_design(PLAIN, tmp_path / "new.toml")
    with pytest.raises(InputError, match="changed on disk"):
        session.save()
    assert read_design(tmp_path / "new.toml") == PLAIN


def test_an_open_file_that_was_removed_is_written_again(session: Session, path: Path) -> None:
    path.unlink()
    session.save()
    assert read_design(path) == PLAIN


def test_another_file_is_replaced_when_asked_twice_without_anything_between(
    session: Session, path: Path
) -> None:
    other = write_design(PLAIN, path.with_name("other.toml"))
    third = write_design(PLAIN, path.with_name("third.toml"))
    session.edit(thicker(12.0))
    for target in (other, third, other):
        with pytest.raises(InputError, match=r"exists\. Press once more to replace it"):
            session.save(target)
    session.save(other)
    assert thickness_in(other) == 12.0
    assert read_design(third) == PLAIN


def test_a_broken_file_changes_nothing(session: Session, path: Path) -> None:
    broken = path.with_name("broken.toml")
    broken.write_text("version = 1\nthickness = 'thin'\n")
    with pytest.raises(InputError, match=r"broken\.toml, line 2"):
        session.open(broken)
    assert session.path == path
    assert session.snapshot().design == PLAIN
    with pytest.raises(InputError, match=r"broken\.toml"):
        Session(broken)


def test_what_a_crash_left_and_what_is_shaped_after_it_are_both_kept(
    session: Session, path: Path
) -> None:
    session.edit(thicker(12.0))
    crash(session)
    after = Session(path)
    assert after.snapshot().design == PLAIN
    after.edit(thicker(50.0))
    assert after.autosave()
    assert thickness_in(autosave_path(path)) == 12.0
    assert after.autosave_file == path.with_name(".shell.autosave-2.toml")
    assert thickness_in(after.autosave_file) == 50.0
    crash(after)
    third = Session(path)
    assert {found.design.thickness for found in third.found} == {12.0, 50.0}
    third.edit(thicker(70.0))
    assert third.autosave()
    assert third.autosave_file == path.with_name(".shell.autosave-3.toml")


def test_the_newest_of_what_crashes_left_is_offered_first(path: Path) -> None:
    for number, (thickness, age) in enumerate(((12.0, 20), (50.0, 10), (70.0, 30)), 1):
        kept = write_design(replace(PLAIN, thickness=thickness), autosave_path(path, number))
        os.utime(kept, (10_000 - age, 10_000 - age))
    assert [found.design.thickness for found in Session(path).found] == [50.0, 12.0, 70.0]


def test_going_on_with_what_a_crash_left_keeps_what_was_shaped_before(
    session: Session, path: Path
) -> None:
    session.edit(thicker(12.0))
    crash(session)
    after = Session(path)
    after.edit(thicker(50.0))
    (found,) = after.found
    after.take_found(found)
    assert after.found == ()
    assert after.snapshot().design.thickness == 12.0
    assert thickness_in(after.autosave_file) == 12.0
    (behind,) = after.left_behind
    assert thickness_in(behind) == 50.0
    after.undo()
    assert after.snapshot().design.thickness == 50.0
    after.redo()
    after.save()
    assert not after.autosave_file.exists()
    crash(after)
    assert [found.design.thickness for found in Session(path).found] == [50.0]


def test_what_a_crash_left_can_be_dropped(session: Session, path: Path) -> None:
    session.edit(thicker(12.0))
    crash(session)
    after = Session(path)
    after.edit(thicker(50.0))
    after.autosave()
    (found,) = after.found
    after.drop_found(found)
    assert after.found == ()
    assert not found.file.exists()
    assert thickness_in(after.autosave_file) == 50.0
    after.take_found(found)  # on a page that has not heard of it yet
    assert after.snapshot().design.thickness == 50.0


def test_nothing_is_offered_after_saving(session: Session, path: Path) -> None:
    session.edit(thicker(12.0))
    session.autosave()
    session.save()
    assert not session.autosave_file.exists()
    session.close()
    assert Session(path).found == ()


def test_saving_leaves_what_a_crash_left(session: Session, path: Path) -> None:
    session.edit(thicker(12.0))
    crash(session)
    after = Session(path)
    after.edit(thicker(50.0))
    after.autosave()
    after.save()
    assert thickness_in(path) == 50.0
    assert not after.autosave_file.exists()
    after.save(path.with_name("other.toml"))
    assert after.found == ()
    assert after.left_behind == [autosave_path(path)]
    crash(after)
    assert [found.design.thickness for found in Session(path).found] == [12.0]


def test_two_studios_keep_one_design_in_two_files(session: Session, path: Path) -> None:
    session.edit(thicker(12.0))
    session.autosave()
    assert session.shared == ""
    second = Session(path)
    assert second.found == ()
    assert "shell.toml is also open in another studio" in second.shared
    second.edit(thicker(50.0))
    assert second.autosave()
    assert thickness_in(autosave_path(path)) == 12.0
    assert thickness_in(second.autosave_file) == 50.0
    second.save()
    assert thickness_in(autosave_path(path)) == 12.0
    with pytest.raises(InputError, match="changed on disk"):
        session.save()
    second.close()
    crash(session)
    third = Session(path)
    assert third.shared == ""
    assert [found.design.thickness for found in third.found] == [12.0]


def test_a_studio_that_ended_leaves_no_lock(session: Session, path: Path) -> None:
    assert len(list(path.parent.iterdir())) == 2
    session.open(path)
    session.save(path.with_name("other.toml"))
    closing = threading.Thread(target=session.close)  # not the one that opened it
    closing.start()
    closing.join()
    assert {file.name for file in path.parent.iterdir()} == {"shell.toml", "other.toml"}


def test_the_lock_of_a_studio_that_was_killed_holds_nobody_up(path: Path) -> None:
    code = (
        "import os, sys\nfrom ifs_cad.studio.session import Session\n"
        "session = Session(sys.argv[1])\n"
        "session.edit(lambda model: model.set_thickness(12.0))\n"
        "session.autosave()\nos._exit(1)"
    )
    subprocess.run([sys.executable, "-c", code, str(path)], check=False, timeout=PATIENCE)
    assert len(list(path.parent.iterdir())) == 3, "the lock stays behind"
    after = Session(path)
    assert after.shared == ""
    assert [found.design.thickness for found in after.found] == [12.0]


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
    assert thickness_in(left) == 33.0
    session.open(other)
    (found,) = session.found
    assert found.design.thickness == 33.0


@pytest.mark.parametrize("text", ["version = 99\n", "no TOML"])
def test_an_unreadable_rest_of_a_crash_is_moved_aside(path: Path, text: str) -> None:
    kept = autosave_path(path)
    for name in (".shell.autosave.bad.toml", ".shell.autosave.bad2.toml"):
        kept.write_text(text)
        session = Session(path)
        assert session.snapshot().design == PLAIN
        assert session.found == ()
        assert str(path.with_name(name)) in session.aside
        assert path.with_name(name).read_text() == text
        assert not kept.exists()
        session.close()
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
    crash(session)
    (found,) = Session().found
    assert found.design.thickness == 12.0


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
