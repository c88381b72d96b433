"""What the package answers is what the command line answers: plans, rewards, statuses, JSON and sentences."""
import json
import tempfile
import unittest
import warnings
from pathlib import Path

import orasp
from program import parsed, random_problem, run, sentence, without_times


def answer(call):
    """The JSON of a result without times, or the sentence of an error."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", orasp.OraspWarning)
            return without_times(call().to_dict())
    except orasp.InputError as error:
        return str(error)


def program_answer(*arguments, stdin=None):
    code, out, err = run(*arguments, stdin=stdin)
    return sentence(err) if code >= 30 else parsed(out)


class Agreement(unittest.TestCase):
    maxDiff = 2000

    def test_every_scenario(self):
        for scenario in orasp.scenarios():
            if scenario.generator:
                continue
            with self.subTest(scenario.name):
                self.assertEqual(answer(lambda: orasp.solve(scenario.name, threads=2)),
                                 program_answer("solve", scenario.name, "--threads", "2", "--json"))

    def test_generated_problems(self):
        for name in ("chain:12", "grid:3x4", "tree:20:7", "random:10:14:3"):
            with self.subTest(name):
                self.assertEqual(answer(lambda: orasp.solve(name)), program_answer("solve", name, "--json"))

    def test_random_problems(self):
        with_plan = 0
        for seed in range(200):
            content = random_problem(seed)
            method = ("auto", "dijkstra", "orasp-search", "greedy", "a-star", "beam")[seed % 6]
            text = json.dumps(content)
            with self.subTest(seed=seed):
                here = answer(lambda: orasp.solve(orasp.Problem.from_dict(content), method))
                there = program_answer("solve", "-", "--method", method, "--json", stdin=text)
                self.assertEqual(here, there)
                with_plan += isinstance(here, dict) and here["reward"] is not None
        self.assertGreater(with_plan, 100)

    def test_walks_the_catalogue(self):
        """Each method on problems that it takes and on one that it refuses."""
        for method in orasp.methods():
            if method.name == "dqn":
                continue  # learning_test.py
            for name in ("4piece", "fleet-lattice", "table-hemnes"):
                if (method.name, name) == ("mip", "table-hemnes"):
                    continue  # takes longer than a minute, and where a limit stops it depends on the machine
                with self.subTest(method=method.name, problem=name):
                    self.assertEqual(answer(lambda: orasp.solve(name, method.name, threads=1, time_limit=60)),
                                     program_answer("solve", name, "--method", method.name, "--threads", "1", "--time-limit",
                                                    "60", "--json"))
                    if name == "4piece" and method.one_robot:
                        self.assertIsNone(orasp.obstacle(name, method.name))

    def test_options_of_methods(self):
        """Every option of the catalogue: a value that it may have, and one that it may not."""
        values = {"flag": [True], "whole": [3], "wholes": [[8, 8]], "real": [0.5]}
        for method in orasp.methods():
            for option in method.options:
                if option.kind == "file":
                    continue
                for value in values.get(option.kind, list(option.words)):
                    if method.name == "dqn":
                        continue
                    with self.subTest(method=method.name, option=option.name, value=value):
                        here = answer(lambda: orasp.solve("4piece", method.name, **{option.name: value}))
                        there = ["--" + option.name.replace("_", "-")]
                        if option.kind != "flag":
                            there.append(",".join(map(str, value)) if option.kind == "wholes" else str(value))
                        self.assertEqual(here,
                                         program_answer("solve", "4piece", "--method", method.name, *there, "--json"))
                if option.kind in ("whole", "wholes", "real", "choice"):
                    with self.subTest(method=method.name, option=option.name, value="nonsense"):
                        hyphened = option.name.replace("_", "-")
                        said = program_answer("solve", "4piece", "--method", method.name, f"--{hyphened}", "nonsense")
                        with self.assertRaises(orasp.InputError) as raised:
                            orasp.solve("4piece", method.name, **{option.name: "nonsense"})
                        self.assertEqual(str(raised.exception), said.replace(f"--{hyphened}", option.name))

    def test_changes_limits_and_other_plans(self):
        cases = [
            (dict(objective="time", direction="assembly"), ["--objective", "time", "--direction", "assembly"]),
            (dict(max_moved_parts=2, max_subassemblies=1), ["--max-moved-parts", "2", "--max-subassemblies", "1"]),
            (dict(max_moved_mass=2.5, seed=7), ["--max-moved-mass", "2.5", "--seed", "7"]),
            (dict(count=True, alternatives=3), ["--count", "--alternatives", "3"]),
            (dict(time_limit=60, memory_limit=100, threads=1),
             ["--time-limit", "60", "--memory-limit", "100", "--threads", "1"]),
        ]
        for keywords, arguments in cases:
            with self.subTest(arguments):
                self.assertEqual(answer(lambda: orasp.solve("lattice", **keywords)),
                                 program_answer("solve", "lattice", *arguments, "--json"))
        self.assertEqual(answer(lambda: orasp.solve("fleet-lattice", objective="fleet_travel", steps=5, robots=5)),
                         program_answer("solve", "fleet-lattice", "--objective", "fleet_travel", "--steps", "5", "--robots", "5",
                                        "--json"))
        self.assertEqual(answer(lambda: orasp.solve("fleet-lattice", objective="cubesat")),
                         program_answer("solve", "fleet-lattice", "--objective", "cubesat", "--json"))

    def test_sentences(self):
        """The same sentences, where options of the command line are named as in Python."""
        cases = [
            (lambda: orasp.solve("hubbel"), ["solve", "hubbel"]),
            (lambda: orasp.solve("hubble", "gredy"), ["solve", "hubble", "--method", "gredy"]),
            (lambda: orasp.solve("hubble", objective="tme"), ["solve", "hubble", "--objective", "tme"]),
            (lambda: orasp.solve("hubble", direction="up"), ["solve", "hubble", "--direction", "up"]),
            (lambda: orasp.solve("hubble", time_limit=-1), ["solve", "hubble", "--time-limit", "-1"]),
            (lambda: orasp.solve("hubble", threads=0), ["solve", "hubble", "--threads", "0"]),
            (lambda: orasp.solve("hubble", seed="x"), ["solve", "hubble", "--seed", "x"]),
            (lambda: orasp.solve("hubble", "greedy", bound="parts"), ["solve", "hubble", "--method", "greedy", "--bound", "parts"]),
            (lambda: orasp.solve("hubble", "greedy", max_sweeps=3), ["solve", "hubble", "--method", "greedy", "--max-sweeps", "3"]),
            (lambda: orasp.solve("hubble", robots=3), ["solve", "hubble", "--robots", "3"]),
            (lambda: orasp.solve("fleet-hubble", sites=99), ["solve", "fleet-hubble", "--sites", "99"]),
            (lambda: orasp.solve("hubble", steps=3), ["solve", "hubble", "--steps", "3"]),
            (lambda: orasp.solve("fleet-hubble", count=True), ["solve", "fleet-hubble", "--count"]),
            (lambda: orasp.solve("jwst", "dijkstra"), ["solve", "jwst", "--method", "dijkstra"]),
            (lambda: orasp.solve("no/such/file.json"), ["solve", "no/such/file.json"]),
            (lambda: orasp.graph("jwst", memory_limit=100), ["graph", "jwst", "--memory-limit", "100"]),
        ]
        for call, arguments in cases:
            with self.subTest(arguments):
                with self.assertRaises(orasp.InputError) as raised:
                    call()
                said = program_answer(*arguments)
                for option in ("time-limit", "max-sweeps", "threads", "seed", "bound", "robots", "sites", "count"):
                    said = said.replace(f"--{option}", option.replace("-", "_"))
                self.assertEqual(str(raised.exception), said)

    def test_faulty_problems(self):
        part = {"id": "a"}
        faulty = [
            {"format": "orasp-problem/1", "parts": [part]},
            {"format": "orasp-problem/1", "parts": [part], "connections": [{"parts": ["a", "b"]}]},
            {"format": "orasp-problem/1", "parts": [part, part], "connections": []},
            {"format": "orasp-problem/1", "parts": [{"id": "a", "mass": -1}], "connections": []},
            {"format": "orasp-problem/1", "parts": [part], "connections": [], "colour": "red"},
            {"format": "orasp-problem/2", "parts": [], "connections": []},
        ]
        for content in faulty:
            with self.subTest(content):
                with self.assertRaises(orasp.InputError) as raised:
                    orasp.load(content)
                said = program_answer("solve", "-", stdin=json.dumps(content))
                self.assertEqual("standard input: " + str(raised.exception), said)

    def test_other_commands(self):
        plan = orasp.solve("hubble", "greedy")
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "plan.json"
            plan.save(file)
            self.assertEqual(orasp.evaluate("hubble", plan, max_moved_parts=1).to_dict(),
                             program_answer("evaluate", "hubble", str(file), "--max-moved-parts", "1", "--json"))
            self.assertEqual(orasp.evaluate("hubble", file).to_dict(),
                             program_answer("evaluate", "hubble", str(file), "--json"))
            ids = plan.connections
            here = without_times(orasp.replan("hubble", plan=file, done=4, inaccessible=[ids[6]], lost_parts="7").to_dict())
            there = program_answer("replan", "hubble", "--plan", str(file), "--done", "4", "--inaccessible", ids[6],
                                   "--lost-part", "7", "--json")
            del there["options"]["plan"]
            self.assertEqual(here, there)
        fleet = orasp.solve("fleet-lattice")
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "plan.json"
            fleet.save(file)
            self.assertEqual(orasp.evaluate("fleet-lattice", fleet).to_dict(),
                             program_answer("evaluate", "fleet-lattice", str(file), "--json"))
        self.assertEqual(orasp.explain("4brick", max_moved_parts=0).to_dict(),
                         program_answer("explain", "4brick", "--max-moved-parts", "0", "--json"))
        self.assertEqual(orasp.sample("hubble-free", 50, seed=3).to_dict(),
                         program_answer("sample", "hubble-free", "-n", "50", "--seed", "3", "--json"))
        said = program_answer("explain", "lattice", "--connection", "4-5", "--max-moved-parts", "0", "--json")
        found = orasp.explain_connection("lattice", "4-5", max_moved_parts=0)
        self.assertEqual(found.to_dict(), said)
        for connection in orasp.load("hubble").connection_ids:
            self.assertEqual(orasp.explain_connection("hubble", connection).to_dict(),
                             program_answer("explain", "hubble", "--connection", connection, "--json"))

    def test_certificates(self):
        """Certificates and the verdicts on them are those of the command line; a verdict depends on the plan."""
        kinds = set()
        with tempfile.TemporaryDirectory() as folder:
            plan_file, certificate_file = Path(folder) / "plan.json", Path(folder) / "certificate.json"
            for seed in range(60):
                problem = orasp.Problem.from_dict(random_problem(seed))
                text = json.dumps(random_problem(seed))
                with self.subTest(seed=seed):
                    certificate_file.unlink(missing_ok=True)
                    plan_file.unlink(missing_ok=True)
                    run("solve", "-", "-o", str(plan_file), "--certificate", str(certificate_file), stdin=text)
                    result = orasp.solve(problem)
                    made = result.certificate()
                    self.assertEqual(made.text, certificate_file.read_text(encoding="utf-8"))
                    kinds.add(made.kind)
                    plan = result if result.has_plan else None
                    verdict = orasp.check(problem, plan, made)
                    self.assertTrue(verdict.proved, verdict)
                    self.assertEqual(verdict.to_dict(), program_answer("check", "-", str(plan_file) if plan else "none",
                                                                       str(certificate_file), "--json", stdin=text))
                    self.assertEqual(orasp.check(problem, plan, certificate_file), verdict)
                    self.assertEqual(orasp.check(problem, plan, made.to_dict()), verdict)
                    self.assertEqual(verdict.bound, made.bound)
                    if plan is not None:
                        self.assertFalse(orasp.check(problem, None, made).proved)
        self.assertLessEqual({"sizes", "states", "waits"}, kinds)
        with self.assertRaises(orasp.InputError) as raised:
            orasp.solve("fleet-lattice").certificate()
        self.assertEqual(f"--certificate: {raised.exception}", program_answer("solve", "fleet-lattice", "--certificate", "none.json"))
        # A worse plan, and a certificate of another problem.
        best = orasp.solve("hubble")
        worse = orasp.solve("hubble", "random", seed=3)
        verdict = orasp.check("hubble", worse, best.certificate())
        self.assertFalse(verdict.proved)
        self.assertIn("bounds plans by", verdict.fault)
        with self.assertRaisesRegex(orasp.InputError, "digest|another problem"):
            orasp.check("lattice", orasp.solve("lattice"), best.certificate())

    def test_explain_with_the_widths_of_an_import(self):
        product = {"format": "orasp-problem/1", "parts": [{"id": "box"}, {"id": "lid"}],
                   "connections": [{"parts": ["box", "lid"]}],
                   "blocking": {"directions": ["+x", "-x"], "x-tolerance": 0.0001,
                                "blocked": [{"part": "lid", "by": "box", "directions": ["+x", "-x"], "x-width": [0.012, 0.00025]}]}}
        found = orasp.explain_connection(product, "box-lid").to_dict()
        self.assertEqual(found, program_answer("explain", "-", "--connection", "box-lid", "--json", stdin=json.dumps(product)))
        self.assertEqual(sorted(along["width"] for along in found["changes"][0]["directions"]), [0.00025, 0.012])

    def test_simulate(self):
        uncertain = {"format": "orasp-problem/1", "parts": [{"id": "a"}, {"id": "b"}, {"id": "c"}],
                     "connections": [{"parts": ["a", "b"], "success": 0.5}, {"parts": ["b", "c"], "success": 0.9}],
                     "objective": {"type": "time"}}
        self.assertEqual(orasp.simulate(uncertain, 500, seed=3).to_dict(),
                         program_answer("simulate", "-", "-n", "500", "--seed", "3", "--json", stdin=json.dumps(uncertain)))
        solved = orasp.solve(uncertain)
        self.assertEqual(without_times(solved.to_dict()), program_answer("solve", "-", "--json", stdin=json.dumps(uncertain)))
        self.assertEqual(orasp.simulate(uncertain, 500, seed=3, policy=solved).expected, solved.reward)

    def test_compare(self):
        rows = orasp.compare(["2x3", "fleet-lattice"], time_limit=60)
        said = program_answer("compare", "2x3", "fleet-lattice", "--time-limit", "60", "--json")["rows"]
        self.assertEqual([without_times(row.to_dict()) for row in rows], said)

    def test_graph_sizes(self):
        for name in ("lattice", "hubble", "4brick"):
            size = orasp.graph(name).size()
            said = program_answer("graph", name, "--json")
            self.assertEqual((size.states, size.actions, size.dead_ends, size.tree_nodes, size.sequences),
                             (said["states"], said["actions"], said["dead_ends"], int(said["tree_nodes"]), int(said["sequences"])))
            self.assertEqual(size.layers, [(layer["states"], layer["actions"]) for layer in said["layers"]])

    def test_plans_come_back(self):
        """What solve writes, evaluate reads, as file, dict and list."""
        for name in ("hubble", "table-hemnes", "fleet-lattice"):
            result = orasp.solve(name, threads=1, time_limit=60)
            with self.subTest(name):
                for plan in (result, result.to_dict()):
                    found = orasp.evaluate(name, plan)
                    self.assertTrue(found.valid, found.violations)
                    self.assertAlmostEqual(found.reward, result.reward, places=9)


if __name__ == "__main__":
    unittest.main()
