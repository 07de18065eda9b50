"""Exploded views: what moves together, and how far."""

from __future__ import annotations

import numpy as np
import pytest

import ifs_cad as ifs
from ifs_cad.elements.explosion import explosion
from ifs_cad.errors import InputError


def flat_shell() -> ifs.Shell:
    """16 panels of 100 x 100 mm in a square about (200, 200), addresses of two digits."""
    line = ifs.Curve([(0, 0, 0), (200, 0, 0), (400, 0, 0)], depth=2)
    across = ifs.Curve([(0, 0, 0), (0, 200, 0), (0, 400, 0)], depth=2)
    return ifs.thicken(ifs.vector_sum(line, across), 10)


def middles(shell: ifs.Shell) -> np.ndarray:
    solids = shell.solids
    return np.array(
        [solids.vertices[solids.solid_of_vertex == k].mean(axis=0) for k in range(len(shell))]
    )


def test_one_factor_moves_first_digits_as_a_whole_away_from_the_middle() -> None:
    shell = flat_shell()
    shifts = explosion(shell, (0.5,))
    for digit in "0123":
        group = [k for k, address in enumerate(shell.addresses) if address[0] == digit]
        assert len(group) == 4
        away = middles(shell)[group].mean(axis=0) - (200, 200, middles(shell)[0, 2])
        assert np.abs(away[:2]) == pytest.approx([100, 100])
        assert shifts[group] == pytest.approx(np.tile(0.5 * away, (4, 1)))


def test_a_single_number_is_halved_from_digit_to_digit() -> None:
    shell = flat_shell()
    assert explosion(shell, 1.0) == pytest.approx(explosion(shell, (1.0, 0.5)))
    second = explosion(shell, (0.0, 0.5))
    assert np.abs(second[:, :2]) == pytest.approx(np.full((16, 2), 25))


def test_pieces_never_overlap_that_did_not_before() -> None:
    """Digit by digit everything is stretched about a middle, so an order along x stays."""
    shell = flat_shell()
    moved = middles(shell) + explosion(shell, 0.8)
    x = np.sort(np.unique(np.round(moved[:, 0], 6)))
    assert len(x) == 4
    assert np.diff(x).min() > 100


def test_nothing_moves_by_zero() -> None:
    assert not explosion(flat_shell(), 0.0).any()


@pytest.mark.parametrize("factor", [-0.1, float("nan"), float("inf"), (0.1, -1)])
def test_a_factor_that_cannot_be_meant_is_refused(factor: float) -> None:
    with pytest.raises(InputError, match="factors of 0 or more"):
        explosion(flat_shell(), factor)
