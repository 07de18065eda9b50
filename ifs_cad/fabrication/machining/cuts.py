"""Cuts: the motions of a program as paths of the tips of real tools.

Terms
-----
steady : the tool does not turn on the way.
lowest : the height of the lowest point of a cutter, taken as a flat-ended cylinder.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ifs_cad.fabrication.machining.convention import Convention
from ifs_cad.fabrication.machining.motions import Kind, Motions
from ifs_cad.fabrication.machining.swept import Sweeps
from ifs_cad.fabrication.machining.tool import Tool
from ifs_cad.tolerance import Tolerance
from ifs_cad.types import BoolArray, FloatArray, IntArray
from ifs_cad.vectors import cross, dot, length

CHORDS = 16
"""An arc is swept as so many chords, made thicker by what the arc bulges out beyond them."""


@dataclass(frozen=True, eq=False)
class Cuts:
    """Motions with the tips and axes of their tools.

    Attributes
    ----------
    motions : Motions
    starts, ends : (n, 3) float, tips, mm; NaN where not yet placed
    start_axes, end_axes : (n, 3) float, unit vectors; NaN where not yet placed
    diameters, flanks, reaches, holders, lengths, points : (n,) float, of the tools, mm, see `Tool`;
        `points` are the heights of their points; NaN for a tool that is not known
    lowest_tips : (n,) float, heights of the tips where they are lowest on their ways, mm
    """

    motions: Motions
    starts: FloatArray
    ends: FloatArray
    start_axes: FloatArray
    end_axes: FloatArray
    diameters: FloatArray
    flanks: FloatArray
    reaches: FloatArray
    holders: FloatArray
    lengths: FloatArray
    points: FloatArray
    lowest_tips: FloatArray
    tol: Tolerance

    def __len__(self) -> int:
        return len(self.motions)

    @property
    def radii(self) -> FloatArray:
        """(n,) float, mm."""
        return self.diameters / 2.0

    @cached_property
    def placed(self) -> BoolArray:
        """(n,) bool, whether start and end are known in all axes."""
        known = np.hstack([self.starts, self.ends, self.start_axes, self.end_axes])
        return np.asarray(np.isfinite(known).all(axis=1) & np.isfinite(self.diameters))

    @cached_property
    def steady(self) -> BoolArray:
        """(n,) bool."""
        return np.asarray(self.placed & ~self.motions.rotates)

    @cached_property
    def feeds(self) -> BoolArray:
        """(n,) bool, whether it cuts: every motion that is not rapid."""
        return np.asarray(self.motions.kinds != Kind.RAPID)

    @cached_property
    def lowest_at_start(self) -> FloatArray:
        """(n,) float, mm."""
        return np.asarray(self.starts[:, 2] - self.radii * np.hypot(*self.start_axes[:, :2].T))

    @cached_property
    def lowest(self) -> FloatArray:
        """(n,) float, of both ends, mm."""
        at_end = self.ends[:, 2] - self.radii * np.hypot(*self.end_axes[:, :2].T)
        return np.asarray(np.minimum(self.lowest_at_start, at_end))

    @cached_property
    def upright(self) -> BoolArray:
        """(n,) bool, whether the tool is vertical at both ends."""
        level = np.abs(np.hstack([self.start_axes[:, :2], self.end_axes[:, :2]])).max(axis=1)
        return np.asarray(level <= self.tol.parallel)

    @cached_property
    def along_axis(self) -> IntArray:
        """(n,) int, 1 for steady lines up the axis of the tool, -1 down, 0 for all others."""
        forward = self.ends - self.starts
        aside = length(cross(self.start_axes, forward)) <= self.tol.machined
        lines = self.steady & (self.motions.kinds != Kind.ARC) & aside
        sign = np.sign(np.where(lines, dot(self.start_axes, forward), 0.0))
        return np.asarray(sign, dtype=np.int64)

    def sweeps(self, which: IntArray) -> tuple[IntArray, Sweeps]:
        """Return what cutters pass through in steady motions, arcs in chords.

        Parameters
        ----------
        which : (k,) int, indices of motions

        Returns
        -------
        owners : (m,) int, the motion of each sweep
        sweeps : up to the holder
        """
        arcs = which[self.motions.kinds[which] == Kind.ARC]
        lines = which[self.motions.kinds[which] != Kind.ARC]
        owners = np.concatenate([lines, np.repeat(arcs, CHORDS)])
        points = self.arc_points(arcs, np.linspace(0.0, 1.0, CHORDS + 1))
        starts = np.concatenate([self.starts[lines], points[:, :-1].reshape(-1, 3)])
        ends = np.concatenate([self.ends[lines], points[:, 1:].reshape(-1, 3)])
        around = np.hypot(*(self.motions.starts[arcs, :2] - self.motions.centres[arcs]).T)
        bulges = around * (1.0 - np.cos(self.motions.sweeps[arcs] / CHORDS / 2.0))
        wider = np.concatenate([np.zeros(len(lines)), np.repeat(bulges, CHORDS)])
        return owners, Sweeps(
            starts,
            ends,
            self.start_axes[owners],
            np.zeros(len(owners)),
            self.reaches[owners],
            self.radii[owners] + wider,
        )

    def holder_sweeps(self, which: IntArray) -> Sweeps:
        """Return what holders pass through in steady motions, arcs by their chords."""
        return Sweeps(
            self.starts[which],
            self.ends[which],
            self.start_axes[which],
            self.reaches[which],
            np.maximum(self.lengths[which], self.reaches[which]),
            self.holders[which] / 2.0,
        )

    def arc_points(self, which: IntArray, shares: FloatArray) -> FloatArray:
        """Return (k, s, 3) tips along k arcs, at (s,) shares of the way."""
        motions = self.motions
        centres = motions.centres[which] @ np.array([1.0, 1.0j])
        spokes = motions.starts[which, :2] @ np.array([1.0, 1.0j]) - centres
        turned = centres[:, None] + spokes[:, None] * np.exp(
            1j * motions.sweeps[which, None] * shares
        )
        heights = (
            motions.starts[which, 2, None]
            + shares * (motions.ends[which, 2] - motions.starts[which, 2])[:, None]
        )
        # the tool keeps its axis on an arc, so its tip is moved alike all along
        shift = self.starts[which] - motions.starts[which]
        return np.stack([turned.real, turned.imag, heights], axis=-1) + shift[:, None, :]


def cuts_of(
    motions: Motions, tools: Sequence[Tool], convention: Convention, tol: Tolerance
) -> Cuts:
    """Return the tips, axes and tools of all motions.

    Parameters
    ----------
    motions : as programmed
    tools : that the machine holds
    convention : how it reads positions and angles
    """
    table = np.full((max([tool.number for tool in tools], default=0) + 2, 6), np.nan)
    for tool in tools:
        table[tool.number] = (
            tool.diameter,
            tool.flank,
            tool.reach,
            tool.holder,
            tool.length,
            tool.point_height,
        )
    known = np.where(motions.tools < len(table), motions.tools, len(table) - 1)
    diameters, flanks, reaches, holders, lengths, points = table[known].T
    start_axes = convention.axis(motions.start_angles)
    end_axes = convention.axis(motions.end_angles)
    return Cuts(
        motions,
        convention.tips(motions.starts, start_axes, lengths),
        convention.tips(motions.ends, end_axes, lengths),
        start_axes,
        end_axes,
        diameters,
        flanks,
        reaches,
        holders,
        lengths,
        points,
        convention.lowest(
            np.stack([motions.starts[:, 2], motions.ends[:, 2]], axis=1),
            np.stack([motions.start_angles, motions.end_angles], axis=1),
            lengths,
        ),
        tol,
    )
