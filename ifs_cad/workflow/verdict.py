"""What a check of a file found, for people and for programs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

SHOWN_FAILURES = 8


@dataclass(frozen=True)
class Failure:
    """One thing that is wrong.

    Attributes
    ----------
    message : str
    addresses : tuple of str
        The parts concerned.
    """

    message: str
    addresses: tuple[str, ...] = ()


@dataclass(frozen=True)
class Check:
    """One property of a file.

    Attributes
    ----------
    name : str
    finding : str
        How many things were looked at, and the worst of them.
    values : mapping
        The same as numbers and texts, mm and mm3.
    failures : tuple of Failure
    """

    name: str
    finding: str
    values: Mapping[str, Any] = field(default_factory=dict)
    failures: tuple[Failure, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong."""
        return not self.failures

    @property
    def addresses(self) -> tuple[str, ...]:
        """The parts that fail, each once."""
        named = (address for failure in self.failures for address in failure.addresses)
        return tuple(dict.fromkeys(named))


@dataclass(frozen=True)
class CheckReport:
    """What was found in a file.

    Attributes
    ----------
    file : str
        Its name.
    checks : tuple of Check
    """

    file: str
    checks: tuple[Check, ...]

    @property
    def ok(self) -> bool:
        """Whether every check passed."""
        return all(check.ok for check in self.checks)

    def __getitem__(self, name: str) -> Check:
        """Return the check of a name."""
        return next(check for check in self.checks if check.name == name)

    def __str__(self) -> str:
        """Return a table, one line for each check, with what fails beneath."""
        width = max(len(check.name) for check in self.checks)
        lines = [self.file]
        for check in self.checks:
            verdict = "pass" if check.ok else "FAIL"
            lines.append(f"  {verdict}  {check.name:<{width}}  {check.finding}")
            indent = " " * (width + 10)
            lines += [f"{indent}{fail.message}" for fail in check.failures[:SHOWN_FAILURES]]
            if len(check.failures) > SHOWN_FAILURES:
                lines.append(f"{indent}and {len(check.failures) - SHOWN_FAILURES} more")
        failed = sum(not check.ok for check in self.checks)
        lines.append(
            f"{failed} of {len(self.checks)} checks failed." if failed else "All checks passed."
        )
        return "\n".join(lines)

    def as_dict(self) -> dict[str, Any]:
        """Return the report as plain data for JSON."""
        return {
            "file": self.file,
            "ok": self.ok,
            "checks": [
                {
                    "name": check.name,
                    "ok": check.ok,
                    "finding": check.finding,
                    "values": dict(check.values),
                    "failures": [
                        {"message": failure.message, "addresses": list(failure.addresses)}
                        for failure in check.failures
                    ],
                }
                for check in self.checks
            ],
        }
