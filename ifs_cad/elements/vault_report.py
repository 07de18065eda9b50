"""The numbers of a vault that a designer and a workshop look at first."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ifs_cad.design.address import listed


@dataclass(frozen=True)
class VaultReport:
    """Summary of a vault; `str()` gives the table.

    Attributes
    ----------
    planks, layers : int
    width, thickness : float, of the planks, mm
    material : str
    depth : float, of all layers together, mm
    volume : float, of all planks, m3
    running : float, length of all planks laid end to end, m
    mass : float, kg
    heaviest : (address, mass in kg)
    lengths : (shortest, longest) plank, mm
    end_angles : (smallest, largest), degrees, without sign
    joint_gap : float, between planks of a layer, mm
    tightest : (address, radius of the curve there in mm)
    joint_distance : float, least distance between joints of neighbouring layers, mm; infinite
        when no two layers have joints
    lost, stubs : addresses of planks that a springing plane took, or left without full width
    """

    planks: int
    layers: int
    width: float
    thickness: float
    material: str
    depth: float
    volume: float
    running: float
    mass: float
    heaviest: tuple[str, float]
    lengths: tuple[float, float]
    end_angles: tuple[float, float]
    joint_gap: float
    tightest: tuple[str, float]
    joint_distance: float
    lost: tuple[str, ...]
    stubs: tuple[str, ...]

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a designer should look at before cutting."""
        found = []
        if self.joint_distance < self.thickness:
            found.append(
                "joints lie on joints of the next layer; stagger=True or curves of other depths "
                "move them apart"
            )
        if self.lost:
            found.append(f"below the springing, not made: {listed(self.lost)}")
        if self.stubs:
            found.append(f"the springing leaves no full width of {listed(self.stubs)}")
        return tuple(found)

    def __str__(self) -> str:
        """Return the table."""
        rows = [
            (
                "planks",
                f"{self.planks} of {self.width:g} x {self.thickness:g} mm {self.material}",
            ),
            ("layers", f"{self.layers}, {self.depth / 1000:.2f} m in all"),
            ("lengths", "{:.1f} to {:.1f} mm".format(*self.lengths)),
            ("end angles", "{:.2f} to {:.2f} degrees".format(*self.end_angles)),
            ("timber", f"{self.volume:.4g} m3, {self.running:.1f} m of plank"),
            (
                "mass",
                f"{self.mass:.4g} kg, heaviest plank {self.heaviest[1]:.3g} kg"
                f" ({self.heaviest[0]})",
            ),
        ]
        if math.isfinite(self.tightest[1]):
            rows.append(("tightest", f"radius {self.tightest[1]:.0f} mm at {self.tightest[0]}"))
        if math.isfinite(self.joint_distance):
            rows.append(("joints", f"{self.joint_distance:.1f} mm apart from layer to layer"))
        if self.joint_gap > 0:
            rows.append(("joint gap", f"{self.joint_gap:.3g} mm"))
        rows += [("warning", text) for text in self.warnings]
        return "\n".join(f"{name:16}{value}" for name, value in rows)
