"""Faults: what is wrong in a program for a machine, and in which line of it.

A controller names lines by their number in the file, so that is how faults are found again.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, order=True)
class Fault:
    """One thing wrong in a program.

    Attributes
    ----------
    line : int, of the file, from 1
    address : str, of the workpiece concerned; empty when it is not about one
    message : str, a sentence with the numbers
    """

    line: int
    address: str
    message: str

    def __str__(self) -> str:
        about = f"{self.address}: " if self.address else ""
        return f"line {self.line}: {about}{self.message}"
