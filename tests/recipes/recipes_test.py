#!/usr/bin/env python3
"""Follows recipes of CONTRIBUTING.md on a copy of the tree, and looks whether they do what they promise.

    tests/recipes/recipes_test.py BUILD    BUILD: the folder of a build of the program, made by Ninja

Only what a recipe changes is compiled, with the flags of BUILD; the rest comes from the libraries there.
"""
import json
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
BUILD = Path()
COPIED = ["src", "docs", "tests/docs_options.py"]

TOY_OPTION = """    OptionSpec{"toy", "N",
               WholeOption{[](Options& o) -> std::uint64_t& { return o.value_iteration.max_sweeps; }, 1},
               "Play with N toys", "none"},
"""

TOY_PLANNER = """#include "orasp/planners/toy.h"

#include "orasp/planners/greedy.h"

namespace orasp {

Result toy(const TransitionSystem& system, const Budget& budget) {
  Result result = greedy(system, budget);
  result.method = "toy";
  return result;
}

}  // namespace orasp
"""
TOY_HEADER = """#pragma once

#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

[[nodiscard]] Result toy(const TransitionSystem& system, const Budget& budget);

}  // namespace orasp
"""
TOY_ROW = """    Planner{.name = "toy",
            .summary = "whatever greedy finds",
            .run = [](const Request& request) { return toy(*request.system, request.budget); }},
"""


def command_of(target, words):
    """The command that Ninja would run last for `target` with all of `words` in it, as a list."""
    listing = subprocess.run(["ninja", "-C", BUILD, "-t", "commands", target], capture_output=True, text=True, check=True)
    line = next(line for line in reversed(listing.stdout.splitlines()) if all(word in line for word in words))
    return shlex.split(next(part for part in line.split(" && ") if all(word in part for word in words)))


class Tree:
    """A copy of the sources, and a program that is built from it."""

    def __init__(self, folder):
        self.root = Path(folder)
        for name in COPIED:
            source, target = ROOT / name, self.root / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copytree(source, target) if source.is_dir() else shutil.copy(source, target)
        self.program = self.root / "orasp"

    def insert(self, file, before, text):
        """Writes `text` before the one place where `before` stands."""
        path = self.root / file
        old = path.read_text(encoding="utf-8")
        assert old.count(before) == 1, f"{file} holds {before!r} {old.count(before)} times"
        path.write_text(old.replace(before, text + before), encoding="utf-8")

    def build(self, *files):
        """Compiles `files` of the copy as BUILD compiles the catalogue, and links them with all else."""
        like = ROOT / "src/orasp/catalogue_table.cpp"  # which is compiled alone
        objects = []
        for file in files:
            words = command_of("orasp", [str(like), "-c", "-o"])
            out = str(self.root / (Path(file).stem + ".o"))
            words[words.index("-o") + 1] = out
            words = [str(self.root / file) if word == str(like) else word for word in words]
            words = [word.replace(str(ROOT / "src"), str(self.root / "src")) if word.startswith("-I") else word for word in words]
            for flag in ("-MF", "-MT"):
                if flag in words:
                    words[words.index(flag) + 1] = str(self.root / "depends")
            precompiled = any("pch" in word for word in words)  # headers that were compiled with the flags of BUILD
            subprocess.run(words if precompiled else [*words, "-O0"], cwd=BUILD, check=True)
            objects.append(out)
        words = command_of("orasp", ["liborasp.a", "-o orasp"])
        place = words.index("-o")
        words[place + 1] = str(self.program)
        subprocess.run([*words[:place], *objects, *words[place:]], cwd=BUILD, check=True)

    def run(self, *arguments):
        done = subprocess.run([self.program, *arguments], capture_output=True, text=True, timeout=120)
        return done.returncode, done.stdout, done.stderr

    def pages(self):
        """docs/cli.md and docs/orasp.1 as `tests/docs_test.py --update` would write them."""
        sys.path.insert(0, str(self.root / "tests"))
        import docs_options
        names = docs_options.names_below("Commands:", self.run("--help")[1])
        helps = {name: self.run(name, "--help")[1] for name in names}
        read = lambda name: (self.root / name).read_text(encoding="utf-8")
        return (docs_options.refreshed_page(read("docs/cli.md"), helps),
                docs_options.refreshed_manual(read("docs/orasp.1"), helps))


class Recipes(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tree = Tree(folder.name)

    def test_an_option_is_one_row(self):
        self.tree.insert("src/orasp/method_options.cpp", '    OptionSpec{"max-sweeps", "N",', TOY_OPTION)
        self.tree.build("src/orasp/method_options.cpp")
        self.assertIn("--toy N", self.tree.run("solve", "--help")[1])
        self.assertRegex(self.tree.run("completion", "bash")[1], r'\n    solve\).* --toy ')
        page, manual = self.tree.pages()
        self.assertIn("| `--toy N` | none | value-iteration: Play with N toys |", page)
        self.assertIn("\\fB\\-\\-toy\\fR \\fIN\\fR\nvalue\\-iteration: Play with N toys (default: none).\n", manual)
        code, out, error = self.tree.run("solve", "4brick", "--method", "value-iteration", "--toy", "3", "--json")
        self.assertEqual((code, error), (0, ""))
        self.assertEqual(json.loads(out)["options"]["toy"], 3)
        self.assertIn("--toy belongs to the method value-iteration, not to greedy",
                      self.tree.run("solve", "4brick", "--method", "greedy", "--toy", "3")[2])
        self.assertIn('--toy: "0" is not a whole number from 1',
                      self.tree.run("solve", "4brick", "--method", "value-iteration", "--toy", "0")[2])

    def test_a_planner_is_a_pair_of_files_and_a_row(self):
        (self.tree.root / "src/orasp/planners/toy.h").write_text(TOY_HEADER, encoding="utf-8")
        (self.tree.root / "src/orasp/planners/toy.cpp").write_text(TOY_PLANNER, encoding="utf-8")
        self.tree.insert("src/orasp/catalogue_table.cpp", '#include "orasp/planners/greedy.h"', '#include "orasp/planners/toy.h"\n')
        self.tree.insert("src/orasp/catalogue_table.cpp", '    Planner{.name = "random",', TOY_ROW)
        self.tree.build("src/orasp/planners/toy.cpp", "src/orasp/catalogue_table.cpp")
        self.assertRegex(self.tree.run("solve", "--help")[1], r"\n  toy +whatever greedy finds\n")
        self.assertRegex(self.tree.run("completion", "bash")[1], r'"[^"\n]*\bgreedy toy random\b[^"\n]*"')
        code, out, error = self.tree.run("solve", "4brick", "--method", "toy", "--json")
        self.assertEqual((code, error), (0, ""))
        self.assertEqual(json.loads(out)["method"], "toy")


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    BUILD = Path(sys.argv.pop(1)).resolve()
    if not (BUILD / "build.ninja").exists():
        print("skipped: not a build by Ninja")
        sys.exit(77)
    unittest.main()
