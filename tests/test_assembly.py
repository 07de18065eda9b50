"""The shell as a CadQuery assembly: names, places, data, and how the parts fit together."""

import itertools

import cadquery as cq
import numpy as np
import pytest
from brep import planes, points, volume
from hypothesis import given, settings
from strategies import accepted, shells
from vaults import GROUND, THICKNESS, plate, roof, vault

from ifs_cad.design.curve import Curve
from ifs_cad.design.mesh import Mesh
from ifs_cad.elements.hole import Holes
from ifs_cad.elements.label import Label
from ifs_cad.elements.polyhedron import Kind
from ifs_cad.elements.thicken import thicken
from ifs_cad.elements.vault import vault as vault_of_planks
from ifs_cad.errors import ClashError, InputError, LabelError, SelfIntersectionError
from ifs_cad.kernel.assembly import STROKES_SUFFIX, modified_parts, to_assembly


def solids_of(assembly):
    """Return the parts that are panels, by address."""
    return {name: part for name, part in assembly.objects.items() if "address" in part.metadata}


def in_world(assembly):
    """Return the panels' solids where they stand, by address, through all locations above them."""
    return {part.name: shape for shape, part in _leaves(assembly, cq.Location())}


def _leaves(assembly, place):
    place = place * assembly.loc
    if "address" in assembly.metadata:
        yield assembly.obj.moved(place), assembly
    for child in assembly.children:
        yield from _leaves(child, place)


def chamfers(shape, panel):
    """Return (normal, level) of the plane face of a solid nearest to each edge of its panel.

    None where the floor took all of it.
    """
    found = []
    mesh = panel.shell.mesh
    for half_edge in panel.half_edges:
        middle = mesh.positions[[half_edge, mesh.next[half_edge]]].mean(axis=0)
        inward = np.cross(panel.normal, mesh.directions[half_edge])
        gaps = [
            (abs(normal @ middle - level), normal, level)
            for normal, level, _ in planes(shape.wrapped)
            if normal @ inward < -0.05 and abs(normal @ mesh.directions[half_edge]) < 1e-6
        ]
        found.append(min(gaps, key=lambda gap: gap[0])[1:] if gaps else None)
    return found


def assert_chamfers_mate(shell, assembly):
    """Check in the assembly's world that both sides of every joint lie in one plane."""
    world, mesh, joints = in_world(assembly), shell.mesh, 0
    sides = {panel.address: chamfers(world[panel.address], panel) for panel in shell}
    for panel in shell:
        for side, half_edge, neighbour in zip(
            sides[panel.address], panel.half_edges, panel.neighbours, strict=True
        ):
            if side is None or neighbour not in sides:
                continue
            across = sides[neighbour][shell[neighbour].neighbours.index(panel.address)]
            (normal, level), (other, other_level) = side, across
            back, other_back = shell.set_backs[[half_edge, mesh.twin[half_edge]]]
            edge = mesh.positions[[half_edge, mesh.next[half_edge]]]
            np.testing.assert_allclose(normal, -other, rtol=0, atol=1e-9)
            np.testing.assert_allclose(edge @ normal - level, back, rtol=0, atol=1e-6)
            assert level + other_level == pytest.approx(-back - other_back, abs=1e-6)
            joints += 1
    assert joints > 0


def test_every_panel_is_a_part_named_by_its_address():
    shell = vault()
    assembly = to_assembly(shell, name="vault")
    assert assembly.name == "vault"
    assert [child.name for child in assembly.children] == list(shell.addresses)
    assert len(set(shell.addresses)) == len(shell) == 16
    assert all(address.isascii() and address.isalnum() for address in shell.addresses)
    assert set(assembly.objects) == {"vault", *shell.addresses}
    for address, part in solids_of(assembly).items():
        assert part is assembly.objects[address]
        assert part.metadata["address"] == address
        assert isinstance(part.obj, cq.Solid)
        assert part.obj.isValid()


@pytest.mark.parametrize("nest", [0, 1, 2])
def test_nested_assembly_groups_panels_by_their_prefix(nest):
    shell = vault(3)
    assembly = to_assembly(shell, nest=nest, validate=False)
    assert list(solids_of(assembly)) != []
    for address, part in solids_of(assembly).items():
        above, digits = part.parent, nest
        while digits:
            assert above.name == f"shell-{address[:digits]}"
            assert above.obj is None
            above, digits = above.parent, digits - 1
        assert above is assembly
    groups = [name for name in assembly.objects if name.startswith("shell-")]
    assert len(groups) == sum(4**k for k in range(1, nest + 1))
    assert sum(len(part.children) for part in assembly.objects.values()) == 64 + len(groups)
    flat = in_world(to_assembly(shell, validate=False))
    for address, shape in in_world(assembly).items():
        np.testing.assert_array_equal(points(shape.wrapped), points(flat[address].wrapped))


def test_dotted_addresses_nest_by_their_digits():
    names = ["10.0", "10.11", "3.0", "3.11"]
    grid = [(x, y, 0) for x in (0, 300, 600) for y in (0, 300, 600)]
    quads = [(0, 3, 4, 1), (1, 4, 5, 2), (3, 6, 7, 4), (4, 7, 8, 5)]
    shell = thicken(Mesh(grid, quads, addresses=names), THICKNESS)
    assembly = to_assembly(shell, nest=1)
    assert [child.name for child in assembly.children] == ["shell-10", "shell-3"]
    assert [child.name for child in assembly.children[0].children] == names[:2]


@pytest.mark.parametrize("nest", [-1, 2, 7])
def test_nesting_deeper_than_the_addresses_is_an_error(nest):
    with pytest.raises(InputError, match="nest must be from 0 to 1 for addresses like 00"):
        to_assembly(vault(), nest=nest)


def test_parts_carry_the_data_of_their_panels():
    shell = vault(clearance=0.2)
    assembly = to_assembly(shell, label="engraved", holes=Holes())
    assert assembly.metadata["elements"] is shell
    for panel in shell:
        data = assembly.objects[panel.address].metadata
        assert data["address"] == panel.address
        assert data["thickness"] == THICKNESS
        assert data["area"] == panel.area
        assert data["mass"] == panel.mass
        assert data["neighbours"] == panel.neighbours
        assert data["chamfer_angles"] == panel.chamfer_angles.tolist()
        assert len(data["chamfer_angles"]) == len(data["neighbours"]) == 4
        assert data["solid"] is assembly.objects[panel.address].obj
        assert data["volume"] == pytest.approx(volume(data["solid"].wrapped), rel=1e-9)
        assert data["volume"] < panel.volume


def test_metadata_of_a_roof_is_what_one_computes_by_hand():
    angle, shell = 20.0, roof(400, 300, 20.0)
    one, other = to_assembly(shell).children
    wide = 400 + THICKNESS * np.tan(np.radians(angle))
    assert one.metadata["area"] == pytest.approx(wide * 300, rel=1e-12)
    assert one.metadata["volume"] == pytest.approx((wide + 400) / 2 * 300 * THICKNESS, rel=1e-12)
    assert one.metadata["mass"] == pytest.approx(
        (wide + 400) / 2 * 300 * THICKNESS * 1e-9 * shell.thickening.material.density, rel=1e-12
    )
    assert sorted(one.metadata["chamfer_angles"]) == pytest.approx([0, 0, 0, angle], abs=1e-9)
    assert sorted(one.metadata["neighbours"]) == ["", "", "", other.name]
    ridge = one.metadata["neighbours"].index(other.name)
    assert one.metadata["chamfer_angles"][ridge] == pytest.approx(angle, abs=1e-9)


def test_parts_have_the_colour_of_their_material():
    shell = vault()
    assembly = to_assembly(shell, label="wire")
    for address in shell.addresses:
        colour = assembly.objects[address].color.toTuple()
        assert colour[:3] == pytest.approx(shell.thickening.material.colour, abs=1e-6)
        assert colour[3] == 1.0
        assert assembly.objects[address + STROKES_SUFFIX].color is None


def test_wires_are_parts_beside_their_panels():
    shell = vault()
    assembly = to_assembly(shell, label=Label(face="outer", style="wire"), nest=1)
    for panel in shell:
        part, strokes = (
            assembly.objects[panel.address + suffix] for suffix in ("", STROKES_SUFFIX)
        )
        assert strokes.parent is part.parent
        assert isinstance(strokes.obj, cq.Compound)
        in_place = points(strokes.obj.moved(strokes.loc).wrapped)
        foot = shell.mesh.positions[panel.half_edges[0]]
        height = (in_place - foot) @ panel.normal
        np.testing.assert_allclose(height, THICKNESS, rtol=0, atol=1e-7)
        bar = in_place[np.argsort(in_place[:, 2])[:2]]  # the lowest stroke of upright text
        assert np.ptp(bar[:, 2]) < 1e-7 or abs(panel.normal[2]) > 0.99


@pytest.mark.parametrize("side", ["outer", "inner", "centre"])
@pytest.mark.parametrize("clearance", [0.0, 0.3])
def test_mating_chamfers_lie_in_one_plane(side, clearance):
    shell = vault(side=side, clearance=clearance)
    assert_chamfers_mate(shell, to_assembly(shell, label="engraved", holes=Holes(), nest=1))


def test_mating_chamfers_lie_in_one_plane_above_a_floor_and_beside_a_door():
    shell = vault(floor=GROUND).without("12")
    assert_chamfers_mate(shell, to_assembly(shell))


@settings(max_examples=40)
@given(shells())
def test_mating_chamfers_of_any_shell_lie_in_one_plane(shell):
    assembly = accepted(to_assembly, shell)
    if any("".join(panel.neighbours) for panel in shell):
        assert_chamfers_mate(shell, assembly)


@pytest.mark.parametrize("side", ["outer", "inner", "centre"])
def test_neighbours_share_no_volume_by_the_kernel(side):
    shell = vault(side=side)
    world = in_world(to_assembly(shell))
    polygons = shell.mesh.polygons()
    node_pairs = [
        (one.address, other.address)
        for one, other in itertools.combinations(shell, 2)
        if set(polygons[one.face]) & set(polygons[other.face])
    ]
    assert len(node_pairs) == 42
    for one, other in node_pairs:
        common = world[one].intersect(world[other])
        assert sum(volume(solid.wrapped) for solid in common.Solids()) < 1e-6


def test_panels_that_run_into_each_other_are_not_assembled():
    colliding = vault(nodes="plain")
    with pytest.raises(ClashError, match="share a node"):
        to_assembly(colliding)
    assert len(to_assembly(colliding, validate=False).children) == 16


def test_designs_that_cross_themselves_are_not_assembled():
    level = [(0, 0, 0), (400, 0, 0), (400, 300, 0), (0, 300, 0)]
    upright = [(200, -50, -200), (200, 400, -200), (200, 400, 200), (200, -50, 200)]
    crossing = Mesh(level + upright, [(0, 1, 2, 3), (4, 5, 6, 7)])
    with pytest.raises(SelfIntersectionError, match="f0000 and f0001"):
        to_assembly(thicken(crossing, THICKNESS))


def test_label_without_room_stops_the_assembly():
    with pytest.raises(LabelError):
        to_assembly(plate(40, 30), label="engraved")


def test_modified_parts_are_those_of_another_shape():
    assembly = to_assembly(vault(), label="wire", nest=1)
    assert modified_parts(assembly) == []
    part = assembly.objects["12"]
    part.obj = part.obj.cut(cq.Solid.makeBox(50, 50, 50))
    assert modified_parts(assembly) == ["12"]
    assembly.objects["03"].obj = cq.Workplane(obj=assembly.objects["03"].obj)
    assert set(modified_parts(assembly)) == {"03", "12"}
    part.obj = part.metadata["solid"]
    assert modified_parts(assembly) == ["03"]


def test_moved_assembly_is_not_a_modified_one():
    assembly = to_assembly(vault())
    assembly.loc = cq.Location(cq.Vector(1000, 0, 0))
    assembly.objects["12"].loc = cq.Location(cq.Vector(0, 0, 5))
    assert modified_parts(assembly) == []


def test_door_leaves_its_panel_out():
    assembly = to_assembly(vault().without("1*"))
    assert set(solids_of(assembly)) == {a for a in vault().addresses if a[0] != "1"}


def test_part_of_a_shell_keeps_its_chamfers_and_its_place():
    shell = vault()
    whole, part = in_world(to_assembly(shell)), in_world(to_assembly(shell.part("0*")))
    assert set(part) == {a for a in shell.addresses if a[0] == "0"}
    for address, shape in part.items():
        np.testing.assert_allclose(points(shape.wrapped), points(whole[address].wrapped), atol=1e-9)
    assert (shell.part("0*").solids.kinds == Kind.CUT).any()


def test_all_panels_make_one_compound_of_their_volumes():
    shell = vault()
    compound = to_assembly(shell, nest=1).toCompound()
    assert sum(volume(s.wrapped) for s in compound.Solids()) == pytest.approx(
        shell.volumes.sum(), rel=1e-9
    )


@pytest.mark.parametrize("nest", [0, 1, 2])
def test_planks_nest_by_layer_and_then_by_digit(nest):
    arch = Curve([(0, 0, 0), (0, 0, 3000), (4000, 0, 3000), (4000, 0, 0)], depth=2)
    planks = vault_of_planks(arch, 120, 40, layers=3, stagger=True)
    assembly = to_assembly(planks, nest=nest, name="vault")
    assert set(solids_of(assembly)) == set(planks.addresses)
    for address, part in solids_of(assembly).items():
        layer, word = address.split("-")
        names = ["vault", f"vault-{layer}", f"vault-{layer}-{word[0]}"][: nest + 1]
        above = []
        while part.parent is not None:
            part = part.parent
            above.append(part.name)
        assert above[::-1] == names
    groups = {name for name in assembly.objects if name.startswith("vault-")}
    assert len(groups) == (0, 3, 3 + 6)[nest]
    flat = in_world(to_assembly(planks))
    for address, shape in in_world(assembly).items():
        np.testing.assert_array_equal(points(shape.wrapped), points(flat[address].wrapped))


def test_planks_nest_no_deeper_than_their_shortest_address():
    planks = vault_of_planks([(0, 0, 0), (0, 0, 900)], 120, 40, layers=2, across=(0, 1, 0))
    with pytest.raises(InputError, match="nest must be from 0 to 1 for addresses like L00-0"):
        to_assembly(planks, nest=2)
