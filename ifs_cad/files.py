"""Safe files: written beside their target and renamed, so that half a file never replaces one."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import NamedTemporaryFile

from ifs_cad.errors import ExportError

SCRATCH_SUFFIX = ".part"
MODE = 0o666  # of a new file, less what the user's umask takes


@contextmanager
def replaced(target: Path) -> Iterator[Path]:
    """Give a scratch file beside the target that takes its place when the block succeeds.

    The folder is made when missing; a link is followed, so that what it points to is replaced. A
    failure removes the scratch file and leaves the target as it was.

    Raises
    ------
    ExportError
        The folder or the file cannot be written, the target is no file but a folder or a device,
        or nothing was written.
    """
    target = target.resolve()
    if target.exists() and not target.is_file():
        raise ExportError(f"Cannot write {target}: it is a folder or a device, not a file.")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with NamedTemporaryFile(
            dir=target.parent, prefix=f".{target.name}.", suffix=SCRATCH_SUFFIX, delete=False
        ) as handle:
            scratch = Path(handle.name)
    except OSError as error:
        raise ExportError(f"Cannot write {target}: {error.strerror}.") from error
    try:
        yield scratch
        if scratch.stat().st_size == 0:
            raise ExportError(f"Nothing arrived in {target}. Is the disk full?")
        scratch.chmod(MODE & ~_umask())
        os.replace(scratch, target)
    except OSError as error:
        if isinstance(error, ExportError):
            raise
        raise ExportError(f"Cannot write {target}: {error.strerror}.") from error
    finally:
        scratch.unlink(missing_ok=True)


def _umask() -> int:
    """Return the user's umask, which can only be read by setting it."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
