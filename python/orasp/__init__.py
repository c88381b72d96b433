"""The best order in which robots put a product together or take it apart, with proof."""

from orasp._orasp import InputError
from orasp._problem import Problem, load
from orasp._solve import Result, solve

__all__ = ["InputError", "Problem", "Result", "load", "solve"]
