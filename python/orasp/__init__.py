"""The best order in which robots put a product together or take it apart, with proof."""

from orasp._orasp import InputError
from orasp._problem import Problem, load
from orasp._solve import Result, solve
from orasp.environment import Environment, VectorEnvironment

__all__ = ["Environment", "InputError", "Problem", "Result", "VectorEnvironment", "load", "solve"]
