"""Making files beside their target: all of them arrive, or none does.

A *stage* is a hidden folder next to the target. What dies with a job leaves a stage behind at
most; the next job for the same target removes it.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ifs_cad.errors import ExportError


@contextmanager
def staging(target: Path) -> Iterator[Path]:
    """Give an empty folder beside a target, which vanishes at the end of the block.

    Of two jobs for one target that overlap the later takes over: the earlier one fails.

    Raises
    ------
    ExportError
        The target's folder does not exist and cannot be made, or nothing can be written there.
    """
    prefix = f".{target.name}-"
    new = not target.parent.exists()
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        for left in target.parent.iterdir():
            if left.name.startswith(prefix):
                shutil.rmtree(left, ignore_errors=True)
        stage = Path(tempfile.mkdtemp(prefix=prefix, dir=target.parent))
    except OSError as error:
        raise ExportError(
            f"Nothing can be written to the folder {target.parent}: {error.strerror}."
        ) from error
    try:
        yield stage
    except ExportError as error:  # the user knows the target, not the stage
        raise ExportError(str(error).replace(str(stage), str(target.parent))) from error
    finally:
        shutil.rmtree(stage, ignore_errors=True)
        if new:
            with suppress(OSError):  # not empty: the job made something
                target.parent.rmdir()


def install(made: Path, target: Path) -> None:
    """Move a finished file to its target, in place of what stood there.

    Raises
    ------
    ExportError
        Not possible; what stood there is unchanged.
    """
    try:
        target.parent.mkdir(exist_ok=True)
        made.replace(target)
    except OSError as error:
        raise ExportError(f"{target} could not be written: {error.strerror}.") from error
