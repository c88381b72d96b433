"""Problems as objects."""

from __future__ import annotations

import copy
import json
import os
import warnings
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Optional, Union

import numpy as np
import numpy.typing as npt

from orasp import _orasp
from orasp._content import json_text, real, whole
from orasp._reward import ObjectiveLike, Reward, reward_of

FORMAT = "orasp-problem/1"


class OraspWarning(UserWarning):
    """Something worth knowing though nothing is wrong."""


def warn(sentence: str) -> None:
    warnings.warn(sentence, OraspWarning, stacklevel=3)


class Problem:
    """An assembly problem: parts, connections, constraints, an objective.

    It is built step by step, read from what a problem file says (:meth:`from_dict`, :meth:`from_json`,
    :meth:`read`), or built in (:meth:`scenario`). It holds what a problem file would hold, and the rules
    for files are the only rules: they are checked when the problem is used, or by :meth:`check`.

    Parts and connections are known by their ids, which are strings. Units: kg, m, s.

    >>> import orasp
    >>> shelf = orasp.Problem("Shelf")
    >>> left, right = shelf.add_part("left", mass=4), shelf.add_part("right", mass=4)
    >>> board = shelf.add_part("board", mass=2)
    >>> shelf.connect(left, board, duration=20)
    'left-board'
    >>> shelf.connect(right, board, duration=20)
    'right-board'
    >>> shelf.objective = "time"
    >>> shelf
    <orasp.Problem 'Shelf': 3 parts, 2 connections, time, disassembly>
    >>> orasp.solve(shelf).reward
    -42.0
    """

    def __init__(self, name: str = "", *, objective: Optional[ObjectiveLike] = None, direction: Optional[str] = None) -> None:
        self._content: Optional[dict[str, Any]] = {"format": FORMAT}
        if name:
            self._content["name"] = name
        self._content.update({"parts": [], "connections": []})
        self._text: Optional[str] = None  # what to read the content from, once it is asked for
        self._made: Optional[_orasp.Problem] = None
        self._reward: Optional[Reward] = None
        self._folder: Optional[str] = None  # of the file, for what it names
        if objective is not None:
            self.objective = objective
        if direction is not None:
            self.direction = direction

    # ---- Where problems come from.

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> Problem:
        """The problem that a file with this content holds. Raises InputError at the first fault."""
        return cls.from_json(json_text(content))

    @classmethod
    def from_json(cls, text: str) -> Problem:
        """The problem of a text in the format orasp-problem/1. Raises InputError at the first fault."""
        return cls._of(_orasp.parse_problem(text), text)

    @classmethod
    def read(cls, file: Union[str, os.PathLike[str]]) -> Problem:
        """The problem of a file. Raises InputError, which names the file."""
        name = os.fspath(file)
        is_file = "/" in name or name.endswith(".json")  # and not the name of a scenario
        problem = cls._of(_orasp.find_problem(name if is_file else f"./{name}"), None)
        problem._text = Path(name).read_text(encoding="utf-8")
        problem._folder = str(Path(name).parent)
        return problem

    @classmethod
    def scenario(cls, name: str) -> Problem:
        """A built-in problem (:func:`scenarios`) or a generated one: "hubble", "grid:5x5", "tree:500:7"
        (parts:seed), "random:50:80:3" (parts:connections:seed). Raises InputError."""
        if not _orasp.is_scenario(name):
            raise _orasp.InputError(f'no built-in problem "{name}"; orasp.scenarios() lists them')
        return cls._of(_orasp.find_problem(name), None)

    @classmethod
    def _of(cls, made: _orasp.Problem, text: Optional[str]) -> Problem:
        problem = cls.__new__(cls)
        problem._content = None
        problem._text = text
        problem._made = made
        problem._reward = None
        problem._folder = None
        for sentence in made.warnings:
            warn(sentence)
        return problem

    # ---- What it holds.

    def _dict(self) -> dict[str, Any]:
        """What a file would say, to be read."""
        if self._content is None:
            assert self._made is not None
            self._content = json.loads(self._made.text() if self._text is None else self._text.removeprefix("\ufeff"))
            self._text = None
        return self._content

    def _changing(self) -> dict[str, Any]:
        """The same, to be changed."""
        content = self._dict()
        self._made = None
        return content

    def _engine(self) -> _orasp.Problem:
        """The checked problem of the library."""
        if self._made is None:
            content = self._dict()
            made = _orasp.parse_problem(json_text(content))
            for sentence in made.warnings:
                warn(sentence)
            self._made = made.edited(objective=self._reward._for(made)) if self._reward is not None else made
        return self._made

    def check(self) -> Problem:
        """Checks it against the rules for problem files. Raises InputError with one sentence for the first
        fault; returns the problem itself."""
        self._engine()
        return self

    def add_part(
        self,
        id: Optional[str] = None,
        *,
        name: Optional[str] = None,
        mass: Optional[float] = None,
        position: Optional[Sequence[float]] = None,
        numbers: Optional[Mapping[str, float]] = None,
        product: Optional[str] = None,
        **more: Any,
    ) -> str:
        """Adds a part and returns its id; where none is given, its number from 1 on.

        ``mass`` is in kg (1), ``position`` [x, y, z] in metres, ``numbers`` are your own, for formulas. Parts with
        the same ``product`` are counted where people read of them: "3 x M5 nut".
        """
        parts = self._changing()["parts"]
        part: dict[str, Any] = {"id": str(len(parts) + 1) if id is None else id}
        _put(part, name=name, product=product, mass=mass, position=_listed(position), numbers=_mapped(numbers), **more)
        parts.append(part)
        return str(part["id"])

    def connect(
        self,
        a: str,
        b: str,
        *,
        id: Optional[str] = None,
        duration: Optional[float] = None,
        success: Optional[float] = None,
        on_failure: Optional[Mapping[str, Any]] = None,
        axis: Optional[str] = None,
        numbers: Optional[Mapping[str, float]] = None,
        attributes: Optional[Mapping[str, str]] = None,
        position: Optional[Sequence[float]] = None,
        **more: Any,
    ) -> str:
        """Joins two parts and returns the id of the connection; where none is given, "a-b".

        ``duration`` is in seconds (1); ``success`` the probability that one attempt succeeds (1), and
        ``on_failure`` what a failure does ({"breaks": [...]} or {"abort": reward}); ``axis`` how the first
        part moves off the second, for fleets; ``numbers`` and ``attributes`` ({"tool": "M4"}) are your own;
        ``position`` is where the work is done, in metres.
        """
        connection: dict[str, Any] = {"parts": [a, b]}
        if id is not None:
            connection = {"id": id, **connection}
        _put(
            connection,
            duration=duration,
            success=success,
            on_failure=_mapped(on_failure),
            axis=axis,
            numbers=_mapped(numbers),
            attributes=_mapped(attributes),
            position=_listed(position),
            **more,
        )
        self._changing()["connections"].append(connection)
        return id if id is not None else f"{a}-{b}"

    def require(
        self,
        connection: str,
        *,
        after: Union[str, Iterable[str]] = (),
        after_any: Union[str, Iterable[str]] = (),
        made_after: Union[str, Iterable[str]] = (),
        made_after_any: Union[str, Iterable[str]] = (),
    ) -> None:
        """Precedence: ``connection`` is removed only after all of ``after`` and at least one of
        ``after_any``; it is made only after all of ``made_after`` and at least one of ``made_after_any``. Each is an id or several."""
        entry: dict[str, Any] = {"connection": connection}
        lists = {"after": after, "after_any": after_any, "made_after": made_after, "made_after_any": made_after_any}
        for key, ids in lists.items():
            if listed := _ids(ids):
                entry[key] = listed
        self._changing().setdefault("precedence", []).append(entry)

    def block(self, part: str, by: str, directions: Union[str, Iterable[str]]) -> None:
        """While both are there, ``part`` cannot leave ``by`` along ``directions``: one, or several."""
        blocking = self._changing().setdefault("blocking", {"directions": ["+x", "-x", "+y", "-y", "+z", "-z"]})
        blocking.setdefault("blocked", []).append({"part": part, "by": by, "directions": _ids(directions)})

    def look_along(self, directions: Iterable[Union[str, Mapping[str, Any]]]) -> None:
        """The directions that blocking considers: axes ("+x"), in opposite pairs, and named ones
        ({"id": "slant", "vector": [0.6, 0, 0.8]}), whose opposite is there too. Default: the six axes."""
        self._changing().setdefault("blocking", {})["directions"] = [
            direction if isinstance(direction, str) else dict(direction) for direction in directions
        ]

    def limit(
        self,
        *,
        max_subassemblies: Optional[int] = None,
        max_moved_parts: Optional[int] = None,
        max_moved_mass: Optional[float] = None,
        grounded: Optional[bool] = None,
    ) -> None:
        """Limits: subassemblies after a step, parts and mass (kg) of a moved piece; ``grounded``: every
        subassembly holds a base part. What is not given stays as it is."""
        limits = self._changing().setdefault("limits", {})
        _put(
            limits,
            max_subassemblies=max_subassemblies,
            max_moved_parts=max_moved_parts,
            max_moved_mass=max_moved_mass,
            grounded=grounded,
        )

    def fix(self, *parts: str) -> None:
        """These parts are fixed, and never move: the base."""
        self._changing().setdefault("base", []).extend(parts)

    def aim(
        self,
        *,
        free: Optional[Union[str, Iterable[str]]] = None,
        removed: Optional[Union[str, Iterable[str]]] = None,
        stop: Optional[str] = None,
    ) -> None:
        """The goal of a disassembly, instead of everything: ``free`` parts have no connection left and
        ``removed`` connections are gone. ``stop`` is "reached", or "best": the plan may go on for profit."""
        goal: dict[str, Any] = {}
        _put(
            goal,
            free=None if free is None else _ids(free),
            removed=None if removed is None else _ids(removed),
            stop=stop,
        )
        self._changing()["goal"] = goal

    def fleet(
        self, robots: int, sites: Iterable[Sequence[float]], *, depot: Sequence[float] = (0.0, 0.0)
    ) -> None:
        """Several robots: how many, the places [x, y] where subassemblies can be put, and the depot, in
        metres. The objective is then "makespan" or "fleet_travel", and connections have an ``axis``."""
        self._changing()["fleet"] = {
            "robots": robots,
            "depot": _listed(depot),
            "sites": [_listed(site) for site in sites],
        }

    @property
    def objective(self) -> Any:
        """What a step earns: as a file says it, or a function (:class:`Reward`). It may be set to a type
        ("time"), to what a file says ({"type": "time", "speed": 2}), or to a function of the step."""
        if self._reward is not None:
            return self._reward
        found: dict[str, Any] = copy.deepcopy(self._dict().get("objective", {"type": "cubesat"}))
        return found

    @objective.setter
    def objective(self, objective: Any) -> None:
        self._reward = reward_of(objective)
        content = self._changing()
        content.pop("objective", None)
        if self._reward is not None:
            return
        if isinstance(objective, str):
            objective = json.loads(_orasp.find_objective(objective).text()) if "/" in objective or objective.endswith(
                ".json"
            ) else {"type": objective}
        content["objective"] = copy.deepcopy(objective)

    @property
    def direction(self) -> str:
        """ "disassembly" or "assembly". """
        return str(self._dict().get("direction", "disassembly"))

    @direction.setter
    def direction(self, direction: str) -> None:
        self._changing()["direction"] = direction

    @property
    def action(self) -> str:
        """What a step takes: "connection", or "part": a part, or several that hang together, with all
        connections to the rest."""
        return str(self._dict().get("action", "connection"))

    @action.setter
    def action(self, action: str) -> None:
        self._changing()["action"] = action

    @property
    def name(self) -> str:
        return str(self._dict().get("name", ""))

    @name.setter
    def name(self, name: str) -> None:
        self._changing()["name"] = name

    def __getitem__(self, key: str) -> Any:
        """A copy of what a file says under a key: ``problem["precedence"]``. KeyError where it says nothing."""
        return copy.deepcopy(self._dict()[key])

    def __setitem__(self, key: str, value: Any) -> None:
        """Says something else under a key, whatever a file may say: ``problem["source"] = "drawing 7"``."""
        if key == "objective":
            self.objective = value
        else:
            self._changing()[key] = copy.deepcopy(value)

    def __delitem__(self, key: str) -> None:
        if key == "objective":
            self._reward = None
        del self._changing()[key]

    # ---- What is known of it.

    @property
    def part_ids(self) -> list[str]:
        """The ids of the parts; the place in this list is the number of a part."""
        return self._engine().part_ids

    @property
    def connection_ids(self) -> list[str]:
        """The ids of the connections; the place in this list is the number of a connection."""
        return self._engine().connection_ids

    @property
    def num_parts(self) -> int:
        return self._engine().num_parts

    @property
    def num_connections(self) -> int:
        return self._engine().num_connections

    @property
    def ends(self) -> npt.NDArray[np.int64]:
        """The numbers of the two parts of each connection, shape ``[connections, 2]``."""
        return self._engine().ends

    @property
    def digest(self) -> str:
        """SHA-256 of what planning depends on: not names and notes, and of a function its name alone."""
        return self._engine().digest()

    def edited(
        self,
        *,
        objective: Optional[ObjectiveLike] = None,
        direction: Optional[str] = None,
        max_subassemblies: Optional[int] = None,
        max_moved_parts: Optional[int] = None,
        max_moved_mass: Optional[float] = None,
        robots: Optional[int] = None,
        sites: Optional[int] = None,
    ) -> Problem:
        """The same problem with these changes; what is not given stays. They are those of the command line
        (``--objective``, ...): an objective of one robot leaves a fleet out; ``sites``: the first so many."""
        if all(
            change is None
            for change in (objective, direction, max_subassemblies, max_moved_parts, max_moved_mass, robots, sites)
        ):
            return self
        before = self._engine()
        reward = reward_of(objective)
        engine = before.edited(
            objective=_objective(before, objective, reward),
            direction=direction,
            max_subassemblies=None if max_subassemblies is None else whole("max_subassemblies", max_subassemblies),
            max_moved_parts=None if max_moved_parts is None else whole("max_moved_parts", max_moved_parts),
            max_moved_mass=None if max_moved_mass is None else real("max_moved_mass", max_moved_mass, "not_negative"),
            robots=None if robots is None else whole("robots", robots, 1),
            sites=None if sites is None else whole("sites", sites, 1),
        )
        if before.robots and not engine.robots:
            robots_text = f"{before.robots} robot{'' if before.robots == 1 else 's'}"
            warn(f"fleet: its {robots_text} are not used: {engine.objective} is an objective of one robot")
        other = Problem._of(engine, None)
        other._folder = self._folder
        other._reward = reward if objective is not None else self._reward
        if other._reward is not None:  # such a problem has no text of its own
            content = json.loads(engine.edited(objective=_orasp.find_objective("cubesat")).text())
            del content["objective"]
            other._content = content
        return other

    def to_dict(self) -> dict[str, Any]:
        """What a problem file would say, as a dict of your own. Raises InputError where the objective is a
        function, which no file can hold."""
        return dict(json.loads(self.to_json()))

    def to_json(self) -> str:
        """The problem as a file, as ``orasp`` would write it. Raises InputError where it is at fault, or its
        objective a function."""
        return self._engine().text()

    def save(self, file: Union[str, os.PathLike[str]]) -> None:
        """Writes a problem file. Raises InputError as :meth:`to_json`."""
        Path(file).write_text(self.to_json(), encoding="utf-8")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Problem):
            return NotImplemented
        if self is other:
            return True
        if self._reward != other._reward:
            return False
        return bool(self._canonical() == other._canonical())

    __hash__ = None  # type: ignore[assignment]  # it can be changed

    def _canonical(self) -> Any:
        """What tells two problems apart, but for a function."""
        try:
            if self._reward is None:
                return self._engine().text()
            content = {key: value for key, value in self._dict().items() if key != "objective"}
            return _orasp.parse_problem(json_text(content)).text()
        except _orasp.InputError:
            return self._dict()

    def copy(self) -> Problem:
        """One that can be changed without changing this one."""
        return copy.deepcopy(self)

    def __deepcopy__(self, memo: dict[int, Any]) -> Problem:
        other = Problem.__new__(Problem)
        other.__setstate__(self.__getstate__())
        other._content = copy.deepcopy(other._content, memo)
        other._made = self._made  # it never changes
        return other

    __copy__ = copy

    def __getstate__(self) -> dict[str, Any]:
        return {"content": self._dict(), "reward": self._reward, "folder": self._folder}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._content = state["content"]
        self._text = None
        self._made = None
        self._reward = state["reward"]
        self._folder = state["folder"]

    def __repr__(self) -> str:
        content = self._dict()
        parts, connections = len(content.get("parts", [])), len(content.get("connections", []))
        objective = self._reward.name if self._reward is not None else content.get("objective", {}).get("type", "cubesat")
        return (
            f"<orasp.Problem {self.name!r}: {parts} part{'' if parts == 1 else 's'}, "
            f"{connections} connection{'' if connections == 1 else 's'}, {objective}, {self.direction}>"
        )

    # ---- Pictures.

    def svg(self) -> str:
        """The assembly graph as an SVG, drawn by Graphviz. Raises InputError where that is missing."""
        return _orasp.structure_svg(self._engine())

    def _repr_svg_(self) -> Optional[str]:
        try:
            return self.svg()
        except _orasp.InputError:
            return None


class Scenario(NamedTuple):
    """A built-in problem, or a generator of problems, whose ``name`` shows its form: "grid:RxC"."""

    name: str
    summary: str
    generator: bool


def scenarios() -> list[Scenario]:
    """The built-in problems, then the generators.

    >>> import orasp
    >>> orasp.scenarios()[0].name
    '3piece'
    """
    return [Scenario(*row) for row in _orasp.scenarios()]


#: What a function takes as a problem: the object, the name of a scenario or of a file, or what a file says.
ProblemLike = Union[Problem, str, os.PathLike[str], Mapping[str, Any]]


def load(source: ProblemLike) -> Problem:
    """The problem that is called so: a scenario's name, a file, or what a file says as a dict. A Problem
    comes back as it is. Raises InputError.

    >>> import orasp
    >>> orasp.load("hubble")
    <orasp.Problem 'Hubble': 20 parts, 19 connections, cubesat, disassembly>
    """
    if isinstance(source, Problem):
        return source
    if isinstance(source, Mapping):
        return Problem.from_dict(source)
    name = os.fspath(source)
    if not isinstance(source, str) or "/" in name or name.endswith(".json"):
        return Problem.read(name)
    problem = Problem._of(_orasp.find_problem(name), None)
    if not _orasp.is_scenario(name):
        problem._folder = "."
    return problem


def _put(entry: dict[str, Any], **values: Any) -> None:
    entry.update({key: value for key, value in values.items() if value is not None})


def _ids(ids: Union[str, Iterable[str]]) -> list[str]:
    return [ids] if isinstance(ids, str) else list(ids)


def _listed(values: Optional[Iterable[Any]]) -> Optional[list[Any]]:
    return None if values is None else list(values)


def _mapped(values: Optional[Mapping[str, Any]]) -> Optional[dict[str, Any]]:
    return None if values is None else dict(values)


def _objective(
    engine: _orasp.Problem, objective: Optional[ObjectiveLike], reward: Optional[Reward]
) -> Optional[_orasp.Objective]:
    if objective is None:
        return None
    if reward is not None:
        return reward._for(engine)
    if isinstance(objective, str):
        return _orasp.find_objective(objective)
    return _orasp.parse_objective(json_text(objective), "objective")
