#!/usr/bin/env python3
"""Tests the program as a user types it: exit codes, messages, files, streams, signals.

    tests/cli/cli_test.py PROGRAM [unittest's arguments]
"""
import csv
import io
import json
import os
import pty
import re
import resource
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
PROGRAM = ""
# A search that no machine finishes: ORASP Search on 31 connections without constraints.
ENDLESS = ["solve", "iss", "--method", "orasp-search", "--bound", "none"]


class Answer:
    def __init__(self, code, out, error):
        self.code, self.out, self.error = code, out, error


def orasp(*arguments, stdin="", environment=None, **options):
    """Runs the program; `stdin` is text or bytes."""
    data = stdin if isinstance(stdin, bytes) else stdin.encode()
    done = subprocess.run([PROGRAM, *arguments], input=data, capture_output=True, timeout=300,
                          env=None if environment is None else dict(os.environ, **environment), **options)
    return Answer(done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace"))


def assembly(connections, **more):
    """A problem file of parts "1", "2", ... joined by pairs such as "1-2"."""
    pairs = [connection.split("-") for connection in connections]
    parts = sorted({part for pair in pairs for part in pair}, key=int)
    return json.dumps({"format": "orasp-problem/1", "name": "test", "parts": [{"id": part} for part in parts],
                       "connections": [{"parts": pair} for pair in pairs], **more})


def commands():
    block = orasp("--help").out.split("\nCommands:\n", 1)[1].split("\n\n", 1)[0]
    return re.findall(r"^  (\S+)", block, re.MULTILINE)


def options_of(command):
    listing = orasp(command, "--help").out
    return sorted(set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", listing)))


def methods():
    block = orasp("solve", "--help").out.split("\nMethods:\n", 1)[1].split("\n\n", 1)[0]
    return re.findall(r"^  (\S+)", block, re.MULTILINE)


CHAIN = assembly(["1-2", "2-3", "3-4"])
CYCLE = assembly(["1-2", "2-3"], precedence=[{"connection": "1-2", "after": ["2-3"]},
                                             {"connection": "2-3", "after": ["1-2"]}])


class Case(unittest.TestCase):
    maxDiff = None

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def file(self, name, content):
        path = self.folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return str(path)

    def check(self, answer, code, *, out=r"\A", error=r"\A"):
        """`out` and `error` are expressions that must be found."""
        self.assertEqual(answer.code, code, answer.out + answer.error)
        self.assertRegex(answer.out, out)
        self.assertRegex(answer.error, error)

    def check_sentence(self, answer, code=30):
        """An error is one line on standard error and nothing else."""
        self.assertEqual(answer.code, code, answer.out + answer.error)
        self.assertEqual(answer.out, "")
        self.assertRegex(answer.error, r"\Aorasp: [^\n]+\n\Z")
        self.assertNotIn("internal error", answer.error)


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
            ("solve hubble --sweep-order up --method value-iteration", r'"up" is neither layers nor textbook'),
            ("solve hubble --bound best", r"--bound belongs to the methods orasp-search, a-star, beam and q-learning, not to auto"),
            ("solve hubble --bound best --method dijkstra", r"--bound belongs to .*, not to dijkstra"),
            ("solve hubble --bound bst --method a-star", r'--bound: "bst" is not a bound; bounds are none, connections, sizes, parts, best; did you mean "best"'  ),
            ("solve hubble --method a-star --bound", r"--bound needs a value, BOUND"),
            ("solve hubble --bound none --objective indexed --method beam", r"beam: the bound 'none' knows nothing.*'best'"),
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
        self.assertEqual(script, (ROOT / "cli/orasp.bash").read_text(encoding="utf-8"))
        for word in commands() + methods():
            with self.subTest(word=word):
                self.assertRegex(manual, rf"(?m)\b{re.escape(word)}\b")
                self.assertRegex(script, rf"\b{re.escape(word)}\b")
        for command in commands():
            for option in options_of(command):
                with self.subTest(command=command, option=option):
                    self.assertRegex(manual, rf"{option}\b")
                    self.assertRegex(script, rf"{option}\b")


class Completion(Case):
    def complete(self, *words):
        script = ('source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _orasp 2>/dev/null; '
                  'printf "%s\\n" "${COMPREPLY[@]}"')
        done = subprocess.run(["bash", "--norc", "-c", script, "bash", ROOT / "cli/orasp.bash", PROGRAM, *words],
                              capture_output=True, text=True, cwd=self.folder, timeout=60)
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


class IntegerProgram(Case):
    def test_a_model_is_written_and_not_solved(self):
        for ending, begin in (("lp", "\\ connection 1 is 1-2"), ("mps", "* connection 1 is 1-2")):
            file = self.folder / f"model.{ending}"
            answer = orasp("solve", "4brick", "--method", "mip", "--write-model", file, "--quiet")
            self.assertEqual((answer.code, answer.error), (0, ""))
            self.assertRegex(answer.out, rf"model\.{ending}: \d+ columns \(\d+ whole\), \d+ rows, \d+ terms; its objective")
            self.assertTrue(file.read_text(encoding="ascii").startswith(begin))

    def test_ids_are_printable_ascii_in_their_remark(self):
        text = assembly(["1-2"]).replace('"parts": ["1", "2"]', '"id": "a End \u00e4", "parts": ["1", "2"]')
        file = self.folder / "model.lp"
        answer = orasp("solve", "-", "--method", "mip", "--write-model", file, stdin=text)
        self.assertEqual(answer.code, 0, answer.error)
        self.assertTrue(file.read_text(encoding="ascii").startswith("\\ connection 1 is a End ??\nMinimize\n"))

    def test_a_model_of_a_fleet_has_as_many_steps_as_asked(self):
        sizes = []
        for steps in (4, 5):
            file = self.folder / "model.mps"
            answer = orasp("solve", "fleet-lattice", "--objective", "travel", "--steps", str(steps), "--method", "mip",
                           "--write-model", file, "--json")
            self.assertEqual(answer.code, 0, answer.error)
            sizes.append(json.loads(answer.out)["columns"])
        self.assertLess(sizes[0], sizes[1])

    def test_what_makes_no_model_is_refused_before_anything_is_written(self):
        for words, sentence in [
            (["4brick", "--write-model", "m.txt"], r"m\.txt: a model is written as FILE\.lp or FILE\.mps"),
            (["4brick", "--write-model", "m.lp", "-o", "plan.json"], r"--write-model solves nothing, so --output has no plan"),
            (["4brick", "--write-model", "m.lp", "--count"], r"--write-model solves nothing, so --count has no plan"),
            (["iss", "--write-model", "m.lp", "--objective", "travel"], r"'travel'|position"),
            (["chain:40", "--write-model", "m.lp"], r"39 connections are too many for the integer program \(at most 32\)"),
            (["fleet-lattice", "--write-model", "m.lp", "--objective", "travel"], r"needs --steps"),
        ]:
            with self.subTest(words=words):
                answer = orasp("solve", *words, "--method", "mip", cwd=self.folder)
                self.assertEqual(answer.code, 30, answer.out)
                self.assertRegex(answer.error, sentence)
                self.assertEqual(list(self.folder.iterdir()), [])
        answer = orasp("solve", "4brick", "--write-model", "m.lp")
        self.assertEqual(answer.code, 30)
        self.assertIn("--write-model belongs to the method mip, not to auto", answer.error)

    def test_it_solves_one_robot_and_a_fleet_or_says_how_to_get_the_solver(self):
        answer = orasp("solve", "4brick", "--method", "mip", "--json")
        if answer.code == 30:
            self.assertIn("install the package coinor-libcbc-dev", answer.error)
            self.skipTest("built without CBC")
        self.assertEqual(json.loads(answer.out)["reward"], 0.557)
        answer = orasp("solve", "fleet-lattice", "--method", "mip", "--json")
        self.assertEqual((answer.code, json.loads(answer.out)["status"]), (0, "optimal"), answer.error)

    def test_ctrl_c_ends_the_solver_with_the_best_plan_so_far(self):
        process = subprocess.Popen([PROGRAM, "solve", "hubble", "--method", "mip", "--json"], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        time.sleep(1.5)
        process.send_signal(signal.SIGINT)
        out, error = process.communicate(timeout=60)
        if process.returncode == 30:
            self.skipTest("built without CBC")
        self.assertEqual(process.returncode, 20, error)
        self.assertEqual(json.loads(out)["stopped"], "interrupted")


class WrongFiles(Case):
    def test_a_file_that_is_no_problem_is_refused_in_a_sentence(self):
        million = '{"format": "orasp-problem/1", "parts": [{"id": "1"}, {"id": "2"}], "connections": [' + ",".join(
            f'{{"id": "{i}", "parts": ["1", "2"]}}' for i in range(10**6)) + "]}"
        for name, content, sentence in [
            ("empty", "", r"the file is empty"),
            ("blank", " \n", r"empty"),
            ("not JSON", "hello", r"line 1, column 1"),
            ("cut off", CHAIN[:-1], r"line 1, column"),
            ("not UTF-8", b'{"name": "\xff"}', r"0xff is not valid UTF-8"),
            ("NaN", CHAIN.replace('{"id": "1"}', '{"id": "1", "mass": NaN}'), r"NaN"),
            ("an infinite number", CHAIN.replace('{"id": "1"}', '{"id": "1", "mass": 1e999}'), r"1e999|finite"),
            ("an unknown key", CHAIN.replace('"parts": [{', '"prats": 1, "parts": [{'), r'"prats"'),
            ("an unknown key inside", CHAIN.replace('{"id": "1"}', '{"id": "1", "weight": 1}'), r'parts\[0\].*"weight"'),
            ("a wrong type", CHAIN.replace('{"id": "1"}', '{"id": 1}'), r"parts\[0\]\.id"),
            ("an id twice", CHAIN.replace('{"id": "2"}', '{"id": "1"}'), r"parts\[1\]"),
            ("a missing part", CHAIN.replace('["3", "4"]', '["3", "5"]'),
             r'connections\[2\]\.parts\[1\]: no part "5"'),
            ("a million connections", million, r"1,?000,?000|16,?384"),
        ]:
            with self.subTest(fault=name):
                for problem, stdin in [(self.file("problem.json", content), ""), ("-", content)]:
                    output = self.folder / "plan.json"
                    answer = orasp("solve", problem, "-o", str(output), stdin=stdin)
                    self.check_sentence(answer)
                    self.assertIn("standard input" if problem == "-" else "problem.json", answer.error)
                    self.assertRegex(answer.error, sentence)
                    self.assertLess(len(answer.error), 500)
                    self.assertFalse(output.exists())

    def test_what_cannot_be_read_is_named(self):
        plan = self.file("plan.json", "[]")
        for arguments in [["solve", str(self.folder)], ["solve", str(self.folder / "none.json")],
                          ["evaluate", "4brick", str(self.folder)], ["evaluate", "4brick", str(self.folder / "none")],
                          ["evaluate", str(self.folder), plan], ["graph", str(self.folder)],
                          ["compare", "4brick", str(self.folder)], ["sample", str(self.folder)],
                          ["solve", "4brick", "--objective", str(self.folder / "none.json")]]:
            with self.subTest(arguments=arguments):
                answer = orasp(*arguments)
                self.check_sentence(answer)
                self.assertIn(str(self.folder), answer.error)

    def test_a_plan_that_is_none_is_refused(self):
        for content in ["", "{}", "[1]", '{"format": "orasp-plan/1"}', b"\xff\n"]:
            with self.subTest(content=content):
                answer = orasp("evaluate", "4brick", self.file("plan.json", content))
                self.check_sentence(answer)
                self.assertIn("plan.json", answer.error)

    def test_control_characters_do_not_reach_the_terminal(self):
        problem = CHAIN.replace('"name": "test"', '"name": "\\u001b[31mred"')
        answer = orasp("solve", "-", stdin=problem)
        self.assertNotIn("\x1b", answer.out + answer.error)
        self.assertNotIn("\x1b", orasp("solve", "\x1b[31mred").error)


class Solve(Case):
    def test_status_decides_the_exit_code(self):
        exact = [name for name in methods() if name not in ("auto", "greedy", "random")]
        for method in ["auto", *exact]:
            with self.subTest(method=method):
                answer = orasp("solve", "-", "--method", method, stdin=CHAIN)
                if "install the package" in answer.error and method in ("dqn", "mip"):
                    self.check_sentence(answer)  # built without the module of this method
                    continue
                self.check(answer, 0, out=r"status   optimal \(proved\)\nreward   0\.557\n")
        for method in ["greedy", "random"]:
            with self.subTest(method=method):
                self.check(orasp("solve", "-", "--method", method, stdin=CHAIN), 0,
                           out=r"status   feasible \(not proved best\)")

    def test_infeasible_is_ten_and_names_the_cycle(self):
        for method in methods():
            with self.subTest(method=method):
                answer = orasp("solve", "-", "--method", method, stdin=CYCLE)
                self.check(answer, 10, out=r"infeasible \(proved: no plan exists\)")
                self.assertRegex(answer.out, r'"1-2" after "2-3".*"2-3" after "1-2"')
        answer = orasp("solve", "-", "--json", stdin=CYCLE)
        self.check(answer, 10)
        plan = json.loads(answer.out)
        self.assertEqual((plan["status"], plan["reward"], plan["steps"]), ("infeasible", None, []))

    def test_without_a_plan_the_file_named_by_o_is_left_alone(self):
        for content in [None, "the plan of yesterday"]:
            with self.subTest(content=content):
                output = self.folder / f"{content}.json"
                if content is not None:
                    output.write_text(content)
                answer = orasp("solve", "-", "-o", str(output), stdin=CYCLE)
                self.check(answer, 10, out=r"infeasible", error=r"there is no plan, so .* is not written")
                self.assertEqual(output.read_text() if output.exists() else None, content)

    def test_the_json_has_the_keys_of_the_contract(self):
        plan = json.loads(orasp("solve", "hubble", "--json").out)
        self.assertLessEqual({"format", "problem", "problem_digest", "method", "status", "reward", "bound", "gap",
                              "disassembly", "assembly", "steps", "order", "statistics", "seed", "options"}, set(plan))
        self.assertEqual(plan["format"], "orasp-plan/1")
        self.assertEqual(plan["status"], "optimal")
        self.assertAlmostEqual(plan["reward"], -0.9902, places=9)
        self.assertEqual(len(plan["steps"]), 19)
        self.assertEqual(set(plan["steps"][0]),
                         {"step", "connection", "reward", "total", "separates", "pieces", "moved"})
        self.assertLessEqual({"states", "actions", "expanded", "generated", "pruned", "seconds", "peak_bytes"},
                             set(plan["statistics"]))
        self.assertEqual(plan["assembly"], plan["disassembly"][::-1])

    def test_the_same_seed_gives_the_same_bytes_times_aside(self):
        def plan(*more):
            found = json.loads(orasp("solve", "hubble-free", "--method", "random", "--json", *more).out)
            found["statistics"]["seconds"] = 0
            return found
        self.assertEqual(plan("--seed", "7"), plan("--seed", "7", "--threads", "1"))
        self.assertNotEqual(plan("--seed", "7")["disassembly"], plan("--seed", "8")["disassembly"])
        self.assertEqual(plan("--seed", "7")["seed"], 7)

    def test_changes_to_the_problem_are_applied_and_noted(self):
        answer = orasp("solve", "4brick", "--objective", "time", "--direction", "assembly", "--json")
        plan = json.loads(answer.out)
        self.assertEqual(plan["reward"], -6)
        self.assertEqual(plan["options"]["objective"], "time")
        self.assertEqual(plan["options"]["direction"], "assembly")
        self.check(orasp("solve", "4brick", "--max-moved-parts", "1"), 0, out=r"reward   0\.545\n")
        self.check(orasp("solve", "4brick", "--max-subassemblies", "0"), 10)
        self.check(orasp("solve", "4brick", "--max-moved-mass", "0.5"), 10)
        objective = self.file("objective.json", '{"type": "piece_cost", "operation": 2}')
        self.check(orasp("solve", "4brick", "--objective", objective), 0, out=r"reward   -4\n")

    def test_a_file_beats_a_scenario_only_if_it_looks_like_one(self):
        Path(self.folder / "hubble").write_text(CHAIN)
        Path(self.folder / "mine").write_text(CHAIN)
        self.check(orasp("solve", "hubble", cwd=self.folder), 0, out=r"\AHubble: 20 parts")
        self.check(orasp("solve", "./hubble", cwd=self.folder), 0, out=r"\Atest: 4 parts")
        self.check(orasp("solve", "mine", cwd=self.folder), 0, out=r"\Atest: 4 parts")

    def test_value_iteration_has_its_options(self):
        for more in [["--sweep-order", "textbook"], ["--initial-value", "-5.5"], ["--epsilon", "1e-6"]]:
            with self.subTest(more=more):
                self.check(orasp("solve", "lattice", "--method", "value-iteration", *more), 0, out=r"reward   0\.0735\n")
        answer = orasp("solve", "lattice", "--method", "value-iteration", "--sweep-order", "textbook",
                       "--max-sweeps", "1", "--json")
        self.assertEqual(json.loads(answer.out)["options"]["max-sweeps"], 1)
        self.assertNotEqual(json.loads(answer.out)["status"], "optimal")

    def test_a_bound_may_be_chosen(self):
        expanded = {}
        for method in ("orasp-search", "a-star", "beam"):
            for bound in ("none", "connections", "sizes", "best"):
                with self.subTest(method=method, bound=bound):
                    answer = orasp("solve", "lattice", "--method", method, "--bound", bound, "--json")
                    self.check(answer, 0)
                    plan = json.loads(answer.out)
                    self.assertEqual(plan["status"], "optimal")
                    self.assertAlmostEqual(plan["reward"], 0.0735, places=9)
                    self.assertEqual(plan["options"]["bound"], bound)
                    expanded[method, bound] = plan["statistics"]["expanded"]
            self.assertLess(10 * expanded[method, "sizes"], expanded[method, "none"])
            default = json.loads(orasp("solve", "lattice", "--method", method, "--json").out)
            self.assertEqual(default["statistics"]["expanded"], expanded[method, "best"])
        self.check(orasp("solve", "lattice", "--objective", "fuel", "--method", "a-star", "--bound", "parts"), 0)

    def test_too_large_for_a_method_is_refused_at_once(self):
        start = time.monotonic()
        answer = orasp("solve", "jwst", "--method", "dijkstra", "--quiet")
        self.check_sentence(answer)
        self.assertRegex(answer.error, r"orasp-search|greedy")
        self.assertLess(time.monotonic() - start, 30)

    def test_warnings_go_to_standard_error_unless_quiet(self):
        self.check(orasp("solve", "jwst", "--method", "greedy"), 0, error=r'orasp: warning: .*"161-161"')
        self.check(orasp("solve", "jwst", "--method", "greedy", "--quiet"), 0, error=r"\A\Z")

    def test_a_problem_without_connections_has_the_empty_plan(self):
        for connections in ([], None):
            problem = json.dumps({"format": "orasp-problem/1", "parts": [{"id": "1"}] if connections is None else [],
                                  "connections": []})
            self.check(orasp("solve", "-", stdin=problem), 0, out=r"optimal \(proved\)\nreward   0\n")


class Output(Case):
    def test_the_plan_is_written_and_the_summary_printed(self):
        path = self.folder / "plan.json"
        answer = orasp("solve", "hubble", "-o", str(path))
        self.check(answer, 0, out=r"reward   -0\.9902\n")
        self.assertEqual(json.loads(path.read_text())["format"], "orasp-plan/1")
        self.assertEqual(os.listdir(self.folder), ["plan.json"])

    def test_nothing_half_written_stays_behind(self):
        old = self.folder / "old.json"
        old.write_text("old")

        def small_files_only():
            resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
        answer = orasp("solve", "hubble", "-o", str(old), preexec_fn=small_files_only)
        self.check_sentence(answer)
        self.assertRegex(answer.error, r"cannot write .*old\.json: File too large")
        self.assertEqual(old.read_text(), "old")
        self.assertEqual(os.listdir(self.folder), ["old.json"])

        for target in [self.folder, self.folder / "none" / "plan.json", "/proc/plan.json"]:
            with self.subTest(target=target):
                answer = orasp("solve", "hubble", "-o", str(target))
                self.check_sentence(answer)
                self.assertIn(str(target), answer.error)
        self.assertEqual(os.listdir(self.folder), ["old.json"])

    @unittest.skipIf(os.geteuid() == 0, "root may write anywhere")
    def test_a_folder_that_may_not_be_written(self):
        os.chmod(self.folder, 0o555)
        self.addCleanup(os.chmod, self.folder, 0o755)
        self.check_sentence(orasp("solve", "hubble", "-o", str(self.folder / "plan.json")))

    def test_standard_output_that_cannot_be_written_is_reported(self):
        for arguments in (["solve", "hubble"], ["--help"], ["--version"], ["solve", "--help"], ["graph", "2x3", "--json"],
                          ["scenarios"], ["completion", "bash"]):
            with self.subTest(arguments=arguments):
                with open("/dev/full", "wb") as full:
                    done = subprocess.run([PROGRAM, *arguments], stdout=full, stderr=subprocess.PIPE, text=True)
                self.assertEqual(done.returncode, 30)
                self.assertRegex(done.stderr, r"\Aorasp: cannot write to standard output: No space left on device\n\Z")
        done = subprocess.run(["bash", "-c", '"$0" solve hubble >&-', PROGRAM], stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 30)
        self.assertIn("cannot write to standard output", done.stderr)

    def test_a_closed_output_is_not_mistaken_for_a_file(self):
        path = self.folder / "plan.json"
        subprocess.run(["bash", "-c", '"$0" solve jwst --method greedy -o "$1" <&- >&- 2>&-', PROGRAM, path], check=False)
        self.assertEqual(json.loads(path.read_text())["format"], "orasp-plan/1")

    def test_a_reader_that_goes_away_is_no_error(self):
        reader, writer = os.pipe()
        os.close(reader)
        done = subprocess.run([PROGRAM, "solve", "hubble"], stdout=writer, stderr=subprocess.PIPE, text=True)
        os.close(writer)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        done = subprocess.run(["bash", "-o", "pipefail", "-c", '"$0" graph chain:12 --dot - | head -1', PROGRAM],
                              capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "digraph H {\n", ""))


UNCERTAIN = json.dumps({
    "format": "orasp-problem/1", "name": "test", "parts": [{"id": part} for part in "abc"],
    "connections": [{"parts": ["a", "b"], "success": 0.8, "on_failure": {"breaks": ["b-c"]}},
                    {"parts": ["b", "c"], "success": 0.5}],
    "objective": {"type": "expression", "formula": "0 - 1 - after"}})


class Simulate(Case):
    """The problem worked out by hand in tests/planners/uncertain_test.cpp: -3.85 in 2.85 attempts."""

    def setUp(self):
        super().setUp()
        self.problem = self.file("uncertain.json", UNCERTAIN)

    def figures(self, *arguments):
        answer = orasp("simulate", self.problem, "--json", *arguments)
        self.check(answer, 0)
        return json.loads(answer.out)

    def test_the_mean_agrees_with_the_expectation(self):
        found = self.figures()
        self.assertEqual((found["n"], found["seed"], found["aborted"], found["replanned"]), (10000, 1, 0, 0))
        self.assertAlmostEqual(found["expected"], -3.85)
        self.assertLess(abs(found["mean"] - found["expected"]), 3 * found["standard_error"])
        self.assertLess(abs(found["attempts"]["mean"] - 2.85), 0.1)
        self.assertLessEqual(found["min"], found["percentiles"]["5"])

    def test_a_policy_from_solve_is_followed_and_a_worse_plan_costs_more(self):
        policy = str(self.folder / "policy.json")
        answer = orasp("solve", self.problem, "-o", policy)
        self.check(answer, 0, out=r"expected reward -3\.85\n")
        self.assertIn("most likely sequence (probability 0.8)", answer.out)
        self.assertAlmostEqual(self.figures("--policy", policy, "-n", "100")["expected"], -3.85)
        plan = self.file("plan.txt", "b-c\na-b\n")
        self.assertAlmostEqual(self.figures("--plan", plan, "-n", "100")["expected"], -5.25)

    def test_the_same_seed_gives_the_same_bytes(self):
        runs = [orasp("simulate", self.problem, "-n", "500", "--seed", seed, "--json").out for seed in "778"]
        self.assertEqual(runs[0], runs[1])
        self.assertNotEqual(runs[0], runs[2])

    def test_wrong_input_is_refused_in_a_sentence(self):
        other = self.file("other.json", orasp("solve", "lattice", "--json").out)
        self.check(orasp("simulate", self.problem, "--plan", other), 30,
                   error='the plan cannot be followed: step 1, "1-2": the problem has no connection "1-2"')
        for arguments in [("--policy", other), ("--plan", "x", "--policy", "y"), ("-n", "0"), ("-n", "-3"),
                          ("--plan", str(self.folder / "none.json"))]:
            with self.subTest(arguments=arguments):
                self.check_sentence(orasp("simulate", self.problem, *arguments))

    def test_other_methods_say_that_they_do_not_apply(self):
        answer = orasp("solve", self.problem, "--method", "dijkstra")
        self.check_sentence(answer)
        self.assertIn("dijkstra plans for attempts that always succeed", answer.error)


class Stopping(Case):
    def start(self, *arguments, **options):
        # A shell may have started us in the background with SIGINT ignored.
        return subprocess.Popen([PROGRAM, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL), **options)

    def test_ctrl_c_prints_the_best_plan_so_far(self):
        for sign in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(signal=sign):
                process = self.start(*ENDLESS, "--json")
                time.sleep(1)
                process.send_signal(sign)
                out, error = process.communicate(timeout=20)
                self.assertEqual(process.returncode, 20, error)
                plan = json.loads(out)
                self.assertEqual((plan["status"], plan["stopped"]), ("feasible", "interrupted"))
                self.assertEqual(len(plan["disassembly"]), 31)

    def test_two_signals_at_the_same_time_are_one(self):
        """timeout(1) sends one to the process and one to its group."""
        process = self.start(*ENDLESS)
        time.sleep(1)
        process.send_signal(signal.SIGTERM)
        time.sleep(0.01)
        process.poll() is None and process.send_signal(signal.SIGTERM)
        out, _ = process.communicate(timeout=20)
        self.assertEqual(process.returncode, 20)
        self.assertIn("feasible (interrupted; not proved best)", out)

    def test_an_ignored_signal_stays_ignored(self):
        process = subprocess.Popen([PROGRAM, *ENDLESS, "--time-limit", "1.5"], stdout=subprocess.PIPE, text=True,
                                   preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN))
        time.sleep(0.7)
        process.send_signal(signal.SIGINT)
        self.assertIn("stopped by the time limit", process.communicate(timeout=20)[0])

    def test_compare_and_sample_print_what_they_have(self):
        process = self.start("compare", "4brick", "iss", "--methods", "greedy,orasp-search", "--objective", "indexed", "--json")
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        out, error = process.communicate(timeout=20)
        self.assertEqual(process.returncode, 20, error)
        rows = json.loads(out)["rows"]
        self.assertEqual([row["method"] for row in rows], ["greedy", "orasp-search"] * 2)
        self.assertEqual(rows[-1]["message"].split(";")[0], "interrupted")

        process = self.start("sample", "jwst", "-n", "1000000000", "--json", "--quiet")
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        out, error = process.communicate(timeout=20)
        self.assertEqual(process.returncode, 20, error)
        sample = json.loads(out)
        self.assertGreater(sample["n"], 0)
        self.assertEqual(sample["n"], len(sample["rewards"]))

    def test_a_time_limit_ends_with_the_best_so_far(self):
        start = time.monotonic()
        answer = orasp(*ENDLESS, "--time-limit", "0.5")
        self.check(answer, 20, out=r"feasible \(stopped by the time limit; not proved best\)")
        self.assertLess(time.monotonic() - start, 20)

    # Problems that no method settles in seconds: 2**256 and 2**180 states, and a bound that is far off.
    HARD = [(["jwst", "--objective", "{sizes}"], 256), (["grid:10x10", "--objective", "time"], 180)]

    def hard(self):
        sizes = self.file("sizes.json", json.dumps({"type": "expression",
                                                    "formula": "-separates*(moved_parts+kept_parts)"}))
        return [([word.format(sizes=sizes) for word in words], steps) for words, steps in self.HARD]

    def test_a_time_limit_is_kept_to_with_a_plan_and_a_bound(self):
        for words, steps in self.hard():
            for method in ("auto", "beam", "a-star", "orasp-search", "and-or"):
                with self.subTest(words=words, method=method):
                    begin = time.monotonic()
                    answer = orasp("solve", *words, "--method", method, "--time-limit", "1", "--json", "--quiet")
                    wall = time.monotonic() - begin
                    self.check(answer, 20)
                    plan = json.loads(answer.out)
                    self.assertEqual((plan["status"], plan["stopped"]), ("feasible", "time limit"))
                    self.assertEqual(len(plan["disassembly"]), steps)
                    self.assertIsNotNone(plan["bound"])
                    self.assertGreater(plan["gap"], 0)
                    # 1.1 s on a quiet machine (docs/performance.md); here others may be at work.
                    self.assertLess(wall, 5)

    def test_ctrl_c_prints_the_plan_of_every_search(self):
        for method in ("auto", "beam", "a-star"):
            with self.subTest(method=method):
                process = self.start("solve", "grid:10x10", "--objective", "time", "--method", method, "--json")
                time.sleep(0.7)
                process.send_signal(signal.SIGINT)
                out, error = process.communicate(timeout=20)
                self.assertEqual(process.returncode, 20, error)
                plan = json.loads(out)
                self.assertEqual((plan["status"], plan["stopped"]), ("feasible", "interrupted"))
                self.assertEqual(len(plan["disassembly"]), 180)

    def test_a_memory_limit_is_kept_to(self):
        libraries = subprocess.run(["ldd", PROGRAM], capture_output=True, text=True).stdout
        if re.search("lib[at]san", libraries):
            self.skipTest("a sanitizer needs memory of its own")
        # The whole process may hold 20 MiB more at any moment. How soon a method gets there tells how large the limit is.
        for method, limit, words in [("orasp-search", 50, ["iss", "--bound", "none"]),
                                     ("a-star", 200, ["grid:5x5", "--objective", "indexed"]),
                                     ("a-star", 200, ["grid:10x10", "--objective", "time"]),
                                     ("beam", 60, ["grid:4x4", "--objective", "indexed"]),
                                     ("auto", 40, ["grid:5x5", "--objective", "indexed"])]:
            with self.subTest(method=method, words=words):
                code = ("import resource, subprocess, sys; code = subprocess.run(sys.argv[1:]).returncode; "
                        "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss, file=sys.stderr); sys.exit(code)")
                done = subprocess.run([sys.executable, "-c", code, PROGRAM, "solve", *words, "--method", method,
                                       "--memory-limit", str(limit), "--time-limit", "60", "--json", "--quiet"],
                                      capture_output=True, text=True, timeout=120)
                self.assertEqual(done.returncode, 20, done.stderr)
                plan = json.loads(done.stdout)
                self.assertEqual((plan["status"], plan["stopped"]), ("feasible", "memory limit"))
                self.assertLess(int(done.stderr) / 1024, limit + 20)

    def test_a_memory_limit_ends_with_the_best_so_far(self):
        answer = orasp(*ENDLESS, "--memory-limit", "2", "--json")
        self.check(answer, 20)
        self.assertEqual(json.loads(answer.out)["stopped"], "memory limit")


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

    def test_progress_is_shown_after_a_second_and_cleared(self):
        code, _, error = self.on_terminal(*ENDLESS, "--time-limit", "2")
        self.assertEqual(code, 20)
        self.assertRegex(error, r"\r\x1b\[KInternational Space Station, orasp-search: ")
        self.assertTrue(error.endswith("\r\x1b[K"))
        self.assertEqual(self.on_terminal(*ENDLESS, "--time-limit", "2", "--quiet")[2], "")
        self.assertEqual(self.on_terminal("solve", "hubble")[2], "")
        self.assertEqual(orasp(*ENDLESS, "--time-limit", "2").error, "")

    def test_colour_only_on_a_terminal_that_wants_it(self):
        self.assertIn("\x1b[32moptimal\x1b[0m", self.on_terminal("solve", "4brick")[1])
        self.assertNotIn("\x1b", self.on_terminal("solve", "4brick", environment={"NO_COLOR": "1"})[1])
        self.assertNotIn("\x1b", orasp("solve", "4brick").out)


class Fleets(Case):
    def solve(self, *arguments):
        answer = orasp("solve", *arguments, "--json", "--quiet")
        return answer.code, json.loads(answer.out)

    def test_auto_plans_for_the_robots_of_a_fleet_and_says_so(self):
        self.check(orasp("solve", "fleet-lattice"), 0, error=r"\A\Z",
                   out=r"objective makespan.*\nstatus    optimal \(proved\)\nmakespan  4 steps\n[^$]*auto: fleet-search, since")
        code, plan = self.solve("fleet-lattice")
        self.assertEqual((code, plan["reward"], plan["fleet"]["makespan"]), (0, -4, 4))

    def test_published_values(self):
        for steps, travel in [("4", 81), ("5", 58), ("6", 54)]:
            with self.subTest(steps=steps):
                code, plan = self.solve("fleet-lattice", "--method", "fleet-search", "--objective", "travel", "--steps", steps)
                self.assertEqual((code, plan["status"], plan["reward"]), (0, "optimal", -travel))
        for robots, sites, steps in [(3, 2, 5), (3, 4, 5), (4, 2, 5), (4, 3, 4), (3, 1, None), (4, 1, None), (2, 4, None)]:
            with self.subTest(robots=robots, sites=sites):
                code, plan = self.solve("fleet-lattice", "--robots", str(robots), "--sites", str(sites))
                self.assertEqual((code, plan["fleet"]["makespan"]), (10 if steps is None else 0, steps))
        code, plan = self.solve("fleet-lattice", "--steps", "3")
        self.assertEqual((code, plan["status"]), (10, "infeasible"))

    def test_a_plan_is_evaluated_and_its_violations_are_named_by_step(self):
        output = self.folder / "plan.json"
        self.check(orasp("solve", "fleet-lattice", "-o", str(output)), 0)
        answer = orasp("evaluate", "fleet-lattice", str(output), "--json")
        self.check(answer, 0, error=r"\A\Z")
        verdict = json.loads(answer.out)
        self.assertEqual((verdict["valid"], verdict["reward"], verdict["makespan"], verdict["travel"]), (True, -4, 4, 81))
        answer = orasp("evaluate", "fleet-lattice", str(output), "--objective", "travel", "--json")
        self.assertEqual(json.loads(answer.out)["reward"], -81)
        self.check_sentence(orasp("evaluate", "fleet-lattice", str(output), "--objective", "cubesat"))
        self.check(orasp("solve", "fleet-lattice", "--robots", "2"), 10, out=r"with 2 robots and 4 sites every order of steps ends")
        self.check(orasp("evaluate", "fleet-lattice", str(output), "--robots", "3"), 10,
                   out=r"the plan is not valid[^$]*step 2: robots: there is no robot 4; robots are 1 to 3")
        plan = json.loads(output.read_text())
        plan["steps"][2]["moves"][0]["motion"] = "+y"
        plan["steps"][3]["connections"].pop()
        answer = orasp("evaluate", "fleet-lattice", "-", "--json", stdin=json.dumps(plan))
        self.check(answer, 10)
        found = [(violation["step"], violation["constraint"]) for violation in json.loads(answer.out)["violations"]]
        self.assertEqual(found[0], (3, "cut"))
        self.assertIn((5, "end"), found)

    def test_what_does_not_fit_is_a_sentence(self):
        axes = assembly(["1-2"], fleet={"robots": 2, "sites": [[1, 0]]})
        sites = axes.replace('"parts": ["1", "2"]', '"parts": ["1", "2"], "axis": "+x"').replace("[[1, 0]]", "[]")
        for arguments, problem, sentence in [
            ("solve - --method fleet-search", CHAIN, r'the problem has no "fleet"'),
            ("solve - --method fleet-search", axes, r'connections\[0\]\.axis: connection "1-2" has no axis'),
            ("solve - --method fleet-search", sites, r"fleet\.sites: there is no site"),
            ("solve -", axes.replace('"robots": 2', '"robots": 0'), r"fleet\.robots: 0 is not allowed"),
            ("solve fleet-lattice --direction assembly", "", r'"assembly" is not allowed in a fleet problem'),
            ("solve fleet-lattice --objective cubesat --method fleet-search", "", r"whose objectives are makespan and travel"),
            ("solve fleet-lattice --objective makespan --method dijkstra", "", r"fleet-search plans for them"),
            ("solve lattice --objective makespan", "", r'the problem has no "fleet"'),
            ("solve lattice --robots 2", "", r'--robots: the problem has no "fleet"'),
            ("solve lattice --steps 2", "", r"--steps belongs to the methods for fleets, not to auto for one robot"),
            ("solve lattice --method greedy --steps 2", "", r"--steps belongs to the methods for fleets, not to greedy"),
            ("solve fleet-lattice --sites 5", "", r"--sites: 5 is more than the 4 sites"),
            ("solve fleet-lattice --robots 0", "", r'--robots: "0" is not a whole number'),
            ("solve fleet-lattice --count", "", r"--count belongs to the methods for one robot"),
        ]:
            with self.subTest(arguments=arguments, sentence=sentence):
                answer = orasp(*arguments.split(), stdin=problem)
                self.check_sentence(answer)
                self.assertRegex(answer.error, sentence)

    def test_methods_for_one_robot_go_on_as_before_with_a_warning(self):
        for arguments in [["--method", "dijkstra"], ["--objective", "cubesat"]]:
            with self.subTest(arguments=arguments):
                answer = orasp("solve", "fleet-lattice", *arguments)
                self.check(answer, 0, out=r"reward   0\.0735\n", error=r"warning: fleet: its 4 robots are not used")

    def test_a_limit_leaves_a_plan_a_bound_and_a_gap(self):
        chain = json.dumps({"format": "orasp-problem/1", "parts": [{"id": str(i)} for i in range(50)],
                            "connections": [{"parts": [str(i), str(i + 1)], "axis": "-x"} for i in range(49)],
                            "fleet": {"robots": 10, "sites": [[1, 0], [0, 1], [2, 0], [0, 2]]}})
        answer = orasp("solve", "-", "--time-limit", "2", "--json", stdin=chain)
        self.check(answer, 20)
        plan = json.loads(answer.out)
        self.assertEqual((plan["status"], plan["stopped"]), ("feasible", "time limit"))
        self.assertLessEqual(plan["fleet"]["makespan"], 11)  # 10, unless the machine is very busy
        self.assertGreaterEqual(plan["bound"], plan["reward"])
        self.assertEqual(plan["gap"], plan["bound"] - plan["reward"])
        self.check(orasp("evaluate", "-", self.file("plan.json", answer.out), stdin=chain), 0)

    def test_compare_shows_makespan_and_travel(self):
        answer = orasp("compare", "fleet-lattice", "fleet-hubble", "lattice", "--objective", "travel", "--json")
        rows = json.loads(answer.out)["rows"]
        self.check(answer, 0)
        found = {(row["problem"], row["method"]): row for row in rows}
        self.assertEqual(found["fleet-lattice", "fleet-search"]["travel"], 81)
        self.assertEqual(found["fleet-hubble", "fleet-search"]["makespan"], 5)
        self.assertEqual({row["status"] for row in rows if row["problem"] == "lattice"}, {"refused"})  # no positions
        table = orasp("compare", "fleet-lattice", "--methods", "fleet-search,dijkstra", "--csv").out.splitlines()
        self.assertTrue(table[0].endswith(",message,makespan,travel"))
        self.assertTrue(table[1].endswith(",4,81"))
        self.assertTrue(table[2].endswith(",,"))


class Evaluate(Case):
    def test_a_solved_plan_is_valid_whichever_way_it_comes(self):
        plan = orasp("solve", "lattice", "--json").out
        order = json.loads(plan)["disassembly"]
        for text in [plan, json.dumps(order), "# by hand\n" + "\n".join(order) + "\n"]:
            answer = orasp("evaluate", "lattice", "-", "--json", stdin=text)
            self.check(answer, 0, error=r"\A\Z")
            verdict = json.loads(answer.out)
            self.assertEqual(set(verdict), {"valid", "reward", "steps", "violations"})
            self.assertEqual((verdict["valid"], verdict["steps"], verdict["violations"]), (True, 12, []))
            self.assertAlmostEqual(verdict["reward"], 0.0735, places=9)
        self.check(orasp("evaluate", "lattice", self.file("plan", plan)), 0, out=r"the plan is valid\nreward   0\.0735\n")

    def test_every_violation_is_named(self):
        problem = self.file("p.json", assembly(["1-2", "2-3", "3-4"],
                                               precedence=[{"connection": "1-2", "after": ["3-4"]}],
                                               limits={"max_moved_parts": 1}))
        answer = orasp("evaluate", problem, "-", "--json", stdin='["1-2", "2-3", "2-3", "x"]')
        self.check(answer, 10)
        verdict = json.loads(answer.out)
        self.assertFalse(verdict["valid"])
        for violation in verdict["violations"]:
            self.assertEqual(set(violation), {"step", "connection", "constraint", "message"})
        found = [(v["step"], v["connection"], v["constraint"]) for v in verdict["violations"]]
        self.assertEqual(found[0], (1, "1-2", "precedence"))
        self.assertIn((4, "x"), [entry[:2] for entry in found])
        answer = orasp("evaluate", problem, "-", stdin='["2-3", "1-2", "3-4"]')
        self.check(answer, 10, out=r"step 1, 2-3: max_moved_parts: ")

    def test_a_plan_for_another_problem_is_worth_a_warning(self):
        plan = self.file("plan.json", orasp("solve", "4brick", "--json").out)
        answer = orasp("evaluate", "4brick", plan, "--objective", "time")
        self.check(answer, 0, out=r"reward   -6\n", error=r"\Aorasp: warning: .*problem_digest differs\n\Z")
        self.check(orasp("evaluate", "4brick", plan, "--objective", "time", "--quiet"), 0, error=r"\A\Z")

    def test_assembly_plans_are_read_in_their_own_direction(self):
        plan = orasp("solve", "hubble", "--direction", "assembly", "--objective", "indexed", "--json").out
        answer = orasp("evaluate", "hubble", "-", "--direction", "assembly", "--objective", "indexed", "--json", stdin=plan)
        self.check(answer, 0)
        self.assertAlmostEqual(json.loads(answer.out)["reward"], json.loads(plan)["reward"])


class Replan(Case):
    def test_the_steps_still_to_come_and_what_changes(self):
        path = self.file("chain.json", CHAIN)
        # All three: -(0.0967 + 0.1368) - (0.0967 + 0.1248) + 1; without 2-3 the two ends come off, the second completes.
        self.check(orasp("solve", path, "-o", str(self.folder / "plan.json")), 0)
        plan = str(self.folder / "plan.json")
        answer = orasp("replan", path, "--plan", plan, "--inaccessible", "2-3", "--json")
        self.check(answer, 0)
        found = json.loads(answer.out)
        self.assertEqual(found["format"], "orasp-plan/1")
        self.assertEqual(sorted(found["disassembly"]), ["1-2", "3-4"])
        self.assertAlmostEqual(found["reward"], 1 - 0.0967 - 0.1368)
        self.assertEqual(len(found["steps"]), 2)
        changes = found["changes"]
        self.assertEqual(changes["dropped"], ["2-3"])
        self.assertEqual(sorted(changes["kept"] + changes["moved"]), ["1-2", "3-4"])
        self.assertAlmostEqual(changes["price"], changes["reward_before"] - found["reward"])
        answer = orasp("replan", path, "--plan", plan, "--done", "1", "--json")
        found = json.loads(answer.out)
        old = json.loads(Path(plan).read_text())
        self.assertEqual(found["disassembly"], old["disassembly"][1:])
        self.assertEqual(found["changes"]["price"], 0)
        self.assertAlmostEqual(found["reward"], old["reward"] - old["steps"][0]["reward"])
        self.check(orasp("replan", path, "--removed", "1-2,2-3,3-4"), 0, out=r"reward   0\n")

    def test_what_cannot_be_next_is_late_or_lost(self):
        path = self.file("chain.json", CHAIN)

        def order(*more):
            return json.loads(orasp("replan", path, "--json", *more).out)["disassembly"]
        self.assertNotEqual(order("--not-next", order()[0])[0], order()[0])
        self.assertEqual(order("--late-part", "1")[-1], "1-2")
        self.assertEqual(sorted(order("--lost-part", "2")), ["3-4"])
        self.assertEqual(order("--direction", "assembly", "--made", "1-2", "--inaccessible", "3-4"), ["2-3"])

    def test_no_plan_is_ten_and_names_what_is_inaccessible(self):
        path = self.file("after.json", assembly(["1-2", "2-3"], precedence=[{"connection": "1-2", "after": ["2-3"]}]))
        answer = orasp("replan", path, "--inaccessible", "2-3")
        self.check(answer, 10, out=r'precedence\[0\]  "1-2" may be removed only after "2-3"\n +"2-3" is inaccessible\n')
        found = json.loads(orasp("replan", path, "--inaccessible", "2-3", "--json").out)
        self.assertEqual([item["constraint"] for item in found["conflict"]], ["precedence", "inaccessible"])
        both = orasp("replan", path, "--not-next", "2-3")
        self.check(both, 10, out='"2-3" cannot be the next step')

    def test_another_objective_reports_both_times(self):
        found = json.loads(orasp("replan", "lattice", "--objective", "time", "--removed", "1-2", "--json").out)
        self.assertEqual(set(found["reweighing"]), {"states", "generated", "reweighed"})
        again = json.loads(orasp("solve", "lattice", "--objective", "time", "--json").out)
        first = [step["reward"] for step in again["steps"]][0]
        self.assertGreaterEqual(found["reward"], again["reward"] - first)

    def test_what_is_wrong_is_said_in_a_sentence(self):
        for words in (["--removed", "1-9"], ["--lost-part", "Z"], ["--done", "1"], ["--inaccessible", "1-2,,2-3"],
                      ["--done", "x"], ["--not-next", ""]):
            self.check_sentence(orasp("replan", "lattice", *words))
        plan = self.file("plan.txt", "1-2\n2-3\n")
        self.check_sentence(orasp("replan", "lattice", "--plan", plan, "--done", "3"))
        self.check_sentence(orasp("replan", "lattice", "--plan", self.file("twice.txt", "1-2\n1-2\n")))


class Explain(Case):
    def test_a_conflict_is_named_by_place_and_word(self):
        path = self.file("cycle.json", CYCLE)
        answer = orasp("explain", path)
        self.check(answer, 10, out=r"test: no plan exists\n\n2 constraints conflict; any 1 of them alone")
        self.assertRegex(answer.out, r'\n  precedence\[0\]  "1-2" may be removed only after "2-3"\n'
                                     r'  precedence\[1\]  "2-3" may be removed only after "1-2"\n')
        found = json.loads(orasp("explain", path, "--json").out)
        self.assertEqual(found["status"], "infeasible")
        self.assertTrue(found["minimal"])
        self.assertEqual([(item["constraint"], item["where"]) for item in found["conflict"]],
                         [("precedence", "precedence[0]"), ("precedence", "precedence[1]")])
        self.assertEqual(set(found["conflict"][0]), {"constraint", "where", "message"})

    def test_a_limit_from_the_command_line_is_a_constraint_too(self):
        found = json.loads(orasp("explain", "4brick", "--max-moved-parts", "0", "--json").out)
        self.assertEqual([item["where"] for item in found["conflict"]], ["limits.max_moved_parts"])
        self.check(orasp("explain", "4brick", "--max-moved-parts", "0"), 10, out="one constraint alone")
        self.check(orasp("explain", "4brick", "--max-moved-parts", "0", "--direction", "assembly"), 10,
                   out=r"limits\.max_moved_parts")

    def test_too_many_subassemblies_to_begin_with(self):
        path = self.file("two.json", assembly(["1-2", "3-4"], limits={"max_subassemblies": 1}))
        self.check(orasp("explain", path), 10, out=r"limits\.max_subassemblies  the whole product is 2 subassemblies")

    def test_a_problem_with_a_plan_is_zero_and_says_what_cannot_go_first(self):
        answer = orasp("explain", "lattice")
        self.check(answer, 0, out=r"a plan exists\n\n8 connections may go first, 4 may not:\n", error=r"\A\Z")
        found = json.loads(orasp("explain", "lattice", "--json").out)
        self.assertEqual((found["status"], found["conflict"]), ("feasible", []))
        self.check(orasp("explain", "3piece"), 0, out="every connection may go first")
        self.check(orasp("explain", "-", stdin=assembly([])), 0, out="the plan is empty")

    def test_a_connection_that_cannot_go_first(self):
        answer = orasp("explain", "lattice", "--connection", "4-5")
        self.check(answer, 10, out=r'"4-5" cannot be removed first\n\n  precedence\[1\]: .*\n    remove first "7-8"\n')
        self.assertRegex(answer.out, r"legal after 1 other step, and after no fewer:\n  7-8\n")
        found = json.loads(orasp("explain", "lattice", "--connection", "4-5", "--json").out)
        self.assertEqual(found["status"], "illegal")
        self.assertEqual(found["changes"][0]["first"], ["7-8"])
        self.assertEqual((found["legal_later"], found["legal_after"], found["fewest"]), (True, ["7-8"], True))

    def test_the_least_limit_would_do(self):
        words = ["explain", "chain:6", "--connection", "3-4", "--max-subassemblies", "1", "--max-moved-parts", "2"]
        found = json.loads(orasp(*words, "--json").out)
        self.assertEqual({change["where"]: change["least"] for change in found["changes"]},
                         {"limits.max_subassemblies": 2, "limits.max_moved_parts": 3})
        self.check(orasp("explain", "chain:6", "--connection", "3-4", "--max-subassemblies", "2",
                         "--max-moved-parts", "3"), 0, out="a plan goes on from there")

    def test_parts_in_the_way_are_named_for_each_direction(self):
        path = self.file("slot.json", assembly(
            ["1-2", "2-3"], blocking={"directions": ["+x", "-x"], "blocked": [
                {"part": "2", "by": "1", "directions": ["+x", "-x"]}, {"part": "3", "by": "1", "directions": ["-x"]}]}))
        found = json.loads(orasp("explain", path, "--connection", "1-2", "--json").out)
        self.assertEqual(found["status"], "illegal")
        self.assertFalse(found["legal_later"])
        directions = {entry["direction"]: entry for entry in found["changes"][0]["directions"]}
        self.assertEqual(set(directions), {"+x", "-x"})
        for entry in directions.values():
            self.assertIn("blocking.blocked[0]", entry["entries"])
        self.check(orasp("explain", path), 10, out=r'blocking\.blocked\[0\]  "2" cannot leave "1" along \+x and -x')

    def test_in_the_middle_of_a_plan(self):
        plan = self.file("plan.json", orasp("solve", "lattice", "--json").out)
        steps = json.loads(Path(plan).read_text())["disassembly"]
        place = steps.index("4-5") + 1
        self.check(orasp("explain", "lattice", "--connection", "4-5", "--plan", plan, "--step", str(place)), 0,
                   out=rf'"4-5" may be removed at step {place}\na plan goes on', error=r"\A\Z")
        answer = orasp("explain", "lattice", "--connection", steps[0], "--plan", plan, "--step", "3")
        self.check(answer, 10, out="was removed before")
        self.check_sentence(orasp("explain", "lattice", "--connection", "4-5", "--plan", plan, "--step", "40"))
        twice = self.file("twice.json", '["1-2", "1-2", "1-4"]')
        self.check_sentence(orasp("explain", "lattice", "--connection", "4-5", "--plan", twice, "--step", "3"))
        wrong = self.file("wrong.json", '["4-5"]')
        self.check(orasp("explain", "lattice", "--connection", "1-2", "--plan", wrong, "--step", "2"), 0,
                   error="step 1 of the plan is not legal")

    def test_a_dead_end_is_legal_and_said_to_be_one(self):
        path = self.file("sandwich.json", assembly(
            ["1-3", "1-2", "2-3"], precedence=[{"connection": "2-3", "after": ["1-2"]}],
            blocking={"directions": ["+x", "-x"], "blocked": [{"part": "1", "by": "2", "directions": ["+x"]},
                                                              {"part": "1", "by": "3", "directions": ["-x"]}]}))
        self.check(orasp("explain", path, "--connection", "1-3"), 0, out="but no plan goes on from there: it is a dead end")
        self.assertIs(json.loads(orasp("explain", path, "--connection", "1-3", "--json").out)["plan_exists"], False)

    def test_what_is_not_decided_is_twenty(self):
        loops = [{"id": f"loop{i}", "parts": ["1", "1"]} for i in range(40)]
        problem = json.loads(assembly(["1-2"]))
        problem["connections"] += loops
        problem["blocking"] = {"directions": ["+x", "-x"],
                               "blocked": [{"part": "1", "by": "2", "directions": ["+x", "-x"]}]}
        answer = orasp("explain", "-", "--time-limit", "0.3", "--quiet", stdin=json.dumps(problem))
        self.check(answer, 20, out="not decided whether a plan exists: stopped by the time limit", error=r"\A\Z")

    def test_the_explanation_is_written_too(self):
        path = self.folder / "why.json"
        self.check(orasp("explain", "4brick", "--max-moved-parts", "0", "-o", str(path)), 10, out="no plan exists")
        self.assertEqual(json.loads(path.read_text())["status"], "infeasible")


class OtherPlans(Case):
    def test_optimal_sequences_are_counted(self):
        plan = json.loads(orasp("solve", "4brick", "--count", "--json").out)
        self.assertEqual(plan["optimal_sequences"], 2)
        self.assertNotIn("alternatives", plan)
        self.assertIs(plan["options"]["count"], True)
        self.check(orasp("solve", "4brick", "--count", "--method", "greedy"), 0, out=r"\n2 optimal sequences\n")
        flat = self.file("flat.json", json.dumps({"type": "completion", "join": 0}))
        plan = json.loads(orasp("solve", "hubble-free", "--count", "--objective", flat, "--json").out)
        self.assertEqual(plan["optimal_sequences"], "121645100408832000")  # 19!, past 2^53
        self.assertNotIn("optimal_sequences", json.loads(orasp("solve", "4brick", "--json").out))

    def test_the_best_plans_are_listed(self):
        plan = json.loads(orasp("solve", "4brick", "--alternatives", "4", "--json").out)
        self.assertEqual([round(other["reward"], 9) for other in plan["alternatives"]], [0.557, 0.557, 0.545, 0.545])
        self.assertEqual(len({tuple(other["disassembly"]) for other in plan["alternatives"]}), 4)
        for other in plan["alternatives"]:
            self.assertEqual(other["assembly"], other["disassembly"][::-1])
            answer = orasp("evaluate", "4brick", "-", "--json", stdin=json.dumps(other["disassembly"]))
            self.assertAlmostEqual(json.loads(answer.out)["reward"], other["reward"], places=9)
        self.check(orasp("solve", "4brick", "--alternatives", "2"), 0, out=r"the 2 best plans\n   1  reward 0\.557\n      2-3, ")
        self.check(orasp("solve", "4brick", "--alternatives", "100"), 0, out=r"all 6 plans\n")
        forward = json.loads(orasp("solve", "4brick", "--alternatives", "1", "--direction", "assembly", "--json").out)
        self.assertEqual(forward["alternatives"][0]["disassembly"], forward["alternatives"][0]["assembly"][::-1])
        self.check(orasp("evaluate", "4brick", "-", "--direction", "assembly",
                         stdin=json.dumps(forward["alternatives"][0]["assembly"])), 0, out="is valid")

    def test_where_there_is_no_plan_there_is_none(self):
        plan = orasp("solve", "4brick", "--max-moved-parts", "0", "--count", "--alternatives", "3", "--json")
        self.assertEqual(plan.code, 10)
        self.assertEqual((json.loads(plan.out)["optimal_sequences"], json.loads(plan.out)["alternatives"]), (0, []))
        cycle = orasp("solve", "-", "--count", "--alternatives", "3", "--json", stdin=CYCLE)
        self.assertEqual(cycle.code, 10)
        self.assertEqual((json.loads(cycle.out)["optimal_sequences"], json.loads(cycle.out)["alternatives"]), (0, []))

    def test_a_graph_too_large_is_refused_at_once(self):
        for words in (["--count"], ["--alternatives", "2"]):
            answer = orasp("solve", "jwst", *words, "--quiet")
            self.check_sentence(answer)
            self.assertRegex(answer.error, rf"{words[0]} needs the whole state-action graph: .* are allowed\n")

    def test_a_limit_leaves_the_plan_and_says_what_is_missing(self):
        answer = orasp("solve", "random:12:22:1", "--method", "greedy", "--count", "--time-limit", "0.2", "--json")
        plan = json.loads(answer.out)
        self.assertEqual(answer.code, 20)
        self.assertNotIn("optimal_sequences", plan)
        self.assertEqual(len(plan["disassembly"]), 22)
        self.assertIn("building H for other plans was stopped by the time limit", plan["notes"])


class Order(Case):
    def test_every_order_that_keeps_the_pairs_of_a_plan_is_valid(self):
        for problem, words in [("lattice", []), ("hubble-upc", []), ("lattice", ["--direction", "assembly"]),
                               ("grid:3x4", ["--max-moved-parts", "2", "--max-subassemblies", "2"])]:
            with self.subTest(problem=problem, words=words):
                plan = json.loads(orasp("solve", problem, *words, "--json").out)
                ids = [step["connection"] for step in plan["steps"]]
                waits = {step: {early for early, late in plan["order"] if late == step}
                         for step in range(1, len(ids) + 1)}
                order = []
                while waits:  # the last step that may come now: as far from the plan's own order as can be
                    order.append(max(step for step, before in waits.items() if before <= set(order)))
                    del waits[order[-1]]
                self.assertNotEqual(order, sorted(order))
                mine = self.file("order.json", json.dumps([ids[step - 1] for step in order]))
                self.check(orasp("evaluate", problem, mine, *words), 0, out="the plan is valid")

    def test_a_plan_with_its_order_is_read_again_and_an_empty_one_has_none(self):
        plan = orasp("solve", "lattice", "--json").out
        self.check(orasp("evaluate", "lattice", "-", stdin=plan), 0, out="the plan is valid")
        self.assertEqual(json.loads(orasp("solve", "-", "--json", stdin=assembly([])).out)["order"], [])
        self.assertEqual(json.loads(orasp("solve", "4brick", "--max-moved-parts", "0", "--json").out)["order"], [])


class Graph(Case):
    def test_sizes_are_those_of_the_reference(self):
        for name, states, actions in [("lattice", 1296, 6048), ("hubble", 12096, 67824), ("2x3", 96, 304)]:
            with self.subTest(name=name):
                answer = orasp("graph", name, "--json")
                self.check(answer, 0)
                size = json.loads(answer.out)
                self.assertEqual(set(size), {"states", "actions", "layers", "dead_ends", "tree_nodes", "sequences",
                                             "seconds"})
                self.assertEqual((size["states"], size["actions"], size["dead_ends"]), (states, actions, 0))
                self.assertEqual(sum(layer["states"] for layer in size["layers"]), states)
                self.assertEqual(sum(layer["actions"] for layer in size["layers"]), actions)
        self.check(orasp("graph", "lattice"), 0, out=r"1,296 states, 6,048 actions, 0 dead ends")

    def test_numbers_past_two_to_the_53_are_strings(self):
        small = json.loads(orasp("graph", "4brick", "--json").out)
        self.assertEqual((small["tree_nodes"], small["sequences"]), (16, 6))  # 1 + 3 + 6 + 6
        large = json.loads(orasp("graph", "hubble-free", "--json").out)
        self.assertEqual(large["sequences"], str(121645100408832000))  # 19!

    def test_an_infeasible_problem_is_ten(self):
        self.check(orasp("graph", "-", stdin=CYCLE), 10, out=r"infeasible \(proved\)")
        size = json.loads(orasp("graph", "-", "--json", stdin=CYCLE).out)
        self.assertEqual((size["states"], size["dead_ends"], size["sequences"]), (1, 1, 0))

    def test_drawings_are_written(self):
        dot, svg = self.folder / "h.dot", self.folder / "h.svg"
        self.check(orasp("graph", "4piece", "--dot", str(dot), "--svg", str(svg)), 0, out=r"16 states, 32 actions")
        self.assertEqual(dot.read_text().count(" -> "), 32)
        self.assertEqual(svg.read_text().count('class="edge"'), 32)
        self.assertEqual(orasp("graph", "4piece", "--dot", "-").out, dot.read_text())
        self.assertEqual(orasp("graph", "4piece", "--svg", "-").out, svg.read_text())

    def test_too_large_to_draw_and_no_program_to_draw_with(self):
        svg = self.folder / "h.svg"
        self.check_sentence(orasp("graph", "hubble", "--svg", str(svg)))
        answer = orasp("graph", "4piece", "--svg", str(svg), environment={"PATH": "/nonexistent"})
        self.check_sentence(answer)
        self.assertIn("Debian package graphviz", answer.error)
        self.assertEqual(os.listdir(self.folder), [])

    def test_a_program_that_fails_to_draw(self):
        dot = self.folder / "dot"
        dot.write_text("#!/bin/sh\necho 'no such luck' >&2\nexit 3\n")
        dot.chmod(0o755)
        answer = orasp("graph", "4piece", "--svg", str(self.folder / "h.svg"),
                       environment={"PATH": f"{self.folder}:{os.environ['PATH']}"})
        self.check_sentence(answer)
        self.assertRegex(answer.error, r"exit code 3: no such luck")
        self.assertEqual(os.listdir(self.folder), ["dot"])

    def test_a_limit_gives_the_layers_so_far(self):
        answer = orasp("graph", "chain:27", "--time-limit", "1", "--json")
        self.check(answer, 20)
        size = json.loads(answer.out)
        self.assertEqual((size["stopped"], size["sequences"], size["tree_nodes"]), ("time limit", None, None))
        self.assertGreater(size["states"], 1)


class Compare(Case):
    KEYS = ["problem", "method", "status", "reward", "bound", "seconds", "states", "actions", "expanded", "generated",
            "pruned", "message"]

    def test_every_exact_method_agrees_and_is_there_by_default(self):
        answer = orasp("compare", "2x3", "4brick", "--json")
        self.check(answer, 0, error=r"\A\Z")
        document = json.loads(answer.out)
        self.assertEqual(list(document), ["rows"])
        rows = document["rows"]
        for row in rows:
            self.assertEqual(list(row), self.KEYS)
            self.assertEqual(row["status"], "optimal")
            self.assertAlmostEqual(row["reward"], {"2x3": 0.3636, "4brick": 0.557}[row["problem"]], places=9)
        self.assertLessEqual({"value-iteration", "dijkstra", "bellman-ford", "orasp-search", "exhaustive"},
                             {row["method"] for row in rows})

    def test_a_method_that_refuses_has_a_row_where_it_was_named(self):
        answer = orasp("compare", "jwst", "--methods", "dijkstra,greedy", "--json", "--quiet")
        self.check(answer, 0)
        refused, greedy = json.loads(answer.out)["rows"]
        self.assertEqual((refused["method"], refused["status"], refused["reward"]), ("dijkstra", "refused", None))
        self.assertIn("state-action graph", refused["message"])
        self.assertEqual(greedy["status"], "feasible")
        rows = json.loads(orasp("compare", "grid:4x3", "--json", "--time-limit", "20").out)["rows"]  # 17 connections
        self.assertNotIn("exhaustive", [row["method"] for row in rows])

    def test_the_table_in_other_forms(self):
        name = self.folder / 'a, "b".json'
        name.write_text(CHAIN)
        answer = orasp("compare", str(name), "jwst", "--methods", "dijkstra,greedy", "--csv", "--quiet")
        rows = list(csv.DictReader(io.StringIO(answer.out)))
        self.assertEqual(list(rows[0]), self.KEYS)
        self.assertEqual([row["problem"] for row in rows], [str(name)] * 2 + ["jwst"] * 2)
        self.assertAlmostEqual(float(rows[0]["reward"]), 0.557)
        self.assertEqual(rows[2]["status"], "refused")
        lines = orasp("compare", "4brick", "--methods", "greedy,dijkstra", "--markdown").out.splitlines()
        self.assertEqual(len(lines), 4)
        self.assertRegex(lines[0], r"^\| problem +\| method +\| status +\| reward +\| seconds +\| states")
        self.assertEqual(len({line.count("|") for line in lines}), 1)

    def test_a_limit_holds_for_each_run_and_is_no_failure(self):
        answer = orasp("compare", "iss", "--methods", "orasp-search,greedy", "--objective", "indexed",
                       "--time-limit", "0.3", "--json")
        self.check(answer, 0)
        self.assertEqual(json.loads(answer.out)["rows"][0]["message"].split(";")[0], "stopped by the time limit")

    def test_the_table_is_written_too(self):
        path = self.folder / "table"
        answer = orasp("compare", "4brick", "--methods", "greedy", "--csv", "-o", str(path))
        self.assertEqual(path.read_text(), answer.out)
        orasp("compare", "4brick", "--methods", "greedy", "-o", str(path))
        self.assertEqual(json.loads(path.read_text())["rows"][0]["method"], "greedy")


class Sample(Case):
    def test_the_figures_are_those_of_the_rewards(self):
        answer = orasp("sample", "hubble-free", "-n", "101", "--seed", "3", "--json")
        self.check(answer, 0)
        sample = json.loads(answer.out)
        self.assertEqual(list(sample), ["n", "seed", "mean", "deviation", "min", "quartiles", "max", "rewards"])
        rewards = sample["rewards"]
        self.assertEqual((sample["n"], sample["seed"], len(rewards)), (101, 3, 101))
        self.assertAlmostEqual(sample["mean"], statistics.mean(rewards))
        self.assertAlmostEqual(sample["deviation"], statistics.stdev(rewards))
        self.assertEqual((sample["min"], sample["max"]), (min(rewards), max(rewards)))
        for ours, theirs in zip(sample["quartiles"], statistics.quantiles(rewards, n=4, method="inclusive")):
            self.assertAlmostEqual(ours, theirs)

    def test_the_same_seed_gives_the_same_bytes_and_longer_samples_begin_alike(self):
        first = orasp("sample", "hubble", "-n", "20", "--json").out
        self.assertEqual(first, orasp("sample", "hubble", "-n", "20", "--seed", "1", "--json").out)
        longer = json.loads(orasp("sample", "hubble", "-n", "30", "--json").out)
        self.assertEqual(longer["rewards"][:20], json.loads(first)["rewards"])

    def test_evaluate_agrees_with_each_sampled_sequence(self):
        for changes in ([], ["--direction", "assembly"]):
            sample = json.loads(orasp("sample", "hubble-upc", "-n", "5", "--json", "--sequences", *changes).out)
            self.assertEqual(len(sample["sequences"]), 5)
            for reward, sequence in zip(sample["rewards"], sample["sequences"]):
                answer = orasp("evaluate", "hubble-upc", "-", "--json", *changes, stdin=json.dumps(sequence))
                self.check(answer, 0)
                self.assertAlmostEqual(json.loads(answer.out)["reward"], reward)

    def test_one_reward_has_no_deviation(self):
        sample = json.loads(orasp("sample", "hubble", "-n", "1", "--json").out)
        self.assertEqual(sample["deviation"], 0)
        self.assertEqual(sample["quartiles"], sample["rewards"] * 3)

    def test_an_infeasible_problem_is_ten(self):
        self.check(orasp("sample", "-", stdin=CYCLE), 10, out=r'"1-2" after "2-3"')
        answer = orasp("sample", "-", "--json", stdin=CYCLE)
        self.check(answer, 10, error=r'"1-2" after "2-3"')
        self.assertEqual(json.loads(answer.out)["n"], 0)

    def test_people_see_a_histogram(self):
        self.check(orasp("sample", "hubble", "-n", "200"), 0, out=r"mean +-\d.*\n(.*\n)+rewards from\n(.*#.*\n)+")


class Train(Case):
    """Learning; where this build has no libtorch only what needs none."""

    @classmethod
    def setUpClass(cls):
        answer = orasp("train", "4brick", "--episodes", "1", "--quiet")
        cls.learns = "libtorch" not in answer.error
        if not cls.learns:
            assert answer.code == 30, answer.error

    def needs_libtorch(self):
        if not self.learns:
            self.skipTest("built without libtorch")

    def trained(self, problem="hubble-upc", *arguments):
        policy = self.folder / "policy.pt"
        answer = orasp("train", problem, "-o", policy, *arguments)
        self.assertIn(answer.code, (0, 20), answer.error)
        return policy

    def test_a_policy_is_written_and_plans_as_well_as_it_says(self):
        self.needs_libtorch()
        policy = self.folder / "policy.pt"
        answer = orasp("train", "2x3", "-o", policy, "--json", "--log", self.folder / "log")
        self.assertEqual(answer.code, 0, answer.error)
        outcome = json.loads(answer.out)
        self.assertEqual(outcome["status"], "optimal")
        self.assertAlmostEqual(outcome["policy_reward"], 0.3636)
        self.assertAlmostEqual(outcome["bound"], 0.3636)
        self.assertEqual(len(outcome["sequence"]), 7)
        self.assertRegex(answer.error, r"episodes .* updates +greedy .* best .* bound")
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["log", "policy.pt"])

        plan = orasp("solve", "2x3", "--method", "dqn", "--policy", policy, "--json")
        self.assertEqual(plan.code, 0, plan.error)
        self.assertEqual(json.loads(plan.out)["reward"], outcome["policy_reward"])
        self.assertEqual(orasp("evaluate", "2x3", "-", stdin=plan.out).code, 0)

        records = [json.loads(line) for line in (self.folder / "log").read_text().splitlines()]
        self.assertGreaterEqual(len(records), 1)
        for record in records:
            self.assertLessEqual(record["best"], record["bound"] + 1e-9)
        self.assertEqual(records[-1]["episodes"], outcome["episodes"])

    def test_a_policy_beside_random_sequences(self):
        self.needs_libtorch()
        policy = self.trained()
        sample = json.loads(orasp("sample", "hubble-upc", "--policy", policy, "--json").out)
        self.assertEqual(sample["n"], 100)
        self.assertEqual(sample["best_status"], "optimal")
        self.assertAlmostEqual(sample["best_reward"], -0.9902)
        self.assertAlmostEqual(sample["bound"], -0.9902)
        self.assertGreater(sample["policy_reward"], sample["max"] + 0.2)
        text = orasp("sample", "hubble-upc", "--policy", policy).out
        self.assertIn("more than 100 of 100 random sequences", text)

    def test_the_same_seed_gives_the_same_policy(self):
        self.needs_libtorch()
        outcomes = []
        for seed in ("7", "7", "8"):
            out = orasp("train", "lattice", "--episodes", "200", "--to-the-end", "--seed", seed, "--json", "--log",
                        self.folder / "log").out
            outcome = json.loads(out)
            outcome.pop("seconds")
            losses = [json.loads(line)["loss"] for line in (self.folder / "log").read_text().splitlines()]
            outcomes.append((outcome, losses))
        self.assertEqual(outcomes[0], outcomes[1])
        self.assertNotEqual(outcomes[0], outcomes[2])

    def test_it_goes_on_where_it_stopped(self):
        self.needs_libtorch()
        policy = self.trained("lattice", "--episodes", "128", "--to-the-end", "--log", self.folder / "log")
        before = len((self.folder / "log").read_text().splitlines())
        answer = orasp("train", "lattice", "--resume", policy, "-o", policy, "--episodes", "256", "--to-the-end",
                       "--json", "--log", self.folder / "log")
        self.assertEqual(answer.code, 0, answer.error)
        self.assertEqual(json.loads(answer.out)["episodes"], 256)
        lines = [json.loads(line)["episodes"] for line in (self.folder / "log").read_text().splitlines()]
        self.assertGreater(len(lines), before)
        self.assertEqual(lines, sorted(lines))

    def test_limits_and_interrupts_keep_the_best(self):
        self.needs_libtorch()
        policy = self.trained("iss", "--time-limit", "10", "--to-the-end", "--quiet")
        self.assertEqual(orasp("solve", "iss", "--method", "dqn", "--policy", policy).code, 0)
        policy.unlink()
        with subprocess.Popen([PROGRAM, "train", "iss", "--to-the-end", "-o", policy], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE,
                              preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)) as process:
            process.stderr.readline()  # the first round is over
            process.send_signal(signal.SIGINT)
            out, _ = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 20)
        self.assertIn("interrupted", out.decode())
        self.assertEqual(orasp("solve", "iss", "--method", "dqn", "--policy", policy).code, 0)

    def test_solve_trains_where_no_policy_is_given(self):
        self.needs_libtorch()
        answer = orasp("solve", "hubble-upc", "--method", "dqn", "--json", "--time-limit", "60")
        self.assertIn(answer.code, (0, 20), answer.error)
        self.assertGreater(json.loads(answer.out)["reward"], -1.01)

    def test_no_plan_is_said_without_training(self):
        for command in (["train", "4brick"], ["solve", "4brick", "--method", "dqn"]):
            answer = orasp(*command, "--max-moved-parts", "0")
            self.assertEqual(answer.code, 10, answer.error)
            self.assertIn("infeasible", answer.out)

    def test_foreign_damaged_and_missing_policies_are_refused_in_a_sentence(self):
        self.needs_libtorch()
        policy = self.trained()
        good = policy.read_bytes()
        bad = self.folder / "bad.pt"
        for content, words in [(good[:1000], "damaged or cut off"), (good[:-1], "damaged or cut off"),
                               (b"", "no policy"), (b"PK\x03\x04", "no policy"), (CHAIN.encode(), "no policy"),
                               (good.replace(b"steps", b"stepz"), "damaged")]:
            bad.write_bytes(content)
            for command in (["solve", "hubble-upc", "--method", "dqn", "--policy", bad],
                            ["train", "hubble-upc", "--resume", bad], ["sample", "hubble-upc", "--policy", bad]):
                answer = orasp(*command)
                self.assertEqual(answer.code, 30, answer.error)
                self.assertEqual(answer.error.count("\n"), 1, answer.error)
                self.assertIn(words, answer.error)
                self.assertIn("bad.pt", answer.error)
            self.assertEqual(bad.read_bytes(), content)
        for command in (["solve", "iss-upc", "--method", "dqn", "--policy", policy],
                        ["solve", "hubble-upc", "--objective", "custom", "--method", "dqn", "--policy", policy],
                        ["train", "iss-upc", "--resume", policy]):
            answer = orasp(*command)
            self.assertEqual(answer.code, 30)
            self.assertIn("was trained on another problem", answer.error)
        self.assertEqual(orasp("solve", "hubble", "--method", "dqn", "--policy", "absent.pt").code, 30)
        answer = orasp("solve", "hubble-upc", "--policy", policy)
        self.assertEqual(answer.code, 30)
        self.assertIn("--policy belongs to the method dqn", answer.error)

    def test_options_that_make_no_sense(self):
        for arguments, words in [(["--discount", "1.5"], "from 0 to 1"), (["--epsilon-end", "-1"], "from 0 to 1"),
                                 (["--imitation", "nan"], "from 0 to 1"), (["--hidden", "8,,8"], "whole number"),
                                 (["--hidden", "0"], "whole number"), (["--learning-rate", "0"], "above 0"),
                                 (["--environments", "0"], "whole number"), (["--episodes", "0"], "whole number")]:
            answer = orasp("train", "4brick", *arguments)
            self.assertEqual(answer.code, 30, arguments)
            self.assertIn(words, answer.error)
            self.assertIn(arguments[0], answer.error)
        if self.learns:
            answer = orasp("train", "4brick", "--device", "tpu")
            self.assertEqual(answer.code, 30)
            self.assertIn("none of auto, cpu, cuda", answer.error)
        answer = orasp("train", "4brick", "--log", self.folder / "no" / "log")
        self.assertEqual(answer.code, 30)
        self.assertIn("cannot write", answer.error)

    def test_a_folder_that_is_not_there_is_said_before_training(self):
        answer = orasp("train", "iss", "--to-the-end", "-o", self.folder / "no" / "policy.pt", "--time-limit", "60")
        self.assertEqual(answer.code, 30)
        self.assertIn("no/policy.pt", answer.error)

    def test_without_its_module_the_program_says_how_to_get_it_and_does_all_else(self):
        alone = self.folder / "bin" / "orasp"
        alone.parent.mkdir()
        alone.write_bytes(Path(PROGRAM).read_bytes())
        alone.chmod(0o755)

        def run(*arguments):
            return subprocess.run([alone, *arguments], capture_output=True, text=True, timeout=60)
        for command in (["train", "hubble"], ["solve", "hubble", "--method", "dqn"]):
            answer = run(*command)
            if "libtorch" not in answer.stderr and answer.returncode != 30:
                self.skipTest("a module is installed on this machine")
            self.assertEqual(answer.returncode, 30)
            self.assertIn("libtorch-dev and libopenblas0-pthread", answer.stderr)
            self.assertEqual(answer.stderr.count("\n"), 1)
        self.assertEqual(run("solve", "hubble").returncode, 0)
        if self.learns:  # planning with a policy needs no libtorch
            policy = self.trained()
            self.assertEqual(run("solve", "hubble-upc", "--method", "dqn", "--policy", policy).returncode, 0)

    def test_the_program_is_not_linked_to_libtorch(self):
        libraries = subprocess.run(["ldd", PROGRAM], capture_output=True, text=True, check=True).stdout
        self.assertNotIn("torch", libraries)


class Report(Case):
    def data_of(self, page):
        """The data that a page holds."""
        return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[1])

    def test_the_page_is_written_whole_and_said_to_be(self):
        path = self.folder / "page.html"
        self.check(orasp("report", "2x3", "-o", path), 0, out=r"\A2x3: 1 plan, written to .*page\.html \(\d+ kB\)\n\Z")
        page = path.read_text(encoding="utf-8")
        self.assertTrue(page.startswith("<!doctype html>") and page.rstrip().endswith("</html>"))
        self.assertLess(len(page.encode()), 2 << 20)
        self.assertNotRegex(page, r"orasp:(title|style|data|3d|script|policy)")
        data = self.data_of(page)
        self.assertEqual(data["plans"][0]["status"], "optimal")
        self.assertEqual(orasp("report", "2x3", "-o", "-").out.count("</html>"), 1)

    def test_what_makes_no_sense_is_refused_in_a_sentence(self):
        sample = self.file("sample.json", "[1, 2]")
        page = str(self.folder / "page.html")
        for words, said in [
            (["2x3"], "-o FILE is missing"),
            (["2x3", "-o", page, "--sample", sample, "--sample-count", "3"], "exclude each other"),
            (["-", "-", "-o", page], "one thing only"),
            (["2x3", "-o", page, "--sample", self.file("bad.json", "{}")], 'bad.json: the key "rewards" is missing'),
            (["2x3", "-o", page, "--log", self.file("log", "{}\n")], "log: training log, line 1: the key"),
            (["2x3", "no-such-plan", "-o", page], "cannot read"),
            (["chain:1500", *[self.file("long.txt", "\n".join(f"{i}-{i + 1}" for i in range(1, 1500)))] * 8,
              "--time-limit", "0.1", "-o", page], "the report would take"),
        ]:
            with self.subTest(words=words):
                answer = orasp("report", *words)
                self.check_sentence(answer)
                self.assertIn(said, answer.error)
                self.assertFalse(os.path.exists(page))

    def test_a_plan_that_breaks_rules_is_shown_and_ten(self):
        page = self.folder / "page.html"
        self.check(orasp("report", ROOT / "examples/shelf.json", ROOT / "examples/shelf-wrong-order.txt", "-o", page), 10)
        plan = self.data_of(page.read_text(encoding="utf-8"))["plans"][0]
        self.assertEqual(plan["status"], "not valid")
        self.assertEqual([violation[2] for violation in plan["violations"]], ["precedence", "blocking"])

    def test_a_problem_without_a_plan_is_shown_with_the_conflict_and_ten(self):
        page = self.folder / "page.html"
        self.check(orasp("report", self.file("cycle.json", CYCLE), "-o", page), 10)
        data = self.data_of(page.read_text(encoding="utf-8"))
        self.assertEqual(data["plans"], [])
        self.assertEqual(len(data["best"]["conflict"]), 2)

    def test_claims_of_a_plan_file_are_not_believed(self):
        plan = json.loads(orasp("solve", "lattice", "--method", "greedy", "--json").out)
        plan.update(status="optimal", bound=plan["reward"])
        page = self.folder / "page.html"
        self.check(orasp("report", "lattice", self.file("claim.json", json.dumps(plan)), "-o", page), 0)
        shown = self.data_of(page.read_text(encoding="utf-8"))["plans"][0]
        self.assertEqual(shown["status"], "feasible")
        self.assertAlmostEqual(shown["gap"], 0.012)

    def test_a_plan_for_another_problem_is_worth_a_warning(self):
        plan = json.loads(orasp("solve", "2x3", "--json").out)
        plan["problem_digest"] = "0" * 64
        answer = orasp("report", "2x3", self.file("plan.json", json.dumps(plan)), "-o", self.folder / "page.html")
        self.check(answer, 0, error=r"warning: .*plan\.json was made for another problem")

    def test_a_sample_is_that_of_sample(self):
        page = self.folder / "page.html"
        self.check(orasp("report", "hubble", "--sample-count", "50", "--seed", "3", "-o", page), 0)
        sample = self.data_of(page.read_text(encoding="utf-8"))["sample"]
        expected = json.loads(orasp("sample", "hubble", "-n", "50", "--seed", "3", "--json").out)
        for name in ("n", "mean", "deviation", "min", "quartiles", "max"):
            self.assertEqual(sample[name], expected[name])

    def test_a_fleet_is_shown_robot_by_robot(self):
        page = self.folder / "page.html"
        self.check(orasp("report", "fleet-lattice", "-o", page), 0)
        data = self.data_of(page.read_text(encoding="utf-8"))
        solved = json.loads(orasp("solve", "fleet-lattice", "--json").out)
        self.assertEqual(data["fleet"]["robots"], 4)
        self.assertEqual(len(data["plans"][0]["steps"]), len(solved["steps"]))
        travel = self.file("travel.json", orasp("solve", "fleet-lattice", "--objective", "travel", "--json").out)
        self.check(orasp("report", "fleet-lattice", travel, "-o", page), 0)
        self.assertEqual(self.data_of(page.read_text(encoding="utf-8"))["plans"][0]["status"], "optimal")
        one = self.file("one.txt", "")
        self.check_sentence(orasp("report", "fleet-lattice", travel, one, "-o", page))
        self.check_sentence(orasp("report", "fleet-lattice", "--sample-count", "3", "-o", page))


class Scenarios(Case):
    def test_each_can_be_printed_and_solved_from_standard_input(self):
        listing = json.loads(orasp("scenarios", "--json").out)
        names = [entry["name"] for entry in listing]
        self.assertLessEqual({"lattice", "hubble", "jwst-upc", "chain:N"}, set(names))
        human = orasp("scenarios").out
        for entry in listing:
            self.assertEqual(set(entry), {"name", "parts", "connections", "summary", "generator"})
            self.assertRegex(human, rf"(?m)^{re.escape(entry['name'])} ")
            if entry["generator"]:
                continue
            with self.subTest(name=entry["name"]):
                problem = json.loads(orasp("scenarios", entry["name"]).out)
                self.assertEqual(len(problem["parts"]), entry["parts"])
                self.assertEqual(len(problem["connections"]), entry["connections"])
        text = orasp("scenarios", "grid:3x3").out
        by_name = json.loads(orasp("solve", "grid:3x3", "--json").out)
        by_file = json.loads(orasp("solve", "-", "--json", stdin=text).out)
        self.assertEqual(by_name["problem_digest"], by_file["problem_digest"])
        self.assertEqual(by_name["disassembly"], by_file["disassembly"])

    def test_it_can_be_written_to_a_file(self):
        path = self.folder / "lattice.json"
        answer = orasp("scenarios", "lattice", "-o", str(path))
        self.assertEqual(path.read_text(), answer.out)


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    PROGRAM = str(Path(sys.argv.pop(1)).resolve())
    unittest.main()
