#!/usr/bin/env python3
"""Tests what is wrong with the words of a command line, help, version and man page.

    tests/cli/usage_test.py PROGRAM [unittest's arguments]
"""
import json
import re
import unittest

from program import ROOT, Case, commands, methods, options_of, orasp, smoke


class Usage(Case):
    def test_what_is_wrong_with_the_words_is_said_in_a_sentence(self):
        for words, sentence in [
            ("slove", r'unknown command "slove"; did you mean "solve"\?'),
            ("frobnicate", r'unknown command "frobnicate"; `orasp --help`'),
            ("--verison", r'unknown option "--verison"; did you mean "--version"\?'),
            ("solve", r"PROBLEM is missing; `orasp solve --help`"),
            ("compare", r"PROBLEM is missing"),
            ("evaluate hubble", r"PLAN is missing"),
            ("completion", r"SHELL is missing"),
            ("completion fish", r'no completion for the shell "fish"'),
            ("solve hubble --metod greedy", r'unknown option "--metod"; did you mean "--method"\?'),
            ("solve --metod=greedy hubble", r'unknown option "--metod"; did you mean "--method"\?'),
            ("solve hubble -x", r'unknown option "-x"'),
            ("solve hubble lattice", r'unexpected argument "lattice"'),
            ("solve hubbel", r'no problem "hubbel": .*; did you mean "hubble"\?'),
            ("solve xyzzy", r'no problem "xyzzy": .*`orasp scenarios`'),
            ("solve grid:4", r'"grid:4".*grid:RxC'),
            ("solve hubble --method gredy", r'unknown method "gredy"; .*; did you mean "greedy"\?'),
            ("compare hubble --methods greedy,radnom", r'unknown method "radnom"; .*; did you mean "random"\?'),
            ("compare hubble --methods greedy,", r'unknown method ""'),
            ("solve hubble --seed", r"--seed needs a value, N"),
            ("solve hubble -o", r"--output needs a value, FILE"),
            ("solve hubble --quiet=3", r"--quiet takes no value"),
            ("solve hubble --seed x", r'--seed: "x" is not a whole number from 0 to 18446744073709551615'),
            ("solve hubble --seed -1", r'--seed: "-1" is not a whole number'),
            ("solve hubble --seed 1.5", r'--seed: "1.5" is not a whole number'),
            ("solve hubble --seed 18446744073709551616", r"is not a whole number"),
            ("solve hubble --threads 0", r'--threads: "0" is not a whole number from 1'),
            ("solve hubble --time-limit 0", r'--time-limit: "0" is not a number above 0'),
            ("solve hubble --time-limit nan", r'--time-limit: "nan" is not a number above 0'),
            ("solve hubble --time-limit inf", r'--time-limit: "inf" is not a number above 0'),
            ("solve hubble --memory-limit -5", r'--memory-limit: "-5" is not a whole number'),
            ("solve hubble --max-moved-mass -1", r'--max-moved-mass: "-1" is not a number of 0 or more'),
            ("solve hubble --objective cubsat", r'no objective "cubsat": .*; did you mean "cubesat"\?'),
            ("solve hubble --objective sum", r'"sum"'),
            ("solve hubble --direction up", r'unknown direction "up"; it is disassembly or assembly'),
            ("solve hubble --epsilon 1 --method greedy", r"--epsilon belongs to the method value-iteration"),
            ("solve hubble --sweep-order up --method value-iteration", r'"up" is none of layers, textbook'),
            ("solve hubble --bound best", r"--bound belongs to the methods orasp-search, a-star, beam and q-learning, not to auto"),
            ("solve hubble --bound best --method dijkstra", r"--bound belongs to .*, not to dijkstra"),
            ("solve hubble --bound bst --method a-star", r'--bound: "bst" is none of none, connections, sizes, parts, best; did you mean "best"'),
            ("solve hubble --method a-star --bound", r"--bound needs a value, BOUND"),
            ("solve hubble --bound none --objective indexed --method beam", r"beam needs a bound, and 'none' knows nothing.*'best'"),
            ("evaluate - -", r"PROBLEM and PLAN cannot both be read from standard input"),
            ("solve hubble --alternatives 0", r'--alternatives: "0" is not a whole number from 1 to 1000000'),
            ("explain hubble --connection 99-1", r'--connection: no connection "99-1"'),
            ("explain hubble --plan p.json", r"--plan needs --connection"),
            ("explain hubble --connection 1-2 --step 2", r"--step needs --plan"),
            ("explain - --connection 1-2 --plan -", r"PROBLEM and --plan cannot both be read from standard input"),
            ("explain hubble --connection 1-2 --plan none.json --step 0", r'--step: "0" is not a whole number from 1'),
            ("compare - -", r"only one PROBLEM can be read from standard input"),
            ("compare hubble --csv --json", r"only one of --json, --csv and --markdown"),
            ("graph hubble --json --dot -", r"only one of --json, --dot - and --svg -"),
            ("sample hubble -n 0", r'--count: "0" is not a whole number from 1'),
            ("scenarios hubbel", r'"hubbel".*did you mean "hubble"\?'),
        ]:
            with self.subTest(words=words):
                answer = orasp(*words.split())
                self.check_sentence(answer)
                self.assertRegex(answer.error, sentence)

    @smoke
    def test_no_words_at_all_print_the_usage_as_an_error(self):
        self.check(orasp(), 30, out=r"\A\Z", error=r"Usage: orasp COMMAND")

    def test_an_empty_value_is_no_value(self):
        self.check_sentence(orasp("solve", "hubble", "-o", ""))

    def test_help_and_version_are_results(self):
        self.check(orasp("--help"), 0, out=r"Commands:\n  solve ", error=r"\A\Z")
        self.check(orasp("--version"), 0, out=r"\Aorasp \d+\.\d+\.\d+\n\Z", error=r"\A\Z")
        for command in commands():
            with self.subTest(command=command):
                answer = orasp(command, "--help")
                self.check(answer, 0, out=r"\nExamples:\n  ", error=r"\A\Z")
                self.assertIn("Exit codes:", answer.out)
                self.assertEqual(orasp(command, "-h").out, answer.out)
                self.assertLessEqual(max(map(len, answer.out.splitlines())), 100)

    def test_every_option_of_the_help_says_its_default(self):
        for command in commands():
            entries = re.findall(r"^  (-.*(?:\n   .*)*)", orasp(command, "--help").out, re.MULTILINE)
            self.assertTrue(entries)
            for entry in entries:
                if not entry.startswith("-h"):
                    with self.subTest(command=command, entry=entry):
                        self.assertRegex(entry, r"\(default:")

    def test_the_last_of_a_repeated_option_counts(self):
        answer = orasp("solve", "4brick", "--method", "greedy", "--method", "dijkstra", "--json")
        self.assertEqual(json.loads(answer.out)["method"], "dijkstra")

    def test_man_page_and_completion_name_every_command_option_and_method(self):
        manual = (ROOT / "docs/orasp.1").read_text(encoding="utf-8").replace("\\-", "-")
        script = orasp("completion", "bash").out
        for word in commands() + methods():
            with self.subTest(word=word):
                self.assertRegex(manual, rf"(?m)\b{re.escape(word)}\b")
                self.assertRegex(script, rf"\b{re.escape(word)}\b")
        for command in commands():
            for option in options_of(command):
                with self.subTest(command=command, option=option):
                    self.assertRegex(manual, rf"{option}\b")
                    self.assertRegex(script, rf"{option}\b")


if __name__ == "__main__":
    unittest.main()
