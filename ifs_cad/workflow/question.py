"""What `ifs-cad analyse` asks, and how its words are read."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import cast

from ifs_cad.elements.fibre import FibreAlongCurve, SumCurve
from ifs_cad.elements.panel import Shell
from ifs_cad.errors import InputError
from ifs_cad.structure.analysis import PRESSURE, Analysis
from ifs_cad.structure.load import AreaLoad, Load, Loads, Per, PointLoad, SelfWeight
from ifs_cad.structure.model import Joints
from ifs_cad.structure.support import SIDES, Support
from ifs_cad.types import Plane


@dataclass(frozen=True)
class Question:
    """What is asked. What is left out, the part says itself (`Analysis`), or else the default.

    Parameters
    ----------
    load : float, optional, N/m2 of the ground plan; 1500 by default
    surface_load : float, optional, N/m2 of the panels themselves, downwards
    half : bool
        Load one half only: that of lower x, or y when the shell is longer along y.
    part : sequence of str
        Load only the panels whose addresses match one of these patterns.
    points : sequence of (address, N)
        Forces downwards in the middles of panels.
    weight : bool
        Add the weight of the panels.
    supports : sequence of str
        "standing" (the default), "borders", numbers or names of borders; with commas between too.
    joints : str, optional
        "hinge" (the default), "rigid" or a stiffness, N mm/rad per mm of edge.
    fibre : str, optional
        "a", "b" or "long": the curve along which the fibre runs, instead of the shell's own rule.
    divisions : int, optional, quads along each edge of a panel
        By default as many as keep the estimated error of the linear answer small.
    nonlinear : bool
        Find equilibrium in the deformed shape.
    modes : int
        How many natural frequencies; 0 for none.

    Raises
    ------
    InputError
        A word that is none, or a number that cannot be meant.
    """

    load: float | None = None
    surface_load: float | None = None
    half: bool = False
    part: Sequence[str] = ()
    points: Sequence[tuple[str, float]] = ()
    weight: bool = False
    supports: Sequence[str] = ()
    joints: str | None = None
    fibre: str | None = None
    divisions: int | None = None
    nonlinear: bool = False
    modes: int = 0

    def __post_init__(self) -> None:
        read_supports_text(self.supports)
        if self.joints is not None:
            _joints(self.joints)
        read_fibre(self.fibre)
        for value in (self.load, self.surface_load):
            if value is not None and not (math.isfinite(value) and value >= 0):
                raise InputError(f"The load must be 0 or more, got {value} N/m2.")
        if self.half and self.part:
            raise InputError("Load one half, or the panels that match a pattern, not both.")


def answer_to(shell: Shell, own: Analysis, question: Question) -> Analysis:
    """Return what a shell is asked: its own analysis, but for what the question says otherwise.

    Parameters
    ----------
    shell : Shell
    own : Analysis
    question : Question

    Raises
    ------
    InputError
    """
    return Analysis(
        loads=_loads(shell, own.loads, question),
        supports=read_supports_text(question.supports) if question.supports else own.supports,
        joints=own.joints if question.joints is None else _joints(question.joints),
    )


def read_supports_text(texts: Sequence[str]) -> list[Support]:
    """Read supports: "standing", "borders" for all of them, names and numbers of borders.

    Raises
    ------
    InputError
    """
    supports = []
    for word in (part.strip() for text in texts for part in text.split(",")):
        if word == "standing":
            supports.append(Support.standing())
        elif word == "borders":
            supports.append(Support.border())
        elif word in SIDES:
            supports.append(Support.border(word))
        elif word.isdecimal():
            supports.append(Support.border(int(word)))
        else:
            raise InputError(
                f"Unknown support {word!r}. Give standing, borders, the number of a border, or "
                f'some of {", ".join(SIDES)}, with commas between: "a start, a end".'
            )
    return supports


def read_fibre(text: str | None) -> FibreAlongCurve | None:
    """Read the curve along which the fibre runs: "a", "b" or "long".

    Raises
    ------
    InputError
    """
    return None if text is None else FibreAlongCurve(cast(SumCurve, text))


def _joints(text: str) -> Joints:
    named: dict[str, Joints] = {"hinge": "hinge", "rigid": "rigid"}
    if text in named:
        return named[text]
    try:
        return float(text)
    except ValueError:
        raise InputError(
            f"Joints are hinge, rigid or a stiffness in N mm/rad per mm of edge, not {text!r}."
        ) from None


def _loads(shell: Shell, own: Loads, question: Question) -> list[Load]:
    """Return the part's own loads, or instead of them those that are asked for."""
    spread = {"plan": question.load, "surface": question.surface_load}
    on = _first_half(shell) if question.half else tuple(question.part) or None
    loads: list[Load] = []
    if spread["plan"] is None and spread["surface"] is None:
        if on is not None:
            loads.append(AreaLoad(pressure=PRESSURE, on=on))
        elif not question.points:
            loads += own if isinstance(own, Iterable) else [own]
    per: Per
    for per in ("plan", "surface"):
        if spread[per]:
            loads.append(AreaLoad(pressure=spread[per] or 0.0, per=per, on=on))
    loads += [PointLoad(force=(0.0, 0.0, -size), at=at) for at, size in question.points]
    if question.weight:
        loads.append(SelfWeight())
    if not loads:
        raise InputError("Nothing is loaded. Give a load above 0, a point, or the weight.")
    return loads


def _first_half(shell: Shell) -> Plane:
    """Return the plane across the longer side in its middle; the lower x or y is above it."""
    low, high = shell.mesh.vertices.min(axis=0), shell.mesh.vertices.max(axis=0)
    along_y = bool((high - low)[1] > (high - low)[0])
    x, y, z = ((low + high) / 2).tolist()
    return Plane((x, y, z), (0.0, -1.0, 0.0) if along_y else (-1.0, 0.0, 0.0))
