"""Where a model comes from: a part script, a design file, or a STEP file.

A part script is an ordinary CadQuery script, run through CadQuery's gateway interface (CQGI).
A *parameter* is a literal assigned at the top level of the script: a number, a text, True or
False, or a flat tuple of them. What the script hands to ``show_object`` is what it makes.
"""

from __future__ import annotations

import ast
import contextlib
import io
import sys
import tokenize
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cadquery as cq
from cadquery import cqgi

from ifs_cad import design_file
from ifs_cad.design_record import Design
from ifs_cad.elements.beam import WireFrame
from ifs_cad.elements.panel import Shell
from ifs_cad.elements.vault import Vault
from ifs_cad.errors import IfsCadError, InputError, ScriptError
from ifs_cad.kernel.assembly import to_assembly

YES = {"true", "yes", "on", "1"}
NO = {"false", "no", "off", "0"}


@dataclass(frozen=True)
class Shown:
    """What a script showed.

    Attributes
    ----------
    name : str
        As the script named it; empty when it did not.
    assembly : cadquery.Assembly
        The thing itself, or an assembly around it.
    """

    name: str
    assembly: cq.Assembly

    @property
    def has_solids(self) -> bool:
        """Whether there is anything to make in it."""
        return any(shape.Solids() for shape, *_ in self.assembly)


class _Collector:
    """Takes what a script shows. In CQGI's own all calls share one dict of options."""

    def __init__(self) -> None:
        self.shown: list[tuple[Any, str]] = []

    def show_object(
        self, thing: Any, name: str | None = None, options: Any = None, **_: Any
    ) -> None:
        self.shown.append((thing, str(name or (options or {}).get("name") or "")))


def _ignore(*_: Any, **__: Any) -> None:
    """Stand in for the calls of CQGI that make nothing."""


class _Signs(ast.NodeTransformer):
    """Make literals of negative numbers, which Python parses, and CQGI skips, as expressions."""

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.AST:
        match node:
            case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=int() | float() as value)):
                return ast.copy_location(ast.Constant(-value), node)
        return node


def run_script(path: Path, settings: Mapping[str, str]) -> list[Shown]:
    """Run a part script and return what it showed, in order; a design file shows its shell.

    Parameters
    ----------
    path : Path
    settings : mapping of str to str
        Parameters to change, as text; each is read as the type of the script's own value. Of a
        design file its values, see `design_file.with_settings`.

    Raises
    ------
    InputError
        No such parameter, or not a value for it; the message lists the parameters.
    ScriptError
        The script failed (the message has its line), showed nothing, or something that is not
        a CadQuery shape.
    """
    if path.suffix.lower() == design_file.SUFFIX:
        design = design_file.read_design(path)
        design = design_file.with_settings(design, settings, str(path))
        return [Shown("shell", design_assembly(design))]
    model = _parse(path)
    model.set_param_values(_values(path, model.metadata.parameters, settings))
    collector = _Collector()
    _execute(path, model.ast_tree, collector)
    if not collector.shown:
        raise ScriptError(
            f'{path} showed nothing to make. Call show_object(assembly, name="shell") in it.'
        )
    return [_shown(path, thing, name) for thing, name in collector.shown]


def design_assembly(design: Design) -> cq.Assembly:
    """Return the shell of a saved design as an assembly, with its labels and holes."""
    return to_assembly(
        design.shell(), label=design.label, holes=design.holes, nest=design.nest, name="shell"
    )


def _parse(path: Path) -> cqgi.CQModel:
    try:
        with tokenize.open(path) as file:
            source = file.read()
        # CQGI prints about each assignment that it cannot make a parameter of
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            model = cqgi.CQModel(source)
            finder = cqgi.ConstantAssignmentFinder(model.metadata)
            for node in model.ast_tree.body:
                if isinstance(node, ast.Assign):
                    node.value = _Signs().visit(node.value)
                    finder.visit_Assign(node)
    except OSError as error:
        raise ScriptError(f"The script {path} cannot be read: {error.strerror}.") from error
    except SyntaxError as error:
        raise ScriptError(_located(path, error.lineno, error, error.text, error.msg)) from error
    except ValueError as error:
        raise ScriptError(f"{path} is not a Python script: {error}.") from error
    return model


def _values(
    path: Path, parameters: Mapping[str, cqgi.InputParameter], settings: Mapping[str, str]
) -> dict[str, Any]:
    values = {}
    for name, text in settings.items():
        try:
            values[name] = _value(name, parameters[name].default_value, text)
        except KeyError:
            problem = f"{path} has no parameter {name!r}."
        except ValueError as error:
            problem = str(error)
        else:
            continue
        in_order = sorted(parameters.values(), key=lambda p: getattr(p.ast_node, "lineno", 0))
        listing = "".join(f"\n  {p.name} = {p.default_value!r}" for p in in_order)
        raise InputError(f"{problem} Its parameters are:{listing or ' none.'}")
    return values


def _value(name: str, default: Any, text: str) -> Any:
    """Read a text as the type of a parameter's default."""
    match default:
        case bool():
            if text.lower() in YES | NO:
                return text.lower() in YES
            wanted = "true or false"
        case int() | float():
            with contextlib.suppress(ValueError):
                return int(text) if isinstance(default, int) else float(text)
            with contextlib.suppress(ValueError):
                return float(text)
            wanted = "a number"
        case tuple():
            with contextlib.suppress(ValueError, SyntaxError):
                value = ast.literal_eval(text)
                if isinstance(value, tuple):
                    return value
            wanted = f"values separated by commas, such as {', '.join(map(repr, default))}"
        case _:
            return text
    raise ValueError(f"{name} must be {wanted}, got {text!r}.")


def _execute(path: Path, tree: ast.Module, collector: _Collector) -> None:
    file = str(path.resolve())
    environment = (
        cqgi.EnvironmentBuilder()
        .with_real_builtins()
        .with_cadquery_objects()
        .add_entry("__name__", "__cqgi__")
        .add_entry("__file__", file)
        .add_entry("show_object", collector.show_object)
        .add_entry("debug", _ignore)
        .add_entry("describe_parameter", _ignore)
        .build()
    )
    # as `python script.py` would: modules beside the script can be imported
    sys.path.insert(0, str(Path(file).parent))
    sys.argv = [str(path)]
    # not CQModel.build: with the script's own file name its tracebacks have lines
    try:
        code = compile(tree, file, "exec", dont_inherit=True)
    except SyntaxError as error:
        raise ScriptError(_located(path, error.lineno, error, error.text, error.msg)) from error
    try:
        exec(code, environment)
    except (Exception, SystemExit) as error:
        raise _failure(path, file, error) from error


def _failure(path: Path, file: str, error: BaseException) -> ScriptError:
    """Describe an exception by the last line of the script itself that led to it."""
    frames = traceback.extract_tb(error.__traceback__)
    frame = [frame for frame in frames if frame.filename == file][-1]
    addresses = error.addresses if isinstance(error, IfsCadError) else ()
    message = _located(path, frame.lineno, error, frame.line, str(error))
    return ScriptError(message, addresses=addresses)


def _located(
    path: Path, line: int | None, error: BaseException, text: str | None, said: str
) -> str:
    kind = type(error).__name__
    place = f"{path}, line {line}" if line else f"{path}"
    what = f"{place}: {kind}" + (f": {said}" if said else "")
    return f"{what}\n    {text.strip()}" if text else what


def _shown(path: Path, thing: Any, name: str) -> Shown:
    match thing:
        case cq.Assembly():
            assembly = thing
        case Shell() | Vault() | WireFrame():
            assembly = to_assembly(thing)
        case cq.Workplane() | cq.Shape():
            assembly = cq.Assembly(thing, name=name or path.stem)
        case _:
            raise ScriptError(
                f"{path} called show_object with something of type {type(thing).__name__}; it "
                "takes a cadquery Assembly, Workplane or Shape, or a shell."
            )
    return Shown(name, assembly)


def together(shown: Sequence[Shown]) -> cq.Assembly:
    """Return everything that was shown as one assembly."""
    if len(shown) == 1:
        return shown[0].assembly
    whole = cq.Assembly()
    for number, thing in enumerate(shown, 1):
        whole.add(thing.assembly, name=str(number))
    return whole


def read_step(path: Path) -> cq.Assembly:
    """Read a STEP file, with its names and colours.

    Raises
    ------
    InputError
        There is no such file, or it is not STEP.
    """
    if not path.is_file():
        raise InputError(f"There is no file {path}.")
    try:
        return cq.Assembly.importStep(str(path))
    except ValueError:  # also for a file with a single part, which is not an assembly
        try:
            return cq.Assembly(cq.importers.importStep(str(path)))
        except ValueError as error:
            raise InputError(f"{path} cannot be read as STEP.") from error
