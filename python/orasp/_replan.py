"""The best plan from where the work stands."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple, Optional, Union

from orasp import _orasp
from orasp._content import json_text, real, whole
from orasp._problem import ProblemLike, load
from orasp._questions import Conflict
from orasp._solve import PlanLike, ProgressCallback, Result, Stopper, changes_in_settings, plan_text, run_of


class Changes(NamedTuple):
    """What a new plan makes of the steps of the old one that were still to come, as connection ids:
    ``kept`` in the order of both, ``moved`` elsewhere in the new one, ``dropped``, ``added``.
    ``reward_before`` is what the old steps would have earned, None where they break a rule from here;
    ``price`` is that less what the new plan earns."""

    kept: list[str]
    moved: list[str]
    dropped: list[str]
    added: list[str]
    reward_before: Optional[float]
    price: Optional[float]


class Replanned(Result):
    """A plan of the steps still to come, and what it changes; ``reward`` is that of these steps alone."""

    #: Against the old plan; None where none was given, or there is no plan.
    changes: Optional[Changes] = None
    #: What waits for lost parts, as connection ids; None where none are lost.
    waiting: Optional[list[str]] = None
    #: Of a goal that cannot be reached any more, what can still be taken off.
    still_reachable: Optional[list[str]] = None
    #: Why there is no plan any more.
    conflict: Optional[list[Conflict]] = None


Ids = Union[str, Iterable[str]]


def _ids(ids: Ids) -> list[str]:
    return [ids] if isinstance(ids, str) else list(ids)


def replan(
    problem: ProblemLike,
    *,
    plan: Optional[PlanLike] = None,
    done: int = 0,
    removed: Ids = (),
    inaccessible: Ids = (),
    not_next: Ids = (),
    lost_parts: Ids = (),
    late_parts: Ids = (),
    time_limit: Optional[float] = None,
    memory_limit: Optional[int] = None,
    threads: Optional[int] = None,
    progress: Optional[ProgressCallback] = None,
    stop: Optional[Stopper] = None,
    **changes: Any,
) -> Replanned:
    """Finds the best plan from where the work stands, with what has changed since.

    ``plan`` is the old plan, of which the first ``done`` steps are done; ``removed`` connections are done
    too (in assembly: made). ``inaccessible`` connections stay as they are, ``not_next`` ones cannot be the
    next step; the connections of ``lost_parts`` wait, with what comes after them; those of ``late_parts``
    are handled only when nothing else can be. ``changes`` are those of :meth:`Problem.edited`.

    >>> import orasp
    >>> plan = orasp.solve("hubble")
    >>> rest = orasp.replan("hubble", plan=plan, done=5, inaccessible=plan.connections[5])
    >>> rest.status, len(rest.connections), rest.changes.dropped == [plan.connections[5]]
    ('optimal', 13, True)
    """
    given = load(problem).edited(**changes)
    lists = {
        "removed": _ids(removed),
        "inaccessible": _ids(inaccessible),
        "not_next": _ids(not_next),
        "lost_parts": _ids(lost_parts),
        "late_parts": _ids(late_parts),
    }
    outcome, changed, waiting, reachable, conflict = _orasp.replan(
        given._engine(),
        None if plan is None else plan_text(plan),
        whole("done", done),
        lists["removed"],
        lists["inaccessible"],
        lists["not_next"],
        lists["lost_parts"],
        lists["late_parts"],
        run_of(time_limit, memory_limit, threads, progress, stop),
    )
    settings = changes_in_settings(**changes, time_limit=time_limit, memory_limit=memory_limit)
    if done:
        settings["done"] = str(done)
    names = {"not_next": "not-next", "lost_parts": "lost-part", "late_parts": "late-part"}
    for name, ids in lists.items():
        if ids:
            settings[names.get(name, name)] = json_text(",".join(ids))
    more = {"still_reachable": reachable, "changes": changed, "waiting": waiting}
    texts = {key: json_text(value) for key, value in more.items() if value is not None}
    items = None if conflict is None else [Conflict(*item) for item in conflict]
    if items is not None:
        texts["conflict"] = json_text([item._asdict() for item in items])
    result = Replanned(given, outcome, settings, texts)
    result.changes = None if changed is None else Changes(**changed)
    result.waiting = waiting
    result.still_reachable = reachable
    result.conflict = items
    return result


class Replanner:
    """Answers, again and again, what the best plan is from where the work stands, while things change.

    H is built once, where it is estimated to have no more than ``most_actions`` actions, and every state's
    best reward still to come is kept: then an answer takes microseconds. Where H is too large, "auto"
    solves what is left. The names of connections and parts are ids; unknown ones raise InputError, and
    nothing is changed then.

    >>> import orasp
    >>> cell = orasp.Replanner("hubble")
    >>> plan = cell.plan()
    >>> cell.done(plan.connections[0])
    >>> cell.set_accessible(plan.connections[2], False)
    >>> cell.plan().status, len(cell.plan().connections)
    ('optimal', 17)
    """

    def __init__(
        self,
        problem: ProblemLike,
        *,
        most_actions: float = 2e7,
        time_limit: Optional[float] = None,
        memory_limit: Optional[int] = None,
        threads: Optional[int] = None,
        **changes: Any,
    ) -> None:
        self.problem = load(problem).edited(**changes)
        self._engine = _orasp.Replanner(
            self.problem._engine(),
            real("most_actions", most_actions, "not_negative"),
            run_of(time_limit, memory_limit, threads, None, None),
        )

    def done(self, *connections: str) -> None:
        """These were handled, by the plan or not."""
        self._engine.set_done(list(connections), True)

    def undone(self, *connections: str) -> None:
        """These were not handled after all."""
        self._engine.set_done(list(connections), False)

    def set_accessible(self, connections: Ids, accessible: bool) -> None:
        self._engine.set_accessible(_ids(connections), accessible)

    def set_possible_next(self, connections: Ids, possible: bool) -> None:
        """Whether they can be the next step; once something is done all can again."""
        self._engine.set_possible_next(_ids(connections), possible)

    def set_lost(self, parts: Ids, lost: bool) -> None:
        """The connections of lost parts wait, with what comes after them or would shut them out."""
        self._engine.set_lost(_ids(parts), lost)

    def set_late(self, parts: Ids, late: bool) -> None:
        """The connections of late parts are handled only when nothing else can be."""
        self._engine.set_late(_ids(parts), late)

    def set_limits(
        self,
        *,
        max_subassemblies: Optional[int] = None,
        max_moved_parts: Optional[int] = None,
        max_moved_mass: Optional[float] = None,
    ) -> None:
        """Other limits; what is not given stays. Up to four choices are held, so going back is quick."""
        changed = self.problem.edited(
            max_subassemblies=max_subassemblies, max_moved_parts=max_moved_parts, max_moved_mass=max_moved_mass
        )
        self._engine.limit(max_subassemblies, max_moved_parts, max_moved_mass, run_of(None, None, None, None, None))
        self.problem = changed

    def reweigh(self, **changes: Any) -> bool:
        """Another objective (``reweigh(objective="time")``): the rewards of the H that is held are replaced,
        which is quicker than to build it. Returns whether they were; else H is built anew."""
        changed = self.problem.edited(**changes)
        replaced = self._engine.reweigh(changed._engine(), run_of(None, None, None, None, None))
        self.problem = changed
        return replaced

    def plan(
        self,
        *,
        time_limit: Optional[float] = None,
        memory_limit: Optional[int] = None,
        progress: Optional[ProgressCallback] = None,
        stop: Optional[Stopper] = None,
    ) -> Result:
        """The best plan from here: the steps still to come, and what they earn."""
        outcome = self._engine.plan(run_of(time_limit, memory_limit, None, progress, stop))
        return Result(self.problem, outcome, {})

    @property
    def open(self) -> list[str]:
        """The connections that are still to be handled."""
        return self._engine.open

    @property
    def holds_graph(self) -> bool:
        """Whether H is held."""
        return self._engine.holds_graph

    @property
    def held_states(self) -> int:
        return self._engine.held_states

    @property
    def seconds_to_build(self) -> float:
        """What building H, or replacing its rewards, took."""
        return self._engine.seconds_to_build


