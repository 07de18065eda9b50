"""The studio without its page: a design, its history, and the rules by which it changes.

Every change that cannot be meant is refused with an `IfsCadError` and leaves the design as it was;
every design that can be drawn at all is accepted, and `evaluate` tells what is wrong with it.

Terms
-----
drag : changes from pressing to releasing the mouse. They are one step of the history, and each is
    made from the design at the beginning, so that no place along the way leaves a trace.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from ifs_cad.design_file import presets, read_design, write_design
from ifs_cad.design_record import Design, DrawnCurve
from ifs_cad.elements.thicken import Side
from ifs_cad.errors import ExportError, InputError
from ifs_cad.studio import editing
from ifs_cad.studio.evaluation import CurveName, Evaluation, evaluate
from ifs_cad.types import ArrayLike

MOST_STEPS = 200
"""Steps that can be undone."""

FIRST_PRESET = "figure_21_prototype"

__all__ = ["StudioModel", "autosave_path", "recover"]


def autosave_path(path: str | os.PathLike[str], number: int = 1) -> Path:
    """Return where the studio saves a design by itself: beside its file.

    Parameters
    ----------
    path : path
        The design file.
    number : int
        Of several such places, the first by default.
    """
    target = Path(path)
    ending = "" if number == 1 else f"-{number}"
    return target.with_name(f".{target.stem}.autosave{ending}{target.suffix}")


def recover(path: str | os.PathLike[str]) -> Design | None:
    """Return the design that an autosave holds, None when there is none.

    Raises
    ------
    InputError
        It cannot be read.
    """
    return read_design(path) if Path(path).exists() else None


class StudioModel:
    """A design that is being shaped.

    Parameters
    ----------
    design : Design, optional
        The paper's prototype by default.
    autosave : path, optional
        Where `autosave` writes.
    """

    def __init__(
        self, design: Design | None = None, *, autosave: str | os.PathLike[str] | None = None
    ) -> None:
        self._design = presets()[FIRST_PRESET] if design is None else design
        self._past: list[Design] = []
        self._future: list[Design] = []
        self._drag_start: Design | None = None
        self._saved = self._design
        self._kept = self._design
        self._autosave = None if autosave is None else Path(autosave)

    @property
    def design(self) -> Design:
        """The design as it is; frozen, so that a worker may evaluate it while it is replaced."""
        return self._design

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to undo."""
        return bool(self._past) or self.is_dragging

    @property
    def can_redo(self) -> bool:
        """Whether there is a step to do again."""
        return bool(self._future)

    @property
    def is_dragging(self) -> bool:
        """Whether a drag has begun and not ended."""
        return self._drag_start is not None

    @property
    def is_saved(self) -> bool:
        """Whether the design is as it was when last saved or loaded."""
        return self._design == self._saved

    def evaluate(self, *, panels: bool = True) -> Evaluation:
        """Return what the design looks like and what is wrong with it; see `evaluate`."""
        return evaluate(self._design, panels=panels)

    def move_control_point(self, curve: CurveName, index: int, point: ArrayLike) -> None:
        """Put a control point elsewhere, mm; in symmetric editing its image moves too."""
        self._edit(curve, lambda drawn: editing.moved_control_point(drawn, index, point))

    def move_subdivision_point(self, curve: CurveName, name: str, point: ArrayLike) -> None:
        """Put a subdivision point at the nearest place that it can reach, mm."""
        self._edit(curve, lambda drawn: editing.moved_subdivision_point(drawn, name, point))

    def reset_subdivision_point(self, curve: CurveName, name: str) -> None:
        """Let a subdivision point go back to where the roughness has it."""
        self._edit(curve, lambda drawn: editing.reset_subdivision_point(drawn, name))

    def set_weight(self, curve: CurveName, handle: int | str, weight: float) -> None:
        """Set the weight of a control point (by number) or of a subdivision point (by name)."""
        if isinstance(handle, str):
            self._edit(
                curve,
                lambda drawn: editing.moved_subdivision_point(drawn, handle, weight=weight),
            )
        else:
            self._edit(
                curve, lambda drawn: editing.moved_control_point(drawn, handle, weight=weight)
            )

    def set_depth(self, curve: CurveName, depth: int) -> None:
        """Set the number of construction steps."""
        self._edit(curve, lambda drawn: replace(drawn, depth=depth))

    def set_roughness(self, curve: CurveName, roughness: float) -> None:
        """Set the roughness, from -1/3 to 1; moved subdivision points change with it."""
        self._edit(curve, lambda drawn: editing.with_roughness(drawn, roughness))

    def set_fold(self, curve: CurveName, slope: float | None) -> None:
        """Set the slope of the even fold, rise over run, or take it off."""
        self._edit(curve, lambda drawn: replace(drawn, fold=slope))

    def set_transformations(self, curve: CurveName, count: int) -> None:
        """Set the number of transformations; moved subdivision points go back."""
        self._edit(curve, lambda drawn: editing.with_transformations(drawn, transformations=count))

    def set_closed(self, curve: CurveName, closed: bool) -> None:
        """Close a curve or open it; moved subdivision points go back."""
        self._edit(curve, lambda drawn: editing.with_transformations(drawn, closed=closed))

    def set_symmetric(self, curve: CurveName, symmetric: bool) -> None:
        """Turn symmetric editing on, which makes the curve symmetric, or off."""
        self._edit(curve, lambda drawn: editing.with_symmetry(drawn, symmetric))

    def add_control_point(self, curve: CurveName) -> None:
        """Add a control point that leaves the shape; see `editing.with_control_point_added`."""
        self._edit(curve, editing.with_control_point_added)

    def remove_control_point(self, curve: CurveName, index: int) -> None:
        """Remove a control point; moved subdivision points go back."""
        self._edit(curve, lambda drawn: editing.with_control_point_removed(drawn, index))

    def set_thickness(self, thickness: float) -> None:
        """Set the thickness of the sheet, mm."""
        self.change(thickness=thickness)

    def set_side(self, side: Side) -> None:
        """Set where panels lie about the surface: "outer", "inner" or "centre"."""
        self.change(side=side)

    def set_floor(self, height: float | None) -> None:
        """Set the height of the floor, mm, or take it away."""
        self.change(floor=height)

    def change(self, **values: Any) -> None:
        """Set any other fields of the design: nodes, clearance, label, holes, fibre, title, ...

        Raises
        ------
        InputError
            A value that cannot be meant.
        """
        self._become(replace(self._start, **values))

    def load_preset(self, name: str) -> None:
        """Take a design of the paper's figures; it can be undone.

        Raises
        ------
        InputError
            There is none of this name; the message lists them.
        """
        known = presets()
        if name not in known:
            raise InputError(f"There is no preset {name!r}; there are {', '.join(known)}.")
        self.take(known[name])

    def take(self, design: Design) -> None:
        """Take a whole design in place of the present one; it can be undone."""
        self.end_drag()
        self._become(design)

    def begin_drag(self) -> None:
        """Make all changes until `end_drag` one step."""
        self.end_drag()
        self._drag_start = self._design

    def end_drag(self) -> None:
        """End a drag, if there is one."""
        start, self._drag_start = self._drag_start, None
        if start is not None and start != self._design:
            self._remember(start)

    def undo(self) -> bool:
        """Take one step back, and tell whether there was one; a drag ends first."""
        self.end_drag()
        return self._step(self._past, self._future)

    def redo(self) -> bool:
        """Do an undone step again, and tell whether there was one."""
        self.end_drag()
        return self._step(self._future, self._past)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the design file and remove the autosave, which it makes needless.

        Raises
        ------
        ExportError
            It could not be written; what stood there is unchanged.
        """
        target = write_design(self._design, path)
        self._saved = self._kept = self._design
        self.discard_autosave()
        return target

    def load(self, path: str | os.PathLike[str]) -> None:
        """Read a design file; the history of the former design ends.

        A step back would put another design where saving replaces the file that was read.

        Raises
        ------
        InputError
            It cannot be read; the message says why.
        """
        self.take(read_design(path))
        self._past.clear()
        self._future.clear()
        self._saved = self._design

    def autosave(self) -> bool:
        """Write the design where it survives a crash, if it changed; tell whether it did.

        The caller decides how often.

        Raises
        ------
        ExportError
            It could not be written.
        """
        if self._autosave is None or self._design == self._kept:
            return False
        write_design(self._design, self._autosave)
        self._kept = self._design
        return True

    def keep_in(self, path: str | os.PathLike[str], holds: Design | None = None) -> None:
        """Write the autosave to another file from now on; the former one is left alone.

        Parameters
        ----------
        path : path
        holds : Design, optional
            What that file holds; nothing that matters by default.
        """
        if self._autosave != Path(path):
            self._autosave = Path(path)
            self._kept = self._saved if holds is None else holds

    def discard_autosave(self) -> None:
        """Remove the autosave, when all is saved or the designer does not want it back."""
        if self._autosave is not None:
            try:
                self._autosave.unlink(missing_ok=True)
            except OSError as error:
                raise ExportError(f"Cannot remove {self._autosave}: {error.strerror}.") from error

    @property
    def _start(self) -> Design:
        """What a change is made from."""
        return self._design if self._drag_start is None else self._drag_start

    def _edit(self, curve: CurveName, edit: Callable[[DrawnCurve], DrawnCurve]) -> None:
        if curve not in ("a", "b"):
            raise InputError(f'A design has the curves "a" and "b", none {curve!r}.')
        drawn: DrawnCurve = getattr(self._start, curve)
        changes: dict[str, Any] = {curve: edit(drawn)}
        self._become(replace(self._start, **changes))

    def _become(self, design: Design) -> None:
        if design == self._design:
            return
        if not self.is_dragging:
            self._remember(self._design)
        self._design = design

    def _remember(self, design: Design) -> None:
        self._past.append(design)
        del self._past[:-MOST_STEPS]
        self._future.clear()

    def _step(self, source: list[Design], target: list[Design]) -> bool:
        if not source:
            return False
        target.append(self._design)
        self._design = source.pop()
        return True
