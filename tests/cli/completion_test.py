#!/usr/bin/env python3
"""Tests the completion of bash.

    tests/cli/completion_test.py PROGRAM [unittest's arguments]
"""
import re
import subprocess
import unittest

from program import CHAIN, PROGRAM, Case, commands, options_of, orasp


class Completion(Case):
    def complete(self, *words):
        script = ('source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _orasp 2>/dev/null; '
                  'printf "%s\\n" "${COMPREPLY[@]}"')
        completion = self.file("completion.bash", orasp("completion", "bash").out)
        done = subprocess.run(["bash", "--norc", "-c", script, "bash", completion, PROGRAM, *words], capture_output=True,
                              text=True, cwd=self.folder, timeout=60)
        self.assertEqual(done.stderr, "")
        return done.stdout.split()

    def test_commands_options_methods_scenarios_and_files(self):
        self.file("hubble-2.json", CHAIN)
        for words, expected in [
            (["so"], ["solve"]),
            (["solve", "hub"], ["hubble", "hubble-free", "hubble-upc", "hubble-2.json"]),
            (["solve", "gri"], ["grid:"]),
            (["solve", "hubble", "--meth"], ["--method"]),
            (["solve", "hubble", "--method", "val"], ["value-iteration"]),
            (["solve", "hubble", "--method", "=", "val"], ["value-iteration"]),
            (["compare", "hubble", "--methods", "greedy,dij"], ["greedy,dijkstra"]),
            (["solve", "hubble", "--bound", ""], ["none", "connections", "sizes", "parts", "best"]),
            (["solve", "hubble", "--objective", "cub"], ["cubesat", "cubesat_zone"]),
            (["solve", "hubble", "--direction", "a"], ["assembly"]),
            (["solve", "hubble", "-o", "hub"], ["hubble-2.json"]),
            (["evaluate", "hubble", "hubble-2"], ["hubble-2.json"]),
            (["graph", "hubble", "--s"], ["--svg", "--sites"]),
            (["sample", "hubble", "--se"], ["--seed", "--sequences"]),
            (["scenarios", "la"], ["lattice"]),
            (["completion", ""], ["bash", "--help"]),
            (["solve", "hubble", "--seed", ""], []),
        ]:
            with self.subTest(words=words):
                self.assertEqual(self.complete(*words), expected)

    def test_every_option_of_a_command_is_offered(self):
        for command in commands():
            if command != "completion":
                with self.subTest(command=command):
                    offered = set(self.complete(command, "--"))
                    # Other commands' options stand in the examples of a help text, never the reverse.
                    self.assertLessEqual(offered, set(options_of(command)))
                    listed = re.findall(r"^  (?:-\w )?(--[a-z-]+)", orasp(command, "--help").out, re.MULTILINE)
                    self.assertEqual(set(listed), offered)


if __name__ == "__main__":
    unittest.main()
