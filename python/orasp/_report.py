"""Report pages and pictures."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from orasp import _orasp
from orasp._content import whole
from orasp._problem import Problem, ProblemLike, load, warn
from orasp._questions import Sample, explain, sample
from orasp._solve import PlanLike, ProgressCallback, Result, Stopper, plan_text, run_of, solve


class Report:
    """A page about a problem and its plans: one HTML file that needs nothing else. A notebook shows it."""

    def __init__(self, html: str) -> None:
        self.html = html

    def save(self, file: Union[str, os.PathLike[str]]) -> Path:
        """Writes the page, and returns its path."""
        path = Path(file)
        path.write_text(self.html, encoding="utf-8")
        return path

    def _repr_html_(self) -> str:
        page = self.html.replace("&", "&amp;").replace('"', "&quot;")
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 700px; border: 0"></iframe>'

    def __repr__(self) -> str:
        return f"<orasp.Report: {(len(self.html.encode()) + 999) // 1000} kB>"


def _effort(result: Result) -> str:
    counts = result.statistics
    names = ("states", "actions", "expanded", "generated", "reopened", "pruned")
    known = [f"{counts[name]:,} {name}" for name in names if counts[name] > 0]
    return ", ".join([*known, f"{result.seconds:.3g} s"])


def report(
    problem: ProblemLike,
    *plans: PlanLike,
    title: Optional[str] = None,
    sample_count: Optional[int] = None,
    seed: int = 1,
    time_limit: float = 10,
    memory_limit: Optional[int] = None,
    threads: Optional[int] = None,
    progress: Optional[ProgressCallback] = None,
    stop: Optional[Stopper] = None,
    **changes: Any,
) -> Report:
    """A page about a problem and its plans; without a plan it is solved first.

    What is proved comes from a plan that is a :class:`Result` with status "optimal", else from "auto" within
    ``time_limit`` seconds. ``sample_count`` adds what so many random orders earn. Where the problem was read
    from a file and names the shapes of its parts, the page shows them.

    >>> import orasp
    >>> page = orasp.report("4piece")
    >>> page.html[:15]
    '<!doctype html>'
    """
    given = load(problem).edited(**changes)
    best = next((plan for plan in plans if isinstance(plan, Result) and plan.status == "optimal"), None)
    if best is None or best.problem != given:
        best = solve(
            given,
            time_limit=time_limit,
            memory_limit=memory_limit,
            threads=threads,
            progress=progress,
            stop=stop,
        )
    shown = [_shown(plan) for plan in plans or ([best] if best.has_plan else [])]
    conflict: list[str] = []
    if best.status == "infeasible" and not given._engine().of_fleet:
        conflict = [f"{item.where}: {item.message}" for item in explain(given, time_limit=time_limit).conflict]
    drawn: Optional[Sample] = None
    if sample_count is not None:
        drawn = sample(given, whole("sample_count", sample_count, 1), seed=seed, time_limit=time_limit)
    shapes, fault = _shapes(given)
    return Report(
        _orasp.report_page(
            best=best._outcome,
            plans=shown,
            title=title if title is not None else given.name,
            effort=_effort(best),
            conflict=conflict,
            sample_origin=f"Rewards of {0 if drawn is None else len(drawn.rewards):,} random legal sequences, seed {seed}.",
            sample=[] if drawn is None else drawn.rewards.tolist(),
            shapes=shapes,
            shapes_fault=fault,
        )
    )


def _shown(plan: PlanLike) -> tuple[str, str, str, Optional[float], list[str]]:
    """Label, origin, text, what is expected of it, and notes."""
    text = plan_text(plan)
    if isinstance(plan, Result):
        expectation = plan.expectation
        if expectation is None:
            return plan.method, f"Found by {plan.method}.", text, None, []
        note = (
            "The steps are the most likely sequence, where no failure changes the state; "
            f"{expectation.attempts:.6g} attempts are expected."
        )
        return plan.method, f"Found by {plan.method}.", text, plan.reward, [note]
    if isinstance(plan, (str, os.PathLike)):
        name = Path(plan).name
        return name, f"Read from {name}.", text, None, []
    return "plan", "Given as a list.", text, None, []


def _shapes(problem: Problem) -> tuple[Optional[bytes], str]:
    """The bytes of the file of shapes that a problem names, or why there are none."""
    name = problem._engine().geometry
    if name is None:
        return None, ""
    path = Path(problem._folder or ".") / name
    try:
        if not path.is_file() and path.exists():
            raise OSError(0, "it is no file")
        return path.read_bytes(), ""
    except OSError as error:
        warn(f'geometry: cannot read "{path}": {error.strerror}; the report does without')
        return None, f'The true parts are not shown: "{path.name}" cannot be read.'


def distribution_svg(rewards: npt.ArrayLike, **marks: float) -> str:
    """The distribution of rewards as a violin, with marks by name (``optimum=-0.99``), as an SVG drawn by
    gnuplot. Raises InputError where that is missing."""
    numbers = np.asarray(rewards, dtype=np.float64).ravel().tolist()
    if not numbers:
        raise _orasp.InputError("there are no rewards to draw")
    return _orasp.distribution_svg(numbers, [(name, float(value)) for name, value in marks.items()])


def figures(
    problem: ProblemLike,
    folder: Union[str, os.PathLike[str]],
    *,
    plan: Optional[Result] = None,
    sample: Optional[Sample] = None,
    time_limit: Optional[float] = None,
    memory_limit: Optional[int] = None,
) -> list[tuple[str, str]]:
    """Figures fit for a paper, as SVG files in a folder: structure.svg; of a plan steps.svg and growth.svg;
    where they are small enough state-graph.svg and tree.svg; of a sample distribution.svg. Returns the name
    and a caption of each. Raises InputError where Graphviz or gnuplot is missing, and where steps take several
    connections."""
    given = load(problem)
    if given._engine().of_fleet or given.action == "part":
        raise _orasp.InputError("figures are drawn of one robot and of steps that take one connection each")
    return _orasp.write_figures(
        given._engine(),
        [] if plan is None else plan.sequence.tolist(),
        [] if sample is None else sample.rewards.tolist(),
        [] if plan is None else [(plan.method, plan.reward)],
        os.fspath(folder),
        run_of(time_limit, memory_limit, None, None, None),
    )


def tree_svg(problem: ProblemLike, plan: Optional[Result] = None) -> str:
    """The tree H~, a node for every order in which connections can be handled, as an SVG drawn by Graphviz;
    a plan in green. Raises InputError above 400 nodes."""
    given = load(problem)
    return _orasp.tree_svg(given._engine(), [] if plan is None else plan.sequence.tolist())
