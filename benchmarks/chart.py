"""A picture of the limits: how much of each one is used."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from table import Line

GOOD, BAD = "#7a9e6a", "#c0392b"


def draw_limits(lines: Sequence[Line], path: Path) -> None:
    """Draw a bar for each limit, as long as the share of it that is used; logarithmic."""
    from matplotlib import pyplot as plt

    limited = [line for line in lines if line.limit is not None][::-1]
    used = [100 * line.used for line in limited]
    names = [f"{line.key}  {_short(line.what)}" for line in limited]
    colours = [GOOD if line.passed else BAD for line in limited]
    figure, axes = plt.subplots(figsize=(9, 0.24 * len(limited) + 0.9), layout="constrained")
    axes.barh(range(len(limited)), used, color=colours)
    axes.set_yticks(range(len(limited)), names, fontsize=7)
    axes.set_xscale("log")
    axes.set_xlim(min(used) / 2, max(200.0, *used))
    axes.axvline(100.0, color="black", linewidth=1)
    axes.xaxis.set_major_formatter("{x:g} %")
    axes.set_xlabel("of the limit is used", fontsize=8)
    axes.tick_params(axis="x", labelsize=8)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    figure.savefig(path, dpi=120)
    plt.close(figure)


def _short(text: str, most: int = 76) -> str:
    return text if len(text) <= most else text[: most - 3] + "..."
