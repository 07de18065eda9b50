"""Animations: frames, their camera, and what happens when they cannot be made."""

from __future__ import annotations

import ctypes.util
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cadquery as cq
import numpy as np
import pytest
from typer.testing import CliRunner

from ifs_cad.cli import app
from ifs_cad.errors import InputError, MissingLibraryError
from ifs_cad.view.animate import animate

Image = pytest.importorskip("PIL.Image", reason="pillow is not installed")

NO_EGL = sys.platform == "linux" and not ctypes.util.find_library("EGL")
draws = pytest.mark.skipif(NO_EGL, reason="no EGL: install libegl1 libegl-mesa0 libgl1-mesa-dri")
SMALL: dict[str, Any] = {"width": 160, "height": 100, "edges": False}


def towers() -> Iterator[cq.Workplane]:
    """A tower of 20 x 20 mm that grows to a height of 60 mm."""
    for height in (20, 40, 60):
        yield cq.Workplane().box(20, 20, height, centered=(True, True, False))


def is_model(picture: np.ndarray) -> np.ndarray:
    return np.ptp(picture.astype(int), axis=-1) > 25


@draws
def test_a_gif_has_the_frames_in_order_before_one_camera(tmp_path: Path) -> None:
    animate(towers(), tmp_path / "t.gif", seconds=0.9, elevation=0.0, **SMALL)
    with Image.open(tmp_path / "t.gif") as film:
        assert film.n_frames == 3
        assert film.size == (160, 100)
        assert film.info["loop"] == 0
        tops, feet = [], []
        for number in range(3):
            film.seek(number)
            assert film.info["duration"] == 300
            rows = np.flatnonzero(is_model(np.asarray(film.convert("RGB"))).any(axis=1))
            tops.append(rows[0])
            feet.append(rows[-1])
    assert np.ptp(feet) <= 1  # the camera and the floor stand still
    heights = np.array(feet) - tops
    assert heights / heights[-1] == pytest.approx([1 / 3, 2 / 3, 1], abs=0.06)


@draws
def test_there_and_back_ends_before_the_first_frame_comes_again(tmp_path: Path) -> None:
    animate(towers(), tmp_path / "t.gif", there_and_back=True, **SMALL)
    with Image.open(tmp_path / "t.gif") as film:
        assert film.n_frames == 4
        film.seek(1)
        there = np.asarray(film.convert("RGB"))
        film.seek(3)
        assert (there == np.asarray(film.convert("RGB"))).all()


@draws
def test_an_mp4_is_read_back_by_another_reader(tmp_path: Path) -> None:
    av = pytest.importorskip("av", reason="PyAV is not installed")
    animate(towers(), tmp_path / "t.mp4", seconds=1.0, **SMALL)
    with av.open(str(tmp_path / "t.mp4")) as film:
        frames = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
    assert len(frames) == 3
    assert frames[0].shape == (100, 160, 3)
    shares = [is_model(frame).mean() for frame in frames]
    assert shares[0] < 0.6 * shares[1] < 0.6 * 0.9 * shares[2]


@draws
def test_the_command_sweeps_a_parameter_of_a_script(tmp_path: Path) -> None:
    script = tmp_path / "tower.py"
    script.write_text(
        "import cadquery as cq\nheight = 20.0\n"
        "show_object(cq.Workplane().box(20, 20, height, centered=(True, True, False)))\n"
    )
    target = tmp_path / "out" / "t.gif"
    arguments = ["animate", str(script), "--sweep", "height=20:60", "--frames", "3"]
    size = ["--width", "160", "--height", "100", "--no-edges"]
    done = CliRunner().invoke(app, [*arguments, *size, "-o", str(target)])
    assert done.exit_code == 0, done.output
    with Image.open(target) as film:
        assert film.n_frames == 3
    assert [path.name for path in target.parent.iterdir()] == ["t.gif"]


@pytest.mark.parametrize(
    ("sweep", "frames", "values"),
    [
        (("1", "4"), None, ["1", "2", "3", "4"]),
        (("4", "0"), 3, ["4", "2", "0"]),
        (("0", "0.5"), 3, ["0", "0.25", "0.5"]),
        (("0", "1"), 5, ["0", "0.25", "0.5", "0.75", "1"]),
        (("0", "1.0"), None, [f"{step / 23:.9g}" for step in range(24)]),
    ],
)
def test_whole_numbers_go_one_by_one_and_others_evenly(
    sweep: tuple[str, str], frames: int | None, values: list[str]
) -> None:
    from ifs_cad.cli.see import _values

    assert _values(*sweep, frames) == values


@pytest.mark.parametrize("text", ["height", "height=1", "height=a:b", "=1:2"])
def test_a_sweep_that_cannot_be_read_is_a_wrong_command_line(text: str) -> None:
    done = CliRunner().invoke(app, ["animate", "x.py", "--sweep", text, "-o", "x.gif"])
    assert done.exit_code == 2


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("t.avi", {}, r"\.gif or an \.mp4"),
        ("t.gif", {"seconds": 0.0}, "more than 0 seconds"),
        ("t.gif", {"width": 7}, "whole pixels"),
        ("t.mp4", {"width": 161}, "even width"),
    ],
)
def test_what_cannot_be_meant_is_refused_before_anything_is_drawn(
    tmp_path: Path, name: str, options: dict[str, Any], message: str
) -> None:
    def never() -> Iterator[Any]:
        pytest.fail("a frame was made")
        yield

    with pytest.raises(InputError, match=message):
        animate(never(), tmp_path / name, **{**SMALL, **options})
    assert not list(tmp_path.iterdir())


def test_a_single_frame_is_no_animation(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="2 frames or more, got 1"):
        animate([cq.Workplane().box(1, 1, 1)], tmp_path / "t.gif", **SMALL)


def test_a_missing_library_is_named_with_its_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(MissingLibraryError, match=r"ifs-cad\[animation\]"):
        animate(towers(), tmp_path / "t.mp4", **SMALL)
