#!/usr/bin/env python3
"""Checks what the compiler makes of a user's code.

    tests/compile/compile_test.py CXX

Mistakes that must not compile stand in REFUSED, each beside the same line done right: all right lines compile together,
and each mistake is refused on its own line for the reason stated. Examples in the comments of headers compile without
a warning.
"""
import re
import subprocess
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
CXX = "c++"
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Werror"]

# What the lines below may use.
SETTING = """
#include "orasp/orasp.h"
namespace orasp {
[[maybe_unused]] constexpr auto use = [](const auto&...) {};
Problem make_problem();
Policy make_policy();
[[maybe_unused]] void judge(const Problem& problem, const TransitionSystem& system, const StateGraph& graph,
                            const FleetProblem& fleet, const Policy& policy, PartIndex part,
                            ConnectionIndex connection, StateId state, ActionId action) {
  use(problem, system, graph, fleet, policy, part, connection, state, action);
"""
DELETED = "use of deleted function"
# name: (the line done right, the mistake, what the compiler says of the mistake)
REFUSED = {
    "a part from a connection": ("PartIndex p = part; use(p);", "PartIndex p = connection; use(p);", DELETED),
    "a part from a connection by a cast": ("PartIndex p(part); use(p);", "PartIndex p(connection); use(p);", DELETED),
    "a connection from a part": ("connection = 3;", "connection = part;", DELETED),
    "a state from an action": ("state = graph.successor(action);", "state = action;", DELETED),
    "a state from a connection": ("state = 0;", "state = connection;", DELETED),
    "a part asked for as a connection": ("use(problem.ends(connection));", "use(problem.ends(part));", DELETED),
    "a state asked for as an action": ("use(graph.reward(graph.begin(state)));", "use(graph.reward(state));", DELETED),
    "a part compared with a connection": ("use(part == part);", "use(part == connection);", DELETED),
    "a part before a connection": ("use(part < part);", "use(part < connection);", DELETED),
    "a list of the wrong kind": ("std::vector<PartIndex> list{part}; std::span<const PartIndex> view = list; use(view);",
                                 "std::vector<PartIndex> list{part}; std::span<const ConnectionIndex> view = list; use(view);",
                                 "conversion from"),
    "a system of a temporary problem": ("TransitionSystem s(problem); use(s.words());",
                                        "TransitionSystem s(make_problem()); use(s.words());", DELETED),
    "a system of a temporary problem and a situation": (
        "TransitionSystem s(problem, Situation::whole(3)); use(s.words());",
        "TransitionSystem s(make_problem(), Situation::whole(3)); use(s.words());", DELETED),
    "an expander of a temporary system": ("Expander e(system); use(e);", "Expander e(TransitionSystem{problem}); use(e);",
                                          DELETED),
    "a graph of a temporary system": ("use(StateGraph::build(system, {}));",
                                      "use(StateGraph::build(TransitionSystem(problem), {}));", DELETED),
    "an uncertain graph of a temporary system": ("use(UncertainGraph::build(system, {}));",
                                                 "use(UncertainGraph::build(TransitionSystem(problem), {}));", DELETED),
    "an index of a temporary graph": ("StateIndex i(graph); use(i);", "StateIndex i(StateGraph::build(system, {})); use(i);",
                                      DELETED),
    "an environment of a temporary system": ("Environment e(system, 1); use(e);",
                                             "Environment e(TransitionSystem(problem), 1); use(e);", DELETED),
    "a vector environment of a temporary system": ("VectorEnvironment e(system, 1); use(e);",
                                                   "VectorEnvironment e(TransitionSystem(problem), 1); use(e);", DELETED),
    "an evaluator of a temporary policy": ("PolicyEvaluator e(policy); use(e);", "PolicyEvaluator e(make_policy()); use(e);",
                                           DELETED),
    "a fleet of a temporary problem": ("FleetProblem f(problem); use(f);", "FleetProblem f(make_problem()); use(f);", DELETED),
    "a task of a temporary problem": ("Task t(problem); use(t.whole());", "Task t(make_problem()); use(t.whole());", DELETED),
    "an expander of a temporary fleet": ("FleetExpander<PartsIn<1>> e(fleet); use(e);",
                                         "FleetExpander<PartsIn<1>> e(FleetProblem{problem}); use(e);",
                                         DELETED),
}
# Headers whose one example is a whole piece of code.
EXAMPLES = ["orasp.h", "model/problem.h"]


def compiled(text, *options):
    """What the compiler writes about `text`, and whether it takes it."""
    done = subprocess.run([CXX, "-std=c++20", "-fsyntax-only", "-fno-diagnostics-show-caret", f"-I{ROOT / 'src'}", *options,
                           "-x", "c++", "-"], input=text, capture_output=True, text=True)
    return done.stderr, done.returncode == 0


def snippet(lines):
    """Each line in a block of its own, the first of them line 1 of a file named `user`."""
    return SETTING + '#line 1 "user"\n' + "".join(f"  {{ {line} }}\n" for line in lines) + "}\n}\n"


def example(header):
    """The lines of code, indented, in the comments of a header that has one example."""
    text = (ROOT / "src/orasp" / header).read_text(encoding="utf-8")
    return re.findall(r"^///     (.*)$", text, re.MULTILINE)


class Compile(unittest.TestCase):
    def test_the_lines_done_right_compile(self):
        errors, taken = compiled(snippet(right for right, _, _ in REFUSED.values()), *WARNINGS)
        self.assertTrue(taken, errors)

    def test_each_mistake_is_refused_for_its_reason(self):
        errors, taken = compiled(snippet(mistake for _, mistake, _ in REFUSED.values()))
        self.assertFalse(taken)
        for number, (name, (_, mistake, reason)) in enumerate(REFUSED.items(), 1):
            with self.subTest(name):
                said = re.findall(rf"^user:{number}:\d+: error: (.*)$", errors, re.MULTILINE)
                self.assertTrue(any(reason in line for line in said), f"{mistake}\n{said}")

    def test_the_examples_in_headers_compile_without_a_warning(self):
        for header in EXAMPLES:
            with self.subTest(header):
                lines = example(header)
                self.assertTrue(lines)
                includes = "\n".join(line for line in lines if line.startswith("#include"))
                body = "\n".join(line for line in lines if not line.startswith("#include"))
                errors, taken = compiled(f'#include "orasp/orasp.h"\n{includes}\nusing namespace orasp;\n'
                                         "constexpr auto use = [](const auto&...) {};\n"
                                         f'void tour();\nvoid tour() {{\n#line 1 "{header}"\n{body}\n}}\n', *WARNINGS)
                self.assertTrue(taken, errors)


if __name__ == "__main__":
    CXX = sys.argv.pop(1) if len(sys.argv) > 1 else CXX
    unittest.main()
