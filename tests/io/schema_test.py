#!/usr/bin/env python3
"""Checks the JSON Schemas of schemas/ against the files of the tree, what the program writes, and what it refuses.

    tests/io/schema_test.py PROGRAM [unittest's arguments]

Skipped (exit code 77) where python3-jsonschema is missing.
"""
import copy
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

try:
    import jsonschema
except ImportError:
    print("skipped: the module jsonschema is missing (Debian: python3-jsonschema)")
    sys.exit(77)

ROOT = Path(__file__).resolve().parent.parent.parent
PROGRAM = ""
# Problems kept beside the repository, which a copy of it need not have.
SHARED = [ROOT.parent / "shared" / "problems", ROOT.parent / "shared" / "field"]


def schema_of(name):
    return json.loads((ROOT / "schemas" / f"{name}.schema.json").read_text(encoding="utf-8"))


def faults(name, document):
    """Why `document` does not fit the schema, a line each."""
    validator = jsonschema.Draft202012Validator(schema_of(name))
    return [f"{list(error.absolute_path)}: {error.message[:200]}" for error in validator.iter_errors(document)]


def orasp(*arguments, text=""):
    done = subprocess.run([PROGRAM, *arguments], input=text, capture_output=True, text=True, timeout=120)
    return done.returncode, done.stdout


def taken_by_the_program(file):
    """Whether the program reads a problem and begins to plan: for one robot, or else for several."""
    return orasp("solve", str(file), "--time-limit", "0.01", "--json", "--quiet")[0] != 30


def problem_files():
    files = [*(ROOT / "data").rglob("*.json"), *(ROOT / "examples").rglob("*.json")]
    return sorted(file for file in files if '"orasp-problem/1"' in file.read_text(encoding="utf-8"))


# A problem with every key that one can have.
FULL = {
    "format": "orasp-problem/1", "name": "full", "note": "all keys", "source": "this test", "x-other": {"any": [1]},
    "parts": [{"id": "1", "name": "one", "mass": 2.5, "position": [0, 0, 0], "note": "n", "x-color": 3},
              {"id": "2", "position": [1, 0, 0]}, {"id": "3", "position": [2, 0, 0]}],
    "connections": [{"id": "a", "parts": ["1", "2"], "duration": 2, "success": 0.5, "axis": "+x",
                     "on_failure": {"breaks": ["2-3"]}},
                    {"parts": ["2", "3"], "success": 0.5, "on_failure": {"abort": -3}},
                    {"id": "c", "parts": ["1", "3"], "success": 0.5, "on_failure": "retry"}],
    "precedence": [{"connection": "a", "after": ["c"], "after_any": ["2-3", "c"], "note": "n"}],
    "blocking": {"directions": ["+x", "-x", {"id": "slant", "vector": [0.6, 0, 0.8], "note": "n", "x-y": 1}],
                 "blocked": [{"part": "1", "by": "2", "directions": ["+x", "slant", "-slant"]}]},
    "limits": {"max_subassemblies": 2, "max_moved_parts": 2.0, "max_moved_mass": 9.5},
    "objective": {"type": "sum", "terms": [
        {"type": "cubesat", "weight": 2}, {"type": "cubesat_zone"}, {"type": "custom"}, {"type": "indexed"},
        {"type": "piece_cost", "operation": 1, "pieces": {"1": 0.5, "16384": 1, "note": "n"}, "completion": 2},
        {"type": "time", "depot": [0, 0, 0], "speed": 2, "transfer": 0},
        {"type": "travel", "depot": [1, 2, 3], "weight": 0.5},
        {"type": "fuel", "dry_mass": 1, "delta_v": 2, "isp": 3},
        {"type": "completion", "join": 1, "step": 2, "bonus": 3},
        {"type": "expression", "formula": "after * c1", "constants": {"c1": 2, "x-ignored": "text"}, "depot": [0, 0, 0]},
        {"type": "sum", "terms": [{"type": "indexed"}]}]},
    "direction": "disassembly",
}
ABSENT = object()
# What is changed in FULL: the path to a value, and what stands there instead (ABSENT: nothing).
HOSTILE = [
    (["format"], "orasp-problem/2"), (["format"], ABSENT), (["parts"], ABSENT), (["connections"], {}),
    (["name"], 3), (["note"], 3), (["unknown"], 1), (["direction"], "sideways"),
    (["parts", 0, "id"], 1), (["parts", 0, "id"], ""), (["parts", 0, "id"], " 1"), (["parts", 0, "id"], "1\u0007"),
    (["parts", 0, "id"], ABSENT), (["parts", 0, "mass"], -1), (["parts", 0, "mass"], "heavy"),
    (["parts", 0, "position"], [0, 0]), (["parts", 0, "weight"], 1), (["parts", 0], "1"),
    (["connections", 0, "parts"], ["1"]), (["connections", 0, "parts"], ["1", "2", "3"]),
    (["connections", 0, "parts"], ABSENT), (["connections", 0, "duration"], -0.5),
    (["connections", 0, "success"], 0), (["connections", 0, "success"], 1.5), (["connections", 0, "axis"], "x"),
    (["connections", 0, "on_failure"], "explode"), (["connections", 0, "on_failure"], {}),
    (["connections", 0, "on_failure"], {"breaks": []}), (["connections", 0, "on_failure"], {"breaks": ["c"], "abort": 1}),
    (["precedence", 0], {"connection": "a"}), (["precedence", 0, "after_any"], []),
    (["precedence", 0, "connection"], ABSENT), (["precedence", 0, "before"], ["c"]),
    (["blocking", "directions"], ["+x"]), (["blocking", "directions"], ["+x", "-x", "+x"]),
    (["blocking", "blocked"], ABSENT), (["blocking", "blocked", 0, "directions"], ["+up"]),
    (["blocking", "blocked", 0, "directions"], [""]), (["blocking", "directions", 2, "vector"], ABSENT),
    (["blocking", "directions", 2, "id"], ABSENT), (["blocking", "directions", 2, "id"], "-slant"),
    (["blocking", "directions", 2, "id"], "+x"), (["blocking", "directions", 2, "id"], "x"),
    (["blocking", "directions", 2, "vector"], [0, 1]), (["blocking", "directions", 2, "length"], 1),
    (["blocking", "directions"], [{"id": "slant", "vector": [0, 0, 1]}, "slant"]),
    (["limits", "max_subassemblies"], -1), (["limits", "max_moved_parts"], 1.5), (["limits", "max_moved_mass"], -1),
    (["limits", "max_moved_part"], 1), (["limits"], []),
    (["objective"], "cubesat"), (["objective"], {}), (["objective"], {"type": "cubsat"}),
    (["objective"], {"type": "cubesat", "weight": 2}), (["objective"], {"type": "cubesat", "completion": 1}),
    (["objective"], {"type": "piece_cost", "pieces": {"0": 1}}),
    (["objective"], {"type": "piece_cost", "pieces": {"16385": 1}}),
    (["objective"], {"type": "time", "speed": 0}), (["objective"], {"type": "time", "transfer": -1}),
    (["objective"], {"type": "travel", "depot": [1, 2]}), (["objective"], {"type": "fuel", "isp": 0}),
    (["objective"], {"type": "fuel", "dry_mass": -1}), (["objective"], {"type": "expression"}),
    (["objective"], {"type": "expression", "formula": 3}), (["objective"], {"type": "expression", "formula": ""}),
    (["objective"], {"type": "expression", "formula": "a", "constants": {"a": "1"}}),
    (["objective"], {"type": "expression", "formula": "1", "constants": {"2a": 1}}),
    (["objective"], {"type": "sum"}), (["objective"], {"type": "sum", "terms": [{"weight": 1}]}),
    (["objective"], {"type": "makespan"}), (["objective"], {"type": "sum", "terms": [{"type": "fleet_travel"}]}),
    (["fleet"], {}), (["fleet"], {"robots": 0}), (["fleet"], {"robots": 1.5}), (["fleet"], {"robots": 1, "depot": [0]}),
    (["fleet"], {"robots": 1, "sites": [[1, 2, 3]]}), (["fleet"], {"robots": 1, "speed": 1}),
    (["geometry"], "pump.glb"), (["geometry"], {}), (["geometry"], []), (["geometry"], None), (["geometry"], {"file": ""}),
    (["geometry"], {"file": 3}), (["geometry"], {"file": "a\u0000b"}), (["geometry"], {"file": "a", "files": []}),
]

# A problem with every key that does not go with attempts that may fail, and what is changed in it.
WIDE = {
    "format": "orasp-problem/1", "name": "wide",
    "parts": [{"id": "1", "position": [0, 0, 0], "numbers": {"value": 2.5, "note": "n", "source": 3, "x-other": "text"}},
              {"id": "2", "position": [1, 0, 0]}, {"id": "3"}],
    "connections": [{"id": "a", "parts": ["1", "2"], "numbers": {"worth": -1}, "attributes": {"tool": "M4", "note": "n", "x-y": 1}},
                    {"id": "b", "parts": ["2", "3"], "position": [2, 0, 0], "attributes": {"tool": ""}}],
    "blocking": {"directions": ["+x", "-x"], "blocked": []},
    "limits": {"grounded": True}, "base": ["3"],
    "goal": {"free": ["1"], "removed": [], "stop": "best", "note": "n", "x-y": 1},
    "action": "connection", "geometry": {"file": "wide.glb", "note": "n", "x-y": 1},
    "objective": {"type": "sum", "terms": [
        {"type": "changeover", "attribute": "tool", "cost": 2, "start": "M4", "weight": 2,
         "costs": [{"from": "M4", "to": "", "cost": 0.25, "note": "n", "x-y": 1}]},
        {"type": "changeover", "attribute": "direction"},
        {"type": "route", "start": [0, 0, 0], "per_metre": 0.5}, {"type": "route"},
        {"type": "expression", "formula": "moved_value + worth - source - elapsed"}]},
}
TERMS = ["objective", "terms"]
HOSTILE_WIDE = [
    (["parts", 0, "numbers"], [1]), (["parts", 0, "numbers", "value"], "2"), (["parts", 0, "numbers", "a b"], 1),
    (["parts", 0, "numbers", "2a"], 1), (["parts", 0, "attributes"], {"tool": "M4"}),
    (["connections", 0, "numbers", "worth"], None), (["connections", 0, "attributes"], ["M4"]),
    (["connections", 0, "attributes", "tool"], 4), (["connections", 0, "attributes", ""], "M4"),
    (["connections", 0, "attributes", "direction"], "+x"), (["connections", 1, "position"], [0, 0]),
    (["limits", "grounded"], "yes"), (["limits", "grounded"], 1), (["base"], ABSENT), (["base"], []),
    (["base"], "3"), (["base"], ["3", "3"]), (["base"], [3]), (["goal"], {}), (["goal"], {"stop": "best"}), (["goal"], ["1"]),
    (["goal", "stop"], "never"), (["goal", "free"], "1"), (["goal", "removed"], [1]), (["goal", "remove"], []),
    (["direction"], "assembly"), (["action"], "parts"), (["action"], None),
    (["fleet"], {"robots": 1, "sites": [[0, 0]]}),
    ([*TERMS, 0, "attribute"], ABSENT), ([*TERMS, 0, "attribute"], ""), ([*TERMS, 0, "attribute"], 3), ([*TERMS, 0, "cost"], "2"),
    ([*TERMS, 0, "costs"], {"M4": 1}), ([*TERMS, 0, "costs", 0, "cost"], ABSENT), ([*TERMS, 0, "costs", 0, "from"], 4),
    ([*TERMS, 0, "costs", 0, "back"], 1), ([*TERMS, 0, "start"], None), ([*TERMS, 0, "default"], 1),
    ([*TERMS, 2, "start"], [0, 0]), ([*TERMS, 2, "per_metre"], "1"), ([*TERMS, 2, "speed"], 1),
]


def changed(document, path, value):
    document = copy.deepcopy(document)
    at = document
    for key in path[:-1]:
        at = at[key]
    if value is ABSENT:
        del at[path[-1]]
    else:
        at[path[-1]] = value
    return document


class Schemas(unittest.TestCase):
    def test_are_schemas(self):
        names = sorted(path.name for path in (ROOT / "schemas").iterdir())
        self.assertEqual(len(names), 6)
        for name in names:
            schema = json.loads((ROOT / "schemas" / name).read_text(encoding="utf-8"))
            jsonschema.Draft202012Validator.check_schema(schema)
            self.assertEqual(schema["$id"], name)
            self.assertFalse(schema["$defs"].keys() - self.referred(schema), "a definition that nothing uses")

    def referred(self, schema):
        if isinstance(schema, list):
            return {name for item in schema for name in self.referred(item)}
        if not isinstance(schema, dict):
            return set()
        own = {schema["$ref"].removeprefix("#/$defs/")} if isinstance(schema.get("$ref"), str) else set()
        return own | {name for item in schema.values() for name in self.referred(item)}


class Problems(unittest.TestCase):
    def test_every_file_of_the_tree_fits(self):
        files = problem_files()
        self.assertGreater(len(files), 15)
        for file in files:
            with self.subTest(file=file.name):
                self.assertEqual(faults("orasp-problem-1", json.loads(file.read_text(encoding="utf-8"))), [])

    def test_every_scenario_that_the_program_prints_fits(self):
        for name in ["hubble", "jwst-upc", "fleet-iss", "grid:3x3", "random:6:7:3"]:
            with self.subTest(name=name):
                self.assertEqual(faults("orasp-problem-1", json.loads(orasp("scenarios", name)[1])), [])

    def test_files_kept_beside_the_repository_fit_where_the_program_takes_them(self):
        files = sorted(file for folder in SHARED if folder.is_dir() for file in folder.rglob("*.json"))
        if not files:
            self.skipTest("there are none")
        taken = 0
        for file in files:
            with self.subTest(file=file.name):
                if taken_by_the_program(file):
                    taken += 1
                    self.assertEqual(faults("orasp-problem-1", json.loads(file.read_text(encoding="utf-8"))), [])
        self.assertGreater(taken, 100)

    def judged(self, document):
        """Whether the schema takes it, and whether the program does."""
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "problem.json"
            file.write_text(json.dumps(document), encoding="utf-8")
            return faults("orasp-problem-1", document) == [], taken_by_the_program(file)

    def test_a_problem_with_all_keys_fits_and_is_taken(self):
        self.assertEqual(self.judged(FULL), (True, True))
        self.assertEqual(self.judged(dict(FULL, objective={"type": "cubesat"}, direction="assembly", connections=[
            {"id": "a", "parts": ["1", "2"]}, {"parts": ["2", "3"]}, {"id": "c", "parts": ["1", "3"]}])), (True, True))

    def test_a_problem_with_all_that_looks_back_fits_and_is_taken(self):
        self.assertEqual(self.judged(WIDE), (True, True))
        self.assertEqual(self.judged(dict(WIDE, action="part", goal={"removed": ["a"]})), (True, True))

    def test_hostile_wide_problems_are_refused_by_both(self):
        for path, value in HOSTILE_WIDE:
            with self.subTest(path=path, value=value if value is not ABSENT else "absent"):
                self.assertEqual(self.judged(changed(WIDE, path, value)), (False, False))

    def test_a_fleet_names_its_own_objectives(self):
        pair = {"format": "orasp-problem/1", "parts": [{"id": "1"}, {"id": "2"}],
                "connections": [{"parts": ["1", "2"], "axis": "+x"}], "fleet": {"robots": 2, "sites": [[1, 0]]}}
        self.assertEqual(self.judged(pair), (True, True))
        self.assertEqual(self.judged(dict(pair, objective={"type": "time"})), (False, False))
        for kind in ["makespan", "fleet_travel"]:
            with self.subTest(kind=kind):
                self.assertEqual(self.judged(dict(pair, objective={"type": kind})), (True, True))
                self.assertEqual(self.judged(dict(pair, objective={"type": kind, "steps": 3})), (False, False))

    def test_hostile_problems_are_refused_by_both(self):
        for path, value in HOSTILE:
            with self.subTest(path=path, value=value if value is not ABSENT else "absent"):
                self.assertEqual(self.judged(changed(FULL, path, value)), (False, False))


class Plans(unittest.TestCase):
    COMMANDS = [
        ["solve", "hubble"], ["solve", "lattice", "--method", "beam"], ["solve", "jwst-upc"],
        ["solve", "lattice", "--count"], ["solve", "lattice", "--alternatives", "3"],
        ["solve", "examples/shelf.json", "--direction", "assembly"], ["solve", "examples/shelf-worn.json"],
        ["solve", "examples/shelf-locked.json"], ["solve", "iss", "--method", "orasp-search", "--bound", "none", "--time-limit", "0.05"],
        ["solve", "lattice", "--method", "q-learning", "--seed", "3"],
        ["solve", "fleet-lattice"], ["solve", "fleet-hubble", "--method", "greedy"],
        ["solve", "fleet-lattice", "--objective", "fleet_travel", "--steps", "5"],
        ["replan", "lattice", "--removed", "1-2", "--inaccessible", "2-3"],
        ["replan", "hubble", "--removed", "1-2,2-3", "--objective", "time"],
        ["replan", "lattice", "--inaccessible", "1-2,2-3,4-5", "--max-moved-parts", "1"],
    ]

    def plan(self, arguments):
        done = subprocess.run([PROGRAM, *arguments, "--json", "--quiet"], cwd=ROOT, capture_output=True, text=True,
                              timeout=120)
        self.assertIn(done.returncode, (0, 10, 20), done.stderr)
        return json.loads(done.stdout)

    def test_what_the_program_prints_fits_and_has_no_key_that_the_schema_does_not_know(self):
        known = schema_of("orasp-plan-1")["properties"].keys()
        for arguments in self.COMMANDS:
            with self.subTest(arguments=arguments):
                plan = self.plan(arguments)
                self.assertEqual(faults("orasp-plan-1", plan), [])
                self.assertEqual(plan.keys() - known, set())

    def test_plans_of_wide_problems_fit(self):
        known = schema_of("orasp-plan-1")["properties"].keys()
        goal = {"removed": ["a"]}
        for problem in [WIDE, dict(WIDE, action="part", goal=goal), dict(WIDE, goal=goal), dict(WIDE, goal={"removed": []})]:
            with self.subTest(problem=problem), tempfile.TemporaryDirectory() as folder:
                file = Path(folder) / "problem.json"
                file.write_text(json.dumps(problem), encoding="utf-8")
                plan = self.plan(["solve", str(file), "--alternatives", "2"])
                self.assertEqual(faults("orasp-plan-1", plan), [])
                self.assertEqual(plan.keys() - known, set())
                self.assertIn("stays", plan)
                if problem.get("action") == "part":
                    self.assertTrue(all(isinstance(step, list) for step in plan["disassembly"]))
                    self.assertTrue(all("connections" in step for step in plan["steps"]))

    def test_task_graphs_fit_and_have_no_key_that_the_schema_does_not_know(self):
        schema = schema_of("orasp-task-graph-1")
        task_keys = schema["properties"]["tasks"]["items"]["properties"].keys()
        for problem in ["hubble", "examples/shelf.json", "examples/formats/drawer_matrices.csv", "examples/shelf-worn.json", "chain:1"]:
            with self.subTest(problem=problem):
                done = subprocess.run([PROGRAM, "convert", problem, "--to", "task-graph", "-o", "-"], cwd=ROOT, capture_output=True,
                                      text=True, timeout=120)
                graph = json.loads(done.stdout)
                self.assertEqual(faults("orasp-task-graph-1", graph), [])
                self.assertEqual(graph.keys() - schema["properties"].keys(), set())
                for task in graph["tasks"]:
                    self.assertEqual(task.keys() - task_keys, set())

    def test_what_replan_says_of_an_old_plan_fits(self):
        with tempfile.TemporaryDirectory() as folder:
            file = str(Path(folder) / "plan.json")
            self.assertEqual(orasp("solve", "lattice", "-o", file)[0], 0)
            self.assertEqual(faults("orasp-plan-1", json.loads(Path(file).read_text())), [])
            plan = self.plan(["replan", "lattice", "--plan", file, "--done", "3", "--inaccessible", "5-8"])
            self.assertEqual(faults("orasp-plan-1", plan), [])
            self.assertIn("changes", plan)

    def test_plans_that_the_program_refuses_do_not_fit(self):
        good = {"format": "orasp-plan/1", "disassembly": ["1-2", "2-3"]}
        for bad in [dict(good, format="orasp-plan/2"), {"disassembly": ["1-2"]}, {"format": "orasp-plan/1"},
                    dict(good, disassembly="1-2"), dict(good, disassembly=[1, 2]), dict(good, problem_digest=7)]:
            with self.subTest(plan=bad):
                self.assertNotEqual(faults("orasp-plan-1", bad), [])
                self.assertEqual(orasp("evaluate", "chain:3", "-", text=json.dumps(bad))[0], 30)
        self.assertEqual(faults("orasp-plan-1", good), [])
        self.assertNotEqual(orasp("evaluate", "chain:3", "-", text=json.dumps(good))[0], 30)

    def test_fleet_plans_that_the_program_refuses_do_not_fit(self):
        good = self.plan(["solve", "fleet-lattice"])
        self.assertEqual(orasp("evaluate", "fleet-lattice", "-", text=json.dumps(good))[0], 0)
        for path, value in [(["fleet", "objective"], "speed"), (["fleet", "objective"], ABSENT), (["steps"], ABSENT),
                            (["steps", 0, "moves"], ABSENT), (["steps", 0, "moves", 0, "from"], "kitchen"),
                            (["steps", 0, "moves", 0, "motion"], "up"), (["steps", 0, "connections", 0], 12),
                            (["steps", 0, "moves", 0, "robots"], ["first"])]:
            with self.subTest(path=path):
                bad = changed(good, path, value)
                self.assertNotEqual(faults("orasp-plan-1", bad), [])
                self.assertEqual(orasp("evaluate", "fleet-lattice", "-", text=json.dumps(bad))[0], 30)


class Policies(unittest.TestCase):
    def test_a_policy_of_states_fits(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "policy.json"
            self.assertEqual(orasp("solve", str(ROOT / "examples/shelf-worn.json"), "-o", str(file))[0], 0)
            policy = json.loads(file.read_text(encoding="utf-8"))
        self.assertEqual(policy["format"], "orasp-state-policy/1")
        self.assertEqual(faults("orasp-state-policy-1", policy), [])
        self.assertEqual(policy.keys() - schema_of("orasp-state-policy-1")["properties"].keys(), set())
        for path, value in [(["format"], "orasp-policy/1"), (["problem_digest"], "x"), (["states"], ABSENT),
                            (["states", 0, "next"], 1), (["states", 0, "removed"], ABSENT)]:
            self.assertNotEqual(faults("orasp-state-policy-1", changed(policy, path, value)), [], path)

    def test_certificates_of_every_kind_fit(self):
        lattice = ["lattice"]
        cycle = {"format": "orasp-problem/1", "parts": [{"id": "1"}, {"id": "2"}, {"id": "3"}],
                 "connections": [{"parts": ["1", "2"]}, {"parts": ["2", "3"]}],
                 "precedence": [{"connection": "1-2", "after": ["2-3"]}, {"connection": "2-3", "after": ["1-2"]}]}
        locked = {key: cycle[key] for key in ["format", "parts", "connections"]}
        locked["blocking"] = {"directions": ["+x", "-x"], "blocked": [{"part": "1", "by": "2", "directions": ["+x", "-x"]}]}
        schema = "orasp-certificate-1"
        kinds = []
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "certificate.json"
            for words, problem in [(lattice, None), ([*lattice, "--objective", "indexed"], None), (["-"], cycle), (["-"], locked)]:
                orasp("solve", *words, "--certificate", str(file), "--quiet", text=json.dumps(problem) if problem else "")
                certificate = json.loads(file.read_text(encoding="utf-8"))
                kinds.append(certificate["kind"])
                self.assertEqual(faults(schema, certificate), [])
                for path, value in [(["format"], "orasp-plan/1"), (["problem_digest"], "x"), (["kind"], "pieces"), (["bound"], "0"),
                                    (["layer"], []), (["bound"], ABSENT)]:
                    self.assertNotEqual(faults(schema, changed(certificate, path, value)), [], path)
        self.assertEqual(kinds, ["sizes", "states", "waits", "locked"])

    def test_the_first_line_of_a_trained_policy_fits(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "lattice.policy"
            code, _ = orasp("train", "lattice", "-o", str(file), "--episodes", "20", "--hidden", "8", "--quiet")
            if code == 30:
                self.skipTest("this build cannot train")
            header = json.loads(file.read_bytes().split(b"\n", 1)[0])
            orasp("train", "lattice", "-o", str(file), "--episodes", "72", "--inputs", "pieces", "--quiet")
            over_pieces = json.loads(file.read_bytes().split(b"\n", 1)[0])
        self.assertEqual(faults("orasp-policy-1", over_pieces), [])
        self.assertEqual(over_pieces["pieces"], {"connections": 12, "hidden": [32, 32]})
        self.assertNotEqual(faults("orasp-policy-1", dict(over_pieces, pieces={"connections": 0, "hidden": []})), [])
        self.assertEqual(faults("orasp-policy-1", header), [])
        self.assertEqual(header.keys() - schema_of("orasp-policy-1")["properties"].keys(), set())
        self.assertNotEqual(faults("orasp-policy-1", dict(header, scale=0)), [])


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    PROGRAM = str(Path(sys.argv.pop(1)).resolve())
    unittest.main()
