"""The numbers of a shell that a designer and a workshop look at first."""

from __future__ import annotations

from dataclasses import dataclass

from ifs_cad.design.address import listed
from ifs_cad.elements.floor import Opening

RELIEF_SHARE_TO_WARN = 0.02


@dataclass(frozen=True)
class ReliefCut:
    """One relief cut.

    Attributes
    ----------
    address, mate : the panel that is cut, and the one it keeps clear of
    length : float, longest edge of the cut, mm
    share : float, of the panel's volume that all its relief cuts take
    """

    address: str
    mate: str
    length: float
    share: float


@dataclass(frozen=True)
class Report:
    """Summary of a shell; `str()` gives the table.

    Attributes
    ----------
    panels : int
    area : float, sum of the larger faces, m2
    mass : float, kg
    heaviest : (address, mass in kg)
    thickness : float, mm
    material : str
    chamfer_angles : (smallest, largest), degrees, without sign
    edges : (shortest, longest) edge of the design, mm
    node_gap : float, largest distance of the offset corners of one node, mm; with node axes the lip
    node_gap_name : str, "node gap" or "lip"
    least_conical : float, degrees by which the worst node misses being conical
    relief_cuts : every relief cut
    joint_gap : (smallest, largest) gap between mating chamfers, mm
    lost, stubs : addresses of panels that the floor took, or left lower than the minimum height
    openings : borders that do not stand on the floor
    """

    panels: int
    area: float
    mass: float
    heaviest: tuple[str, float]
    thickness: float
    material: str
    chamfer_angles: tuple[float, float]
    edges: tuple[float, float]
    node_gap: float
    node_gap_name: str
    least_conical: float
    relief_cuts: tuple[ReliefCut, ...]
    joint_gap: tuple[float, float]
    lost: tuple[str, ...]
    stubs: tuple[str, ...]
    openings: tuple[Opening, ...]

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a designer should look at before cutting."""
        found = []
        deep = {c.address: c.share for c in self.relief_cuts if c.share > RELIEF_SHARE_TO_WARN}
        if deep:
            found.append(
                f"relief takes up to {100 * max(deep.values()):.1f} % of {listed(sorted(deep))}"
            )
        if self.lost:
            found.append(f"below the floor, not made: {listed(self.lost)}")
        if self.stubs:
            found.append(f"the floor leaves little of {listed(self.stubs)}")
        return tuple(found)

    def __str__(self) -> str:
        """Return the table."""
        rows = [
            ("panels", f"{self.panels}"),
            ("area", f"{self.area:.2f} m2 of {self.thickness:g} mm {self.material}"),
            (
                "mass",
                f"{self.mass:.1f} kg, heaviest panel {self.heaviest[1]:.2f} kg"
                f" ({self.heaviest[0]})",
            ),
            ("chamfer angles", "{:.2f} to {:.2f} degrees".format(*self.chamfer_angles)),
            ("edges", "{:.1f} to {:.1f} mm".format(*self.edges)),
            (
                self.node_gap_name,
                f"{self.node_gap:.2g} mm at most, nodes conical to "
                f"{self.least_conical:.2g} degrees",
            ),
        ]
        if self.joint_gap[1] > 0:
            rows.append(("joint gap", "{:.3g} to {:.3g} mm".format(*self.joint_gap)))
        if self.relief_cuts:
            longest = max(self.relief_cuts, key=lambda cut: cut.length)
            most = max(self.relief_cuts, key=lambda cut: cut.share)
            rows.append(
                (
                    "relief cuts",
                    f"{len(self.relief_cuts)}, longest {longest.length:.2f} mm "
                    f"({longest.address}), "
                    f"most {100 * most.share:.2g} % of a panel ({most.address})",
                )
            )
        for opening in self.openings:
            first, last = opening.addresses[0], opening.addresses[-1]
            rows.append(("opening", f"{opening.height:.0f} mm high, {first} to {last}"))
        rows += [("warning", text) for text in self.warnings]
        return "\n".join(f"{name:16}{value}" for name, value in rows)
