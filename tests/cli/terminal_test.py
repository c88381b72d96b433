#!/usr/bin/env python3
"""Tests progress and colour on a terminal.

    tests/cli/terminal_test.py PROGRAM [unittest's arguments]
"""
import os
import pty
import subprocess
import unittest

from program import ENDLESS, PROGRAM, Case, orasp, smoke, threads


class Terminal(Case):
    def on_terminal(self, *arguments, environment=None):
        """What the program writes where standard output and standard error are terminals: (code, out, error)."""
        ends = [pty.openpty(), pty.openpty()]
        process = subprocess.Popen([PROGRAM, *arguments], stdin=subprocess.DEVNULL, stdout=ends[0][1], stderr=ends[1][1],
                                   env=dict(os.environ, TERM="xterm", **(environment or {})))
        texts = []
        for _, inner in ends:
            os.close(inner)
        code = process.wait(timeout=60)
        for outer, _ in ends:
            text = b""
            try:
                while piece := os.read(outer, 65536):
                    text += piece
            except OSError:
                pass  # Linux's word for the end of a terminal
            os.close(outer)
            texts.append(text.decode())
        return code, *texts

    @threads
    def test_progress_is_shown_after_a_second_and_cleared(self):
        code, _, error = self.on_terminal(*ENDLESS, "--time-limit", "2")
        self.assertEqual(code, 20)
        self.assertRegex(error, r"\r\x1b\[KInternational Space Station, orasp-search: ")
        self.assertTrue(error.endswith("\r\x1b[K"))
        self.assertEqual(self.on_terminal(*ENDLESS, "--time-limit", "2", "--quiet")[2], "")
        self.assertEqual(self.on_terminal("solve", "hubble")[2], "")
        self.assertEqual(orasp(*ENDLESS, "--time-limit", "2").error, "")

    @smoke
    def test_colour_only_on_a_terminal_that_wants_it(self):
        self.assertIn("\x1b[32moptimal\x1b[0m", self.on_terminal("solve", "4brick")[1])
        self.assertNotIn("\x1b", self.on_terminal("solve", "4brick", environment={"NO_COLOR": "1"})[1])
        self.assertNotIn("\x1b", orasp("solve", "4brick").out)


if __name__ == "__main__":
    unittest.main()
