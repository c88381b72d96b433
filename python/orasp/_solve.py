from __future__ import annotations

from orasp import _orasp
from orasp._problem import Problem, load


class Result:
    def __init__(self, outcome: _orasp.Outcome) -> None:
        self._outcome = outcome

    @property
    def reward(self) -> float:
        return self._outcome.reward

    @property
    def status(self) -> str:
        return self._outcome.status


def solve(problem: Problem | str, method: str = "auto", *, seed: int = 1, **options: object) -> Result:
    made = load(problem) if isinstance(problem, str) else problem
    texts = {name.replace("_", "-"): str(value) for name, value in options.items()}
    return Result(_orasp.solve(made._made, method, texts, seed))
