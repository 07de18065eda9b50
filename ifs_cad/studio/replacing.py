"""What keeps saving from replacing a file that nobody has seen."""

from __future__ import annotations

import hashlib
from pathlib import Path

from ifs_cad.errors import InputError

__all__ = ["ReplaceGuard", "is_same_file"]


class ReplaceGuard:
    """Knows what the open file held when it was last read or written.

    Parameters
    ----------
    path : Path, optional
        The file that is about to be read.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        self._known = "" if path is None else _digest(path)
        self._asked: tuple[Path, str] | None = None

    def withdraw(self) -> None:
        """Forget that replacing a file was asked for once."""
        self._asked = None

    def refuse_once(self, target: Path) -> None:
        """Raise an error when a file holds what is not known, unless asked a second time.

        Raises
        ------
        InputError
            It would be replaced; the next call with this file, as it is now, passes.
        """
        present = _digest(target)
        is_own = self._path is not None and is_same_file(target, self._path)
        asked, self._asked = self._asked, None
        if present in ("", self._known if is_own else "") or asked == (target, present):
            return
        self._asked = target, present
        if is_own:
            raise InputError(
                f"{target} was changed on disk since it was opened. Save again to replace it, or "
                "open it to see it."
            )
        raise InputError(f"{target} exists. Press once more to replace it.")


def is_same_file(one: Path, other: Path) -> bool:
    """Tell whether two paths lead to one file, which need not exist."""
    return one.resolve() == other.resolve()


def _digest(path: Path) -> str:
    """Return what tells whether a file has changed; empty when there is none."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except FileNotFoundError:
        return ""
    except OSError:
        return "unreadable"
