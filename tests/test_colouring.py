"""Values become colours, and colours a legend."""

from __future__ import annotations

import numpy as np
import pytest

import ifs_cad as ifs
from ifs_cad.elements.colouring import (
    APART,
    UNKNOWN,
    VIRIDIS,
    Colouring,
    distinct,
    numbered,
    shades,
)
from ifs_cad.errors import InputError
from ifs_cad.view.quantity import QUANTITIES, colouring


def folded_shell(thickness: float = 20.0) -> ifs.Shell:
    """Two panels of 1000 x 500 mm that meet at a right angle along y."""
    a = [(0, 0, 0), (500, 0, 500), (1000, 0, 0)]
    return ifs.thicken(ifs.vector_sum(a, [(0, 0, 0), (0, 1000, 0)]), thickness, side="inner")


def test_the_ends_of_a_scale_are_those_of_viridis_and_unknown_is_grey() -> None:
    colours = Colouring("x, mm", np.array([1.0, 3.0, np.nan])).colours
    assert colours.tolist() == [VIRIDIS[0].tolist(), VIRIDIS[-1].tolist(), list(UNKNOWN)]


def test_equal_steps_of_a_scale_look_equal() -> None:
    """Luminance of viridis grows evenly: in grey print the order is kept."""
    luminance = (shades(np.linspace(0, 1, 50)) / 255.0) ** 2.2 @ (0.2126, 0.7152, 0.0722)
    lightness = 116 * np.cbrt(luminance) - 16
    steps = np.diff(lightness)
    assert steps.min() > 0
    assert steps.max() < 2.5 * steps.mean()


def test_ends_of_ones_own_clip_the_values() -> None:
    given = Colouring("x, mm", np.array([0.0, 5.0, 20.0]), low=0.0, high=10.0)
    assert given.range == (0.0, 10.0)
    assert given.colours[2].tolist() == VIRIDIS[-1].tolist()
    assert [text for text, _ in given.ticks(3)] == ["0", "5", "10"]
    assert str(given) == "x, mm: 0 (dark) to 10 (light)"


def test_one_value_for_all_is_one_colour() -> None:
    given = Colouring("x, mm", np.full(3, 7.0))
    assert len(np.unique(given.colours, axis=0)) == 1
    assert [text for text, _ in given.ticks()] == ["7"]


def test_names_have_colours_of_their_own() -> None:
    given = numbered("sheet", ["b", "a", None, "b"])
    assert given.names == ("a", "b")
    assert given.colours.tolist() == [
        APART[1].tolist(),
        APART[0].tolist(),
        list(UNKNOWN),
        APART[1].tolist(),
    ]
    assert given.ticks() == [("a", tuple(APART[0].tolist())), ("b", tuple(APART[1].tolist()))]
    assert len(np.unique(distinct(24), axis=0)) == 24


@pytest.mark.parametrize(
    ("values", "names"), [([np.nan], ()), ([], ()), ([2.0], ("a", "b")), ([-1.0], ("a",))]
)
def test_nothing_known_or_no_such_name_is_refused(
    values: list[float], names: tuple[str, ...]
) -> None:
    with pytest.raises(InputError):
        Colouring("x", np.array(values), names)


def test_quantities_of_a_fold_of_two_panels_are_those_worked_out_by_hand() -> None:
    shell = folded_shell()
    side = 500 * np.sqrt(2)
    values = {name: colouring(shell, name).values for name in QUANTITIES[:5]}
    assert values["chamfer"] == pytest.approx([45, 45])
    assert values["area"] == pytest.approx([side * 1e-3] * 2)
    assert values["length"] == pytest.approx([1000, 1000])
    assert values["mass"] == pytest.approx(shell.masses)
    assert values["planarity"] == pytest.approx([0, 0], abs=1e-9)
    # noise far below the tolerance is no difference
    assert len(np.unique(colouring(shell, "planarity").colours, axis=0)) == 1


def test_elements_are_coloured_by_the_sheet_they_are_cut_from() -> None:
    shell = folded_shell(10.0)
    pieces = ifs.workpieces(shell)
    sheets = [sheet for sheet in ifs.read_stock().sheets if sheet.thickness == 10.0]
    layout = ifs.nest(pieces, sheets, spacing=14.0)
    given = colouring(shell, "sheet", layout=layout)
    homes = [layout.homes[address][0].name for address in shell.addresses]
    assert [given.names[int(k)] for k in given.values] == homes
    assert colouring(shell, "sheet").names == given.names


def test_a_vault_has_some_quantities_and_not_others() -> None:
    arch = ifs.Curve([(0, 0, 0), (0, 0, 800), (2000, 0, 800), (2000, 0, 0)], depth=2)
    vault = ifs.vault(arch, 200, 40, layers=2)
    assert colouring(vault, "chamfer").values == pytest.approx(np.abs(vault.end_angles).max(axis=1))
    for quantity in ("planarity", "utilisation", "deflection"):
        with pytest.raises(InputError, match="Vault has no"):
            colouring(vault, quantity)


def test_an_unknown_quantity_lists_the_known_ones() -> None:
    with pytest.raises(InputError, match="chamfer, area, length, mass, planarity, sheet"):
        colouring(folded_shell(), "beauty")


def test_a_result_colours_panels_by_deflection_and_utilisation() -> None:
    pytest.importorskip("KratosMultiphysics", reason="Kratos is not installed")
    arch = ifs.Curve([(0, 0, 0), (0, 0, 800), (2000, 0, 800), (2000, 0, 0)], depth=2)
    shell = ifs.thicken(ifs.vector_sum(arch, [(0, 0, 0), (0, 800, 300), (0, 1600, 0)]), 20)
    shell = shell.with_fibre(ifs.FibreAlongCurve("a"))
    result = ifs.analyse(shell, loads=ifs.AreaLoad(pressure=1500.0), supports=ifs.Support.border())
    deflection = colouring(shell, "deflection", result=result)
    worst = int(np.argmax(deflection.values))
    assert deflection.values[worst] == pytest.approx(np.abs(result.displacements[:, 2]).max())
    used = colouring(shell, "utilisation", result=result)
    assert used.values == pytest.approx(result.utilisation)
    assert used.range[0] == 0
