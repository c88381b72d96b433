"""Questions beside a plan: evaluate, explain, sample, simulate, compare."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from orasp import _orasp
from orasp._content import whole
from orasp._problem import Problem, ProblemLike, load
from orasp._reward import ObjectiveLike
from orasp._solve import (
    Method,
    PlanLike,
    ProgressCallback,
    Result,
    Stopper,
    methods,
    plan_text,
    run_of,
    solve,
    warn_of_another_problem,
)


class Violation(NamedTuple):
    """What a step breaks: ``step`` is counted from 1; ``connection`` is its id as given; ``constraint`` the
    name that a problem file uses."""

    step: int
    connection: str
    constraint: str
    message: str


@dataclass(frozen=True)
class Evaluation:
    """A plan replayed: ``reward`` is that of the ``steps`` that could be made; ``travel`` (m^2) is that of
    several robots."""

    valid: bool
    reward: float
    steps: int
    violations: tuple[Violation, ...]
    travel: Optional[float] = None

    def to_dict(self) -> dict[str, Any]:
        """As ``orasp evaluate --json`` prints it."""
        found: dict[str, Any] = {"valid": self.valid, "reward": self.reward, "steps": self.steps}
        if self.travel is not None:
            found |= {"makespan": self.steps, "travel": self.travel}
        return found | {"violations": [violation._asdict() for violation in self.violations]}


def evaluate(problem: ProblemLike, plan: PlanLike, **changes: Any) -> Evaluation:
    """Replays a plan: its reward, and every rule that it breaks.

    ``plan`` is a :class:`Result`, a plan file (a name), what it says (a dict), or connection ids in the
    problem's direction (lists of them where steps take several). ``changes`` are those of
    :meth:`Problem.edited`. Raises InputError where the plan is none.

    >>> import orasp
    >>> orasp.evaluate("4piece", ["1-2", "3-4", "2-3", "1-4"]).reward
    0.557
    >>> orasp.evaluate("4piece", ["1-2", "1-2"]).violations[0].message
    '"1-2" was removed before'
    """
    given = load(problem).edited(**changes)
    valid, reward, steps, travel, faults, differs = _orasp.evaluate(given._engine(), plan_text(plan))
    warn_of_another_problem(differs)
    return Evaluation(valid, reward, steps, tuple(Violation(*fault) for fault in faults), travel)


class Conflict(NamedTuple):
    """A constraint that takes part in a conflict: ``where`` is its place in the problem file."""

    constraint: str
    where: str
    message: str


@dataclass(frozen=True)
class Explanation:
    """Why there is no plan: ``status`` is "feasible" (there is one), "infeasible" (then ``conflict`` lists
    constraints that together allow none, and if ``minimal`` none of them can be left out) or "unknown"."""

    status: str
    conflict: tuple[Conflict, ...]
    minimal: bool
    tests: int
    stopped: Optional[str]

    def to_dict(self) -> dict[str, Any]:
        """As ``orasp explain --json`` prints it."""
        found: dict[str, Any] = {"status": self.status, "conflict": [item._asdict() for item in self.conflict]}
        if self.status == "infeasible":
            found["minimal"] = self.minimal
        found["tests"] = self.tests
        if self.stopped is not None:
            found["stopped"] = self.stopped
        return found


@dataclass(frozen=True)
class ConnectionExplanation:
    """Why a connection cannot be handled, and what would have to change: a dict for each reason, with the
    keys of ``orasp explain --connection --json``. ``later`` is "legal" (after the steps of ``after``),
    "never" or "unknown"; ``plan_exists`` is known where the connection is legal; ``step`` is that at which it
    was asked for, from 1."""

    connection: str
    legal: bool
    conflict: tuple[Conflict, ...]
    changes: tuple[dict[str, Any], ...]
    plan_exists: Optional[bool]
    later: str
    after: tuple[str, ...]
    fewest: bool
    step: int

    def to_dict(self) -> dict[str, Any]:
        """As ``orasp explain --connection --json`` prints it."""
        found: dict[str, Any] = {
            "status": "legal" if self.legal else "illegal",
            "conflict": [item._asdict() for item in self.conflict],
            "connection": self.connection,
            "step": self.step,
        }
        if self.legal:
            return found | {"plan_exists": self.plan_exists}
        legal_later = {"legal": True, "never": False}.get(self.later)
        found |= {
            "changes": list(self.changes),
            "legal_later": legal_later,
            "legal_after": list(self.after) if legal_later else None,
        }
        return found | {"fewest": self.fewest} if legal_later else found


def explain(
    problem: ProblemLike,
    *,
    time_limit: Optional[float] = None,
    memory_limit: Optional[int] = None,
    threads: Optional[int] = None,
    progress: Optional[ProgressCallback] = None,
    stop: Optional[Stopper] = None,
    **changes: Any,
) -> Explanation:
    """Says why there is no plan: a smallest set of constraints that conflict.

    >>> import orasp
    >>> orasp.explain("4brick", max_moved_parts=0).conflict[0].where
    'limits.max_moved_parts'
    """
    given = load(problem).edited(**changes)
    status, conflict, minimal, tests, stopped = _orasp.explain(
        given._engine(), run_of(time_limit, memory_limit, threads, progress, stop)
    )
    return Explanation(status, tuple(Conflict(*item) for item in conflict), minimal, tests, stopped)


def explain_connection(
    problem: ProblemLike,
    connection: str,
    *,
    done: Sequence[str] = (),
    time_limit: Optional[float] = None,
    memory_limit: Optional[int] = None,
    threads: Optional[int] = None,
    progress: Optional[ProgressCallback] = None,
    stop: Optional[Stopper] = None,
    **changes: Any,
) -> ConnectionExplanation:
    """Says why a connection cannot be handled next, after the connections ``done``, and what would have to
    change.

    >>> import orasp
    >>> orasp.explain_connection("hubble", "2-3").legal
    False
    """
    given = load(problem).edited(**changes)
    legal, conflict, changes_text, plan_exists, later, after, fewest = _orasp.explain_connection(
        given._engine(), connection, list(done), run_of(time_limit, memory_limit, threads, progress, stop)
    )
    return ConnectionExplanation(
        connection,
        legal,
        tuple(Conflict(*item) for item in conflict),
        tuple(json.loads(changes_text)),
        plan_exists,
        later,
        tuple(after),
        fewest,
        len(done) + 1,
    )


class Statistics(NamedTuple):
    """What is known of a list of numbers: ``deviation`` is that of a sample (n - 1); ``percentiles`` are 5,
    25, 50, 75 and 95."""

    mean: float
    deviation: float
    least: float
    percentiles: tuple[float, ...]
    greatest: float


def _statistics(figures: Any) -> Optional[Statistics]:
    if figures is None:
        return None
    mean, deviation, least, percentiles, greatest = figures
    return Statistics(mean, deviation, least, tuple(percentiles), greatest)


@dataclass(frozen=True)
class Sample:
    """Random legal sequences: what they earn, shape ``[drawn]``, and, if asked for, the connections of each.
    ``infeasible``: it is proved that there is none."""

    rewards: npt.NDArray[np.float64]
    seed: int
    statistics: Optional[Statistics]
    sequences: Optional[list[npt.NDArray[np.int64]]]
    infeasible: bool
    stopped: Optional[str]
    notes: list[str]

    def to_dict(self) -> dict[str, Any]:
        """As ``orasp sample --json`` prints it, without the sequences."""
        known = self.statistics
        return {
            "n": len(self.rewards),
            "seed": self.seed,
            "mean": known and known.mean,
            "deviation": known and known.deviation,
            "min": known and known.least,
            "quartiles": list(known.percentiles[1:4]) if known else [None] * 3,
            "max": known and known.greatest,
            "rewards": self.rewards.tolist(),
        }


def sample(
    problem: ProblemLike,
    n: int = 100,
    *,
    seed: int = 1,
    sequences: bool = False,
    time_limit: Optional[float] = None,
    memory_limit: Optional[int] = None,
    threads: Optional[int] = None,
    progress: Optional[ProgressCallback] = None,
    stop: Optional[Stopper] = None,
    **changes: Any,
) -> Sample:
    """Draws ``n`` random legal sequences, every legal action of a state as likely as any other.

    >>> import orasp
    >>> orasp.sample("4piece", 3, seed=7).rewards
    array([0.545, 0.545, 0.545])
    """
    given = load(problem).edited(**changes)
    seed = whole("seed", seed)
    rewards, figures, drawn, infeasible, stopped, notes = _orasp.sample(
        given._engine(), whole("n", n, 1), seed, sequences, run_of(time_limit, memory_limit, threads, progress, stop)
    )
    return Sample(rewards, seed, _statistics(figures), drawn, infeasible, stopped, notes)


@dataclass(frozen=True)
class Simulation:
    """Random runs of a plan or a policy where attempts may fail: what each earned, and the attempts that it
    made, shapes ``[runs]``. ``expected`` and ``expected_attempts`` are computed, not measured. ``aborted``
    runs were ended by a failure; ``replanned``: how often the plan could not go on."""

    rewards: npt.NDArray[np.float64]
    attempts: npt.NDArray[np.int64]
    seed: int
    statistics: Optional[Statistics]
    expected: Optional[float]
    expected_attempts: Optional[float]
    aborted: int
    replanned: int
    infeasible: bool
    stopped: Optional[str]
    notes: list[str]

    def to_dict(self) -> dict[str, Any]:
        """As ``orasp simulate --json`` prints it."""
        known = self.statistics
        runs = len(self.rewards)
        names = ("5", "25", "50", "75", "95")
        return {
            "n": runs,
            "seed": self.seed,
            "expected": self.expected,
            "mean": known and known.mean,
            "deviation": known and known.deviation,
            "standard_error": known and known.deviation / float(np.sqrt(runs)),
            "min": known and known.least,
            "percentiles": dict(zip(names, known.percentiles if known else [None] * 5)),
            "max": known and known.greatest,
            "attempts": {
                "mean": float(self.attempts.mean()) if runs else 0.0,
                "max": int(self.attempts.max()) if runs else None,
            },
            "aborted": self.aborted,
            "replanned": self.replanned,
        }


def simulate(
    problem: ProblemLike,
    n: int = 10_000,
    *,
    plan: Optional[PlanLike] = None,
    policy: Optional[Union[str, Result]] = None,
    seed: int = 1,
    time_limit: Optional[float] = None,
    memory_limit: Optional[int] = None,
    progress: Optional[ProgressCallback] = None,
    stop: Optional[Stopper] = None,
    **changes: Any,
) -> Simulation:
    """Executes a plan or a policy ``n`` times with random failures.

    ``plan`` is followed, and replanned where its next connection is not legal; ``policy`` is a Result for
    attempts that may fail, or the text of its file; without either an optimal policy is solved first. Raises
    InputError where both are given, or the plan is not legal.

    >>> import orasp
    >>> p = orasp.Problem(objective="time")
    >>> _ = p.add_part("lid"), p.add_part("box"), p.connect("lid", "box", success=0.5)
    >>> orasp.simulate(p, 1000).expected_attempts
    2.0
    """
    if plan is not None and policy is not None:
        raise _orasp.InputError("only one of plan and policy can be given")
    given = load(problem).edited(**changes)
    seed = whole("seed", seed)
    text = policy.state_policy if isinstance(policy, Result) else policy
    rewards, attempts, figures, expected, expected_attempts, aborted, replanned, infeasible, stopped, notes = (
        _orasp.simulate(
            given._engine(),
            None if plan is None else plan_text(plan),
            text,
            whole("n", n, 1),
            seed,
            run_of(time_limit, memory_limit, None, progress, stop),
        )
    )
    return Simulation(
        rewards,
        attempts,
        seed,
        _statistics(figures),
        expected,
        expected_attempts,
        aborted,
        replanned,
        infeasible,
        stopped,
        notes,
    )


@dataclass(frozen=True)
class Comparison:
    """One method on one problem. Without a ``result`` the method refused it, and ``message`` says why."""

    problem: str
    method: str
    result: Optional[Result]
    message: str

    @property
    def status(self) -> str:
        return "refused" if self.result is None else self.result.status

    @property
    def reward(self) -> Optional[float]:
        return self.result.reward if self.result is not None and self.result.has_plan else None

    @property
    def bound(self) -> Optional[float]:
        return None if self.result is None else self.result.bound

    @property
    def seconds(self) -> float:
        return 0.0 if self.result is None else self.result.seconds

    def to_dict(self) -> dict[str, Any]:
        """A row as ``orasp compare --json`` prints it."""
        names = ("states", "actions", "expanded", "generated", "pruned")
        counts = {name: 0 if self.result is None else self.result.statistics[name] for name in names}
        row: dict[str, Any] = {
            "problem": self.problem,
            "method": self.method,
            "status": self.status,
            "reward": self.reward,
            "bound": self.bound,
            "seconds": self.seconds,
            **counts,
            "message": self.message,
        }
        if self.result is not None and self.result.makespan is not None:
            row |= {"makespan": self.result.makespan, "travel": self.result.travel}
        return row


def _methods_for(problem: Problem) -> list[Method]:
    """Those that are compared where none are named: every one that proves something, or all for fleets."""
    of_fleet = problem._engine().of_fleet
    chosen = [method for method in methods() if method.role not in ("chooser", "baseline")]
    if of_fleet:
        return [method for method in chosen if method.fleets]
    return [method for method in chosen if (method.exact or method.bounds) and method.one_robot]


def compare(
    problems: Union[ProblemLike, Iterable[ProblemLike]],
    methods: Optional[Sequence[str]] = None,
    *,
    seed: int = 1,
    steps: Optional[int] = None,
    time_limit: Optional[float] = None,
    memory_limit: Optional[int] = None,
    threads: Optional[int] = None,
    progress: Optional[ProgressCallback] = None,
    stop: Optional[Stopper] = None,
    **changes: Any,
) -> list[Comparison]:
    """Runs several methods on several problems, one after the other, each within the limits.

    Without ``methods``: every one with a proof that accepts the problem, and for several robots every one
    for them. Ctrl-C ends the comparison with the rows so far.

    >>> import orasp
    >>> [(row.method, row.status) for row in orasp.compare("2x3", ["greedy", "dijkstra"])]
    [('greedy', 'feasible'), ('dijkstra', 'optimal')]
    """
    if isinstance(problems, (str, Problem)) or not isinstance(problems, Iterable) or isinstance(problems, dict):
        problems = [problems]
    rows: list[Comparison] = []
    for given in problems:
        name = given if isinstance(given, str) else load(given).name
        problem = load(given).edited(**changes)
        refused: list[Comparison] = []
        before = len(rows)
        for method in methods if methods is not None else [method.name for method in _methods_for(problem)]:
            try:
                result = solve(
                    problem,
                    method,
                    seed=seed,
                    steps=steps,
                    time_limit=time_limit,
                    memory_limit=memory_limit,
                    threads=threads,
                    progress=progress,
                    stop=stop,
                )
            except _orasp.InputError as error:
                row = Comparison(name, method, None, str(error))
                (rows if methods is not None else refused).append(row)
                continue
            sentences = result.notes
            if result.stopped is not None:
                ended = "interrupted" if result.stopped == "interrupted" else f"stopped by the {result.stopped}"
                sentences = [ended, *sentences]
            rows.append(Comparison(name, method, result, "; ".join(sentences)))
            if result.stopped == "interrupted":
                return rows
        if len(rows) == before:
            rows.extend(refused)
    return rows
