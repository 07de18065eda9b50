"""What the structure check answers, and how it says so."""

import re
import sys
from dataclasses import replace

import numpy as np
import pytest
from structures import TIMBER, shell_of, strip
from vaults import GROUND, vault

import ifs_cad as ifs
from ifs_cad.elements.fibre import FibreTowards
from ifs_cad.elements.material import Material, Stiffness, Strength
from ifs_cad.errors import InputError, MechanismError, MissingLibraryError
from ifs_cad.progress import listening
from ifs_cad.structure import kratos
from ifs_cad.structure.analyse import analyse
from ifs_cad.structure.converge import converged
from ifs_cad.structure.load import AreaLoad, PointLoad, SelfWeight
from ifs_cad.structure.model import model_of
from ifs_cad.structure.modes import natural_frequencies
from ifs_cad.structure.result import MESH_ERROR
from ifs_cad.structure.section import utilisation
from ifs_cad.structure.solver import Solver
from ifs_cad.structure.support import Support
from ifs_cad.tolerance import DEFAULT

STRENGTH = Strength(20, 10, 12, 6, 16, 8, 4, 2, 1)


def arch(joints="hinge", divisions=4, **options):
    """A folded arch on pinned ends under its weight and snow on one half."""
    curve = ifs.Curve([(0, 0, 0), (1500, 0, 1200), (3000, 0, 0)], depth=2)
    fold = [(0, 0, 0), (0, 300, 80), (0, 600, 0)]
    return analyse(
        shell_of(curve.points, fold, 12.0),
        loads=[SelfWeight(), AreaLoad(pressure=1500, on=ifs.Plane((1500, 0, 0), (-1, 0, 0)))],
        supports=[Support.border("a start"), Support.border("a end")],
        joints=joints,
        stiffness=TIMBER,
        divisions=divisions,
        **options,
    )


@pytest.mark.parametrize("joints", ["hinge", 5e3, "rigid"])
def test_reactions_carry_the_loads(joints):
    result = arch(joints)
    size = np.linalg.norm(result.load)
    assert result.imbalance <= 1e-6 * size
    plan = 1500 * 600
    assert result.load[2] == pytest.approx(-result.weight - 1500e-6 * plan, rel=1e-9)
    left, right = (one.force for one in result.reactions)
    assert left[2] > right[2] > 0  # the loaded side takes more
    assert left[0] > 0 > right[0]  # both push the feet inwards


def test_extremes_are_where_the_arrays_have_them():
    result = arch()
    down = np.abs(result.displacements[:, 2])
    assert result.deflection.value == down.max()
    assert result.deflection.place == tuple(result.model.grid.nodes[down.argmax()])
    assert result.deflection.address in result.model.shell.addresses
    assert result.largest_displacement.value >= result.deflection.value
    moved = result.deformed(2.0) - result.model.grid.nodes
    np.testing.assert_allclose(moved, 2 * result.displacements, atol=1e-9)
    np.testing.assert_array_equal(result.displacements[result.model.grid.nodes[:, 0] == 0], 0)


def test_table_names_the_numbers():
    result = arch()
    text = str(result)
    assert "8 panels of 4 x 4 quads" in text
    assert f"{result.deflection.value:.2f} mm in {result.deflection.address}" in text
    assert "reaction border a start" in text
    assert f"{result.largest_utilisation.value:.2f} in {result.largest_utilisation.address}" in text


def test_panels_use_what_their_worst_quad_uses():
    result = arch()
    panels = result.utilisation
    assert panels.shape == (len(result.model.shell),)
    assert panels.max() == result.quad_utilisation.max() == result.largest_utilisation.value
    face = result.model.grid.face_of_quad == 3
    assert panels[3] == result.quad_utilisation[face].max()


def test_panels_move_as_their_worst_node_does():
    result = arch()
    own = result.model.grid.face_of_node == 5
    assert result.deflections.shape == (len(result.model.shell),)
    assert result.deflections[5] == np.abs(result.displacements[own, 2]).max()
    assert np.nanmax(result.deflections) == result.deflection.value


def test_mesh_is_refined_until_its_error_is_small():
    """What the estimate says is what a much finer mesh moves the answer by."""
    result = arch(divisions=None)
    assert result.model.grid.divisions in {4, 8}
    finest = arch(divisions=16).largest_displacement.value
    missing = abs(result.largest_displacement.value / finest - 1)
    assert missing <= 1.5 * result.mesh_error <= 1.5 * MESH_ERROR
    assert f"about {100 * result.mesh_error:.1f} %" in str(result)
    assert not any("mesh" in text for text in result.warnings)
    unknown = arch()
    assert unknown.mesh_error is None
    assert "not estimated" in str(unknown)


def test_mesh_that_may_not_be_refined_says_how_far_it_is_off():
    result = arch(divisions=None)
    options = {"supports": Support.border("a start", "a end"), "stiffness": TIMBER}
    loads = AreaLoad(pressure=1500)
    coarse = converged(result.model.shell, loads, close=1e-6, finest=8, **options)
    assert coarse.model.grid.divisions == 8
    assert coarse.mesh_error > 1e-6
    warned = replace(coarse, mesh_error=0.05)
    assert any("off by 5 %; give divisions=16" in text for text in warned.warnings)


def test_material_without_strength_has_no_utilisation():
    bare = Material("felt", 100.0, (0.5, 0.5, 0.5), stiffness=TIMBER)
    plate = ifs.thicken(strip(400, 200, 10).mesh, 10.0, material=bare)
    result = analyse(plate, loads=SelfWeight(), supports=Support.border())
    assert result.largest_utilisation is None
    assert np.isnan(result.utilisation).all()
    assert "not known" in str(result)


@pytest.mark.parametrize(
    ("place", "value", "used"),
    [
        (0, 60.0, 6 / 12),  # 6 MPa of tension
        (0, -80.0, (8 / 16) ** 2),
        (1, 30.0, 3 / 6),
        (2, -20.0, 2 / 4),
        (3, -100.0, 6 / 20),
        (4, 50.0, 3 / 10),
        (5, 10.0, 0.6 / 4),
        (6, 8.0, 1.2 / 2),
        (7, -4.0, 0.6 / 1),
    ],
)
def test_utilisation_of_one_force_is_its_stress_over_its_strength(place, value, used):
    """Thickness 10 mm: forces / 10, moments * 6 / 100, transverse forces * 1.5 / 10."""
    forces = np.zeros((1, 8))
    forces[0, place] = value
    assert utilisation(forces, 10.0, STRENGTH)[0] == pytest.approx(used, rel=1e-12)


def test_utilisation_of_bending_and_membrane_force_adds_up():
    """Tension linearly, compression squared (EN 1995-1-1, 6.2.3 and 6.2.4)."""
    pulled = np.array([[60.0, 0, 0, -100, 0, 0, 0, 0]])
    pressed = np.array([[-80.0, 0, 0, -100, 0, 0, 0, 0]])
    assert utilisation(pulled, 10.0, STRENGTH)[0] == pytest.approx(0.5 + 0.3)
    assert utilisation(pressed, 10.0, STRENGTH)[0] == pytest.approx(0.25 + 0.3)


def test_cases_of_one_solver_are_those_of_analyse_and_superpose():
    shell = strip(900, 300, 12, panels=3)
    supports = [Support.border()]
    solve = Solver(model_of(shell, supports=supports, stiffness=TIMBER))
    weight, snow = solve(SelfWeight()), solve(AreaLoad(pressure=800))
    both = analyse(
        shell,
        loads=[1.35 * SelfWeight(), 1.5 * AreaLoad(pressure=800)],
        supports=supports,
        divisions=4,
        stiffness=TIMBER,
    )
    sum_of_both = 1.35 * weight.displacements + 1.5 * snow.displacements
    np.testing.assert_allclose(both.displacements, sum_of_both, atol=1e-9)


def test_shell_stands_on_its_floor():
    result = analyse(
        vault(floor=GROUND),
        loads=AreaLoad(pressure=1000),
        supports="standing",
        divisions=2,
        stiffness=TIMBER,
    )
    (standing,) = result.reactions
    assert standing.support == "standing"
    assert standing.force[2] == pytest.approx(-result.load[2], rel=1e-6)
    held = result.model.grid.nodes[np.linalg.norm(result.displacements, axis=1) == 0]
    assert GROUND.height(held).max() <= 5.0


def test_turned_shell_gives_turned_answers():
    """Nothing depends on the axes: a quarter turn about z and the fibre with it."""
    plain = strip(600, 300, 12, panels=2)
    turned = shell_of(np.linspace((0, 0, 0), (0, 600, 0), 3), [(0, 0, 0), (-300, 0, 0)], 12.0)
    plywood = Stiffness(11000, 6000, 0.05, 600, 600, 600)
    loads = AreaLoad(pressure=1000)
    one = analyse(
        plain,
        loads=loads,
        supports=Support.border(),
        fibre=FibreTowards((1, 0.5, 0)),
        stiffness=plywood,
    )
    other = analyse(
        turned,
        loads=loads,
        supports=Support.border(),
        fibre=FibreTowards((-0.5, 1, 0)),
        stiffness=plywood,
    )
    assert one.deflection.value == pytest.approx(other.deflection.value, rel=1e-9)
    np.testing.assert_allclose(
        np.sort(one.quad_utilisation), np.sort(other.quad_utilisation), rtol=1e-6
    )


def test_progress_tells_its_stages():
    stages = []
    with listening(lambda stage, done, total: stages.append(stage)):
        arch()
    assert list(dict.fromkeys(stages)) == ["element matrices", "assembly", "factorisation"]


def test_missing_kratos_is_explained(monkeypatch):
    monkeypatch.setitem(sys.modules, "KratosMultiphysics", None)
    monkeypatch.setitem(sys.modules, "Kratos", None)
    kratos.load_kratos.cache_clear()
    with pytest.raises(MissingLibraryError, match=r"needed for the structure check.*structure"):
        analyse(strip(400, 200, 10), loads=SelfWeight(), stiffness=TIMBER)
    kratos.load_kratos.cache_clear()


def test_unsupported_shell_is_a_mechanism_as_a_whole():
    with pytest.raises(MechanismError, match="6 as a whole") as caught:
        analyse(strip(400, 200, 10), loads=SelfWeight(), supports=[], stiffness=TIMBER)
    assert caught.value.values["count"] == caught.value.values["rigid"] == 6
    with pytest.raises(MechanismError, match="6 as a whole"):
        natural_frequencies(strip(400, 200, 10), supports=[], stiffness=TIMBER)


def nearly_a_linkage():
    """A hinged arch on one foot, which only the twist of its panels holds."""
    legs = ifs.Curve([(0, 0, 0), (0, 0, 750), (1500, 0, 750), (1500, 0, 0)], depth=2)
    return shell_of(legs.points, [(0, 0, 0), (0, 187, 75), (0, 375, 50), (0, 750, 0)], 20.0)


def test_shell_that_moves_by_more_than_its_size_is_almost_a_mechanism():
    foot = Support.border("a start")
    question = {"stiffness": TIMBER, "divisions": 2}
    load = AreaLoad(pressure=1500)
    said = r"\d{4} mm, more than its own size of 1500 mm"
    with pytest.raises(MechanismError, match=said) as caught:
        analyse(nearly_a_linkage(), loads=load, supports=foot, **question)
    error = caught.value
    assert "hardly resists moving in" in str(error)
    assert set(error.addresses) <= set(nearly_a_linkage().addresses)
    assert error.addresses
    assert "rigid" not in error.values
    holds = [Support.nodes(place, hold=axis) for place, axis in error.values["holding"]]
    held = analyse(nearly_a_linkage(), loads=load, supports=[foot, *holds], **question)
    assert held.largest_displacement.value < 0.1 * 1500


def test_large_movement_is_told_in_plain_numbers():
    foot = Support.border("a start")
    question = {"supports": foot, "stiffness": TIMBER, "divisions": 2}
    small = analyse(nearly_a_linkage(), loads=AreaLoad(pressure=0.1), **question)
    wanted = 900 / small.largest_displacement.value  # mm, of 1500
    large = analyse(nearly_a_linkage(), loads=AreaLoad(pressure=0.1 * wanted), **question)
    assert any("moves by 900 mm, 60 % of its size" in text for text in large.warnings)


def test_forces_out_of_balance_are_explained_by_what_gives_way():
    strict = replace(DEFAULT, equilibrium=1e-30)  # which no arithmetic keeps
    corners = [(0, 0, 0), (900, 0, 0), (900, 300, 0), (0, 300, 0)]
    shell = ifs.thicken(ifs.Mesh(corners, [(0, 1, 2, 3)], tol=strict), 12.0)
    with pytest.raises(MechanismError, match="fail to balance") as caught:
        analyse(shell, loads=SelfWeight(), supports=Support.border(), stiffness=TIMBER)
    assert caught.value.addresses
    assert re.search(r"hardly resists moving.*Holding [xyz] at \(", str(caught.value))


def test_frequencies_rise_and_their_shapes_swing_where_nothing_holds():
    modes = natural_frequencies(
        strip(900, 300, 12, panels=3), 4, supports=Support.border("a start", turn="xyz"),
        joints="rigid", stiffness=TIMBER, divisions=2,
    )  # fmt: skip
    assert (np.diff(modes.frequencies) > 0).all()
    assert modes.shapes.shape == (4, len(modes.model.grid.nodes), 3)
    np.testing.assert_allclose(np.abs(modes.shapes).max(axis=(1, 2)), 1)
    np.testing.assert_array_equal(modes.shapes[:, modes.model.grid.nodes[:, 0] == 0], 0)
    assert str(modes).count("Hz") == 4
    with pytest.raises(InputError, match="count must be"):
        natural_frequencies(strip(9, 9, 1), 0, supports=Support.border(), stiffness=TIMBER)


def test_support_that_is_no_support_is_refused():
    with pytest.raises(InputError, match="'floating'"):
        analyse(
            strip(400, 200, 10),
            loads=PointLoad(force=(0, 0, -1)),
            supports=["floating"],
            stiffness=TIMBER,
        )


def test_linear_answer_that_misleads_says_so():
    shell = strip(900, 300, 12, panels=3)
    supports, loads = Support.border(), AreaLoad(pressure=1000)
    stiff = analyse(shell, loads=loads, supports=supports, stiffness=TIMBER)
    assert stiff.warnings == ()
    soft = analyse(
        shell, loads=40 * loads, supports=supports, stiffness=Stiffness.isotropic(900, 0.3)
    )
    assert any("use analyse_nonlinear" in text for text in soft.warnings)
    assert any("the material fails" in text for text in soft.warnings)
    assert str(soft).count("warning") == 2
