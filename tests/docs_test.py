#!/usr/bin/env python3
"""Checks that the documentation is not stale.

    tests/docs_test.py PROGRAM            check it against this orasp
    tests/docs_test.py PROGRAM --update   first write the program's outputs into the examples, and its
                                          options into docs/cli.md and docs/orasp.1

An example is a block ```console with lines `$ ./run ...` or `$ orasp ...`, each followed by what it prints (both
streams). It is run in a folder that shows the repository's files; what examples write there, later ones find. Times and memory sizes may differ, nothing else.
"""
import functools
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import docs_options

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ""
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").glob("*.md"))]
FENCE = re.compile(r"^( *)```(\w*)\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)


def page(name):
    return (ROOT / name).read_text(encoding="utf-8")


def orasp(*arguments, text=None):
    """Exit code, standard output and standard error of the program."""
    done = subprocess.run([PROGRAM, *arguments], input=text, capture_output=True, text=True, timeout=60)
    return done.returncode, done.stdout, done.stderr


def commands():
    return docs_options.names_below("Commands:", orasp("--help")[1])


def methods():
    return docs_options.names_below("Methods:", orasp("solve", "--help")[1])


def fleet_methods():
    return docs_options.names_below("Methods for fleets:", orasp("solve", "--help")[1])


def objectives():
    help_text = " ".join(orasp("solve", "--help")[1].split())
    return re.search(r"What a step earns: ([\w, ]+);", help_text)[1].split(", ")


# ---------------------------------------------------------------------------------------------------------------------
# Examples

@functools.cache
def stage():
    """The folder in which examples run: links to all that lies in the repository's."""
    folder = tempfile.TemporaryDirectory()
    for path in ROOT.iterdir():
        os.symlink(path, Path(folder.name) / path.name)
    return folder


def output_of(command):
    """What a line `$ ...` prints, run by bash with PROGRAM in the place of ./run and orasp."""
    with tempfile.TemporaryDirectory() as folder:
        os.symlink(PROGRAM, Path(folder) / "orasp")
        environment = dict(os.environ, PATH=f"{folder}:{os.environ['PATH']}", NO_COLOR="1")
        line = re.sub(r"(^|[|&;] *)\./run\b", r"\1orasp", command)
        done = subprocess.run(["bash", "-c", line], cwd=stage().name, env=environment, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=60)
        return done.stdout


def examples(block):
    """The (command, output) pairs of a block."""
    pairs = re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", block, re.MULTILINE)
    return [(command, output.rstrip("\n")) for command, output in pairs]


def without_figures(output):
    """The output with times and memory sizes struck out, in sentences and in a table's column `seconds`."""
    lines = []
    column = None
    for line in output.splitlines():
        line = re.sub(r"\b[\d.,e-]+ s\b", "TIME s", line)
        line = re.sub(r"\b[\d.,e-]+ (bytes|KiB|MiB|GiB|TiB)\b", "SIZE", line)
        cells = re.split(r"  +", line.rstrip())
        if "seconds" in cells:
            column = cells.index("seconds")
        elif column is not None and column < len(cells):
            cells[column] = "TIME"
        lines.append("  ".join(cells) if column is not None else line.rstrip())
    return "\n".join(lines).strip()


def is_example(command):
    return re.match(r"(\./run|orasp)\b", command)


def update():
    for path in PAGES:
        def rewritten(match):
            indent, language, block = match.groups()
            pairs = examples(block)
            if language != "console" or not pairs or not all(is_example(command) for command, _ in pairs):
                return match[0]
            text = ""
            for command, output in pairs:
                now = output_of(command).strip("\n")
                if without_figures(now) == without_figures(output):
                    now = output
                text += f"$ {command}\n{now}\n\n"
            return f"{indent}```console\n{text.rstrip()}\n{indent}```"
        text = path.read_text(encoding="utf-8")
        new = FENCE.sub(rewritten, text)
        if new != text:
            path.write_text(new, encoding="utf-8")
            print(f"updated {path.relative_to(ROOT)}")


# ---------------------------------------------------------------------------------------------------------------------
# Options

def pages_of_options():
    """The pages that hold what the helps say of the options -> their text as it should be."""
    helps = {name: orasp(name, "--help")[1] for name in commands()}
    return {"docs/cli.md": docs_options.refreshed_page(page("docs/cli.md"), helps),
            "docs/orasp.1": docs_options.refreshed_manual(page("docs/orasp.1"), helps)}


def update_options():
    for name, text in pages_of_options().items():
        if text != page(name):
            (ROOT / name).write_text(text, encoding="utf-8")
            print(f"updated {name}")


# ---------------------------------------------------------------------------------------------------------------------
# Links

def slug(heading):
    """The anchor that GitHub gives a heading."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


def prose(text):
    return FENCE.sub("", text)


def anchors(text):
    found = []
    for heading in re.findall(r"^#+ (.*)$", prose(text), re.MULTILINE):
        name = slug(heading)
        found.append(name if name not in found else f"{name}-{found.count(name)}")
    return found


class Docs(unittest.TestCase):
    def test_every_method_is_described(self):
        self.assertIn("value-iteration", methods())
        for name in methods():
            with self.subTest(method=name):
                self.assertIn(f"### {name}\n", page("docs/algorithms.md"))
                self.assertIn(f"| `{name}` |", page("docs/algorithms.md"))
                self.assertIn(f"| `{name}` |", page("README.md"))
                self.assertIn(name, page("docs/cli.md"))

    def test_every_method_for_fleets_is_described(self):
        self.assertIn("fleet-search", fleet_methods())
        for name in fleet_methods():
            with self.subTest(method=name):
                self.assertIn(f"### {name}\n", page("docs/algorithms.md"))
                self.assertIn(f"| `{name}` |", page("docs/algorithms.md"))
                self.assertIn(f"| `{name}` |", page("README.md"))
                self.assertIn(name, page("docs/cli.md"))
                self.assertIn(name.replace("-", "\\-"), page("docs/orasp.1"))

    def test_no_method_is_described_that_does_not_exist(self):
        table = page("README.md").split("## Methods", 1)[1].split("\n## ", 1)[0]
        self.assertEqual(re.findall(r"^\| `([\w-]+)` \|", table, re.MULTILINE), methods())

    def test_every_command_is_described(self):
        self.assertIn("solve", commands())
        for name in commands():
            with self.subTest(command=name):
                self.assertIn(f"| `{name}` |", page("README.md"))
                self.assertIn(f"orasp {name}", page("docs/cli.md"))

    def test_every_option_is_described(self):
        for name in commands():
            for option in sorted(set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", orasp(name, "--help")[1]))):
                with self.subTest(command=name, option=option):
                    self.assertIn(option, page("docs/cli.md"))

    def test_every_objective_is_described(self):
        self.assertIn("cubesat", objectives())
        for name in objectives():
            with self.subTest(objective=name):
                self.assertIn(f"`{name}`", page("docs/format.md"))

    def test_every_exit_code_is_described(self):
        codes = re.findall(r"^  k\w+ = (\d+),?", page("cli/exit_codes.h"), re.MULTILINE)
        self.assertIn("30", codes)
        for code in codes:
            with self.subTest(code=code):
                self.assertRegex(page("docs/cli.md"), rf"(?m)^\| *`?{code}`? *\|")

    def test_options_are_described_as_the_helps_say(self):
        for name, text in pages_of_options().items():
            with self.subTest(page=name):
                self.assertEqual(page(name), text, "refresh it with: tests/docs_test.py PROGRAM --update")

    def test_no_option_is_lost_on_the_way_into_the_pages(self):
        for name in commands():
            help_text = orasp(name, "--help")[1]
            listed = re.findall(r"^  (?:-\w )?(--[a-z-]+)", help_text, re.MULTILINE)
            found = [option.names[0 if option.names[0].startswith("--") else 1]
                     for option in docs_options.options_of(help_text)]
            with self.subTest(command=name):
                self.assertEqual([word for word in listed if word != "--help"], found)

    def test_the_cpp_example_compiles(self):
        block = next(text for _, language, text in FENCE.findall(page("README.md")) if language == "cpp")
        includes = "".join(re.findall(r"^#include .*\n", block, re.MULTILINE))
        code = f"#include <iostream>\n{includes}int main() {{\n{block.replace(includes, '')}}}\n"
        done = subprocess.run([os.environ.get("CXX", "c++"), "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Werror",
                               f"-I{ROOT / 'src'}", "-x", "c++", "-"],
                              input=code, capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_the_version_is_in_the_changelog(self):
        version = orasp("--version")[1].split()[1]
        self.assertIn(f"## [{version}]", page("CHANGELOG.md"))

    def test_links_resolve(self):
        for path in PAGES:
            text = path.read_text(encoding="utf-8")
            for link in re.findall(r"\]\(([^)\s]+)\)", prose(text)):
                if re.match(r"[a-z]+:", link):
                    continue
                with self.subTest(page=path.name, link=link):
                    target, _, anchor = link.partition("#")
                    file = (path.parent / target) if target else path
                    self.assertTrue(file.exists(), "there is no such file")
                    if anchor:
                        self.assertIn(anchor, anchors(file.read_text(encoding="utf-8")))

    def test_paths_named_in_the_text_exist(self):
        folders = "|".join(["src", "cli", "tests", "benchmarks", "examples", "data", "docs", "fuzz", "schemas", "tools", "cmake", r"\.ci"])
        for path in PAGES:
            for name in re.findall(rf"`((?:{folders})/[^`\s]*)`", prose(path.read_text(encoding="utf-8"))):
                if re.search(r"[A-Z*<]", name.removesuffix("CMakeLists.txt")):
                    continue  # a pattern: tests/planners/NAME_test.cpp
                with self.subTest(page=path.name, path=name):
                    self.assertTrue((ROOT / re.sub(r"[{].*", "", name)).exists(), "there is no such file")

    def test_problems_in_the_format_page_load(self):
        count = 0
        for _, language, block in FENCE.findall(page("docs/format.md")):
            if language != "json" or '"orasp-problem/1"' not in block:
                continue
            count += 1
            with self.subTest(block=block[:200]):
                json.loads(block)
                code, _, error = orasp("solve", "-", "--time-limit", "2", "--json", text=block)
                self.assertIn(code, (0, 10, 20), error)
        self.assertGreater(count, 0)

    def test_examples_print_what_the_page_says(self):
        count = 0
        for path in PAGES:
            for _, language, block in FENCE.findall(path.read_text(encoding="utf-8")):
                pairs = examples(block) if language == "console" else []
                if not all(is_example(command) for command, _ in pairs):
                    continue
                for command, output in pairs:
                    count += 1
                    with self.subTest(page=path.name, command=command):
                        self.assertEqual(without_figures(output_of(command)), without_figures(output),
                                         "refresh it with: tests/docs_test.py PROGRAM --update")
        self.assertGreater(count, 0)


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    PROGRAM = str(Path(sys.argv.pop(1)).resolve())
    if "--update" in sys.argv:
        sys.argv.remove("--update")
        update()
        update_options()
    unittest.main()
