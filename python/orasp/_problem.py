from __future__ import annotations

from orasp import _orasp


class Problem:
    def __init__(self, made: _orasp.Problem) -> None:
        self._made = made

    @property
    def name(self) -> str:
        return self._made.name


def load(source: str) -> Problem:
    return Problem(_orasp.find_problem(source))
