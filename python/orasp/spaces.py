"""Spaces: which actions and observations an environment has.

They answer as those of Gymnasium (https://gymnasium.farama.org/api/spaces/) do, and serve where it is not
installed. Where it is, ``orasp.Environment`` and ``orasp.VectorEnvironment`` have Gymnasium's own.

>>> import numpy as np
>>> actions = Discrete(3, seed=1)
>>> actions.contains(2), actions.contains(3), 0 in actions
(True, False, True)
>>> int(actions.sample(mask=np.array([0, 0, 1], dtype=np.int8)))
2
>>> Box(0, 1, (2, 2), np.float32).shape
(2, 2)
"""

from __future__ import annotations

from typing import Any, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

__all__ = ["Box", "Discrete", "MultiDiscrete", "Space"]

Seed = Union[int, np.random.Generator, None]


class Space:
    """What a value may be: the base of the others.

    ``shape`` is the shape of one value and ``dtype`` its type.
    """

    def __init__(self, shape: Sequence[int], dtype: npt.DTypeLike, seed: Seed = None) -> None:
        self.shape = tuple(int(size) for size in shape)
        self.dtype = np.dtype(dtype)
        self._np_random: Optional[np.random.Generator] = None
        if isinstance(seed, np.random.Generator):
            self._np_random = seed
        elif seed is not None:
            self.seed(seed)

    @property
    def np_random(self) -> np.random.Generator:
        """The random numbers that ``sample`` draws by; where no seed was given, from the system."""
        if self._np_random is None:
            self.seed()
        assert self._np_random is not None
        return self._np_random

    def seed(self, seed: Optional[int] = None) -> int:
        """Begins the random numbers anew, and returns the seed."""
        if seed is None:
            seed = int(np.random.SeedSequence().generate_state(1)[0])
        self._np_random = np.random.default_rng(seed)
        return seed

    def sample(self) -> Any:
        """A random value."""
        raise NotImplementedError

    def contains(self, x: Any) -> bool:
        """Whether ``x`` is such a value."""
        raise NotImplementedError

    def __contains__(self, x: Any) -> bool:
        return self.contains(x)


class Box(Space):
    """Arrays of numbers from ``low`` to ``high``, both included, of one shape."""

    def __init__(
        self, low: float, high: float, shape: Sequence[int], dtype: npt.DTypeLike = np.float32, seed: Seed = None
    ) -> None:
        super().__init__(shape, dtype, seed)
        self.low = np.full(self.shape, low, self.dtype)
        self.high = np.full(self.shape, high, self.dtype)

    def sample(self) -> npt.NDArray[Any]:
        """An array of which each number is equally likely anywhere between its bounds."""
        if self.dtype.kind == "f":
            return self.np_random.uniform(self.low, self.high, self.shape).astype(self.dtype)
        whole = self.np_random.integers(self.low.astype(np.int64), self.high.astype(np.int64), self.shape, endpoint=True)
        return whole.astype(self.dtype)

    def contains(self, x: Any) -> bool:
        if not isinstance(x, np.ndarray):
            return False
        fits = np.can_cast(x.dtype, self.dtype) and x.shape == self.shape
        return bool(fits and np.all(x >= self.low) and np.all(x <= self.high))

    def __repr__(self) -> str:
        return f"Box({self.low.min(initial=0)}, {self.high.max(initial=0)}, {self.shape}, {self.dtype})"

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Box)
            and self.dtype == other.dtype
            and np.array_equal(self.low, other.low)
            and np.array_equal(self.high, other.high)
        )


class Discrete(Space):
    """The whole numbers 0 to n - 1."""

    def __init__(self, n: int, seed: Seed = None) -> None:
        super().__init__((), np.int64, seed)
        self.n = np.int64(n)
        self.start = np.int64(0)

    def sample(self, mask: Optional[npt.NDArray[np.int8]] = None) -> np.int64:
        """A number, each equally likely; with a ``mask``, int8 [n], one of those where it is 1, and 0 where it is nowhere."""
        if mask is None:
            return np.int64(self.np_random.integers(self.n))
        allowed = np.flatnonzero(_checked_mask(mask, (int(self.n),)))
        return np.int64(self.np_random.choice(allowed)) if allowed.size else self.start

    def contains(self, x: Any) -> bool:
        if isinstance(x, (np.generic, np.ndarray)):
            if not np.issubdtype(x.dtype, np.integer) or x.shape != ():
                return False
        elif not isinstance(x, int):
            return False
        return bool(0 <= x < self.n)

    def __repr__(self) -> str:
        return f"Discrete({self.n})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Discrete) and bool(self.n == other.n)


class MultiDiscrete(Space):
    """Rows of whole numbers, of which number i is one of 0 to nvec[i] - 1."""

    def __init__(self, nvec: Sequence[int] | npt.NDArray[np.int64], seed: Seed = None) -> None:
        self.nvec = np.array(nvec, dtype=np.int64)
        super().__init__(self.nvec.shape, np.int64, seed)

    def sample(self, mask: Optional[Sequence[npt.NDArray[np.int8]]] = None) -> npt.NDArray[np.int64]:
        """A row, each equally likely; with ``mask``, one of int8 [nvec[i]] for each number, as ``Discrete.sample``."""
        if mask is None:
            return self.np_random.integers(self.nvec, dtype=np.int64)
        row = np.zeros(self.shape, np.int64)
        for i, one in enumerate(mask):
            allowed = np.flatnonzero(_checked_mask(one, (int(self.nvec[i]),)))
            if allowed.size:
                row[i] = self.np_random.choice(allowed)
        return row

    def contains(self, x: Any) -> bool:
        if not isinstance(x, np.ndarray) or not np.issubdtype(x.dtype, np.integer) or x.shape != self.shape:
            return False
        return bool(np.all(x >= 0) and np.all(x < self.nvec))

    def __repr__(self) -> str:
        return f"MultiDiscrete({self.nvec})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, MultiDiscrete) and np.array_equal(self.nvec, other.nvec)


def _checked_mask(mask: npt.NDArray[np.int8], shape: Sequence[int]) -> npt.NDArray[np.int8]:
    assert isinstance(mask, np.ndarray), f"a mask is an array, not {type(mask)}"
    assert mask.dtype == np.int8, f"a mask is of type int8, not {mask.dtype}"
    assert mask.shape == tuple(shape), f"a mask is of shape {tuple(shape)}, not {mask.shape}"
    assert np.all((mask == 0) | (mask == 1)), "a mask is 0 or 1 everywhere"
    return mask
