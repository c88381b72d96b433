"""Rewards that are functions of Python."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Optional, Union

from orasp import _orasp

Step = _orasp.Step
Steps = _orasp.Steps


class Reward:
    """What a step earns, as a function: more is better, and a plan earns the sum over its steps.

    ``function`` is called with a :class:`Step` and returns a number. It must be pure: the same step, the
    same reward. With ``vectorized=True`` it is called with many steps at once (:class:`Steps`, whose
    attributes are arrays of shape ``[steps]``) and returns an array of that shape; what it says of a step
    must not depend on which others come with it. That is 20 to 100 times as fast where H is built.

    ``least`` and ``greatest`` are the least and the greatest reward that one step can earn, if you know
    them: methods that prove with bounds (``orasp-search``) need ``greatest``, and are only as right as it
    is. ``name`` is all that the digest of a problem knows of the function. ``depot`` (metres) is where
    ``distance`` of many steps is measured from.

    The function runs in a thread of its own while the caller waits, and what it raises comes out of
    ``solve`` as it is.

    >>> import orasp
    >>> heavy = orasp.Reward(lambda step: -step.moved_mass, name="heavy", greatest=0)
    >>> orasp.solve("4piece", objective=heavy).reward
    -3.0
    >>> many = orasp.Reward(lambda steps: -steps.moved_mass, vectorized=True, greatest=0)
    >>> orasp.solve("4piece", objective=many).reward
    -3.0
    """

    def __init__(
        self,
        function: Callable[[Any], Any],
        *,
        name: Optional[str] = None,
        vectorized: bool = False,
        least: float = -math.inf,
        greatest: float = math.inf,
        depot: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> None:
        if not callable(function):
            raise _orasp.InputError("the reward must be a function of the step")
        self.function = function
        self.name = name if name is not None else getattr(function, "__name__", "callable").strip("<>") or "callable"
        self.vectorized = bool(vectorized)
        self.least = float(least)
        self.greatest = float(greatest)
        x, y, z = (float(coordinate) for coordinate in depot)
        self.depot = (x, y, z)

    def __repr__(self) -> str:
        return f"<orasp.Reward {self.name!r}{', vectorized' if self.vectorized else ''}>"

    def _key(self) -> tuple[Any, ...]:
        return (self.function, self.name, self.vectorized, self.least, self.greatest, self.depot)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Reward):
            return NotImplemented
        return self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def _for(self, problem: _orasp.Problem) -> _orasp.Objective:
        return _orasp.objective_of(
            problem, self.function, self.name, self.vectorized, self.least, self.greatest, list(self.depot)
        )


#: What a problem may be judged by: a type ("time") or the file of an objective, an objective as a file
#: says it ({"type": "time", "speed": 2}), a Reward, or a function of one step.
ObjectiveLike = Union[str, dict[str, Any], Reward, Callable[[Step], float]]


def reward_of(objective: Any) -> Optional[Reward]:
    """The Reward that an objective is, if it is a function."""
    if isinstance(objective, Reward):
        return objective
    return Reward(objective) if callable(objective) else None
