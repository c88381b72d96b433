"""The best order in which robots put a product together or take it apart, with proof.

>>> import orasp
>>> result = orasp.solve("hubble")
>>> result.status, result.reward
('optimal', -0.9902)

The parts of the package:

* problems: :class:`Problem`, :func:`load`, :func:`scenarios`, :func:`import_model`,
  :func:`read_format`, :func:`write_format`
* plans: :func:`solve`, :class:`Result`, :func:`methods`, :func:`obstacle`
* the work as it goes on: :func:`replan`, :class:`Replanner`
* questions: :func:`evaluate`, :func:`explain`, :func:`explain_connection`, :func:`sample`,
  :func:`simulate`, :func:`compare`
* proofs: :meth:`Result.certificate`, :func:`check`
* H as arrays: :func:`graph`, :class:`Graph`, :func:`estimate_graph`
* rewards of your own: :class:`Reward`
* learning: :func:`train`, :class:`Policy`, :class:`GeneralPolicy`, :class:`Environment`, :class:`VectorEnvironment`
* pages and pictures: :func:`report`, :func:`figures`, ``.svg()`` of problems, plans and graphs

What is wrong with an input is an :class:`InputError`, a ValueError with one sentence.
"""

from orasp._certificates import Certificate, Check, check
from orasp._formats import Format, format_text, formats, read_format, write_format
from orasp._graph import Graph, GraphEstimate, GraphSize, estimate_graph, graph
from orasp._learning import GeneralPolicy, Policy, Training, learning_available, train, training_options
from orasp._models import ImportedModel, import_model
from orasp._orasp import InputError, __version__
from orasp._problem import OraspWarning, Problem, ProblemLike, Scenario, load, scenarios
from orasp._questions import (
    Comparison,
    Conflict,
    ConnectionExplanation,
    Evaluation,
    Explanation,
    Sample,
    Simulation,
    Statistics,
    Violation,
    compare,
    evaluate,
    explain,
    explain_connection,
    sample,
    simulate,
)
from orasp._replan import Changes, Replanned, Replanner, replan
from orasp._report import Report, distribution_svg, figures, report, tree_svg
from orasp._reward import ObjectiveLike, Reward, Step, Steps
from orasp._solve import (
    Alternative,
    Expectation,
    FleetStep,
    Method,
    ModelSize,
    Move,
    Operation,
    Option,
    PlanLike,
    PlanStep,
    Progress,
    Result,
    Stopper,
    methods,
    obstacle,
    solve,
    write_model,
)
from orasp.environment import Environment, VectorEnvironment

__all__ = [
    "Alternative",
    "Certificate",
    "Changes",
    "Check",
    "Comparison",
    "Conflict",
    "ConnectionExplanation",
    "Environment",
    "Evaluation",
    "Expectation",
    "Explanation",
    "FleetStep",
    "Format",
    "Graph",
    "GraphEstimate",
    "GraphSize",
    "ImportedModel",
    "InputError",
    "Method",
    "ModelSize",
    "Move",
    "ObjectiveLike",
    "Operation",
    "Option",
    "OraspWarning",
    "PlanLike",
    "PlanStep",
    "GeneralPolicy",
    "Policy",
    "Problem",
    "ProblemLike",
    "Progress",
    "Replanned",
    "Replanner",
    "Report",
    "Result",
    "Reward",
    "Sample",
    "Scenario",
    "Simulation",
    "Statistics",
    "Step",
    "Steps",
    "Stopper",
    "Training",
    "VectorEnvironment",
    "Violation",
    "check",
    "compare",
    "distribution_svg",
    "estimate_graph",
    "evaluate",
    "explain",
    "explain_connection",
    "figures",
    "format_text",
    "formats",
    "graph",
    "import_model",
    "learning_available",
    "load",
    "methods",
    "obstacle",
    "read_format",
    "replan",
    "report",
    "sample",
    "scenarios",
    "simulate",
    "solve",
    "train",
    "training_options",
    "tree_svg",
    "write_format",
    "write_model",
    "__version__",
]
