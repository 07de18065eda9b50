"""Posts: how a control wants its programs, as data.

LinuxCNC has no word for tool-centre-point control: its kinematics `5axiskins` do it always. There
X Y Z B C are the tip's when the pin `5axiskins.pivot-length` holds the distance from the crossing
of the rotary axes to the tip: that of the head plus `motion.tooloffset.z`, added by a `sum2` as in
LinuxCNC's own example of a bridge mill. W stays 0.

Source: section 4.3, figure 19 (automatic generation of the machine code).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ifs_cad.errors import InputError
from ifs_cad.fabrication.machining.convention import Convention
from ifs_cad.fabrication.machining.machine import Machine, RotaryAxes
from ifs_cad.fabrication.machining.orientation import RotaryHead

FEWEST_DECIMALS = 3

__all__ = ["FANUC", "LINUXCNC", "POSTS", "THREE_AXES", "Post"]


@dataclass(frozen=True)
class Post:
    """How a control wants its programs.

    Parameters
    ----------
    name : str
    head : RotaryHead
        The rotary axes, and the way their angles are counted.
    tool_centre_point : bool
        Whether X Y Z are those of the tip while the head turns; else those of the axes.
    tool_offset : str
        Words that take the length of a tool into account, `{tool}` for its number.
    feed_mode : "G94" or "G93"
        Feeds in mm/min, or as the inverse of the minutes that a move takes.
    path : str
        Words for how truly the path is followed, such as "G61"; without them a control may round
        corners as it was last told.
    decimal_point : bool
        Whether whole numbers keep their point: a control that counts in its smallest unit reads
        Z52 as 0.052 mm.
    straight_rapids : bool
        Whether a leaning tool is drawn out of its cut by G1, for controls whose G0 is no straight
        line.
    cycles : bool
        Whether holes are drilled with G81 and G83, or with single moves.
    decimals, angle_decimals : int
    header, footer : tuple of str
        First and last lines, `{number}` for the number of the sheet.
    remarks : tuple of str, comments below the header
    line_numbers : int, step of the numbers of the lines; 0 for none
    comments : bool

    Raises
    ------
    InputError
        Decimals or line numbers that cannot be meant, or another feed mode.
    """

    name: str
    head: RotaryHead
    tool_centre_point: bool = True
    tool_offset: str = "G43 H{tool}"
    feed_mode: Literal["G94", "G93"] = "G94"
    path: str = ""
    decimal_point: bool = False
    straight_rapids: bool = False
    cycles: bool = True
    decimals: int = 4
    angle_decimals: int = 5
    header: tuple[str, ...] = ()
    footer: tuple[str, ...] = ("M30",)
    remarks: tuple[str, ...] = ()
    line_numbers: int = 0
    comments: bool = True

    def __post_init__(self) -> None:
        if self.feed_mode not in ("G94", "G93"):
            raise InputError(f"Post {self.name}: feed_mode must be G94 or G93.")
        for key in ("decimals", "angle_decimals"):
            if not FEWEST_DECIMALS <= getattr(self, key) <= 9:
                raise InputError(
                    f"Post {self.name}: {key} must be {FEWEST_DECIMALS} to 9, or planes are not "
                    f"true; got {getattr(self, key)}."
                )
        if self.line_numbers < 0:
            raise InputError(f"Post {self.name}: line_numbers must be 0 or more.")

    def convention(self, machine: Machine) -> Convention:
        """Return how the control reads what is written, for verification."""
        head = self.head
        pivot = None if self.tool_centre_point else machine.pivot
        return Convention(head.axes, head.tilt_sign, head.turn_sign, pivot)


LINUXCNC = Post(
    "LinuxCNC 5axiskins",
    RotaryHead("BC", tilt_sign=-1),
    path="G61",
    remarks=("5axiskins.pivot-length: head and motion.tooloffset.z together, W at 0",),
)
"""LinuxCNC with its kinematics for a bridge mill, see the module."""

FANUC = Post(
    "Fanuc G43.4",
    RotaryHead("AC"),
    tool_offset="G43.4 H{tool}",
    decimal_point=True,
    straight_rapids=True,
    cycles=False,  # not while G43.4 is in force
    header=("%", "O{number:04}"),
    footer=("M30", "%"),
    line_numbers=10,
)
"""Controls that understand G43.4 (tool centre point control), with an AC head by the textbook."""

THREE_AXES = Post("three axes", RotaryHead("none"), path="G61")
"""Controls of routers whose tool is always upright: LinuxCNC and most others."""

POSTS: dict[str, Post] = {"linuxcnc": LINUXCNC, "fanuc": FANUC, "three axes": THREE_AXES}
"""By the names that a file of tools calls them."""

USUAL: dict[RotaryAxes, Post] = {"BC": LINUXCNC, "AC": FANUC, "none": THREE_AXES}
"""What is taken for a machine when nothing is said of its control."""
