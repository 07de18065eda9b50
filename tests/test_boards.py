"""Cutting plans: every piece once, no board exceeded, as cheap as can be and not cheaper."""

import dataclasses
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ifs_cad import progress
from ifs_cad.elements.material import SPRUCE
from ifs_cad.errors import InputError, StockError
from ifs_cad.fabrication.boards.cutting_plan import cut_boards
from ifs_cad.fabrication.stock import Board
from ifs_cad.tolerance import DEFAULT

TOUCH = 2 * DEFAULT.coincident


def board(length, price=None, count=None):
    return Board(f"spruce {length}", float(length), 150.0, 27.0, SPRUCE, price, count)


def first_fit_decreasing(lengths, length, kerf, trim=0.0):
    """Return how many boards of one length the textbook needs."""
    rooms = []
    for piece in sorted(lengths, reverse=True):
        for k, room in enumerate(rooms):
            if piece <= room + TOUCH:
                rooms[k] -= piece + kerf
                break
        else:
            rooms.append(length - 2 * trim - piece - kerf)
    return len(rooms)


def cheapest(lengths, boards, kerf, trim):
    """Return least cost and then fewest boards, by trying all ways to part a few pieces."""
    costs = [b.length if b.price is None else b.price for b in boards]
    rooms = [b.length - 2 * trim + kerf for b in boards]
    count = len(lengths)
    sizes = [sum(lengths[k] + kerf for k in range(count) if m >> k & 1) for m in range(2**count)]

    @cache
    def least(pieces, left):
        if not pieces:
            return 0.0, 0
        found = [(np.inf, 0)]
        first, rest = pieces & -pieces, pieces & (pieces - 1)
        others = rest
        while True:  # every subset of the rest goes with the first piece
            for s, room in enumerate(rooms):
                if left[s] and sizes[first | others] <= room + TOUCH:
                    fewer = (*left[:s], left[s] - 1, *left[s + 1 :])
                    cost, number = least(rest ^ others, fewer)
                    found.append((cost + costs[s], number + 1))
            if not others:
                return min(found)
            others = (others - 1) & rest

    return least(2**count - 1, tuple(count if b.count is None else b.count for b in boards))


def check(plan, lengths, boards):
    """Assert all that must hold of any plan."""
    assert sorted(k for cut in plan.boards for k in cut.pieces) == list(range(len(lengths)))
    for cut in plan.boards:
        sizes = [lengths[k] for k in cut.pieces]
        assert cut.starts[0] == plan.trim
        for (start, size), (following, _) in pairwise(zip(cut.starts, sizes, strict=True)):
            assert following == pytest.approx(start + size + plan.kerf, abs=TOUCH)
        end = cut.starts[-1] + sizes[-1]
        assert end <= cut.stock.length - plan.trim + TOUCH
        rest = max(0.0, cut.stock.length - plan.trim - end - plan.kerf)
        assert cut.rest == pytest.approx(rest, abs=TOUCH)
    assert [cut.name for cut in plan.boards] == [
        f"board-{n:03d}" for n in range(1, len(plan.boards) + 1)
    ]
    assert all(b in boards and (b.count is None or n <= b.count) for b, n in plan.bought)
    assert sum(n for _, n in plan.bought) == len(plan.boards)
    unit = [b.length if any(b.price is None for b in boards) else b.price for b in boards]
    price = dict(zip(boards, unit, strict=True))
    assert plan.cost == pytest.approx(sum(price[cut.stock] for cut in plan.boards))
    assert plan.optimal == (plan.bound == plan.cost)
    assert plan.bound <= plan.cost
    total = sum(cut.stock.length for cut in plan.boards)
    assert plan.waste == pytest.approx((total - sum(lengths)) / total, abs=1e-12)


pieces = st.one_of(
    st.integers(1, 20).map(lambda n: 50.0 * n),
    st.floats(20.0, 1000.0),
)
kerfs = st.sampled_from([0.0, 3.2, 4.0])


# Known optima


def test_three_thirds_fit_exactly_without_kerf():
    plan = cut_boards([1000.0] * 9, [board(3000)], kerf=0.0)
    check(plan, [1000.0] * 9, [board(3000)])
    assert (len(plan.boards), plan.optimal, plan.waste) == (3, True, 0.0)
    assert {cut.starts for cut in plan.boards} == {(0.0, 1000.0, 2000.0)}


@pytest.mark.parametrize(("excess", "expected"), [(-0.001, 1), (0.0, 1), (0.001, 2)])
def test_kerf_is_taken_between_neighbours_only(excess, expected):
    """Three pieces and two kerfs make exactly the board between its trims."""
    lengths = [1000.0, 1000.0, 972.0 + excess]  # and 2 x 4 + 2 x 10
    plan = cut_boards(lengths, [board(3000)], kerf=4.0, trim=10.0)
    check(plan, lengths, [board(3000)])
    assert (len(plan.boards), plan.optimal) == (expected, True)


def test_rest_is_what_the_last_cut_leaves():
    rests = [
        cut_boards([size], [board(3000)], kerf=4.0, trim=10.0).boards[0].rest
        for size in (2000.0, 2975.0, 2976.0, 2978.0, 2980.0)
    ]
    assert rests == [976.0, 1.0, 0.0, 0.0, 0.0]


def test_rounding_does_not_part_what_fits_exactly():
    lengths = [0.1] * 30  # in floats their sum is more than 3
    assert sum(lengths) > 3.0
    plan = cut_boards(lengths, [board(3)], kerf=0.0)
    check(plan, lengths, [board(3)])
    assert len(plan.boards) == 1


def test_known_instance_is_solved_where_first_fit_is_not_optimal():
    lengths = [4.0, 4.0, 3.0, 3.0, 3.0, 3.0]  # two of 4 on one board leave room for nothing
    assert first_fit_decreasing(lengths, 10, 0.0) == 3
    plan = cut_boards(lengths, [board(10)], kerf=0.0)
    check(plan, lengths, [board(10)])
    assert (len(plan.boards), plan.bound, plan.optimal) == (2, 20.0, True)


def test_triplets_are_put_together_again():
    """Falkenauer's triplets: boards cut into three without waste have no other optimum."""
    rng = np.random.default_rng(4)
    first = rng.integers(380, 490, 20)
    second = rng.integers(260, 300, 20)
    lengths = np.concatenate([first, second, 1000 - first - second]).astype(float).tolist()
    plan = cut_boards(lengths, [board(1000)], kerf=0.0)
    check(plan, lengths, [board(1000)])
    assert (len(plan.boards), plan.optimal) == (20, True)
    assert plan.waste == pytest.approx(0.0, abs=1e-12)


def test_linear_program_below_the_optimum_is_passed_by_trying_all_patterns():
    """Boards of 415 mm would do for the linear program, and 443 mm are needed."""
    lengths = [*[26.0] * 5, *[50.0] * 4, 24.0, 22.0]
    boards = [board(111), board(166)]
    plan = cut_boards(lengths, boards, kerf=0.0)
    check(plan, lengths, boards)
    assert (plan.cost, plan.bound, plan.optimal) == (443.0, 443.0, True)
    assert cheapest(lengths, boards, 0.0, 0.0)[0] == 443.0


def test_material_that_can_never_fill_a_board_counts_for_the_bound():
    """259 mm on two boards of 132, of which no pieces fill more than 129."""
    lengths = [*[44.0] * 2, *[33.0] * 3, *[12.0] * 6]
    plan = cut_boards(lengths, [board(132)], kerf=0.0, time_limit=0.0)
    check(plan, lengths, [board(132)])
    assert (len(plan.boards), plan.bound, plan.optimal) == (3, 396.0, True)


# Against other ways


@settings(max_examples=40)
@given(st.lists(pieces, min_size=1, max_size=40), kerfs, st.sampled_from([0.0, 12.5]))
def test_plan_is_whole_and_no_worse_than_first_fit_decreasing(lengths, kerf, trim):
    boards = [board(1030), board(1400)]
    plan = cut_boards(lengths, boards, kerf=kerf, trim=trim, time_limit=0.3)
    check(plan, lengths, boards)
    for one in boards:
        assert plan.cost <= one.length * first_fit_decreasing(lengths, one.length, kerf, trim)


@settings(max_examples=60)
@given(
    st.lists(pieces, min_size=1, max_size=6),
    st.sampled_from(
        [
            [board(1100)],
            [board(1100), board(1700)],
            [board(1100, 9.5), board(1450, 12.0), board(2100, 19.9)],
            [board(1100), board(1500, None, 2), board(2200, None, 1)],
            [board(1100, 7.0), board(2000, 0.0, 1)],
        ]
    ),
    kerfs,
)
def test_plan_of_few_pieces_is_the_cheapest_of_all(lengths, boards, kerf):
    plan = cut_boards(lengths, boards, kerf=kerf, trim=5.0)
    check(plan, lengths, boards)
    cost, number = cheapest(lengths, boards, kerf, 5.0)
    assert plan.optimal
    assert plan.cost == pytest.approx(cost, rel=1e-12)
    assert len(plan.boards) >= number


@pytest.mark.parametrize("seed", range(20))
def test_random_list_is_cut_at_least_as_well_as_by_first_fit_decreasing(seed):
    rng = np.random.default_rng(seed)
    sizes = rng.uniform(200.0, 1900.0, rng.integers(5, 40))
    lengths = np.repeat(sizes, rng.integers(1, 8, len(sizes))).tolist()
    plan = cut_boards(lengths, [board(4000)], time_limit=0.5)
    check(plan, lengths, [board(4000)])
    needed = first_fit_decreasing(lengths, 4000, 4.0)
    assert plan.bound / 4000 <= len(plan.boards) <= needed
    # what the material alone demands is a bound, too
    assert plan.bound / 4000 >= (sum(lengths) + 4.0 * len(lengths)) / 4004.0


def test_vault_of_thirty_layers_is_solved_to_proof():
    sizes = np.random.default_rng(1).uniform(200.0, 800.0, 32)
    lengths = np.repeat(sizes, 30).tolist()
    plan = cut_boards(lengths, [board(4000)])
    check(plan, lengths, [board(4000)])
    assert plan.optimal
    assert len(plan.boards) == 122 < first_fit_decreasing(lengths, 4000, 4.0)


def test_time_limit_leaves_a_whole_plan_and_an_honest_bound():
    lengths = np.repeat(np.random.default_rng(1).uniform(600.0, 1900.0, 32), 10).tolist()
    plan = cut_boards(lengths, [board(4000)], time_limit=0.0)
    check(plan, lengths, [board(4000)])
    assert len(plan.boards) <= first_fit_decreasing(lengths, 4000, 4.0)
    assert not plan.optimal
    assert plan.gap == pytest.approx(1 - plan.bound / plan.cost)
    assert f"at most {100 * plan.gap:.1f} % could be saved" in str(plan)
    longer = cut_boards(lengths, [board(4000)])
    check(longer, lengths, [board(4000)])
    assert plan.bound <= longer.bound <= longer.cost < plan.cost


def test_many_different_lengths_are_first_joined_to_fewer():
    """More sizes than are solved at once: first fit decreasing needs more boards."""
    lengths = np.random.default_rng(1).uniform(600.0, 1900.0, 90).tolist()
    plan = cut_boards(lengths, [board(4000)], time_limit=2.0)
    check(plan, lengths, [board(4000)])
    assert len(plan.boards) < first_fit_decreasing(lengths, 4000, 4.0)


# Prices and counts


def test_prices_decide_which_boards_are_bought():
    lengths = [1900.0] * 4
    by_length = cut_boards(lengths, [board(2000), board(4000)])
    assert by_length.bought == [(board(4000), 2)]  # as long as four short ones, and fewer
    dear = [board(2000, 5.0), board(4000, 10.5)]
    plan = cut_boards(lengths, dear)
    check(plan, lengths, dear)
    assert plan.bought == [(dear[0], 4)]
    assert (plan.cost, plan.optimal) == (20.0, True)
    half_known = [board(2000, 5.0), board(4000)]
    assert cut_boards(lengths, half_known).cost == 8000.0


def test_free_boards_are_used_up_first():
    boards = [board(4000, 12.0), board(3000, 0.0, 2)]
    plan = cut_boards([1400.0] * 8, boards)
    assert plan.bought == [(boards[0], 2), (boards[1], 2)]
    assert (plan.cost, plan.bound, plan.optimal) == (24.0, 24.0, True)


def test_counts_are_kept_where_first_fit_would_fail():
    lengths = [4.0, 4.0, 3.0, 3.0, 3.0, 3.0]
    boards = [board(10, None, 2)]
    plan = cut_boards(lengths, boards, kerf=0.0)
    check(plan, lengths, boards)
    assert {cut.starts for cut in plan.boards} == {(0.0, 4.0, 7.0)}


def test_boards_shorter_than_every_piece_are_left_alone():
    boards = [board(15), board(900), board(4000)]
    plan = cut_boards([1000.0, 2000.0], boards, trim=10.0)
    assert plan.bought == [(boards[2], 1)]


# Errors


def test_pieces_longer_than_every_board_are_named():
    with pytest.raises(StockError) as caught:
        cut_boards(
            [100.0, 3990.5, 5000.0],
            [board(3000), board(4000)],
            trim=5.0,
            addresses=["L00-00", "L00-01", "L00-10"],
        )
    assert str(caught.value) == (
        "Longer than every board: L00-01 (3990.5 mm), L00-10 (5000.0 mm). The longest board, "
        "spruce 4000, leaves 3990.0 mm. Add longer boards, or divide these pieces."
    )
    assert caught.value.addresses == ("L00-01", "L00-10")
    assert caught.value.values == {"lengths": [3990.5, 5000.0], "longest": 3990.0}


def test_too_few_boards_say_what_is_missing():
    with pytest.raises(StockError) as caught:
        cut_boards([900.0] * 5, [board(2000, 3.0, 2)], kerf=5.0, addresses="abcde")
    assert str(caught.value).startswith(
        "There are not enough boards: 1 of 5 pieces, 900 mm in all, found no place: e (900.0 mm). "
        "All boards together are 515 mm too short for all pieces with their kerfs."
    )
    assert caught.value.addresses == ("e",)


def test_boards_long_enough_together_may_be_too_few():
    with pytest.raises(StockError, match="long enough, but no way to cut them was found"):
        cut_boards([600.0] * 3, [board(1000, None, 2)], kerf=0.0)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"lengths": []}, "Lengths must be a list of at least one"),
        ({"lengths": [[1.0]]}, "Lengths must be a list"),
        ({"lengths": ["a"]}, "Lengths must be numbers of mm"),
        ({"lengths": [1.0, 0.0, np.nan]}, "pieces 1, 2 are not"),
        ({"boards": []}, "Boards must be at least one"),
        ({"boards": [board(4000), board(4000)]}, "each with a name of its own"),
        ({"kerf": -1.0}, "Kerf must be a finite number of at least 0, got -1.0"),
        ({"trim": np.inf}, "Trim must be a finite number"),
        ({"time_limit": np.nan}, "Time limit must be a finite number"),
        ({"addresses": ["a", "b"]}, "one for each of 1 lengths, got 2"),
    ],
)
def test_value_that_cannot_be_meant_is_an_error(changed, message):
    given_values = {"lengths": [100.0], "boards": [board(4000)]} | changed
    with pytest.raises(InputError, match=message):
        cut_boards(**given_values)


# What is told


def test_report_shows_purchase_waste_and_bound():
    plan = cut_boards([1000.0] * 6, [board(4000, 12.5)], kerf=4.0)
    assert str(plan).splitlines() == [
        "pieces          6, 6.00 m",
        "buy             2 x spruce 4000, 4000 mm",
        "boards          2",
        "waste           25.0 %, longest rest 988 mm, kerf 4 mm, trim 0 mm",
        "cost            25.00",
        "lower bound     25.00: this plan is optimal",
    ]
    assert plan.report() == str(plan)


def test_plan_is_the_same_each_time_and_frozen():
    lengths = np.random.default_rng(3).uniform(200.0, 900.0, 30).tolist()
    plan = cut_boards(lengths, [board(3000), board(4000)])
    assert cut_boards(lengths, [board(3000), board(4000)]) == plan
    with pytest.raises(dataclasses.FrozenInstanceError):
        plan.cost = 0.0


def test_progress_is_told_as_patterns_are_found():
    told = []
    lengths = np.random.default_rng(1).uniform(600.0, 1900.0, 32)
    with progress.listening(lambda *step: told.append(step)):
        cut_boards(np.repeat(lengths, 10), [board(4000)])
    assert told[0] == ("cutting boards", 0, None)
    assert {(stage, total) for stage, _, total in told} == {("cutting boards", None)}
    found = [done for _, done, _ in told]
    assert found == sorted(found)
    assert found[-1] > 0
