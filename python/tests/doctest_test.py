"""The examples in docstrings and in docs/python.md."""
import doctest
import importlib
import pkgutil
import unittest

import orasp
from program import ROOT


def load_tests(loader, tests, pattern):
    del loader, pattern
    tests.addTests(doctest.DocTestSuite(orasp, optionflags=doctest.NORMALIZE_WHITESPACE))
    for module in pkgutil.iter_modules(orasp.__path__):
        if module.name.startswith("_") and module.name != "_orasp":
            tests.addTests(doctest.DocTestSuite(importlib.import_module(f"orasp.{module.name}"),
                                                optionflags=doctest.NORMALIZE_WHITESPACE))
    page = ROOT / "docs" / "python.md"
    text = "\n".join("" if line.startswith("```") else line for line in page.read_text(encoding="utf-8").split("\n"))
    examples = doctest.DocTestParser().get_doctest(text, {}, "python.md", str(page), 0)
    tests.addTest(doctest.DocTestCase(examples, optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS))
    return tests


if __name__ == "__main__":
    unittest.main()
