"""Runs checks and tells of each that fails in one line."""

import sys
import unittest


class PlainResult(unittest.TestResult):
    """Checks that fail, with what they say, without where the program was."""

    def __init__(self):
        super().__init__()
        self.lines = []

    def _add(self, check, error):
        words = " ".join(str(error[1]).split()) or error[0].__name__
        self.lines.append(f"{check.id().rsplit('.', 1)[-1]}: {words[:300]}")

    def addFailure(self, test, err):
        super().addFailure(test, err)
        self._add(test, err)

    def addError(self, test, err):
        super().addError(test, err)
        self._add(test, err)

    def addSubTest(self, test, subtest, err):
        super().addSubTest(test, subtest, err)
        if err is not None:
            self._add(test, err)


def failed_checks(cases):
    """What fails of some TestCases: a line each."""
    result = PlainResult()
    loader = unittest.defaultTestLoader
    unittest.TestSuite(map(loader.loadTestsFromTestCase, cases)).run(result)
    return result.lines, result.testsRun


def run(program, cases):
    """Runs the checks of a program; its exit code."""
    lines, number_run = failed_checks(cases)
    for line in lines:
        print(f"{program}: {line}", file=sys.stderr)
    if not lines:
        print(f"{program}: all {number_run} checks hold", file=sys.stderr)
    return 1 if lines else 0
