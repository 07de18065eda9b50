"""What a design must meet to be built: named constraints, checked together, with a report.

A constraint is a small value, such as ``MinimumEdge(100)``, that looks at a mesh or a discrete
curve and returns a result: whether it is met, the worst number there is, and the offenders by
address. A node is named by the faces around it.

Terms
-----
topological constraint : how parts hang together; `ifs_cad.design.connection`.
geometric constraint : sizes and shapes; `ifs_cad.design.form`, `ifs_cad.design.development`.

Source: the paper, section 3.3.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Literal, NoReturn, Protocol

import numpy as np

from ifs_cad.design.address import listed
from ifs_cad.design.curve import Curve
from ifs_cad.design.mesh import Mesh
from ifs_cad.errors import ConstraintError, InputError
from ifs_cad.types import ArrayLike, BoolArray, FloatArray, vector

Bound = Literal["at least", "at most", "exactly"]

__all__ = [
    "Bound",
    "Constraint",
    "ConstraintReport",
    "ConstraintResult",
    "check_constraints",
    "curve_names",
    "judged",
    "looks_at",
    "node_faces",
    "positive",
]


@dataclass(frozen=True)
class ConstraintResult:
    """How a design stands to one constraint.

    Attributes
    ----------
    name : str
        Of the constraint, for reports.
    ok : bool
    value : float
        The worst there is; the limit itself when there is nothing to look at.
    limit : float
    bound : "at least", "at most" or "exactly"
        How the value must stand to the limit.
    unit : str
    addresses : tuple of str
        The offenders: faces, segments or elements. Empty when the constraint is met.
    note : str
        What else there is to say.
    """

    name: str
    ok: bool
    value: float
    limit: float
    bound: Bound
    unit: str = ""
    addresses: tuple[str, ...] = ()
    note: str = ""

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        text = (
            f"{'met' if self.ok else 'NOT MET'}: {self.name}, {self.value:.6g}{unit} "
            f"({self.bound} {self.limit:.6g})"
        )
        if self.note:
            text += f"; {self.note}"
        if self.addresses:
            text += f"; {len(self.addresses)} offenders: {listed(self.addresses)}"
        return text


class Constraint(Protocol):
    """Anything that can judge a design."""

    def check(self, design: Any) -> ConstraintResult:
        """Return how a design stands to the constraint."""


@dataclass(frozen=True)
class ConstraintReport:
    """The results of several constraints, in the order they were asked for.

    Attributes
    ----------
    results : tuple of ConstraintResult
    """

    results: tuple[ConstraintResult, ...]

    @property
    def ok(self) -> bool:
        """Whether all constraints are met."""
        return all(result.ok for result in self.results)

    @property
    def failed(self) -> tuple[ConstraintResult, ...]:
        """The results that are not met."""
        return tuple(result for result in self.results if not result.ok)

    def __str__(self) -> str:
        met = len(self.results) - len(self.failed)
        lines = [f"{met} of {len(self.results)} constraints are met."]
        return "\n".join(lines + [f"  {result}" for result in self.results])

    def require(self) -> None:
        """Raise unless all constraints are met.

        Raises
        ------
        ConstraintError
            Lists what is not met; carries the offenders of all, each once.
        """
        if self.ok:
            return
        offenders = dict.fromkeys(name for result in self.failed for name in result.addresses)
        raise ConstraintError(
            f"{len(self.failed)} of {len(self.results)} constraints are not met:\n"
            + "\n".join(f"  {result}" for result in self.failed),
            addresses=offenders,
            failed=tuple(result.name for result in self.failed),
        )


def check_constraints(design: Any, constraints: Iterable[Constraint]) -> ConstraintReport:
    """Check a design against constraints.

    Parameters
    ----------
    design : Mesh, Curve or Elements
    constraints : iterable of Constraint
        For example ``[MinimumEdge(100), NodeValence(6), MaximumPart(2500, 1250)]``.

    Returns
    -------
    ConstraintReport
        Readable as text; ``report.require()`` raises when something is not met.

    Raises
    ------
    InputError
        A constraint that does not look at designs of this kind.
    """
    return ConstraintReport(tuple(constraint.check(design) for constraint in constraints))


def judged(
    name: str,
    values: FloatArray,
    bound: Bound,
    limit: float,
    offenders: Callable[[BoolArray], Iterable[str]],
    *,
    unit: str = "",
    slack: float = 0.0,
    note: str = "",
) -> ConstraintResult:
    """Return the result of measured values.

    Parameters
    ----------
    values : (n,) float
        What was measured; met when there is none.
    bound, limit
        How each of them must stand to what.
    offenders : callable
        Gives the addresses of those that do not.
    slack : float
        How far a value may be on the wrong side of the limit by rounding.
    """
    excess = {"at least": limit - values, "at most": values - limit, "exactly": abs(values - limit)}
    bad = excess[bound] > slack
    worst = float(values[int(excess[bound].argmax())]) if len(values) else limit
    names = tuple(offenders(bad)) if bad.any() else ()
    return ConstraintResult(name, not bad.any(), worst, limit, bound, unit, names, note)


def looks_at(constraint: Constraint, design: Any, kinds: str) -> NoReturn:
    """Refuse a design of a kind that a constraint does not look at.

    Raises
    ------
    InputError
    """
    raise InputError(
        f"{type(constraint).__name__} looks at {kinds}, not at a {type(design).__name__}."
    )


def positive(value: float, what: str) -> float:
    """Read a finite number above zero.

    Raises
    ------
    InputError
    """
    number = float(vector([value], what, 1)[0])
    if not number > 0.0:
        raise InputError(f"{what} must be above 0, got {value!r}.")
    return number


def curve_names(curve: Curve, chosen: BoolArray) -> list[str]:
    """Return the addresses of chosen segments of a curve."""
    return [curve.addresses[number] for number in np.flatnonzero(chosen)]


def node_faces(mesh: Mesh, vertices: ArrayLike) -> list[str]:
    """Return the addresses of the faces around some vertices, each once, in order."""
    return mesh.names(mesh.face[np.isin(mesh.corners, vertices)])
