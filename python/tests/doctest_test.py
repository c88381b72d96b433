"""The examples in docstrings."""
import doctest
import importlib
import pkgutil
import unittest

import orasp


def load_tests(loader, tests, pattern):
    del loader, pattern
    tests.addTests(doctest.DocTestSuite(orasp, optionflags=doctest.NORMALIZE_WHITESPACE))
    for module in pkgutil.iter_modules(orasp.__path__):
        if module.name.startswith("_") and module.name != "_orasp":
            tests.addTests(doctest.DocTestSuite(importlib.import_module(f"orasp.{module.name}"),
                                                optionflags=doctest.NORMALIZE_WHITESPACE))
    return tests


if __name__ == "__main__":
    unittest.main()
