"""Plans: solving, and what comes of it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Optional, Protocol, Union

import numpy as np
import numpy.typing as npt

from orasp import _orasp
from orasp._content import OptionValue, json_text, option_texts, real, whole
from orasp._problem import Problem, ProblemLike, load, warn
from orasp._reward import ObjectiveLike

if TYPE_CHECKING:
    from orasp._certificates import Certificate
    from orasp._learning import GeneralPolicy, Policy

_LARGEST_FILE = 256 << 20


class Progress(NamedTuple):
    """What a method tells while it works.

    ``done`` and ``total`` are in units of the phase ("building H", "sweep", "search"), ``total`` is 0 where
    it is not known; ``states`` are held; ``best`` is the reward of the best plan so far, -inf before one.
    """

    phase: str
    done: int
    total: int
    states: int
    best: float


#: Called some 20 times a second with a Progress; what it raises stops the work and comes out.
ProgressCallback = Callable[[Progress], object]


class Stopper(Protocol):
    """What ``stop=`` takes: anything with ``is_set()``, such as ``threading.Event``. Once that is true the
    work ends as after Ctrl-C."""

    def is_set(self) -> bool:
        """Whether to stop."""


def run_of(
    time_limit: Optional[float],
    memory_limit: Optional[int],
    threads: Optional[int],
    progress: Optional[ProgressCallback],
    stop: Optional[Stopper],
) -> _orasp.Run:
    tell = None
    if progress is not None:
        call = progress

        def tell(*told: Any) -> None:
            call(Progress(*told))

    return _orasp.Run(
        time_limit=None if time_limit is None else real("time_limit", time_limit, "positive"),
        memory_limit=None if memory_limit is None else whole("memory_limit", memory_limit, 1, 1 << 40),
        threads=None if threads is None else whole("threads", threads, 1, 4096),
        progress=tell,
        stop=stop,
    )


def changes_in_settings(
    objective: Optional[ObjectiveLike] = None,
    direction: Optional[str] = None,
    max_subassemblies: Optional[int] = None,
    max_moved_parts: Optional[int] = None,
    max_moved_mass: Optional[float] = None,
    robots: Optional[int] = None,
    sites: Optional[int] = None,
    time_limit: Optional[float] = None,
    memory_limit: Optional[int] = None,
) -> dict[str, str]:
    """What shaped a result, as ``orasp solve --json`` writes it under "options"."""
    settings: dict[str, str] = {}
    if isinstance(objective, (str, Mapping)):
        settings["objective"] = json_text(objective)
    elif objective is not None:
        settings["objective"] = json_text(getattr(objective, "name", "callable"))
    if direction is not None:
        settings["direction"] = json_text(direction)
    for name, number in (
        ("max-subassemblies", max_subassemblies),
        ("max-moved-parts", max_moved_parts),
        ("robots", robots),
        ("sites", sites),
        ("memory-limit", memory_limit),
    ):
        if number is not None:
            settings[name] = str(int(number))
    if max_moved_mass is not None:
        settings["max-moved-mass"] = _orasp.number_text(float(max_moved_mass))
    if time_limit is not None:
        settings["time-limit"] = _orasp.number_text(float(time_limit))
    return settings


@dataclass(frozen=True)
class PlanStep:
    """One step of a plan of one robot.

    ``connections`` is what it handles, mostly one; ``pieces`` are the two sides (part ids) where it
    separates, ``moved`` the parts that move; ``total`` is what the plan has earned so far. ``direction`` is
    the way in which the moved piece leaves, None where the problem has no blocking.
    """

    number: int
    connections: tuple[str, ...]
    reward: float
    total: float
    separates: bool
    pieces: tuple[tuple[str, ...], ...]
    moved: tuple[str, ...]
    direction: Optional[str] = None
    free_directions: tuple[str, ...] = ()

    @property
    def connection(self) -> str:
        """The connection that it handles; of several the first."""
        return self.connections[0]


@dataclass(frozen=True)
class Move:
    """What a robot, or several side by side, do in one step of a fleet: ``parts`` go ``motion`` from place
    to place. ``distance`` is in m^2: squared, summed over the parts."""

    robots: tuple[int, ...]
    parts: tuple[str, ...]
    start: str
    end: str
    motion: str
    distance: float


@dataclass(frozen=True)
class FleetStep:
    """One step of a plan of several robots, all of which move at once."""

    number: int
    connections: tuple[str, ...]
    moves: tuple[Move, ...]
    robots_used: int
    distance: float
    reward: float
    total: float


@dataclass(frozen=True)
class Operation:
    """Steps that one does in one go, by their numbers, and the parts that they bring or take away."""

    steps: tuple[int, ...]
    moved: tuple[str, ...]
    direction: Optional[str] = None


@dataclass(frozen=True)
class Alternative:
    """Another plan: the connections in the problem's direction, step by step, and what they earn."""

    reward: float
    steps: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Expectation:
    """What is known of a policy where attempts may fail: ``attempts`` is their expected number; the value
    of the start is proved to be within ``error`` of the optimum; ``most_likely`` is the likeliest course, of
    that ``probability``: (connection, whether it succeeds)."""

    attempts: float
    residual: float
    error: float
    probability: float
    most_likely: tuple[tuple[str, bool], ...]
    states: int


class Result:
    """What a method answers: a plan, and what is proved.

    >>> import orasp
    >>> result = orasp.solve("4piece")
    >>> result
    <orasp.Result auto: optimal, reward 0.557, 4 steps>
    >>> result.connections
    ['1-2', '3-4', '2-3', '1-4']
    >>> result.sequence
    array([0, 2, 1, 3])
    >>> result.steps[1].moved
    ('2', '3')
    >>> round(float(result.rewards.sum()), 4)
    0.557
    """

    def __init__(
        self,
        problem: Problem,
        outcome: _orasp.Outcome,
        settings: dict[str, str],
        more: Optional[dict[str, str]] = None,
    ) -> None:
        self.problem = problem
        self._outcome = outcome
        self._settings = settings
        self._more = more or {}
        self._text: Optional[str] = None

    @property
    def method(self) -> str:
        return self._outcome.method

    @property
    def status(self) -> str:
        """ "optimal" (proved), "feasible" (a plan, no proof), "infeasible" (proved that there is none), or
        "unknown" (stopped with neither). """
        return self._outcome.status

    @property
    def stopped(self) -> Optional[str]:
        """What ended the work early: "time limit", "memory limit", "interrupted"; None if it was done."""
        return self._outcome.stopped

    @property
    def has_plan(self) -> bool:
        return self._outcome.has_plan

    @property
    def reward(self) -> float:
        """What the plan earns; -inf where there is none."""
        return self._outcome.reward

    @property
    def bound(self) -> Optional[float]:
        """A proved bound: no plan earns more. None where none is known."""
        return self._outcome.bound

    @property
    def gap(self) -> Optional[float]:
        """``bound - reward``; None without either."""
        return self.bound - self.reward if self.bound is not None and self.has_plan else None

    @property
    def seed(self) -> int:
        return self._outcome.seed

    @property
    def notes(self) -> list[str]:
        """What one should know beyond the figures, a sentence each."""
        return self._outcome.notes

    @property
    def statistics(self) -> dict[str, Any]:
        """What it took: states, actions, expanded, generated, reopened, pruned, sweeps, seconds,
        peak_bytes."""
        return self._outcome.statistics

    @property
    def seconds(self) -> float:
        return float(self.statistics["seconds"])

    @property
    def sequence(self) -> npt.NDArray[np.int64]:
        """The numbers of all connections in the problem's direction, shape ``[connections]``; empty without
        a plan. Of several robots: in the order in which they are cut."""
        if self.problem._engine().of_fleet:
            numbers = {id: number for number, id in enumerate(self.problem.connection_ids)}
            return np.array([numbers[id] for id in self.to_dict()["disassembly"]], dtype=np.int64)
        return self._outcome.sequence

    @property
    def connections(self) -> list[str]:
        """The ids of :attr:`sequence`."""
        ids = self.problem.connection_ids
        return [ids[number] for number in self.sequence]

    @property
    def steps(self) -> list[PlanStep]:
        """The plan of one robot step by step; empty without one."""
        found = self.to_dict()
        return [] if "fleet" in found else [_step(step) for step in found["steps"]]

    @property
    def fleet_steps(self) -> list[FleetStep]:
        """The plan of several robots step by step; empty without one."""
        found = self.to_dict()
        return [_fleet_step(step) for step in found["steps"]] if "fleet" in found else []

    @property
    def rewards(self) -> npt.NDArray[np.float64]:
        """What each step earns, shape ``[steps]``."""
        return np.array([step["reward"] for step in self.to_dict()["steps"]], dtype=np.float64)

    @property
    def operations(self) -> list[Operation]:
        """The steps in the groups in which one does them; empty for several robots."""
        return [
            Operation(tuple(entry["steps"]), tuple(entry["moved"]), entry.get("direction"))
            for entry in self.to_dict().get("operations", [])
        ]

    @property
    def order(self) -> Optional[npt.NDArray[np.int64]]:
        """What of the order matters for the plan to stay legal: pairs of step numbers, from 1, of which the
        first must come before the second, shape ``[pairs, 2]``. None where it is not worked out."""
        pairs = self.to_dict().get("order")
        return None if pairs is None else np.array(pairs, dtype=np.int64).reshape(-1, 2)

    @property
    def values(self) -> Optional[npt.NDArray[np.float64]]:
        """value-iteration: the best reward still to come from each state of H, shape ``[states]``;
        bellman-ford: from the start to each state; numbered as in :func:`orasp.graph`. A view, nothing is
        copied. None for others, and where value-iteration did without H."""
        return self._outcome.values

    @property
    def expectation(self) -> Optional[Expectation]:
        """Where attempts may fail: ``reward`` and ``bound`` are expectations, and this is the policy."""
        found = self._outcome.expectation
        if found is None:
            return None
        attempts, residual, error, probability, course, states = found
        return Expectation(attempts, residual, error, probability, tuple(course), states)

    @property
    def state_policy(self) -> str:
        """Where attempts may fail: the policy as a file, format orasp-state-policy/1. Raises InputError
        where none does."""
        return self._outcome.state_policy_text()

    @property
    def optimal_sequences(self) -> Optional[int]:
        """The number of optimal sequences, where ``count=True`` asked for it."""
        digits = self._outcome.optimal_sequences
        return None if digits is None else int(digits)

    @property
    def alternatives(self) -> list[Alternative]:
        """The best plans, where ``alternatives=K`` asked for them, the very best first."""
        key = self.problem._engine().direction
        return [
            Alternative(plan["reward"], tuple((step,) if isinstance(step, str) else tuple(step) for step in plan[key]))
            for plan in self.to_dict().get("alternatives", [])
        ]

    @property
    def makespan(self) -> Optional[int]:
        """The steps of a plan of several robots; None for one robot, or without a plan."""
        return self.to_dict().get("fleet", {}).get("makespan") if self.has_plan else None

    @property
    def travel(self) -> Optional[float]:
        """The travel of a plan of several robots in m^2; None for one robot, or without a plan."""
        return self.to_dict().get("fleet", {}).get("travel") if self.has_plan else None

    def to_json(self) -> str:
        """The result as ``orasp solve --json`` prints it: a plan file, format orasp-plan/1."""
        if self._text is None:
            self._text = self._outcome.text(self._settings, self._more)
        return self._text

    def to_dict(self) -> dict[str, Any]:
        """The same as a dict of your own."""
        return dict(json.loads(self.to_json()))

    def certificate(
        self,
        *,
        time_limit: Optional[float] = None,
        progress: Optional[ProgressCallback] = None,
        stop: Optional[Stopper] = None,
    ) -> Certificate:
        """Why no plan is better, or why there is none, for whoever does not want to trust this library:
        what ``orasp solve --certificate`` writes. :func:`check` verifies it. Costs O(parts^2), or, where
        sizes do not prove it, as much as all states. Raises InputError with the reason where there is none.

        >>> import orasp
        >>> orasp.solve("hubble").certificate()
        <orasp.Certificate sizes: no plan earns more than -0.9902>
        """
        from orasp._certificates import Certificate

        text, reason = _orasp.certificate(self._outcome, run_of(time_limit, None, None, progress, stop))
        if not text:
            raise _orasp.InputError(reason)
        return Certificate(text)

    def save(self, file: Union[str, os.PathLike[str]]) -> None:
        """Writes the plan, as ``orasp solve -o`` does. Raises InputError without a plan."""
        if not self.has_plan:
            raise _orasp.InputError(f"there is no plan, so {os.fspath(file)} is not written")
        Path(file).write_text(self.to_json() if self.expectation is None else self.state_policy, encoding="utf-8")

    def svg(self) -> str:
        """The plan as a strip of small structures, as an SVG, drawn by Graphviz. Raises InputError where
        that is missing, or steps take several connections."""
        if self.problem.action == "part" or not self.has_plan or self.problem._engine().of_fleet:
            raise _orasp.InputError("plans are drawn of one robot and of steps that take one connection each")
        return _orasp.steps_svg(self.problem._engine(), self.sequence.tolist())

    def _repr_svg_(self) -> Optional[str]:
        try:
            return self.svg()
        except _orasp.InputError:
            return None

    def __repr__(self) -> str:
        text = f"<orasp.Result {self.method}: {self.status}"
        if self.stopped is not None:
            text += f", stopped ({self.stopped})"
        if self.has_plan:
            steps = len(self.to_dict()["steps"])
            text += f", reward {self.reward:.6g}, {steps} step{'' if steps == 1 else 's'}"
        if self.status == "feasible" and self.bound is not None:
            text += f", bound {self.bound:.6g}"
        return text + ">"


def _step(step: Mapping[str, Any]) -> PlanStep:
    return PlanStep(
        number=step["step"],
        connections=(step["connection"],) if "connection" in step else tuple(step["connections"]),
        reward=step["reward"],
        total=step["total"],
        separates=step["separates"],
        pieces=tuple(tuple(piece) for piece in step["pieces"]),
        moved=tuple(step["moved"]),
        direction=step.get("direction"),
        free_directions=tuple(step.get("free_directions", ())),
    )


def _fleet_step(step: Mapping[str, Any]) -> FleetStep:
    moves = (
        Move(tuple(m["robots"]), tuple(m["parts"]), m["from"], m["to"], m["motion"], m["distance"])
        for m in step["moves"]
    )
    return FleetStep(
        number=step["step"],
        connections=tuple(step["connections"]),
        moves=tuple(moves),
        robots_used=step["robots_used"],
        distance=step["distance"],
        reward=step["reward"],
        total=step["total"],
    )


def solve(
    problem: ProblemLike,
    method: str = "auto",
    *,
    objective: Optional[ObjectiveLike] = None,
    direction: Optional[str] = None,
    max_subassemblies: Optional[int] = None,
    max_moved_parts: Optional[int] = None,
    max_moved_mass: Optional[float] = None,
    robots: Optional[int] = None,
    sites: Optional[int] = None,
    seed: int = 1,
    steps: Optional[int] = None,
    count: bool = False,
    alternatives: int = 0,
    time_limit: Optional[float] = None,
    memory_limit: Optional[int] = None,
    threads: Optional[int] = None,
    progress: Optional[ProgressCallback] = None,
    stop: Optional[Stopper] = None,
    policy: Optional[Union[Policy, GeneralPolicy, str, os.PathLike[str]]] = None,
    **options: OptionValue,
) -> Result:
    """Finds a plan: the order in which to take a product apart, or to put it together.

    ``problem`` is a :class:`Problem`, the name of a scenario ("hubble"), a file, or what a file says.
    ``method`` is one of :func:`methods`; ``options`` are its own, by their names with underscores
    (``solve(p, "beam", bound="parts")``), and ``seed`` that of methods that draw random numbers. ``objective``
    (a type, what a file says, or a function of the step), ``direction``, limits, ``robots`` and ``sites``
    change the problem, as on the command line. ``steps``: for several robots, at most so many.
    ``count=True`` counts the optimal sequences, ``alternatives=K`` lists the K best plans; both build H.

    ``time_limit`` is in seconds, ``memory_limit`` in MiB (three quarters of the machine's memory);
    ``threads`` default to all of the machine's, and to one where rewards are a function of Python.
    ``progress`` is called with a :class:`Progress`, in your thread; ``stop`` is anything with ``is_set()``
    that ends the work once it is true. Other threads of Python run meanwhile.

    A limit, ``stop`` and Ctrl-C end the work with the best plan so far: ``result.stopped`` says which. A
    second Ctrl-C before that raises KeyboardInterrupt. "No plan" is a status, not an error.

    Raises InputError, with the sentence of the command line, for what is wrong with the problem or an
    option, and where the method does not take the problem.

    >>> import orasp
    >>> orasp.solve("hubble").status
    'optimal'
    >>> orasp.solve("hubble", "beam", bound="sizes", max_moved_parts=3).reward
    -0.9902
    """
    given = load(problem).edited(
        objective=objective,
        direction=direction,
        max_subassemblies=max_subassemblies,
        max_moved_parts=max_moved_parts,
        max_moved_mass=max_moved_mass,
        robots=robots,
        sites=sites,
    )
    texts = option_texts(options)
    settings = {
        "method": json_text(method),
        **changes_in_settings(
            objective,
            direction,
            max_subassemblies,
            max_moved_parts,
            max_moved_mass,
            robots,
            sites,
            time_limit,
            memory_limit,
        ),
        **_orasp.settings_of(method, texts),
    }
    if count:
        settings["count"] = "true"
    if alternatives:
        settings["alternatives"] = str(whole("alternatives", alternatives, 1, 1_000_000))
    if steps is not None:
        settings["steps"] = str(whole("steps", steps, 1, 1_000_000))
    weights: Optional[_orasp.Weights] = None
    graph_weights: Optional[_orasp.GraphWeights] = None
    if policy is not None:
        from orasp._learning import GeneralPolicy, Policy, read_policy

        texts["policy"] = ""
        _orasp.settings_of(method, texts)  # refuses a policy where the method has none
        if isinstance(policy, (Policy, GeneralPolicy)):
            trained: Union[Policy, GeneralPolicy] = policy
            name = "the policy"
        else:
            trained = read_policy(policy)
            name = f'"{os.fspath(policy)}"'
            settings["policy"] = json_text(os.fspath(policy))
        trained._file.require_trained_on(given._engine(), name)
        if isinstance(trained, GeneralPolicy):
            graph_weights = trained._file.weights()
        else:
            weights = trained._file.weights()
    outcome = _orasp.solve(
        given._engine(),
        method,
        texts,
        weights,
        graph_weights,
        whole("seed", seed),
        None if steps is None else whole("steps", steps, 1, 1_000_000),
        bool(count),
        whole("alternatives", alternatives, 0, 1_000_000),
        run_of(time_limit, memory_limit, threads, progress, stop),
    )
    return Result(given, outcome, settings)


class Option(NamedTuple):
    """An option of a method. ``kind`` is flag, whole, wholes (a list), real, choice (one of ``words``) or
    file; ``default`` is a text."""

    name: str
    kind: str
    help: str
    default: str
    words: tuple[str, ...]


@dataclass(frozen=True)
class Method:
    """A method of the catalogue.

    ``exact``: it proves that a plan is optimal, or that there is none, if it is not stopped; ``bounds``: it
    proves a bound; ``one_robot``, ``fleets``, ``uncertain``: what it plans for.
    """

    name: str
    summary: str
    role: str
    exact: bool
    bounds: bool
    one_robot: bool
    fleets: bool
    uncertain: bool
    options: tuple[Option, ...]


def options_of(rows: Sequence[tuple[str, str, str, str, list[str]]]) -> tuple[Option, ...]:
    return tuple(
        Option(name.replace("-", "_"), kind, help, default, tuple(words)) for name, kind, help, default, words in rows
    )


def methods() -> list[Method]:
    """All methods, in the order of the documentation.

    >>> import orasp
    >>> [method.name for method in orasp.methods()][:3]
    ['auto', 'value-iteration', 'dijkstra']
    """
    return [Method(*row[:-1], options_of(row[-1])) for row in _orasp.methods()]


def obstacle(problem: ProblemLike, method: str) -> Optional[str]:
    """Why a method does not take a problem, in one sentence that names methods which do; None where it
    does. Raises InputError for an unknown method.

    >>> import orasp
    >>> orasp.obstacle("fleet-hubble", "dijkstra")[:40]
    'dijkstra plans for one robot, and makesp'
    """
    return _orasp.obstacle(load(problem)._engine(), method)


class ModelSize(NamedTuple):
    """The size of an integer program; ``whole_columns`` are those that must be whole, ``terms`` the
    coefficients of its rows."""

    columns: int
    whole_columns: int
    rows: int
    terms: int


def write_model(
    problem: ProblemLike, file: Union[str, os.PathLike[str]], *, steps: Optional[int] = None, **changes: Any
) -> ModelSize:
    """Writes the integer program of the method mip to a file that ends in .lp or .mps, for another solver,
    and solves nothing. ``steps`` is the horizon for several robots, needed for the least travel.

    >>> import orasp, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     orasp.write_model("3piece", f"{folder}/3piece.lp").rows > 0
    True
    """
    given = load(problem).edited(**changes)
    horizon = None if steps is None else whole("steps", steps, 1, 1_000_000)
    return ModelSize(*_orasp.write_model(given._engine(), os.fspath(file), horizon))


#: What a function takes as a plan: a Result, a plan file, what it says, or connection ids in order.
PlanLike = Union[Result, str, os.PathLike[str], Mapping[str, Any], Sequence[str], Sequence[Sequence[str]]]


def file_text(name: str) -> str:
    """What a file says, of at most 256 MiB."""
    try:
        if os.path.getsize(name) > _LARGEST_FILE:
            raise _orasp.InputError(f'"{name}" holds more than 256 MiB')
        return Path(name).read_text(encoding="utf-8")
    except OSError as error:
        raise _orasp.InputError(f'cannot read "{name}": {error.strerror}') from None
    except UnicodeDecodeError:
        raise _orasp.InputError(f'cannot read "{name}": it is not UTF-8') from None


def plan_text(plan: PlanLike) -> str:
    """A plan as the library reads it. A str is the name of a file."""
    if isinstance(plan, Result):
        return plan.to_json()
    if isinstance(plan, (str, os.PathLike)):
        return file_text(os.fspath(plan))
    if isinstance(plan, Mapping):
        return json_text(plan)
    return json_text([step if isinstance(step, str) else list(step) for step in plan])


def warn_of_another_problem(differs: bool) -> None:
    if differs:
        warn("the plan was made for another problem: its problem_digest differs")
