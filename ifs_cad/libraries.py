"""Missing libraries explained in a sentence.

Two kinds can be missing: a Python package (an optional extra was not installed) and a system
library that a wheel links but does not carry (OpenCascade links libGL and libX11, which a bare
Linux container lacks). Python reports the second with the words of the dynamic loader, which
name a file and no package; here they become a `MissingLibraryError` that says what to install.
"""

from __future__ import annotations

import re
from importlib import import_module
from types import ModuleType

from ifs_cad.errors import MissingLibraryError

_LOADER_MESSAGE = re.compile(r"(?P<file>(?P<library>lib[\w+.-]+?)\.so[\d.]*): cannot open shared")

# Library -> packages of Debian and Ubuntu, packages of Fedora. libGL and libX11 are linked by
# the same wheel, so whoever lacks one is told of both.
_KERNEL_PACKAGES = ("libgl1 libx11-6", "mesa-libGL libX11")
_PACKAGES = {
    "libGL": _KERNEL_PACKAGES,
    "libX11": _KERNEL_PACKAGES,
    "libEGL": ("libegl1 libegl-mesa0 libgl1-mesa-dri", "mesa-libEGL mesa-dri-drivers"),
}


def explain_import_error(error: ImportError) -> MissingLibraryError | None:
    """Translate the loader's message about a missing system library.

    Parameters
    ----------
    error : ImportError
        What an import raised.

    Returns
    -------
    MissingLibraryError or None
        Names the library and the packages that hold it; None when `error` is about something
        else.
    """
    found = _LOADER_MESSAGE.search(str(error))
    if found is None:
        return None
    packages = _PACKAGES.get(found["library"])
    if packages is None:
        remedy = "Install the package of your system that holds it."
    else:
        debian, fedora = packages
        remedy = (
            f"On Debian or Ubuntu: apt-get install {debian}. On Fedora: dnf install {fedora}. "
            "On Windows and macOS nothing has to be installed."
        )
    return MissingLibraryError(
        f"The system library {found['file']} is missing. {remedy}", library=found["file"]
    )


def load(module: str) -> ModuleType:
    """Import a module by its full name, explaining a missing system library.

    Raises
    ------
    MissingLibraryError
        A system library is missing; the message names its packages.
    ImportError
        Any other reason, as raised.
    """
    try:
        return import_module(module)
    except ImportError as error:
        explained = explain_import_error(error)
        if explained is None:
            raise
        raise explained from error


def require(module: str, purpose: str, extra: str | None = None) -> ModuleType:
    """Import a library that may not be installed.

    Parameters
    ----------
    module : str
        Full name of a module of another distribution, `"ocp_viewer.server"`.
    purpose : str
        What it is needed for, to complete "... is needed for".
    extra : str, optional
        The extra of ifs-cad that installs it; without one it comes with ifs-cad itself.

    Raises
    ------
    MissingLibraryError
        The package, or a system library that it links, is not installed; the message says what
        to install.
    """
    package = module.partition(".")[0]
    try:
        return load(module)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] != package:
            raise
        distribution = f"'ifs-cad[{extra}]'" if extra else "ifs-cad"
        raise MissingLibraryError(
            f"The Python package {package} is needed for {purpose}: pip install {distribution}.",
            library=package,
        ) from error
