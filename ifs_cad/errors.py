"""The exception tree.

Every error that ifs_cad raises on purpose is an `IfsCadError` and also the built-in exception
that a caller who knows nothing of ifs_cad would expect (`ValueError`, `OSError`, ...). The
message says what is wrong, where, and what to do; `addresses` and `values` carry the same facts
for programs.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any


class IfsCadError(Exception):
    """Root of all errors of this package.

    Parameters
    ----------
    message : str
        What is wrong, where, and what to do.
    addresses : iterable of str
        The elements (panels, planks, faces, nodes) concerned; empty when none.
    **values
        The numbers behind the message, in mm and degrees.
    """

    def __init__(self, message: str, *, addresses: Iterable[str] = (), **values: Any) -> None:
        super().__init__(message)
        self.message = message
        self.addresses = tuple(addresses)
        self.values = values

    def __str__(self) -> str:  # KeyError would quote the message
        return self.message


class InputError(IfsCadError, ValueError):
    """A value that cannot be meant: NaN, a wrong shape, too few points, an unknown name."""


class SizeError(IfsCadError, MemoryError):
    """What is asked for would not fit in memory."""


class GeometryError(IfsCadError, ValueError):
    """Root of the errors that a design can repair."""


class WeightError(GeometryError):
    """A weight, given or computed, is not positive."""


class OutOfReachError(GeometryError):
    """A point off the span of the control points."""


class ContinuityError(GeometryError):
    """Transformations or a germ that would tear the curve apart."""


class ContractionError(GeometryError):
    """Transformations that do not contract, so that they have no attractor."""


class DegenerateSegmentError(GeometryError):
    """A curve segment without length: consecutive points coincide."""


class FoldError(GeometryError):
    """An even fold less steep than the curve it folds."""


class DomeError(GeometryError):
    """A profile off its plane or on the axis of its dome, or sides without room."""


class DegenerateFaceError(GeometryError):
    """A face without area: parallel or vanishing edges."""


class PlanarityError(GeometryError):
    """A face deviates from its plane."""


class ConvexityError(GeometryError):
    """A face is not convex."""


class ManifoldError(GeometryError):
    """An edge with more than two faces, or faces that disagree about which side is out."""


class ConstraintError(GeometryError):
    """A design that does not meet a constraint that it was checked for."""


class ThicknessError(GeometryError):
    """A face too small for the thickness at its folds."""


class SelfIntersectionError(GeometryError):
    """The design surface crosses itself."""


class ClashError(GeometryError):
    """Panels that share volume though their design faces are apart."""


class FloorError(GeometryError):
    """A standing border that does not reach the floor."""


class LabelError(GeometryError):
    """A label that does not fit its face, or cannot be engraved."""


class HoleError(GeometryError):
    """A hole that does not fit its panel."""


class StockError(GeometryError):
    """Elements larger than any stock, or more than there is."""


class MachineError(GeometryError):
    """What the machine or its tools cannot cut."""


class MechanismError(GeometryError):
    """A structure that moves without resistance."""


class InstabilityError(GeometryError):
    """A structure that finds no equilibrium under its load: it buckles or snaps through."""


class AddressError(IfsCadError, KeyError):
    """No element has this address."""


class ExportError(IfsCadError, OSError):
    """A file could not be written; what stood there before is unchanged."""


class CheckError(IfsCadError, ValueError):
    """A file that cannot be checked: not readable, or no solids in it."""


class ScriptError(IfsCadError, RuntimeError):
    """A part script that failed, or showed nothing that can be built."""


class WorkerError(IfsCadError, RuntimeError):
    """The process that does a job died, or failed in a way that nobody foresaw."""


class ViewerError(IfsCadError, RuntimeError):
    """No viewer, no open page, or no way to draw."""


class MissingLibraryError(IfsCadError, ImportError):
    """A Python package or a system library is missing; the message names it."""
