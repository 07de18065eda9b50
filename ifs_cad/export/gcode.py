"""Machine code (G-code, RS-274/ISO 6983) for routers with two rotary axes in their head.

A `Post` says how a control wants it. X, Y and Z are those of the tool's tip, from the lower left
corner of the sheet on the face of the spoilboard, when the control keeps the tip in place while the
head turns (tool-centre-point control); else those of the axes, counted so that they are the tip's
when the tool is vertical.

Comments that programs may rely on: `(SHEET name length x width x thickness)` and `(HOLD ...)` at
the top, `(STEP pierce|engrave|contour TOOL number Ddiameter)` at the beginning of each step and
`(ADDRESS address)` of each piece.

Before a person acts the spindle is stopped and the head brought aside, its tool upright at the safe
height. It is parked at a place in the frame of the sheet and not by G28 or G53: where the frame
stands in the machine is known to the control alone, and what is in the way there could not be
checked.

Source: section 4.3, figure 19 (automatic generation of the machine code).
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from ifs_cad.errors import MachineError
from ifs_cad.fabrication.machining.limits import axis_positions
from ifs_cad.fabrication.machining.machine_time import machining_time
from ifs_cad.fabrication.machining.motion import Cut, Drilling, Moves, Program, Step
from ifs_cad.fabrication.machining.post import LINUXCNC, Post
from ifs_cad.fabrication.machining.tool import Tool
from ifs_cad.files import replaced
from ifs_cad.types import FloatArray

__all__ = ["export_gcode", "gcode"]

LONGEST_COMMENT = 200
"""Characters; controls limit the length of a line, LinuxCNC to 255."""


def export_gcode(program: Program, path: str | os.PathLike[str], post: Post = LINUXCNC) -> Path:
    """Write the program of one sheet.

    Parameters
    ----------
    program : Program
    path : path of the file; its folder is made when missing
    post : Post, optional

    Returns
    -------
    Path of the written file.

    Raises
    ------
    ExportError
        The file could not be written; what stood there before is unchanged.
    MachineError
        The post is for another head than the machine's, or an angle is out of its range.
    """
    text, target = gcode(program, post), Path(path)
    with replaced(target) as scratch:
        scratch.write_text(text, encoding="ascii", newline="\n")
    return target


def gcode(program: Program, post: Post = LINUXCNC) -> str:
    """Return the text of a program, see `export_gcode`."""
    machine = program.machine
    if post.head.axes != machine.rotary:
        raise MachineError(
            f"The post {post.name} is for {post.head.axes} heads; {machine.name} has the axes "
            f"{machine.rotary}. Choose another post."
        )
    return _Writer(program, post).text()


class _Writer:
    """Writes a program line by line, words that stay the same only once."""

    def __init__(self, program: Program, post: Post) -> None:
        self.program, self.post = program, post
        self.lines: list[str] = []
        self.last: dict[str, str] = {}
        self.feed_word = ""
        self.letters = "XYZ" + post.head.letters
        self.angles = self._angles()

    def _angles(self) -> FloatArray:
        """Return tilt and turn at each cut, degrees; the head turns only between cuts."""
        cuts = [cut for step in self.program.steps for cut in step.cuts]
        axes = np.array([cut.moves.axes[0] for cut in cuts])
        machine = self.program.machine
        return self.post.head.follow(axes, machine.tilt, machine.turn)

    def text(self) -> str:
        """Return all lines."""
        post, sheet = self.post, self.program.sheet
        self.lines += [line.format(number=sheet.number) for line in post.header]
        self._head()
        self._line(f"G21 G17 G90 {post.feed_mode} G40 G49 G80 G54 {post.path}".rstrip())
        angles = iter(self.angles.tolist())
        for place, step in enumerate(self.program.steps):
            self._start(step)
            address = None
            for cut in step.cuts:
                if cut.address != address:
                    address = cut.address
                    self._comment(f"ADDRESS {address}")
                if cut.note:
                    self._comment(cut.note)
                self._cut(cut, step.tool, next(angles))
            self._upright()
            self._line("M5")
            if self.program.parks_after(place):
                self._comment("PARK")
                self._go("G0", self.program.park)
            self._line("G49")
            if place == self.program.screwed_after:
                self._comment("SCREW THE PIECES DOWN THROUGH THEIR HOLES, THEN GO ON")
                self._line("M0")
        self.lines += [line.format(number=sheet.number) for line in post.footer]
        return "\n".join(self.lines) + "\n"

    def _head(self) -> None:
        program, stock = self.program, self.program.sheet.stock
        time = machining_time(program)
        minutes, seconds = divmod(round(time.seconds), 60)
        self._comment(
            f"SHEET {program.sheet.name} {stock.length:g} x {stock.width:g} x {stock.thickness:g}"
        )
        self._comment(f"STOCK {stock.name}")
        self._comment(f"MACHINE {program.machine.name}, POST {self.post.name}")
        what = (
            "TIP OF THE TOOL" if self.post.tool_centre_point else "AXES, OF A VERTICAL TOOL'S TIP"
        )
        self._comment(f"XYZ {what}, FROM THE LOWER LEFT CORNER OF THE SHEET ON THE SPOILBOARD")
        for remark in self.post.remarks:
            self._comment(remark)
        self._comment(f"HOLD {program.hold}")
        for tool in dict.fromkeys(step.tool for step in program.steps):
            self._comment(
                f"TOOL {tool.number} {tool.name} D{tool.diameter:g} FLANK {tool.flank:g} "
                f"REACH {tool.reach:g} LENGTH {tool.length:g}"
            )
        duration = f"{minutes // 60}:{minutes % 60:02}:{seconds:02}"
        self._comment(f"TIME {duration} {time.interruptions.upper()}")

    def _start(self, step: Step) -> None:
        """Change the tool, and go up before anything else."""
        tool = step.tool
        self._comment(f"STEP {step.name} TOOL {tool.number} D{tool.diameter:g}")
        self._line(f"T{tool.number} M6")
        self._line(f"S{tool.speed:.0f} M3")
        self.last.clear()
        self.feed_word = ""
        offset = self.post.tool_offset.format(tool=tool.number)
        safe = self._number(self.program.safe)
        self._line(f"{offset} G0 Z{safe}")
        self.last["Z"] = safe
        self._upright()

    def _upright(self) -> None:
        """Set the tool upright, above everything."""
        safe = np.array([np.nan, np.nan, self.program.safe])
        if not self.post.tool_centre_point:
            self._go("G0", safe)
        turn = self.last.get(self.letters[-1], "0")  # of three axes it is not written
        self._go("G0", safe, (0.0, float(turn)))

    def _cut(self, cut: Cut | Drilling, tool: Tool, angles: tuple[float, float]) -> None:
        """Write the moves of one cut; the first brings the tool above its start."""
        moves = cut.moves
        points = moves.tips
        if not self.post.tool_centre_point:
            arm = self.program.machine.pivot + tool.length
            points = axis_positions(points, moves.axes, arm)
            # without control of its tip a tool that turns may dip: turn high up, then go there
            high = np.array([np.nan, np.nan, self.program.safe])
            self._go("G0", high)
            self._go("G0", high, angles)
            self._go("G0", np.array([*points[0, :2], np.nan]))
        self._go("G0", points[0], angles)
        if isinstance(cut, Drilling) and self.post.cycles and self.post.feed_mode == "G94":
            self._cycle(cut)
        else:
            self._moves(moves, points)

    def _moves(self, moves: Moves, points: FloatArray) -> None:
        ways, rapid = moves.lengths.tolist(), moves.is_rapid.tolist()
        feeds, bulges = moves.feeds.tolist(), moves.bulges.tolist()
        for row in range(1, len(points)):
            if rapid[row]:
                feed = self._withdrawal(moves, row)
                self._go("G1" if feed else "G0", points[row], feed=feed)
                continue
            inverse = self.post.feed_mode == "G93"
            feed = feeds[row] / ways[row] if inverse and ways[row] else feeds[row]
            self._go("G1", points[row], feed=feed, bulge=bulges[row], start=points[row - 1])

    def _withdrawal(self, moves: Moves, row: int) -> float:
        """Return the feed of a rapid move that must be a straight line all the same, else 0."""
        leans = moves.axes[row, 2] < 1.0
        rises = moves.tips[row, 2] > moves.tips[row - 1, 2]
        straight = self.post.straight_rapids and leans and rises and self.post.feed_mode == "G94"
        return self.program.machine.feed if straight else 0.0

    def _cycle(self, drilling: Drilling) -> None:
        """Write holes as G81, or as G83 when the chips have to be cleared."""
        pecks = len(drilling.depths) > 1
        number = self._number
        words = f"Z{number(drilling.bottom)} R{number(drilling.start)}"
        if pecks:
            words += f" Q{number(drilling.peck)}"
        words += f" F{drilling.feed:g}"
        for place, (x, y) in enumerate(drilling.points.tolist()):
            begin = f"G98 {'G83' if pecks else 'G81'} " if not place else ""
            self._line(f"{begin}X{number(x)} Y{number(y)}" + (f" {words}" if not place else ""))
            self.last |= {"X": number(x), "Y": number(y)}
        self._line("G80")
        self.feed_word = ""

    def _go(
        self,
        code: str,
        point: FloatArray,
        angles: tuple[float, float] | None = None,
        feed: float = 0.0,
        bulge: float = 0.0,
        start: FloatArray | None = None,
    ) -> None:
        """Write a move; coordinates that are NaN or unchanged are left out."""
        words = [self._number(value) for value in point.tolist()]
        if angles is not None:
            words += [self._number(value, self.post.angle_decimals) for value in angles]
        line = ""
        for letter, word in zip(self.letters, words, strict=False):
            if word != "nan" and self.last.get(letter) != word:
                self.last[letter] = word
                line += f" {letter}{word}"
        if bulge and start is not None:
            code = "G3" if bulge > 0.0 else "G2"
            line = f" X{words[0]} Y{words[1]}{self._centre(point, start, bulge)}"
        if not line:
            return
        if feed:
            word = self._number(feed)
            if word != self.feed_word or self.post.feed_mode == "G93":
                line += f" F{word}"
                self.feed_word = word
        self._line(code + line)

    def _centre(self, point: FloatArray, start: FloatArray, bulge: float) -> str:
        """Return the words for the centre of an arc, seen from its start as it was written."""
        chord = point[:2] - start[:2]
        to_the_left = np.array([-chord[1], chord[0]])
        centre = start[:2] + chord / 2.0 + to_the_left * (1.0 / bulge - bulge) / 4.0
        i, j = (centre - np.round(start[:2], self.post.decimals)).tolist()
        return f" I{self._number(i)} J{self._number(j)}"

    def _number(self, value: float, decimals: int | None = None) -> str:
        """Return a number without an exponent, superfluous zeros or a sign of zero."""
        text = f"{value:.{self.post.decimals if decimals is None else decimals}f}"
        if "." in text:
            text = text.rstrip("0").rstrip(".")
        text = "0" if text == "-0" else text
        return f"{text}." if self.post.decimal_point and text.lstrip("-").isdigit() else text

    def _comment(self, text: str) -> None:
        if self.post.comments:
            plain = text.encode("ascii", "replace").decode().replace("(", "[").replace(")", "]")
            self._line(f"({' '.join(plain.split())[:LONGEST_COMMENT]})")

    def _line(self, text: str) -> None:
        step = self.post.line_numbers
        if step:
            number = step * (len(self.lines) - len(self.post.header) + 1)
            text = f"N{number} {text}"
        self.lines.append(text)
