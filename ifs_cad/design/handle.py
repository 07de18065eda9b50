"""What the designer can take hold of: the columns of a scheme as a table.

Source: the paper, section 3.1: of the columns c_1, c_2, ... some are fixed, some equal to others,
and the rest free.
"""

from __future__ import annotations

from dataclasses import dataclass

from ifs_cad.design.transform import Kind, Scheme

__all__ = ["Handle", "handles"]


@dataclass(frozen=True)
class Handle:
    """One column of a scheme and what moving it does.

    Attributes
    ----------
    name : str
        Of the subdivision point that shows it.
    kind : "fixed", "shared" or "free"
        It cannot move, moves in several transformations at once, or in one.
    places : pairs of int
        ``(k, j)`` for each column j of T_k that it is, both from 1 as in the paper.
    partner : str, optional
        In a symmetric scheme, the mirror image that moves with it; may be itself.
    """

    name: str
    kind: Kind
    places: tuple[tuple[int, int], ...]
    partner: str | None = None

    def __str__(self) -> str:
        stands = " = ".join(f"column {j} of T_{k}" for k, j in self.places)
        if self.partner is None:
            return f"{self.name}: {self.kind}, {stands}"
        mirrored = "itself" if self.partner == self.name else self.partner
        return f"{self.name}: {self.kind}, {stands}, mirror image {mirrored}"


def handles(scheme: Scheme) -> tuple[Handle, ...]:
    """Return a handle for each column, in the paper's order.

    Parameters
    ----------
    scheme : Scheme
    """
    places: list[list[tuple[int, int]]] = [[] for _ in scheme.names]
    for k, rows in enumerate(scheme.layout.tolist(), start=1):
        for j, row in enumerate(rows, start=1):
            places[row].append((k, j))
    return tuple(
        Handle(name, kind, tuple(stands), scheme.partner(name))
        for (name, kind), stands in zip(scheme.kinds().items(), places, strict=True)
    )
