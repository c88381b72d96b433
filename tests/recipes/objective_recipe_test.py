#!/usr/bin/env python3
"""The recipe "Add an objective" of CONTRIBUTING.md, followed on a copy of the tree.

    tests/recipes/objective_recipe_test.py BUILD_FOLDER

The toy objective `moved_squared` costs the square of the number of parts that move. It is added by one pair of files and
one row (and a line each for the build, the oracle and the page of formats); then the program must list it, solve with it,
and every planner must agree with the oracle about it. The copy lies in BUILD_FOLDER and is built without optimisation, so
that a second run finds what the first one built.
"""
import json
import os
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
COPY = Path(sys.argv.pop(1) if len(sys.argv) > 1 else ROOT / "build/recipes").resolve() / "objective"
TREE = COPY / "tree"
BUILD = COPY / "build"

HEADER = """#pragma once

namespace orasp {

class ObjectiveKind;

/// `moved_squared`: -(parts in the moved piece)^2 if the step separates, else 0. No parameters.
struct MovedSquared {};

[[nodiscard]] const ObjectiveKind& moved_squared_kind();

}  // namespace orasp
"""

SOURCE = """#include "orasp/model/objectives/moved_squared.h"

#include <algorithm>
#include <memory>

#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

class MovedSquaredTerm : public ObjectiveTerm {
 public:
  explicit MovedSquaredTerm(std::size_t num_parts) : most_moved_(static_cast<double>(num_parts / 2)) {
    sees.counting = sees.piece_only = sees.gain_by_sizes = true;
  }
  [[nodiscard]] double reward(const detail::StepFacts& facts, const detail::Movement& movement,
                              const detail::StepPieces& pieces) const override {
    static_cast<void>(movement);
    static_cast<void>(pieces);
    const double moved = std::min(facts.a_parts, facts.b_parts);
    return 0.0 - moved * moved;
  }
  [[nodiscard]] RewardRange range(const RangeQuestion& question) const override {
    static_cast<void>(question);
    return {0.0 - most_moved_ * most_moved_, 0};
  }
  [[nodiscard]] double greatest_gain(double weight, std::size_t moved,
                                     std::size_t kept) const override {
    const auto parts = static_cast<double>(std::min(moved, kept));
    return weight * (0.0 - parts * parts);
  }

 private:
  double most_moved_;
};

class MovedSquaredKind : public ObjectiveKindOf<MovedSquared> {
  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> term(
      const MovedSquared& parameters, const detail::ProblemTotals& totals) const override {
    static_cast<void>(parameters);
    return std::make_unique<MovedSquaredTerm>(totals.problem.num_parts());
  }
  [[nodiscard]] detail::CheckedTerm checked(const MovedSquared& parameters,
                                            const detail::CheckedProblem& problem) const override {
    static_cast<void>(parameters);
    static_cast<void>(problem);
    detail::CheckedTerm term;
    term.value = [](const detail::SeenStep& step) -> detail::CheckedValue {
      const auto parts = static_cast<double>(step.moved_parts);
      return {step.separates ? 0.0 - parts * parts : 0.0};
    };
    return term;
  }
};

}  // namespace

const ObjectiveKind& moved_squared_kind() {
  static const MovedSquaredKind kind;
  return kind;
}

}  // namespace orasp
"""

NOT_SOURCES = {".git", "build", "node_modules", "__pycache__"}

TABLE = "src/orasp/model/objectives/objective_table.h"
# File -> what is put in front of which line (or of which text in a line).
CHANGES = [
    ("src/orasp/CMakeLists.txt", "    model/objectives/piece_cost\n", "    model/objectives/moved_squared\n"),
    (TABLE, '#include "orasp/model/objectives/piece_cost.h"\n', '#include "orasp/model/objectives/moved_squared.h"\n'),
    (TABLE, "Changeover, Route, Expression,", "MovedSquared, "),
    (TABLE, '    {.type = "expression",', '    {.type = "moved_squared", .kind = moved_squared_kind},\n'),
    ("tests/oracle.cpp", '  if (objective.type == "completion") {\n',
     '  if (objective.type == "moved_squared") {\n'
     "    const auto moved = static_cast<double>(facts.moved.size());\n"
     "    return -(moved * moved);\n"
     "  }\n"),
    ("docs/format.md", "| `expression` | a [formula]",
     "| `moved_squared` | −(parts in the moved piece)² if it separates, else 0 | none |\n"),
]


def run(*command, **options):
    done = subprocess.run([str(part) for part in command], text=True, capture_output=True, **options)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))}\nended with {done.returncode}\n{done.stdout[-4000:]}{done.stderr[-4000:]}")
    return done.stdout


def write(file, text):
    """Writes a file if that changes it: what is built from it stays otherwise."""
    if not file.exists() or file.read_bytes() != text:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(text)


def followed():
    """The files of the tree after the recipe, and the names of those that it touched."""
    files = {}
    for folder, inner, names in os.walk(ROOT):
        inner[:] = [name for name in inner if name not in NOT_SOURCES]
        for file in (Path(folder) / name for name in names):
            if file.is_file():
                files[file.relative_to(ROOT).as_posix()] = file.read_bytes()
    before = dict(files)
    for name, place, addition in CHANGES:
        text = files[name].decode()
        assert text.count(place) == 1, f"{name}: {place!r} is there {text.count(place)} times, not once"
        files[name] = text.replace(place, addition + place).encode()
    files["src/orasp/model/objectives/moved_squared.h"] = HEADER.encode()
    files["src/orasp/model/objectives/moved_squared.cpp"] = SOURCE.encode()
    return files, sorted(name for name in files if files[name] != before.get(name))


class ObjectiveRecipe(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        files, cls.touched = followed()
        for name, text in files.items():
            write(TREE / name, text)
            (TREE / name).chmod((ROOT / name).stat().st_mode if (ROOT / name).exists() else 0o644)
        for old in [path for path in TREE.rglob("*") if path.is_file()]:
            if str(old.relative_to(TREE)) not in files:
                old.unlink()
        run("cmake", "-S", TREE, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=None", "-DCMAKE_CXX_FLAGS=-O0", "-DORASP_UNITY=ON",
            "-DORASP_BUILD_TESTS=ON", "-DORASP_WERROR=ON", "-DORASP_WITH_TORCH=OFF", "-DORASP_WITH_OCCT=OFF",
            "-DORASP_WITH_ASSIMP=OFF")
        run("cmake", "--build", BUILD, "--target", "orasp_cli", "orasp_test_support")
        cls.program = next(path for path in BUILD.rglob("orasp") if path.is_file())

    def test_touches_six_files(self):
        self.assertEqual(len(self.touched), 6, self.touched)

    def test_the_program_lists_it_and_solves_with_it(self):
        self.assertIn("moved_squared", run(self.program, "solve", "--help"))
        # The program checks the plan and its reward by the second formula before it says anything.
        plan = json.loads(run(self.program, "solve", "lattice", "--objective", "moved_squared", "--json"))
        self.assertEqual(plan["status"], "optimal")
        self.assertLess(plan["reward"], 0)

    def test_every_planner_agrees_with_the_oracle(self):
        compiler = shutil.which("c++")
        libraries = [next(BUILD.rglob(name)) for name in ("liborasp_test_support.a", "liborasp.a")]
        run(compiler, "-std=c++20", "-O0", "-I", TREE / "src", "-I", TREE, TREE / "tests/agreement_test.cpp", *libraries,
            "-lgtest", "-lgtest_main", "-lfmt", "-lmuparser", "-lmd", "-lpthread", "-ldl", "-o",
            BUILD / "agreement")  # beside the module that solves integer programs
        said = run(BUILD / "agreement", "--gtest_filter=Seeds/Agreement.EveryPlannerIsRight*:Seeds/Agreement.Values*:"
                   "Seeds/Agreement.*Admissible*", env={**os.environ, "ORASP_TEST_SEEDS": "20"})
        self.assertIn("[  PASSED  ]", said)


if __name__ == "__main__":
    unittest.main()
