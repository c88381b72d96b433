"""Proofs that others can check: certificates, and the verdict on them."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Optional, Union

from orasp import _orasp
from orasp._content import json_text
from orasp._problem import ProblemLike, load
from orasp._solve import PlanLike, ProgressCallback, Stopper, file_text, plan_text, run_of, warn_of_another_problem


@dataclass(frozen=True)
class Certificate:
    """Why no plan of a problem earns more than a bound, or why there is none: ``text`` is the file, format
    orasp-certificate/1."""

    text: str

    @property
    def kind(self) -> str:
        """What proves it: "sizes", "pieces", "states", "waits" or "locked"."""
        return str(self.to_dict()["kind"])

    @property
    def bound(self) -> Optional[float]:
        """No plan earns more; None where there is none."""
        bound = self.to_dict().get("bound")
        return None if bound is None else float(bound)

    def to_dict(self) -> dict[str, Any]:
        return dict(json.loads(self.text))

    def save(self, file: Union[str, os.PathLike[str]]) -> None:
        Path(file).write_text(self.text, encoding="utf-8")

    def __repr__(self) -> str:
        claim = "there is no plan" if self.bound is None else f"no plan earns more than {self.bound:.6g}"
        return f"<orasp.Certificate {self.kind}: {claim}>"


@dataclass(frozen=True)
class Check:
    """The verdict on a certificate.

    ``proved``: the plan is legal and none earns more than it by more than ``tolerance``, or, where
    ``claim`` is "infeasible", there is none; ``fault`` says in one sentence why not. ``inequalities`` were
    verified.
    """

    proved: bool
    claim: str
    kind: str
    reward: Optional[float]
    bound: Optional[float]
    tolerance: float
    inequalities: int
    fault: Optional[str] = None

    def to_dict(self) -> dict[str, Any]:
        """As ``orasp check --json`` prints it."""
        found = {name: value for name, value in vars(self).items() if name != "fault"}
        return found if self.fault is None else found | {"fault": self.fault}


def check(
    problem: ProblemLike,
    plan: Optional[PlanLike],
    certificate: Union[Certificate, str, os.PathLike[str], Mapping[str, Any]],
    *,
    time_limit: Optional[float] = None,
    progress: Optional[ProgressCallback] = None,
    stop: Optional[Stopper] = None,
    **changes: Any,
) -> Check:
    """Checks a certificate: that no plan earns more than this one, or, with None for the plan, that there
    is none. The check shares nothing with the planners and their bounds.

    ``certificate`` is what :meth:`Result.certificate` gave, a file (a name), or what it says (a dict);
    ``plan`` and ``changes`` are those of :func:`evaluate`. Raises InputError where something is none of
    these, or was made for another problem.

    >>> import orasp
    >>> result = orasp.solve("4piece")
    >>> orasp.check("4piece", result, result.certificate()).proved
    True
    >>> orasp.check("4piece", ["1-2", "3-4", "2-3", "1-4"], result.certificate()).reward
    0.557
    """
    given = load(problem).edited(**changes)
    if isinstance(certificate, Certificate):
        text = certificate.text
    elif isinstance(certificate, Mapping):
        text = json_text(certificate)
    else:
        text = file_text(os.fspath(certificate))
    run = run_of(time_limit, None, None, progress, stop)
    proved, kind, reward, bound, tolerance, inequalities, fault, differs = _orasp.check(
        given._engine(), None if plan is None else plan_text(plan), text, run
    )
    warn_of_another_problem(differs)
    claim = "infeasible" if plan is None else "optimal"
    return Check(proved, claim, kind, reward, bound, tolerance, inequalities, None if proved else fault)
