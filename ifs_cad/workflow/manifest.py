"""The manifest of a folder: every file that was made, with its size and checksum."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ifs_cad.errors import CheckError

NAME = "manifest.json"
VERSION = 1


def write_manifest(folder: Path, facts: Mapping[str, Any]) -> None:
    """List every file of a folder in its manifest, beside some facts about the whole."""
    files = [
        {"path": place, "bytes": size, "sha256": checksum}
        for place, size, checksum in _contents(folder)
    ]
    content = {"version": VERSION, **facts, "files": files}
    (folder / NAME).write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


def read_manifest(folder: Path) -> dict[str, dict[str, Any]]:
    """Return what the manifest says of each file, by place; nothing without a manifest.

    Raises
    ------
    CheckError
        The manifest is not one.
    """
    path = folder / NAME
    if not path.is_file():
        return {}
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return {entry["path"]: dict(entry) for entry in content["files"]}
    except (ValueError, KeyError, TypeError) as error:
        raise CheckError(f"{path} is no manifest: {error}. Move it away.") from error


def differences(folder: Path) -> list[str]:
    """Return in which files a folder no longer is what its manifest says; none in a good one."""
    listed = read_manifest(folder)
    found = {place: checksum for place, _, checksum in _contents(folder)}
    missing = [f"{place} is missing" for place in listed if place not in found]
    changed = [
        f"{place} was changed"
        for place, entry in listed.items()
        if place in found and found[place] != entry["sha256"]
    ]
    return missing + changed


def _contents(folder: Path) -> list[tuple[str, int, str]]:
    paths = sorted(path for path in folder.rglob("*") if path.is_file() and path.name != NAME)
    found = []
    for path in paths:
        with path.open("rb") as file:
            checksum = hashlib.file_digest(file, "sha256").hexdigest()
        found.append((path.relative_to(folder).as_posix(), path.stat().st_size, checksum))
    return found
