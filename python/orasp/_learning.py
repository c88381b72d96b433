"""Policies: training, and planning with them."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

from orasp import _orasp
from orasp._content import OptionValue, option_texts, real, whole
from orasp._problem import ProblemLike, load, warn
from orasp._solve import Option, ProgressCallback, Result, Stopper, options_of, run_of


class Policy:
    """A trained network: in every state it says what handling each open connection next is worth.

    The network is plain weights, so planning needs no libtorch. Its input is 1 for each open connection, its
    output a number for each connection: an action's worth is ``scale`` times that, plus its own reward where
    ``adds_reward``, up to a number that all actions of a state share.
    """

    def __init__(self, file: _orasp.Policy) -> None:
        self._file = file

    @classmethod
    def read(cls, file: Union[str, os.PathLike[str]]) -> Policy:
        """Reads a file of ``orasp train``, format orasp-policy/1. Raises InputError, which names the file."""
        data = _bytes_of(file)
        try:
            return cls.from_bytes(data)
        except _orasp.InputError as error:
            raise _orasp.InputError(f'"{os.fspath(file)}": {error}') from None

    @classmethod
    def from_bytes(cls, data: bytes) -> Policy:
        """The policy of the bytes of a file. Raises InputError where they are damaged."""
        return cls(_orasp.parse_policy(data))

    def to_bytes(self) -> bytes:
        """The bytes of its file."""
        return self._file.bytes()

    def save(self, file: Union[str, os.PathLike[str]]) -> None:
        Path(file).write_bytes(self.to_bytes())

    @property
    def reward(self) -> float:
        """What the plan earns that it makes from the start; -inf where none was found soon."""
        return self._file.reward

    @property
    def problem_digest(self) -> str:
        """Of the problem that it was trained on."""
        return self._file.problem_digest

    @property
    def layers(self) -> list[tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]]:
        """The weights, shape ``[inputs, outputs]``, and the bias, shape ``[outputs]``, of each layer; between
        layers stands max(0, x). Empty for a policy over pieces. Views, nothing is copied."""
        return self._file.layers

    @property
    def scale(self) -> float:
        return self._file.scale

    @property
    def adds_reward(self) -> bool:
        return self._file.adds_reward

    def follow(self, problem: ProblemLike, *, time_limit: Optional[float] = None) -> Result:
        """The plan that it makes: in every state the legal action that it values most."""
        given = load(problem)
        return Result(given, _orasp.follow(given._engine(), self._file, run_of(time_limit, None, None, None, None)), {})

    def __reduce__(self) -> tuple[Any, ...]:
        return Policy.from_bytes, (self.to_bytes(),)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Policy):
            return NotImplemented
        return self.to_bytes() == other.to_bytes()

    def __hash__(self) -> int:
        return hash(self.to_bytes())

    def __repr__(self) -> str:
        sizes = [str(weights.shape[0]) for weights, _ in self.layers]
        sizes += [str(bias.shape[0]) for _, bias in self.layers[-1:]]
        return f"<orasp.Policy {'-'.join(sizes) or 'over pieces'}, reward {self.reward:.6g}>"


class GeneralPolicy:
    """A policy for many products, of ``orasp train --problems``: a graph network that answers for every problem
    of its kind. ``solve(problem, "dqn", policy=...)`` plans with it, without libtorch."""

    def __init__(self, file: _orasp.GeneralPolicy) -> None:
        self._file = file

    @classmethod
    def read(cls, file: Union[str, os.PathLike[str]]) -> GeneralPolicy:
        """Reads a file of format orasp-graph-policy/1. Raises InputError, which names the file."""
        return cls.from_bytes(_bytes_of(file), f'"{os.fspath(file)}": ')

    @classmethod
    def from_bytes(cls, data: bytes, place: str = "") -> GeneralPolicy:
        """The policy of the bytes of a file. Raises InputError where they are damaged."""
        try:
            return cls(_orasp.parse_general_policy(data))
        except _orasp.InputError as error:
            raise _orasp.InputError(f"{place}{error}") from None

    def to_bytes(self) -> bytes:
        """The bytes of its file."""
        return self._file.bytes()

    def save(self, file: Union[str, os.PathLike[str]]) -> None:
        Path(file).write_bytes(self.to_bytes())

    @property
    def objective(self) -> str:
        """The objective of its problems, as a problem file writes it."""
        return self._file.objective

    @property
    def direction(self) -> str:
        return self._file.direction

    @property
    def keys(self) -> frozenset[str]:
        """What its problems may state: of base, blocking, precedence and the limits those that one of its
        training stated."""
        return frozenset(self._file.keys)

    def __reduce__(self) -> tuple[Any, ...]:
        return GeneralPolicy.from_bytes, (self.to_bytes(),)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, GeneralPolicy):
            return NotImplemented
        return self.to_bytes() == other.to_bytes()

    def __hash__(self) -> int:
        return hash(self.to_bytes())

    def __repr__(self) -> str:
        return f"<orasp.GeneralPolicy for {self.direction}, {self.objective}>"


def _bytes_of(file: Union[str, os.PathLike[str]]) -> bytes:
    try:
        return Path(file).read_bytes()
    except OSError as error:
        raise _orasp.InputError(f'cannot read "{os.fspath(file)}": {error.strerror}') from None


def read_policy(file: Union[str, os.PathLike[str]]) -> Union[Policy, GeneralPolicy]:
    """The policy of a file of ``orasp train``, for one problem or for many."""
    if _orasp.is_general_policy(_bytes_of(file)):
        return GeneralPolicy.read(file)
    return Policy.read(file)


@dataclass(frozen=True)
class Training:
    """What training came to: the best policy that was met (None where it was stopped before the first), the
    best plan of any episode, and the last line of the log."""

    policy: Optional[Policy]
    result: Result
    record: dict[str, Any]
    device: str


#: What came of a round of episodes: episodes, updates, epsilon, loss, greedy, best_greedy, best, bound, seconds.
LogCallback = Callable[[dict[str, Any]], object]


def learning_available() -> bool:
    """Whether policies can be trained here: that needs libtorch. To plan with one does not."""
    return _orasp.learning_obstacle() is None


def training_options() -> list[Option]:
    """The options of :func:`train`.

    >>> import orasp
    >>> orasp.training_options()[0].name
    'episodes'
    """
    return list(options_of(_orasp.training_options()))


def train(
    problem: ProblemLike,
    *,
    seed: int = 1,
    resume: Optional[Policy] = None,
    checkpoint: Optional[Union[str, os.PathLike[str]]] = None,
    checkpoint_every: float = 30,
    log: Optional[LogCallback] = None,
    time_limit: Optional[float] = None,
    memory_limit: Optional[int] = None,
    progress: Optional[ProgressCallback] = None,
    stop: Optional[Stopper] = None,
    objective: Any = None,
    direction: Optional[str] = None,
    max_subassemblies: Optional[int] = None,
    max_moved_parts: Optional[int] = None,
    max_moved_mass: Optional[float] = None,
    **options: OptionValue,
) -> Training:
    """Learns a policy by deep Q-learning.

    ``options`` are those of ``orasp train`` (:func:`training_options`), with underscores: ``episodes=500,
    hidden=[64, 64]``. ``log`` is called after every round of episodes; ``checkpoint`` is a file that gets the
    policy every so many seconds and at the end; ``resume`` goes on from a policy.

    Raises InputError, which says how to get it, where libtorch is missing. A limit and Ctrl-C end it with
    the best policy so far.
    """
    given = load(problem).edited(
        objective=objective,
        direction=direction,
        max_subassemblies=max_subassemblies,
        max_moved_parts=max_moved_parts,
        max_moved_mass=max_moved_mass,
    )
    policy, outcome, record, device, warning = _orasp.train(
        given._engine(),
        option_texts(options),
        whole("seed", seed),
        None if resume is None else resume._file,
        "" if checkpoint is None else os.fspath(checkpoint),
        real("checkpoint_every", checkpoint_every, "positive"),
        log,
        run_of(time_limit, memory_limit, None, progress, stop),
    )
    if warning:
        warn(warning)
    return Training(None if policy is None else Policy(policy), Result(given, outcome, {}), record, device)
