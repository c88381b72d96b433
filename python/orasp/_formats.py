"""Problems and plans in the formats of other programs."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple, Optional, Union

from orasp import _orasp
from orasp._problem import Problem, ProblemLike, load, warn
from orasp._solve import PlanLike, plan_text, solve


class Format(NamedTuple):
    """A format of files: its endings, what it is, and what it cannot carry. ``reads`` and ``writes`` say
    which ways there are; with ``of_plan`` what is written is a plan."""

    name: str
    endings: tuple[str, ...]
    summary: str
    limits: str
    reads: bool
    writes: bool
    of_plan: bool


def formats() -> list[Format]:
    """All formats that problems are read from, or that problems or plans are written in.

    >>> import orasp
    >>> "graphml" in [format.name for format in orasp.formats()]
    True
    """
    return [
        Format(name, tuple(endings.split()), summary, limits, reads, writes, of_plan)
        for name, endings, summary, limits, reads, writes, of_plan in _orasp.formats()
    ]


def read_format(file: Union[str, os.PathLike[str]], format: Optional[str] = None) -> Problem:
    """The problem of a file in the format of another program: ``format``, or what its ending and its
    content tell. What is left out is an OraspWarning each. Raises InputError, which names the file."""
    name = os.fspath(file)
    try:
        text = Path(name).read_bytes()
    except OSError as error:
        raise _orasp.InputError(f'cannot read "{name}": {error.strerror}') from None
    try:
        made, _, notes = _orasp.read_format(text, name, format)
    except _orasp.InputError as error:
        raise _orasp.InputError(f"{name}: {error}") from None
    for note in notes:
        warn(note)
    return Problem._of(made, None)


def format_text(problem: ProblemLike, format: str, *, plan: Optional[PlanLike] = None) -> str:
    """A problem in the format of another program, or a plan for it where that is what the format holds:
    ``plan``, or else what "auto" finds. What is left out is an OraspWarning each. Raises InputError where the
    format cannot say what the problem says, or the plan breaks a rule.

    >>> import orasp
    >>> orasp.format_text("4piece", "graphml")[:5]
    '<?xml'
    """
    given = load(problem)
    chosen = next((known for known in formats() if known.name == format), None)
    if plan is None and chosen is not None and chosen.of_plan:
        plan = solve(given)
        if not plan.has_plan:
            raise _orasp.InputError("no plan was found, so there is nothing to write")
    text, notes = _orasp.write_format(given._engine(), format, None if plan is None else plan_text(plan))
    for note in notes:
        warn(note)
    return text


def write_format(
    problem: ProblemLike,
    file: Union[str, os.PathLike[str]],
    *,
    format: Optional[str] = None,
    plan: Optional[PlanLike] = None,
) -> None:
    """:func:`format_text` into a file, whose ending tells the format unless ``format`` does."""
    name = os.fspath(file)
    text = format_text(problem, format if format is not None else _orasp.format_of_output(name), plan=plan)
    Path(name).write_text(text, encoding="utf-8", newline="")
