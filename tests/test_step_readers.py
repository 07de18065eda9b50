"""Our STEP files in programs that did not write them: gmsh, FreeCAD, and a plain Part 21 parser."""

import cadquery as cq
import numpy as np
import pytest
from step_readers import gmsh_model, needs_freecad, read_by_freecad, read_by_gmsh
from steputils import p21

import ifs_cad as ifs
from ifs_cad.elements.cutting import cutting_frames
from ifs_cad.kernel.assembly import STROKES_SUFFIX


def small_shell():
    arch = ifs.Curve([(0, 0, 0), (0, 0, 700), (1400, 0, 700), (1400, 0, 0)], depth=2)
    fold = ifs.Curve([(0, 0, 0), (0, 500, 150), (0, 1000, 0)], depth=2).with_roughness(0.3)
    return ifs.thicken(ifs.vector_sum(arch, fold), 12.0, clearance=0.1)


def panels_of(assembly):
    """Return the parts that are solids, by address."""
    return {
        part.name: part
        for part in assembly.objects.values()
        if part.obj is not None and not part.name.endswith(STROKES_SUFFIX)
    }


MADE = {
    "engraved": {"label": ifs.Label(cutter=2.0), "holes": ifs.Holes()},
    "drawn and nested": {"label": "wire", "nest": 1},
}


@pytest.fixture(scope="module", params=MADE)
def written(request, tmp_path_factory):
    """An assembly and the file that holds it."""
    assembly = ifs.to_assembly(small_shell(), **MADE[request.param])
    path = tmp_path_factory.mktemp("readers") / "shell.step"
    return assembly, ifs.export_step(assembly, path)


@pytest.fixture
def model():
    with gmsh_model() as empty:
        yield empty


def test_gmsh_finds_every_panel_with_its_name_place_and_volume(written, model):
    assembly, path = written
    found = read_by_gmsh(model, path)
    panels = panels_of(assembly)
    assert len(found) == 16
    assert found.keys() == panels.keys()
    for address, part in panels.items():
        volume = part.metadata["volume"]
        assert model.occ.getMass(3, found[address]) == pytest.approx(volume, rel=1e-9)
        middle = part.metadata["solid"].moved(part.loc).Center().toTuple()
        assert model.occ.getCenterOfMass(3, found[address]) == pytest.approx(middle, abs=1e-6)


@needs_freecad
def test_freecad_finds_every_panel_with_its_label_place_group_and_volume(written, tmp_path):
    assembly, path = written
    found = read_by_freecad(path, tmp_path)
    parts = {part.name: part for part in assembly.objects.values() if part.obj is not None}
    assert found.keys() == parts.keys()
    for name, part in parts.items():
        assert found[name]["group"] == [part.parent.name]
        placement = np.reshape(found[name]["placement"], (4, 4))
        frame = part.loc.wrapped.Transformation()
        wanted = [[frame.Value(i, j) for j in range(1, 5)] for i in range(1, 4)]
        assert placement[:3] == pytest.approx(np.array(wanted), abs=1e-9)
    for address, part in panels_of(assembly).items():
        assert found[address]["solids"] == 1
        assert found[address]["volume"] == pytest.approx(part.metadata["volume"], rel=1e-9)


# --- without any kernel -----------------------------------------------------------------------


def entities(path):
    """Return the simple entities of a file by number, and the numbers that refer to each."""
    section = p21.readfile(str(path)).data[0]
    simple = {
        number: instance.entity
        for number, instance in section.instances.items()
        if hasattr(instance, "entity")
    }
    referring = {}
    for number, entity in simple.items():
        for reference in references(entity.params):
            referring.setdefault(reference, []).append(number)
    return simple, referring


def references(parameters):
    for value in parameters:
        if isinstance(value, (list, tuple)):
            yield from references(value)
        elif isinstance(value, p21.Reference):
            yield value


def test_parser_finds_the_addresses_as_product_names(written):
    assembly, path = written
    simple, _ = entities(path)
    products = [entity.params[0] for entity in simple.values() if entity.name == "PRODUCT"]
    parts = [part.name for part in assembly.objects.values()]
    assert sorted(products) == sorted(parts)
    solids = [entity for entity in simple.values() if entity.name == "MANIFOLD_SOLID_BREP"]
    assert len(solids) == 16


def test_parser_finds_the_corners_of_every_panel(tmp_path):
    """From the product's name to its vertices, in the text alone."""
    shell = small_shell()
    path = ifs.export_step(ifs.to_assembly(shell), tmp_path / "shell.step")
    simple, referring = entities(path)

    def only(numbers, *kinds):
        (found,) = [number for number in numbers if simple[number].name in kinds]
        return found

    def below(number):
        """Yield the numbers of everything that an entity is made of."""
        waiting, seen = [number], set()
        while waiting:
            here = waiting.pop()
            if here not in seen and here in simple:
                seen.add(here)
                waiting += references(simple[here].params)
        return seen

    products = {e.params[0]: n for n, e in simple.items() if e.name == "PRODUCT"}
    solids = cutting_frames(shell).solids
    for index, address in enumerate(shell.addresses):
        number = products[address]
        for kind in (
            "PRODUCT_DEFINITION_FORMATION",
            "PRODUCT_DEFINITION",
            "PRODUCT_DEFINITION_SHAPE",
            "SHAPE_DEFINITION_REPRESENTATION",
        ):
            number = only(referring[number], kind)
        representation = simple[number].params[1]
        corners = [
            simple[simple[n].params[1]].params[1]
            for n in below(representation)
            if simple[n].name == "VERTEX_POINT"
        ]
        wanted = solids.vertices[solids.solid_of_vertex == index]
        found = np.array(corners, dtype=float)
        assert len(found) == len(wanted)
        distances = np.linalg.norm(found[:, None] - wanted, axis=2)
        assert distances.min(axis=0).max() < 1e-9
        assert distances.min(axis=1).max() < 1e-9


def test_parser_finds_the_schema_and_millimetres(tmp_path):
    box = cq.Assembly(cq.Workplane().box(1, 2, 3), name="box")
    for schema, name in (("AP214", "AUTOMOTIVE_DESIGN"), ("AP242", "AP242")):
        path = ifs.export_step(box, tmp_path / f"{schema}.step", schema=schema)
        file = p21.readfile(str(path))
        assert str(file.header["FILE_SCHEMA"].params[0][0]).startswith(name)
        units = [
            str(entity.params)
            for instance in file.data[0].instances.values()
            if not hasattr(instance, "entity")
            for entity in instance.entities
            if entity.name == "SI_UNIT" and "METRE" in str(entity.params)
        ]
        assert len(units) > 0
        assert all("MILLI" in unit for unit in units)
