"""The house rules about imports: light, one way, no circles, the kernel in its room."""

import ast
import graphlib
import importlib.util
import json
import os
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

import ifs_cad

PACKAGE = Path(ifs_cad.__file__).parent

# A room imports only from itself and from rooms in lines above.
ROOMS = [
    {"errors", "files", "libraries", "progress", "tolerance", "toml", "types", "vectors"},
    {"design"},
    {"elements"},
    {"design_file", "design_record", "design_script", "design_text"},
    {"fabrication"},
    {"structure"},
    {"kernel"},
    {"export"},
    {"view"},
    {"workflow"},
    {"studio"},
    {"cli"},
]
LEVELS = {room: level for level, rooms in enumerate(ROOMS) for room in rooms}

KERNEL_LIBRARIES = {"OCP", "cadquery", "vtk", "vtkmodules"}
KERNEL_ROOMS = {"kernel", "view"}  # pictures are drawn of the kernel's shapes
MAY_IMPORT_THE_KERNEL = {"ifs_cad.export.step", "ifs_cad.export.vtu"}
VIEWER_LIBRARIES = {"ocp_tessellate", "ocp_viewer", "ocp_viewer_core", "ocp_vscode"}
MAY_IMPORT_THE_VIEWER = {"ifs_cad.view.preview"}
PAGE_LIBRARIES = {"viser"}
MAY_IMPORT_THE_PAGE = {"ifs_cad.studio.server", "ifs_cad.studio.run"}
STUDIO_WITHOUT_A_PAGE = (
    *(
        "model",
        "editing",
        "evaluation",
        "kept",
        "replacing",
        "session",
        "recompute",
        "access",
        "jobs",
    ),
)
MAY_LOAD_SCIPY = {"ifs_cad.elements.clash"}


def module_name(path: Path) -> str:
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


SOURCES = {module_name(path): path for path in sorted(PACKAGE.rglob("*.py"))}
MODULES = sorted(SOURCES.keys() - {"ifs_cad"})


def room(module: str) -> str:
    return module.split(".")[1]


def is_light(module: str) -> bool:
    return room(module) == "cli" or LEVELS[room(module)] < LEVELS["structure"]


class Import(NamedTuple):
    name: str  # as far as it is a module of this package; else as written
    line: int
    for_types: bool  # under `if TYPE_CHECKING`, never executed


def imports_of(module: str) -> Iterator[Import]:
    """Every import of a module, in functions too, and those by name given as text."""
    tree = ast.parse(SOURCES[module].read_text(encoding="utf-8"))
    package = module if SOURCES[module].name == "__init__.py" else module.rpartition(".")[0]
    for_types = {
        child
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test)
        for statement in node.body
        for child in ast.walk(statement)
    }
    for node in ast.walk(tree):
        match node:
            case ast.Import(names=names):
                found = [alias.name for alias in names]
            case ast.ImportFrom(module=source, names=names, level=level):
                base = importlib.util.resolve_name("." * level + (source or ""), package)
                members = [f"{base}.{alias.name}" for alias in names]
                found = [name if name in SOURCES else base for name in members]
            case ast.Call(
                func=ast.Name(id=name) | ast.Attribute(attr=name),
                args=[ast.Constant(str(text)), *_],
            ) if name in {"require", "load", "import_module", "__import__"}:
                found = [text]
            case _:
                continue
        for name in found:
            yield Import(name, node.lineno, node in for_types)


def run(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=300,
        cwd=PACKAGE.parent,
        env=os.environ | environment,
    )


def packages_loaded_by(code: str) -> set[str]:
    """Top-level names in sys.modules of a fresh process."""
    listing = "import json, sys; print(json.dumps([*{n.partition('.')[0] for n in sys.modules}]))"
    result = run(f"{code}\n{listing}")
    assert result.returncode == 0, result.stderr
    return set(json.loads(result.stdout.splitlines()[-1]))


def test_import_of_the_package_loads_no_heavy_library():
    loaded = packages_loaded_by("import ifs_cad")
    assert loaded.isdisjoint(KERNEL_LIBRARIES | {"numpy", "scipy", "typer", "rich"})


# what modules may find loaded anyway, or this would take minutes
BEFORE_LIGHT = "import importlib.metadata, numpy, typer, wrapt"
BEFORE_OTHERS = f"{BEFORE_LIGHT}, cadquery, rich.progress, scipy.optimize, scipy.spatial, tomlkit"
IMPORT_EACH = """
import json, os, sys
for module in sys.argv[1:]:
    reader, writer = os.pipe()
    if os.fork() == 0:
        try:
            __import__(module)
            said = sorted({name.partition(".")[0] for name in sys.modules})
        except BaseException as error:
            said = repr(error)
        os.write(writer, json.dumps(said).encode())
        os._exit(0)
    os.close(writer)
    with open(reader) as pipe:
        print(pipe.read())
    os.wait()
"""


def loaded_by_each(modules: list[str], after: str) -> dict[str, list[str] | str]:
    """What each module loads in a process of its own, or its error; all fork from one."""
    code = f"{after}\n{IMPORT_EACH}"
    result = subprocess.run(
        [sys.executable, "-c", code, *modules],
        capture_output=True,
        text=True,
        timeout=600,
        cwd=PACKAGE.parent,
        check=True,
    )
    return dict(zip(modules, map(json.loads, result.stdout.splitlines()), strict=True))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes cannot fork here")
@pytest.mark.parametrize("light", [True, False])
def test_modules_import_alone_in_a_process_of_their_own(light):
    modules = [module for module in MODULES if is_light(module) is light]
    found = loaded_by_each(modules, BEFORE_LIGHT if light else BEFORE_OTHERS)
    failed = {module: said for module, said in found.items() if isinstance(said, str)}
    assert failed == {}
    if light:
        for module, loaded in found.items():
            heavy = KERNEL_LIBRARIES if module in MAY_LOAD_SCIPY else KERNEL_LIBRARIES | {"scipy"}
            assert heavy.isdisjoint(loaded), module


def test_every_module_has_a_room():
    assert {room(module) for module in MODULES} <= LEVELS.keys()


@pytest.mark.parametrize("module", MODULES)
def test_module_imports_only_from_rooms_above(module):
    below = [
        f"line {line}: {name}"
        for name, line, _ in imports_of(module)
        if name.startswith("ifs_cad.") and LEVELS[room(name)] > LEVELS[room(module)]
    ]
    assert below == []


@pytest.mark.parametrize("module", MODULES)
def test_module_reaches_no_other_by_the_public_package(module):
    """The package's lazy names lead to every room, so they would hide what is imported."""
    assert [line for name, line, _ in imports_of(module) if name == "ifs_cad"] == []


def test_no_imports_in_a_circle():
    above = {
        module: {name for name, *_ in imports_of(module) if name in MODULES and name != module}
        for module in MODULES
    }
    graphlib.TopologicalSorter(above).prepare()  # raises CycleError, which names the circle


def test_export_formats_import_no_other_format():
    for module in (module for module in MODULES if module.startswith("ifs_cad.export.")):
        names = {name for name, *_ in imports_of(module)}
        assert not any(name.startswith("ifs_cad.export.") for name in names), module


@pytest.mark.parametrize("module", MODULES)
def test_outside_libraries_are_imported_only_in_their_room(module):
    forbidden = set()
    if room(module) not in KERNEL_ROOMS and module not in MAY_IMPORT_THE_KERNEL:
        forbidden |= KERNEL_LIBRARIES
    if module not in MAY_IMPORT_THE_VIEWER:
        forbidden |= VIEWER_LIBRARIES
    if module not in MAY_IMPORT_THE_PAGE:
        forbidden |= PAGE_LIBRARIES
    found = [
        f"line {line}: {name}"
        for name, line, for_types in imports_of(module)
        if name.partition(".")[0] in forbidden and not for_types
    ]
    assert found == []


def test_the_studio_without_its_page_loads_neither_page_nor_kernel():
    names = ", ".join(f"ifs_cad.studio.{name}" for name in STUDIO_WITHOUT_A_PAGE)
    loaded = packages_loaded_by(f"import {names}")
    assert loaded.isdisjoint(PAGE_LIBRARIES | KERNEL_LIBRARIES)


def test_every_public_name_is_found_where_the_type_checker_looks():
    text = SOURCES["ifs_cad"].read_text(encoding="utf-8")
    block = next(node for node in ast.parse(text).body if isinstance(node, ast.If))
    declared = {
        alias.name: node.module.removeprefix("ifs_cad.")
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert declared == ifs_cad._HOMES
    assert sorted(declared) == sorted(ifs_cad.__all__)


def test_every_public_name_resolves():
    result = run("from ifs_cad import *")  # raises for the first name that does not
    assert result.returncode == 0, result.stderr


def test_version_is_that_of_the_project_file():
    project = tomllib.loads((PACKAGE.parent / "pyproject.toml").read_text(encoding="utf-8"))
    assert ifs_cad.__version__ == project["project"]["version"]


def test_public_names_are_listed_before_they_are_loaded():
    result = run("import ifs_cad; print(*dir(ifs_cad))")
    assert set(ifs_cad.__all__) <= set(result.stdout.split())


def test_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="'ifs_cad' has no attribute 'panel_maker'"):
        _ = ifs_cad.panel_maker


@pytest.mark.parametrize(
    "imports",
    [
        "import ifs_cad; import cadquery",
        "import cadquery; import ifs_cad",
        "import ifs_cad.kernel.plugin; import cadquery",
    ],
)
def test_workplane_methods_attach_in_any_order_of_import(imports):
    result = run(f"{imports}; print(callable(cadquery.Workplane.ifsPanels))")
    assert result.stdout.strip() == "True", result.stderr


@pytest.fixture
def without_libgl(tmp_path):
    """Environment in which OpenCascade fails to load as it does in a bare container."""
    message = "libGL.so.1: cannot open shared object file: No such file or directory"
    (tmp_path / "OCP").mkdir()
    (tmp_path / "OCP" / "__init__.py").write_text(f"raise ImportError({message!r})\n")
    return {"PYTHONPATH": str(tmp_path)}


@pytest.mark.parametrize(
    "statement",
    ["import ifs_cad.kernel", "from ifs_cad import to_assembly", "from ifs_cad import export_step"],
)
def test_missing_system_library_is_explained_by_its_package(without_libgl, statement):
    result = run(statement, **without_libgl)
    last_line = result.stderr.splitlines()[-1]
    assert last_line.startswith("ifs_cad.errors.MissingLibraryError: ")
    assert "libGL.so.1 is missing" in last_line
    assert "apt-get install libgl1 libx11-6" in last_line


def test_failed_import_of_cadquery_leaves_the_package_usable(without_libgl):
    code = """
import ifs_cad
try:
    import cadquery
except ImportError as error:
    print(type(error).__name__, error)
print(ifs_cad.Plane((0, 0, 0), (0, 0, 2)).normal)
"""
    result = run(code, **without_libgl)
    assert result.stdout.splitlines() == [
        "ImportError libGL.so.1: cannot open shared object file: No such file or directory",
        "(0.0, 0.0, 1.0)",
    ]
