"""Environments: a problem as reinforcement learning takes it.

``Environment`` is one episode with the interface of Gymnasium (https://gymnasium.farama.org),
``VectorEnvironment`` thousands of them side by side in NumPy arrays. Which actions are legal, what they earn
and where they lead comes from the library's rules; nothing is worked out here. Gymnasium need not be
installed. Where it is, both are environments of its own classes with spaces of its own; else the spaces are
those of ``orasp.spaces``, which answer the same way.

**Actions.** Action c is to handle connection c, in the order of the problem's file: 0 to connections - 1.
Where the objective looks at the direction in which a piece leaves, each connection has 1 + directions
actions, one after another: the first where nothing moves, then one a direction. Where a plan may end before
nothing is left (a goal with ``"stop": "best"``), the last action is to end it. ``action_names`` lists them
all.

**Observations.** A row of ones and zeros: one column a connection, 1 while it is still to be handled; then,
where the objective looks at what the step before left behind, one column for each value that may be in force
and each place where the last step may have been done. So what is observed is the whole state.
``observation_names`` lists the columns.

**Ends.** An episode is ``terminated`` where its plan is ended, and ``truncated`` at a dead end, where nothing
is legal and connections are left. A dead end earns nothing by itself: a learner that maximises what is earned
must count it as the failure that it is.

>>> environment = Environment("hubble")
>>> observation, info = environment.reset(seed=1)
>>> observation.shape, observation.dtype, int(info["action_mask"].sum())
((19,), dtype('float32'), 9)
>>> total, over = 0.0, False
>>> while not over:
...     action = environment.action_space.sample(info["action_mask"])
...     observation, reward, terminated, truncated, info = environment.step(action)
...     total, over = total + reward, terminated or truncated
>>> terminated, len(info["plan"])
(True, 19)
"""

from __future__ import annotations

import operator
import sys
from typing import TYPE_CHECKING, Any, Callable, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from orasp import _orasp
from orasp._orasp import InputError
from orasp._problem import Problem, ProblemLike, load

if TYPE_CHECKING:
    from orasp.spaces import Box, Discrete, MultiDiscrete
else:
    try:
        from gymnasium.spaces import Box, Discrete, MultiDiscrete
    except ModuleNotFoundError:
        from orasp.spaces import Box, Discrete, MultiDiscrete

__all__ = ["Environment", "VectorEnvironment"]

_MAX_BYTES = 256 << 20


class _Base:
    """What Gymnasium's own classes bring, where they are not there."""

    metadata: dict[str, Any] = {}
    render_mode: Optional[str] = None
    spec: Any = None
    _np_random: Optional[np.random.Generator] = None

    def reset(self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None) -> Any:
        """Begins the random numbers of the environment anew where a seed is given."""
        if seed is not None:
            self._np_random = np.random.default_rng(seed)

    @property
    def np_random(self) -> np.random.Generator:
        """The environment's random numbers."""
        if self._np_random is None:
            self._np_random = np.random.default_rng()
        return self._np_random

    @property
    def unwrapped(self) -> Any:
        """The environment without wrappers: itself."""
        return self

    def close(self) -> None:
        """Nothing is held that must be given back; may be called twice."""

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


if TYPE_CHECKING:

    class _Env(_Base):
        pass

    class _VectorEnv(_Base):
        pass

else:
    try:
        from gymnasium import Env as _Env
        from gymnasium.vector import VectorEnv as _VectorEnv
    except ModuleNotFoundError:
        _Env = _VectorEnv = _Base


class _LegalActions(Discrete):
    """The actions of an environment; without a mask, ``sample`` draws one that is legal now (0 where none is)."""

    def __init__(self, n: int, legal: Callable[[], npt.NDArray[np.int8]]) -> None:
        super().__init__(n)
        self._legal = legal

    def sample(self, mask: Optional[npt.NDArray[np.int8]] = None, **others: Any) -> np.int64:
        if mask is None and not others:
            mask = self._legal()
        return super().sample(mask, **others)

    def __reduce__(self) -> Any:
        return Discrete, (int(self.n),)


class _LegalRows(MultiDiscrete):
    """The actions of many episodes; without a mask, ``sample`` draws some that are legal now (0 where none is)."""

    def __init__(self, n: int, episodes: int, draw: Callable[[int], npt.NDArray[np.int64]]) -> None:
        super().__init__(np.full(episodes, n, np.int64))
        self._draw = draw

    def sample(self, mask: Any = None, **others: Any) -> npt.NDArray[np.int64]:
        if mask is None and not others:
            return self._draw(int(self.np_random.integers(2**63)))
        return super().sample(mask, **others)

    def __reduce__(self) -> Any:
        return MultiDiscrete, (self.nvec,)


class _Arrays:
    """Episodes of the library, and the arrays that they write to."""

    def __init__(
        self, problem: ProblemLike, episodes: int, autoreset: str, dtype: npt.DTypeLike, max_bytes: int
    ) -> None:
        self.problem = load(problem)
        if isinstance(episodes, bool) or not isinstance(episodes, (int, np.integer)) or episodes < 1:
            raise InputError(f"episodes: {episodes!r} is not a number of episodes, which is at least 1")
        if np.dtype(dtype) not in (np.dtype(np.float32), np.dtype(np.uint8)):
            raise InputError(f"observation_dtype: {np.dtype(dtype)} is none of float32 and uint8")
        if max_bytes < 0:
            raise InputError(f"max_bytes: {max_bytes} is below 0")
        made = self.made = _orasp.Episodes(self.problem._engine(), int(episodes), autoreset, max_bytes)
        shape = (episodes, made.observation_size)
        self.observations = np.zeros(shape, dtype)
        self.final_observations = np.zeros(shape, dtype)
        self.masks: npt.NDArray[np.int8] = np.zeros((episodes, made.num_actions), np.int8)
        self.rewards = np.zeros(episodes, np.float64)
        self.terminated = np.zeros(episodes, np.bool_)
        self.truncated = np.zeros(episodes, np.bool_)
        self.returns = np.zeros(episodes, np.float64)
        self.lengths = np.zeros(episodes, np.int64)
        made.write_to(
            self.observations,
            self.final_observations,
            self.masks,
            self.rewards,
            self.terminated,
            self.truncated,
            self.returns,
            self.lengths,
        )
        self.connection_ids = self.problem.connection_ids
        self.assembly = self.problem.direction == "assembly"
        self.action_names: list[str] = [made.action_name(a) for a in range(made.num_actions)]
        self.observation_names: list[str] = [made.column_name(c) for c in range(made.observation_size)]

    def actions_of(self, steps: Sequence[Union[str, int]]) -> list[int]:
        """The actions that are named, or numbered."""
        actions = []
        for i, step in enumerate(steps):
            if isinstance(step, str):
                actions.append(self.action_of(step, f"done[{i}]"))
            else:
                actions.append(_index(step, f"done[{i}]"))
        return actions

    def action_of(self, name: str, place: str) -> int:
        """The number of an action that is named at ``place``."""
        if name not in self.action_names:
            raise InputError(f'{place}: no action "{name}"; action_names lists them')
        return self.action_names.index(name)

    def start(self, options: Optional[dict[str, Any]], known: Sequence[str]) -> None:
        """Looks at the options of a reset, and sets where episodes start."""
        given = options or {}
        for key in given:
            if key not in known:
                raise InputError(f'options: no "{key}"; there is {" and ".join(known)}')
        if "done" in given:
            self.made.start_after(self.actions_of(given["done"]))


def _index(value: Any, place: str) -> int:
    try:
        return operator.index(value)
    except TypeError:
        raise InputError(f"{place}: {value!r} is no whole number") from None


def _checked_seed(seed: Optional[int]) -> Optional[int]:
    if seed is not None and (isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0):
        raise InputError(f"seed: {seed!r} is no whole number from 0")
    return seed


class Environment(_Env):
    """One episode at a time, with the interface of ``gymnasium.Env``.

    ``problem`` is a problem, the name of one that is built in, a file, or what a file says; it is taken as it
    is now. ``render_mode`` is None, "ansi" or "rgb_array". ``observation_dtype`` is float32 or uint8.
    ``max_bytes`` limits what is remembered of states that were met; beyond it all is forgotten and worked out
    again.

    ``observation_space`` is a Box of [0, 1] of shape [observations], ``action_space`` a Discrete of the
    actions. The module's page says what the columns and numbers mean. ``info["action_mask"]`` of ``reset``
    and ``step`` is int8 [actions]: 1 where an action is legal. ``action_space.sample()`` draws among the
    legal ones.

    An action that is not legal is an ``InputError`` that says why, and changes nothing:

    >>> environment = Environment("lattice")
    >>> _ = environment.reset()
    >>> environment.step(environment.action_of("1-2"))[1]
    0.0
    >>> environment.step(environment.action_of("1-2"))
    Traceback (most recent call last):
    ...
    orasp.InputError: action 0: connection "1-2" cannot be handled now: "1-2" was removed before

    Problems whose steps take parts off (``"action": "part"``) are refused: such steps cannot be numbered.
    Attempts that may fail succeed here.
    """

    metadata: dict[str, Any] = {"render_modes": ["ansi", "rgb_array"], "render_fps": 2}

    def __init__(
        self,
        problem: ProblemLike,
        *,
        render_mode: Optional[str] = None,
        observation_dtype: npt.DTypeLike = np.float32,
        max_bytes: int = _MAX_BYTES,
    ) -> None:
        if render_mode not in (None, "ansi", "rgb_array"):
            raise InputError(f'render_mode: "{render_mode}" is none of ansi and rgb_array')
        self.render_mode = render_mode
        self._arrays = _Arrays(problem, 1, "off", observation_dtype, max_bytes)
        self._made = self._arrays.made
        self._over = False
        self._observation: npt.NDArray[Any] = self._arrays.observations[0]
        self._mask: npt.NDArray[np.int8] = self._arrays.masks[0]
        self.observation_space = Box(0, 1, self._observation.shape, observation_dtype)
        self.action_space = _LegalActions(self._made.num_actions, lambda: self._mask)

    @property
    def problem(self) -> Problem:
        """The problem that it is made of."""
        return self._arrays.problem

    @property
    def action_names(self) -> list[str]:
        """What each action is: the connection's id, with its direction where actions have one, or "end"."""
        return self._arrays.action_names

    @property
    def observation_names(self) -> list[str]:
        """What each column of an observation says: "open 1-2", "tool M4", "place 3"."""
        return self._arrays.observation_names

    def action_of(self, name: str) -> int:
        """The number of an action of ``action_names``."""
        return self._arrays.action_of(name, "action")

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None
    ) -> tuple[npt.NDArray[Any], dict[str, Any]]:
        """Begins an episode, and returns what is observed, [observations], and the info.

        ``seed`` begins ``np_random`` anew; nothing that the environment does is random. ``options["done"]``,
        a list of actions by name or number, has this and later episodes begin after these steps; an empty
        list, at the start again.
        """
        super().reset(seed=_checked_seed(seed))
        self._arrays.start(options, ["done"])
        self._made.reset()
        self._over = False
        return self._observation.copy(), {"action_mask": self._mask.copy()}

    def step(self, action: Union[int, np.integer[Any]]) -> tuple[npt.NDArray[Any], float, bool, bool, dict[str, Any]]:
        """Takes an action, and returns what is observed, what was earned, terminated, truncated and the info.

        Where the plan is ended, ``info["plan"]`` has its connections in order.
        """
        number = _index(action, "action")
        if self._over:
            raise InputError("the episode is over; reset the environment before its next step")
        if not 0 <= number < self._mask.shape[0] or not self._mask[number]:
            raise InputError(f"action {number}: {self._made.obstacle(0, number)}")
        reward, terminated, truncated = self._made.step_one(number)
        info: dict[str, Any] = {"action_mask": self._mask.copy()}
        if terminated or truncated:
            self._over = True
            if terminated:
                info["plan"] = self.plan
        return self._observation.copy(), reward, terminated, truncated, info

    @property
    def plan(self) -> list[str]:
        """The connections that the episode has handled, in order."""
        connections: list[str] = self._made.plan(0)[0]
        return connections

    @property
    def directions(self) -> list[Optional[str]]:
        """The directions that its actions chose, one for each of ``plan``; None where actions have none."""
        directions: list[Optional[str]] = self._made.plan(0)[1]
        return directions

    @property
    def total(self) -> float:
        """What the steps of the episode earned so far."""
        total: float = self._made.total(0)
        return total

    def render(self) -> Any:
        """The state as text ("ansi") or as a picture ("rgb_array": uint8 [480, 640, 3]); None without a render mode."""
        if self.render_mode == "ansi":
            return self._text()
        if self.render_mode == "rgb_array":
            return self._picture()
        return None

    def _text(self) -> str:
        plan, left = self.plan, self._made.open(0)
        legal = [name for name, flag in zip(self.action_names, self._mask) if flag]
        end = "" if not self._over else ": the plan is ended" if not legal and not left else ": a dead end"
        return (
            f"{self.problem.name}: {len(plan)} steps, earned {self.total:.6g}{end}\n"
            f"handled  {' '.join(plan) or '-'}\n"
            f"open     {' '.join(left) or '-'}\n"
            f"legal    {' '.join(legal) or '-'}\n"
        )

    def _picture(self) -> npt.NDArray[np.uint8]:
        from orasp._picture import picture

        positions, ends = self._made.layout()
        ways = max(1, self._mask.shape[0] // max(1, len(ends)))
        legal = self._mask[: ways * len(ends)].reshape(len(ends), ways).any(axis=1)
        left = np.isin(self._arrays.connection_ids, self._made.open(0))
        return picture(positions, ends, left != self._arrays.assembly, legal)


class VectorEnvironment(_VectorEnv):
    """Thousands of episodes side by side, with the interface of ``gymnasium.vector.VectorEnv``.

    ``autoreset`` says what becomes of an episode that is over: "same_step" begins the next one in the step
    that ends it, so that what is observed is its start, and the end stands in ``info["final_obs"]``;
    "next_step" begins it in the next step, whatever the action is, which earns 0; "disabled" leaves it until
    ``reset(options={"reset_mask": ...})``. The other parameters are those of ``Environment``.

    **Arrays.** Every step writes to the same arrays, and returns them: they hold what the last step or reset
    said, for as long as anything refers to them, and the next one overwrites them. Copy what is to be kept;
    with ``copy=True`` the environment does so. Observations are float32 or uint8 [episodes, observations],
    masks int8 [episodes, actions], rewards float64 [episodes], terminated and truncated bool [episodes].

    >>> environment = VectorEnvironment("hubble", 1024)
    >>> observations, info = environment.reset(seed=1)
    >>> for _ in range(19):
    ...     step = environment.step(environment.sample_actions())
    >>> observations, rewards, terminated, truncated, info = step
    >>> bool(terminated.all()), info["episode"]["r"].shape, info["action_mask"].shape
    (True, (1024,), (1024, 19))
    >>> len(environment.best_plan)
    19

    What is remembered of states is shared by all episodes, so a state's actions are worked out once. One call
    at a time: during a step the lock of the interpreter is released.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": "same_step"}

    def __init__(
        self,
        problem: ProblemLike,
        episodes: int,
        *,
        autoreset: str = "same_step",
        observation_dtype: npt.DTypeLike = np.float32,
        copy: bool = False,
        max_bytes: int = _MAX_BYTES,
    ) -> None:
        if autoreset not in ("same_step", "next_step", "disabled"):
            raise InputError(f'autoreset: "{autoreset}" is none of same_step, next_step and disabled')
        self._arrays = _Arrays(problem, episodes, autoreset, observation_dtype, max_bytes)
        self._made = self._arrays.made
        self.num_envs = int(episodes)
        self.autoreset = autoreset
        self.copy = copy
        self.closed = False
        self.metadata = {"render_modes": [], "autoreset_mode": _autoreset_mode(autoreset)}
        size, actions = self._made.observation_size, self._made.num_actions
        self.single_observation_space = Box(0, 1, (size,), observation_dtype)
        self.single_action_space = Discrete(actions)
        self.observation_space = Box(0, 1, (self.num_envs, size), observation_dtype)
        self.action_space = _LegalRows(actions, self.num_envs, self._draw)
        self._seeded = False

    @property
    def problem(self) -> Problem:
        """The problem that it is made of."""
        return self._arrays.problem

    @property
    def action_names(self) -> list[str]:
        """As ``Environment.action_names``."""
        return self._arrays.action_names

    @property
    def observation_names(self) -> list[str]:
        """As ``Environment.observation_names``."""
        return self._arrays.observation_names

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None
    ) -> tuple[npt.NDArray[Any], dict[str, Any]]:
        """Begins all episodes, and returns what is observed and the info, with ``info["action_mask"]``.

        ``seed`` is that of ``sample_actions``; nothing else is random. ``options["reset_mask"]``, bool
        [episodes], begins only those where it is true. ``options["done"]`` is that of ``Environment.reset``.
        """
        super().reset(seed=_checked_seed(seed))
        if seed is not None:
            self._seed()
        self._arrays.start(options, ["done", "reset_mask"])
        which = (options or {}).get("reset_mask")
        if which is not None:
            which = np.ascontiguousarray(which)
            if which.dtype != np.bool_ or which.shape != (self.num_envs,):
                raise InputError(
                    f"reset_mask: an array of {which.dtype} {list(which.shape)} is given, bool [{self.num_envs}] is needed"
                )
        self._made.reset(which)
        return self._own(self._arrays.observations), {"action_mask": self._own(self._arrays.masks)}

    def step(
        self, actions: npt.ArrayLike
    ) -> tuple[npt.NDArray[Any], npt.NDArray[np.float64], npt.NDArray[np.bool_], npt.NDArray[np.bool_], dict[str, Any]]:
        """Takes one action in each episode, whole numbers [episodes], and returns the arrays and the info.

        ``info["action_mask"]`` has the masks. Where an episode ended, ``info["_episode"]``, bool [episodes],
        says which did; ``info["episode"]`` has what each earned, "r", float64 [episodes], and its steps, "l",
        int64 [episodes]; and ``info["final_obs"]``, of the shape of the observations, what was observed at
        its end. Rows of other episodes mean nothing there.

        An action that is not legal is an ``InputError`` that names the episode and says why; no episode changes then.
        """
        taken = np.asarray(actions)
        if taken.shape != (self.num_envs,) or taken.dtype.kind not in "iu":
            raise InputError(
                f"actions: an array of {taken.dtype} {list(taken.shape)} is given, "
                f"whole numbers [{self.num_envs}] are needed"
            )
        ended = self._made.step(np.ascontiguousarray(taken, np.int64))
        arrays, own = self._arrays, self._own
        info: dict[str, Any] = {"action_mask": own(arrays.masks)}
        if ended:
            over = arrays.terminated | arrays.truncated
            info["final_obs"] = own(arrays.final_observations)
            info["_final_obs"] = over
            info["episode"] = {"r": own(arrays.returns), "l": own(arrays.lengths)}
            info["_episode"] = over
        return own(arrays.observations), own(arrays.rewards), own(arrays.terminated), own(arrays.truncated), info

    def sample_actions(self, out: Optional[npt.NDArray[np.int64]] = None) -> npt.NDArray[np.int64]:
        """A legal action for each episode, int64 [episodes], each equally likely; 0 where none is.

        ``out``, int64 [episodes], is written and returned where it is given.
        """
        if not self._seeded:
            self._seed()
        drawn = np.empty(self.num_envs, np.int64) if out is None else out
        if drawn.shape != (self.num_envs,) or drawn.dtype != np.int64 or not drawn.flags.c_contiguous:
            raise InputError(
                f"out: an array of {drawn.dtype} {list(drawn.shape)} is given, int64 [{self.num_envs}] in one piece is needed"
            )
        self._made.sample(drawn)
        return drawn

    def plan(self, episode: int) -> list[str]:
        """The connections that an episode has handled, in order."""
        if not 0 <= episode < self.num_envs:
            raise InputError(f"episode: there is no {episode}; episodes are 0 to {self.num_envs - 1}")
        connections: list[str] = self._made.plan(episode)[0]
        return connections

    @property
    def best_reward(self) -> Optional[float]:
        """What the best plan of all episodes since the start was last set earned; None before the first."""
        best = self._made.best()
        return None if best is None else float(best[0])

    @property
    def best_plan(self) -> Optional[list[str]]:
        """Its connections in order."""
        best = self._made.best()
        return None if best is None else list(best[1][0])

    @property
    def best_directions(self) -> Optional[list[Optional[str]]]:
        """The directions that its actions chose; None where actions have none."""
        best = self._made.best()
        return None if best is None else list(best[1][1])

    @property
    def statistics(self) -> dict[str, int]:
        """How many states were expanded, how many are remembered, their bytes, and how often all were forgotten."""
        made = self._made
        return {
            "expanded": made.expanded,
            "remembered": made.remembered,
            "bytes": made.bytes,
            "forgotten": made.forgotten,
        }

    def _own(self, array: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return array.copy() if self.copy else array

    def _seed(self) -> None:
        self._made.seed(int(self.np_random.integers(2**63)))
        self._seeded = True

    def _draw(self, seed: int) -> npt.NDArray[np.int64]:
        drawn = np.empty(self.num_envs, np.int64)
        self._made.sample(drawn, seed)
        return drawn


def _autoreset_mode(autoreset: str) -> Any:
    """The name as Gymnasium has it, where it is installed and has one."""
    vector = sys.modules.get("gymnasium.vector")
    modes = getattr(vector, "AutoresetMode", None)
    return autoreset if modes is None else modes[autoreset.upper()]
