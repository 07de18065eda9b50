"""How long programs take: by their feeds, the speeds of the machine, and changes of the tool.

Speeding up and slowing down are left out. A stop takes as long as the person takes who is waited
for, so stops are counted and not timed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from ifs_cad.fabrication.machining.machine import Machine
from ifs_cad.fabrication.machining.motion import Moves, Program
from ifs_cad.types import FloatArray

__all__ = ["MachineTime", "hours", "machining_summary", "machining_time"]


@dataclass(frozen=True)
class MachineTime:
    """How long the machine runs.

    Parameters
    ----------
    seconds : float, with the changes of the tool, without the stops
    tool_changes : int
    stops : int, how often it waits for a person, changes of the tool aside
    """

    seconds: float
    tool_changes: int
    stops: int

    @classmethod
    def total(cls, times: Iterable[MachineTime]) -> MachineTime:
        """Return the time of programs one after the other."""
        every = tuple(times)
        return cls(
            sum(one.seconds for one in every),
            sum(one.tool_changes for one in every),
            sum(one.stops for one in every),
        )

    @property
    def interruptions(self) -> str:
        """What is in the time and what is not, in words."""
        return interruptions(self.tool_changes, self.stops)


def interruptions(tool_changes: int, stops: int) -> str:
    """Return in words how often tools are changed and a person is waited for."""
    changes = "1 tool change" if tool_changes == 1 else f"{tool_changes} tool changes"
    waits = "1 stop" if stops == 1 else f"{stops} stops"
    return f"with {changes}" + (f" and {waits} for a person, not timed" if stops else "")


def machining_time(program: Program, machine: Machine | None = None) -> MachineTime:
    """Estimate how long a program takes.

    Parameters
    ----------
    program : Program
    machine : Machine, optional
        The program's own by default.
    """
    machine = machine or program.machine
    places = range(len(program.steps))
    moving = sum(
        _minutes(Moves.joined([way.moves for way in program.ways(place)]), machine)
        for place in places
    )
    changes = len(places)
    return MachineTime(moving * 60.0 + changes * machine.tool_change, changes, program.stops)


def machining_summary(times: Mapping[str, MachineTime]) -> str:
    """Return the times of programs as text.

    Parameters
    ----------
    times : of each program, by the name of its sheet
    """
    listed = ", ".join(f"{name} {hours(time.seconds)}" for name, time in times.items())
    programs = "1 program" if len(times) == 1 else f"{len(times)} programs"
    total = MachineTime.total(times.values())
    return f"{programs}, {hours(total.seconds)} h of machining {total.interruptions}: {listed}"


def hours(seconds: float) -> str:
    """Return a time as hours and minutes."""
    whole, minutes = divmod(round(seconds / 60.0), 60)
    return f"{whole}:{minutes:02}"


def _minutes(moves: Moves, machine: Machine) -> float:
    ways = moves.lengths
    speeds = np.where(moves.is_rapid, machine.rapid, moves.feeds)
    return float(np.maximum(ways / speeds, _turns(moves.axes) / machine.rotation).sum())


def _turns(axes: FloatArray) -> FloatArray:
    """Return how far the head turns for each move, the larger of tilt and turn, degrees."""
    level = np.hypot(axes[:, 0], axes[:, 1])
    tilts = np.degrees(np.arctan2(level, axes[:, 2]))
    # while the tool is vertical, the turn stays
    last = np.maximum.accumulate(np.where(level > 0.0, np.arange(len(axes)), 0))
    turns = np.degrees(np.arctan2(axes[last, 1], axes[last, 0]))
    turned = np.abs((np.diff(turns, prepend=turns[:1]) + 180.0) % 360.0 - 180.0)
    return np.asarray(np.maximum(np.abs(np.diff(tilts, prepend=tilts[:1])), turned))
