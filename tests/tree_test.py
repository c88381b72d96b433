#!/usr/bin/env python3
"""Checks what stands around the code: the files for those who fork or cite it, and what comments and pages refer to.

    tests/tree_test.py [unittest's arguments]

The checks that read YAML are skipped where python3-yaml is missing.
"""
import os
import re
import unittest
from pathlib import Path

try:
    import yaml
except ImportError:
    yaml = None

ROOT = Path(__file__).resolve().parent.parent
# Folders whose text is ours. web/ has a licence file of other people's among its sources.
FOLDERS = ["src", "cli", "python", "tests", "fuzz", "examples", "benchmarks", "tools", "cmake", "docs", "schemas", ".ci", ".github"]
SUFFIXES = {".h", ".cpp", ".py", ".sh", ".mjs", ".md", ".txt", ".cmake", ".in", ".bash", ".json", ".yml", ".1", ""}
# Files that may name a folder beside the repository, since they skip where it is missing.
KNOWS_SHARED = {"tests/files.h", "tests/planners/automatic_test.cpp", "tests/planners/known_values_test.cpp",
                "tests/web/browser.mjs", "tests/io/schema_test.py", "benchmarks/measure.py", "tests/tree_test.py"}
# References to a document by a number, which no page of the tree has.
NUMBERED = re.compile(r"\b(?:[Dd]esign|[Cc]ontract|[Ss]tyle|[Rr]eference),?\s+(?:[Ss]ection\s+)?\d+\b|\b[Ss]ection\s+\d")


def read(name):
    return (ROOT / name).read_text(encoding="utf-8")


def texts():
    """Name and text of every file of ours."""
    files = [path for path in ROOT.iterdir() if path.is_file()]
    for folder in FOLDERS:
        files += [path for path in (ROOT / folder).rglob("*") if path.is_file()]
    for path in sorted(files):
        name = path.relative_to(ROOT).as_posix()
        if path.suffix not in SUFFIXES or "/corpus/" in name or "__pycache__" in name:
            continue
        yield name, path.read_text(encoding="utf-8")


def headings(page):
    return re.findall(r"^#+ (.*)$", page, re.MULTILINE)


def citation_faults(name, text):
    """What a text refers to that a reader of the tree cannot look up."""
    flat = re.sub(r"\s*\n\s*(?:///?|#|\*)?\s*", " ", text)
    # A section of a book has the book's year shortly before it.
    faults = [f"{name}: \"{match[0]}\": no page of the tree has numbered sections" for match in NUMBERED.finditer(flat)
              if not re.search(r"\(\d{4}\)", flat[max(0, match.start() - 120):match.start()])]
    for page in set(re.findall(r"(?<![\w./${}<>*-])(?:[\w.-]+/)*[\w-]+\.md\b", text)):
        nearby = [ROOT, ROOT / "docs", (ROOT / name).parent]
        if re.match(r"[A-Z]+/", page):
            continue  # what a command writes into the folder DIR
        if not any((folder / page).exists() for folder in nearby):
            faults.append(f"{name}: {page}: there is no such page")
    for page, heading in re.findall(r"\b(docs/\w+\.md|CONTRIBUTING\.md|README\.md), section \"([^\"]+)\"", flat):
        if (ROOT / page).exists() and heading not in headings(read(page)):
            faults.append(f"{name}: {page} has no section \"{heading}\"")
    if "../shared" in text and name not in KNOWS_SHARED:
        faults.append(f"{name}: ../shared is not in the tree")
    return faults


OBJECTIVES = "src/orasp/model/objectives/"
# A sum may be walked anywhere, and those of a fleet are worked out by whoever plans for it.
ASKED_ANYWHERE = {"WeightedSum", "Makespan", "FleetTravel"}
# The check of certificates shares no formula with anyone, so it has its own of those objectives that it knows; of others it proves nothing.
KNOWS_OBJECTIVES = {"src/orasp/certificate/detail/size_rewards.cpp", "src/orasp/certificate/detail/place_rewards.cpp"}


def objective_structs():
    table = read(OBJECTIVES + "objective_table.h")
    variant = re.search(r"using ObjectiveParameters =\s*std::variant<(.*?)>;", table, re.DOTALL)
    return [name.strip() for name in variant[1].split(",") if name.strip() not in ASKED_ANYWHERE]


def kind_questions(text, structs):
    """Where code asks which kind of objective it has: that is the kind's own business."""
    names = "|".join(structs)
    return [match[0] for match in re.finditer(rf"\b(?:holds_alternative|get_if|get)<(?:const )?(?:{names})\b", text)] + \
        re.findall(r"\bstd::visit\([^;]*?objective[^;]*?parameters", text, re.DOTALL) + \
        re.findall(r"objective\w*(?:\(\))?\.type == \"(?!makespan|fleet_travel)\w+\"", text)


class Objectives(unittest.TestCase):
    def test_no_code_outside_of_their_folder_asks_which_it_has(self):
        structs = objective_structs()
        self.assertGreater(len(structs), 8)
        for name, text in texts():
            if name.startswith(("src/", "cli/")) and name.endswith((".h", ".cpp")) and not name.startswith(OBJECTIVES) and name not in KNOWS_OBJECTIVES:
                with self.subTest(file=name):
                    self.assertEqual(kind_questions(text, structs), [])

    def test_such_questions_are_found(self):
        structs = objective_structs()
        for text in ("if (std::holds_alternative<Fuel>(objective.parameters))", "std::get_if<Callable>(&objective.parameters)",
                     "std::visit(Overloaded{}, objective.parameters)", 'if (objective.type == "travel")'):
            self.assertEqual(len(kind_questions(text, structs)), 1, text)
        self.assertEqual(kind_questions("std::get_if<WeightedSum>(&objective.parameters)", structs), [])

    def test_every_type_has_a_row_in_the_page_of_formats(self):
        rows = re.findall(r'\{\.type = "(\w+)"([^}]*)\}', read(OBJECTIVES + "objective_table.h"))
        page = read("docs/format.md")
        self.assertGreater(len(rows), 12)
        for name, columns in rows:
            if ".in_files = false" not in columns:
                self.assertIn(f"\n| `{name}` |", page)


class Citations(unittest.TestCase):
    def test_no_text_refers_to_what_is_not_in_the_tree(self):
        count = 0
        for name, text in texts():
            if name == "tests/tree_test.py":
                continue
            count += 1
            with self.subTest(file=name):
                self.assertEqual(citation_faults(name, text), [])
        self.assertGreater(count, 300)

    def test_such_references_are_found(self):
        for text in ["// Design section 1: the side moves", "// the contract,\n/// section 3.", "/// see style 21", "// reference.md says so",
                     "// docs/missing.md", '// docs/format.md, section "Nothing"', "files under ../shared/problems"]:
            with self.subTest(text=text):
                self.assertEqual(len(citation_faults("src/orasp/planted.h", text)), 1)
        for text in ["// RFC 3629", "// FIPS 180-4", '// docs/format.md, section "Digest"', "// docs/format.md", "// sections of a page",
                     "// Aho, Hopcroft and Ullman (1974), The Design of\n// Algorithms, section 4.6"]:
            with self.subTest(text=text):
                self.assertEqual(citation_faults("src/orasp/planted.h", text), [])


def commands_of(text):
    """The words of a shell text that name a file of the tree to be run."""
    return re.findall(r"(?:^|[\s;&|])(\.(?:/|ci/)[\w./-]+)", text)


@unittest.skipIf(yaml is None, "the module yaml is missing (Debian: python3-yaml)")
class Yaml(unittest.TestCase):
    def test_the_workflow_runs_what_a_change_must_pass(self):
        workflow = yaml.safe_load(read(".github/workflows/ci.yml"))
        job = workflow["jobs"]["check"]
        self.assertEqual(job["container"], "debian:12")
        runs = [command for step in job["steps"] for command in commands_of(step.get("run", ""))]
        self.assertIn(".ci/run", runs)
        for command in runs:
            self.assertTrue(os.access(ROOT / command, os.X_OK), command)

    def test_the_citation_is_whole_and_true(self):
        citation = yaml.safe_load(read("CITATION.cff"))
        for key in ["cff-version", "message", "title", "version", "license", "authors", "preferred-citation"]:
            self.assertIn(key, citation)
        version = re.search(r"project\(orasp VERSION (\S+)", read("CMakeLists.txt"))[1]
        self.assertEqual(str(citation["version"]), version)
        self.assertIn(citation["license"], read("LICENSE"))
        paper = citation["preferred-citation"]
        readme = " ".join(read("README.md").split())
        self.assertIn(paper["title"], readme)
        self.assertIn(paper["doi"], readme)
        for author in paper["authors"]:
            self.assertIn(f"{author['given-names']} {author['family-names']}", readme)

    def test_issue_templates_have_a_name_and_say_what_for(self):
        templates = sorted((ROOT / ".github/ISSUE_TEMPLATE").glob("*.md"))
        self.assertGreater(len(templates), 1)
        for template in templates:
            _, front, body = template.read_text(encoding="utf-8").split("---\n", 2)
            self.assertEqual(yaml.safe_load(front).keys(), {"name", "about"})
            self.assertIn("**", body)


class Container(unittest.TestCase):
    def test_the_dockerfile_names_what_is_there(self):
        text = read("Dockerfile")
        lines = [line for line in text.splitlines() if not line.startswith("#")]
        runs = [command for line in lines for command in commands_of(line)]
        self.assertIn(".ci/run", runs)
        self.assertIn("./run", runs)
        for command in runs:
            self.assertTrue(os.access(ROOT / command, os.X_OK), command)
        stages = set(re.findall(r"^FROM \S+ AS (\w+)$", text, re.MULTILINE))
        used = set(re.findall(r"--from=(\w+)|--target (\w+)|^FROM (?!debian)(\w+)", text, re.MULTILINE))
        for names in used:
            self.assertIn("".join(names), stages)
        self.assertEqual(set(re.findall(r"^FROM ([\w]+:\d+)", text, re.MULTILINE)), {"debian:12"})

    def test_its_packages_are_those_that_the_program_needs(self):
        packages = re.search(r"--no-install-recommends ([^\\]*)", read("Dockerfile"))[1].split()
        needed = read("docs/dependencies.md")
        for package in packages:
            self.assertIn(package, needed)


if __name__ == "__main__":
    unittest.main()
