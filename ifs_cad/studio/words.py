"""What the page says about a design, as HTML."""

from __future__ import annotations

from html import escape

from ifs_cad.studio.evaluation import Evaluation, Problem
from ifs_cad.studio.look import DOUBTFUL, WRONG, css

GOOD, GREY = "#3c7d4f", "#8a8178"

PADDING = "0 0.7em 0.4em"
NAME_WIDTH = 16  # of the first column of reports

__all__ = ["problems_html", "report_html", "small_html", "status_html", "table_html"]


def status_html(evaluation: Evaluation, note: str = "") -> str:
    """Return one line: how many panels, and whether they can be built.

    Parameters
    ----------
    evaluation : Evaluation
    note : str, optional
        What else there is to say, such as why the last change was refused.
    """
    rows, columns = evaluation.shape
    errors = sum(problem.severity == "error" for problem in evaluation.problems)
    warnings = len(evaluation.problems) - errors
    said = [(f"{_many(errors, 'thing')} in the way", css(WRONG))] if errors else []
    said += [(_many(warnings, "warning"), css(DOUBTFUL))] if warnings else []
    if not errors and evaluation.shell is not None:
        said.insert(0, ("can be built", GOOD))
    words = " · ".join(f'<b style="color:{colour}">{text}</b>' for text, colour in said)
    count = f"{rows} x {columns} = {rows * columns:,} panels" if rows else "no surface"
    line = f"{count}{' · ' if words else ''}{words}"
    refused = f'<br><span style="color:{css(WRONG)}">{escape(note)}</span>' if note else ""
    return f'<div style="font-size:0.85em;padding:{PADDING}">{line}{refused}</div>'


def problems_html(problems: tuple[Problem, ...]) -> str:
    """Return every problem with its message; those that keep it from being built come first."""
    order = sorted(problems, key=lambda problem: problem.severity != "error")
    return "".join(_problem(problem) for problem in order)


def report_html(evaluation: Evaluation) -> str:
    """Return problems and numbers."""
    wrong = problems_html(evaluation.problems)
    if evaluation.report is None:
        numbers = "" if wrong else small_html("Numbers appear when the panels are made.")
    else:
        numbers = table_html(str(evaluation.report))
    return f'<div style="padding-top:0.4em">{wrong}{numbers}</div>'


def table_html(report: str) -> str:
    """Return a report, whose lines are a name and a value in columns, as a table."""
    rows = []
    for line in report.splitlines():
        name, value = escape(line[:NAME_WIDTH].strip()), escape(line[NAME_WIDTH:].strip())
        colour = css(DOUBTFUL) if name == "warning" else GREY
        rows.append(
            f'<tr><td style="color:{colour};padding-right:0.8em;vertical-align:top;'
            f'white-space:nowrap">{name}</td><td>{value}</td></tr>'
        )
    return (
        f'<div style="padding:{PADDING}"><table style="font-size:0.82em;'
        f'border-spacing:0 0.15em">{"".join(rows)}</table></div>'
    )


def small_html(text: str) -> str:
    """Return a remark."""
    return f'<div style="font-size:0.82em;color:{GREY};padding:{PADDING}">{escape(text)}</div>'


def _problem(problem: Problem) -> str:
    colour = css(WRONG if problem.severity == "error" else DOUBTFUL)
    return (
        f'<div style="border-left:4px solid {colour};background:{colour}14;font-size:0.85em;'
        f'padding:0.35em 0.6em;margin:0 0.7em 0.4em;overflow-wrap:anywhere">'
        f"{escape(problem.message)}</div>"
    )


def _many(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"
