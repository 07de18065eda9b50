"""Missing libraries are explained: system libraries by package, Python packages by extra."""

import pytest

from ifs_cad.errors import MissingLibraryError
from ifs_cad.libraries import explain_import_error, load, require

LOADER = "{}: cannot open shared object file: No such file or directory"


@pytest.mark.parametrize(
    ("file", "debian"),
    [
        ("libGL.so.1", "apt-get install libgl1 libx11-6."),
        ("libX11.so.6", "apt-get install libgl1 libx11-6."),
        ("libEGL.so.1", "apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri."),
    ],
)
def test_explanation_of_a_known_library_names_its_packages(file, debian):
    explained = explain_import_error(ImportError(LOADER.format(file)))
    assert str(explained).startswith(f"The system library {file} is missing. ")
    assert debian in str(explained)
    assert explained.values == {"library": file}


def test_explanation_of_an_unknown_library_names_the_file():
    explained = explain_import_error(ImportError(LOADER.format("libwood-2.0.so.7.1")))
    assert "libwood-2.0.so.7.1" in str(explained)


def test_other_import_errors_are_not_explained():
    assert explain_import_error(ImportError("cannot import name 'saw' from 'wood'")) is None


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package `ifs_fake` whose modules fail to import in three ways."""
    monkeypatch.syspath_prepend(tmp_path)
    folder = tmp_path / "ifs_fake"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "loader.py").write_text(f"raise ImportError({LOADER.format('libGL.so.1')!r})\n")
    (folder / "inner.py").write_text("import ifs_fake_dependency\n")
    (folder / "broken.py").write_text("raise ImportError('broken')\n")
    return "ifs_fake"


def test_load_returns_the_module_itself(package):
    assert load(f"{package}.__init__").__package__ == package


def test_load_keeps_the_loader_error_as_cause(package):
    with pytest.raises(MissingLibraryError, match=r"libGL\.so\.1 is missing") as caught:
        load(f"{package}.loader")
    assert str(caught.value.__cause__) == LOADER.format("libGL.so.1")


def test_load_passes_other_import_errors_on(package):
    with pytest.raises(ImportError, match=r"^broken$") as caught:
        load(f"{package}.broken")
    assert not isinstance(caught.value, MissingLibraryError)


def test_require_names_the_extra_of_a_package_that_is_not_installed():
    with pytest.raises(MissingLibraryError) as caught:
        require("ifs_absent.server", "the preview", "view")
    assert str(caught.value) == (
        "The Python package ifs_absent is needed for the preview: pip install 'ifs-cad[view]'."
    )


def test_require_without_extra_names_the_distribution():
    with pytest.raises(MissingLibraryError, match=r"for exact solids: pip install ifs-cad\.$"):
        require("ifs_absent", "exact solids")


def test_require_does_not_blame_the_package_for_what_it_lacks(package):
    with pytest.raises(ModuleNotFoundError, match="ifs_fake_dependency"):
        require(f"{package}.inner", "a test", "view")
