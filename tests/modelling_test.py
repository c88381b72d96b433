#!/usr/bin/env python3
"""Checks the situations of docs/modelling.md: that the program solves each file to the value that the page prints.

    tests/modelling_test.py PROGRAM [unittest's arguments]

The page is the source: under each of its headings stand lines of one file of examples/modelling, and a command with the first
lines of what it prints, the reward among them.
"""
import json
import re
import subprocess
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/modelling.md"
PROGRAM = ""
SITUATIONS = 20
COMMAND = re.compile(r"^\$ orasp solve examples/modelling/(\S+\.json)\b.*$", re.MULTILINE)
REWARD = re.compile(r"^(?:expected )?reward +(-?\d+(?:\.\d+)?)$", re.MULTILINE)
# What a reward is printed with.
DECIMALS = 6


def sections(text):
    """Heading and text of each section of the page."""
    return re.findall(r"^## (.*)\n((?:(?!^## ).*\n)*)", text, re.MULTILINE)


def blocks(text, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def situations(text):
    """Heading, file, printed reward and shown lines of each section that solves a file."""
    found = []
    for heading, body in sections(text):
        for block in blocks(body, "console"):
            files = COMMAND.findall(block)
            rewards = REWARD.findall(block)
            if len(files) != 1 or len(rewards) != 1:
                raise ValueError(f"{heading}: expected one command with one reward, found {files} and {rewards}")
            shown = [line.strip() for lines in blocks(body, "json") for line in lines.splitlines()]
            found.append((heading, files[0], float(rewards[0]), [line for line in shown if line != "..."]))
    return found


def solved(file):
    done = subprocess.run([PROGRAM, "solve", str(file), "--json", "--quiet"], capture_output=True, text=True, timeout=60)
    return done.returncode, json.loads(done.stdout or "{}"), done.stderr


class Modelling(unittest.TestCase):
    page = PAGE.read_text(encoding="utf-8")
    situations = situations(page)

    def test_the_page_has_all_situations(self):
        self.assertEqual(len(self.situations), SITUATIONS)

    def test_each_file_stands_in_the_page_once_and_the_page_names_no_other(self):
        files = sorted(file.name for file in (ROOT / "examples/modelling").iterdir())
        self.assertEqual(sorted(file for _, file, _, _ in self.situations), files)

    def test_each_file_is_solved_with_proof_to_the_value_of_the_page(self):
        for heading, file, reward, _ in self.situations:
            with self.subTest(situation=heading):
                code, plan, error = solved(ROOT / "examples/modelling" / file)
                self.assertEqual(code, 0, error)
                self.assertEqual(error, "")
                self.assertEqual(plan["status"], "optimal")
                self.assertAlmostEqual(plan["reward"], reward, delta=0.5 * 10 ** -DECIMALS)

    def test_the_lines_that_the_page_shows_are_those_of_the_file(self):
        for heading, file, _, shown in self.situations:
            text = (ROOT / "examples/modelling" / file).read_text(encoding="utf-8")
            lines = [line.strip().rstrip(",") for line in text.splitlines()]
            with self.subTest(situation=heading):
                self.assertTrue(shown)
                places = [lines.index(line.rstrip(",")) if line.rstrip(",") in lines else line for line in shown]
                self.assertEqual([place for place in places if isinstance(place, str)], [], "not in the file")
                self.assertEqual(places, sorted(places), "in another order than in the file")

    def test_the_files_are_small(self):
        for _, file, _, _ in self.situations:
            problem = json.loads((ROOT / "examples/modelling" / file).read_text(encoding="utf-8"))
            with self.subTest(file=file):
                self.assertIn(len(problem["parts"]), range(3, 9))
                self.assertTrue(problem["name"])

    def test_the_contents_list_all_sections(self):
        listed = re.findall(r"^\d+\. \[(.*)\]\(#", self.page, re.MULTILINE)
        self.assertEqual(listed, [heading for heading, _, _, _ in self.situations])

    def test_a_page_without_a_value_is_found(self):
        good = "## One\n\n```console\n$ orasp solve examples/modelling/a.json | head -4\nreward   -2\n```\n"
        self.assertEqual(situations(good), [("One", "a.json", -2.0, [])])
        for bad in (good.replace("reward   -2\n", ""), good.replace("reward   -2", "reward   two"), good.replace("orasp solve", "orasp graph")):
            with self.assertRaises(ValueError):
                situations(bad)


if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    PROGRAM = str(Path(sys.argv.pop(1)).resolve())
    unittest.main()
