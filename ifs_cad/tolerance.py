"""Every tolerance of the package, in one frozen place.

Lengths in mm, angles as sines (dimensionless). Functions take `tol: Tolerance = DEFAULT`; to
loosen one, pass `dataclasses.replace(DEFAULT, planar=1e-3)`.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Tolerance:
    """Limits below which two things count as the same.

    Attributes
    ----------
    coincident : float
        Points closer than this are one point, mm.
    planar : float
        A face may leave its plane by this much, mm.
    coplanar : float
        Mating chamfers may be apart by this much, mm.
    shared_radius : float
        Radius of the largest ball inside two panels that still counts as touching, mm.
    parallel : float
        Sine of the angle below which two directions are parallel.
    rank : float
        Singular values below this share of the largest count as zero.
    barycentric : float
        Barycentric columns whose entries differ by less than this are the same.
    weight : float
        Homogeneous weights must exceed this share of the largest.
    cone : float
        Sine by which two corner cones at a node must overlap to collide.
    relief : float
        Relief cuts shorter than this are made by a set-back instead, mm.
    sliver : float
        Segments of a groove's outline shorter than this are closed up, mm.
    volume : float
        Relative difference of volumes that count as equal.
    cost : float
        Relative difference of costs that count as equal.
    equilibrium : float
        Share of the loads by which forces of a structure may fail to balance.
    machined : float
        What a program makes may be off by this much, mm.
    machined_angle : float
        Planes that a program makes may be turned by this much, degrees.
    mechanism : float
        A movement whose stiffness is below this share of that of its own degrees of freedom meets
        no resistance.
    """

    coincident: float = 1e-9
    planar: float = 1e-6
    coplanar: float = 1e-6
    shared_radius: float = 1e-6
    parallel: float = 1e-6
    rank: float = 1e-10
    barycentric: float = 1e-10
    weight: float = 1e-12
    cone: float = 1e-10
    relief: float = 1e-3
    sliver: float = 1e-3
    volume: float = 1e-9
    cost: float = 1e-9
    equilibrium: float = 1e-6
    machined: float = 1e-3
    machined_angle: float = 1e-3
    mechanism: float = 1e-13


DEFAULT = Tolerance()

MEMORY_LIMIT = 4 * 2**30
"""Bytes that one computation may ask for before it is refused with a SizeError."""

KERNEL = 1e-7
"""Tolerance that OpenCascade shapes are made with (its own `Precision::Confusion`), mm."""

SOLVER = 1e-6
"""Tolerance that linear and integer programs are solved with (the default of HiGHS)."""

LARGEST_COORDINATE = 1e9
"""Points must lie closer to the origin than this, mm: beyond it, doubles cannot hold tolerances."""
