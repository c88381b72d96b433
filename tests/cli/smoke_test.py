#!/usr/bin/env python3
"""Runs the marked tests of the other files: @smoke, for a build with the address sanitizer, or @threads with --threads.

    tests/cli/smoke_test.py PROGRAM [--threads]
"""
import importlib
import sys
import unittest
from pathlib import Path

import program  # takes PROGRAM from the command line


def marked(mark):
    suite = unittest.TestSuite()
    for file in sorted(Path(program.__file__).parent.glob("*_test.py")):
        if file.stem in ("smoke_test", "paper_test"):
            continue
        for group in unittest.defaultTestLoader.loadTestsFromModule(importlib.import_module(file.stem)):
            for test in group:
                if getattr(getattr(test, test._testMethodName), mark, False):
                    suite.addTest(test)
    return suite


if __name__ == "__main__":
    if sys.argv[1:] not in ([], ["--threads"]):
        sys.exit(__doc__)
    tests = marked("threads" if sys.argv[1:] else "smoke")
    if tests.countTestCases() == 0:
        sys.exit("no test is marked")
    sys.exit(not unittest.TextTestRunner(verbosity=2).run(tests).wasSuccessful())
