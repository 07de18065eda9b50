"""Pictures of the structure check."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from matplotlib import pyplot as plt

import ifs_cad as ifs
from drawings.gallery import shown
from drawings.style import PICTURES
from ifs_cad.workflow.analysis import asked


def deformed() -> None:
    """Draw the three shells of figure 22 under their load, side by side."""
    figure, axes = plt.subplots(1, 3, figsize=(16, 3.6), layout="constrained")
    with TemporaryDirectory() as folder:
        for axis, (name, (shell, asked_for)) in zip(
            axes, asked([shown("figure_22")]).items(), strict=True
        ):
            path = Path(folder) / f"{name}.png"
            result = ifs.analyse(
                shell, loads=asked_for.loads, supports=asked_for.supports, divisions=4
            )
            ifs.render_deformed(result, path, width=1000, height=620)
            axis.imshow(plt.imread(path))
            axis.set_title(f"{name.replace('_', ' ')}: {result.deflection.value:.3g} mm")
            axis.axis("off")
    figure.savefig(PICTURES / "figure_22_deformed.png", dpi=90)
    plt.close(figure)
