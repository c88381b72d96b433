"""Problems from CAD models, pictures and pages."""
import base64
import json
import shutil
import tempfile
import unittest
from pathlib import Path

import orasp
from program import ROOT, run, sentence

STEP = ROOT / "tests" / "cli" / "references" / "references.step"


class Models(unittest.TestCase):
    def setUp(self):
        code, out, error = run("import", str(STEP), "-o", "-")
        if code != 0 and "not part of this build" in error:
            self.skipTest("OpenCASCADE is not there")
        self.printed = out

    def test_as_the_command_line(self):
        model = orasp.import_model(STEP)
        self.assertEqual(model.problem_json(), self.printed)
        self.assertEqual([part["id"] for part in model.parts], model.problem.part_ids)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "model.json"
            shapes = model.write(file)
            self.assertEqual(shapes.read_bytes(), model.shapes())
            problem = orasp.load(file)
            self.assertTrue(orasp.solve(problem).has_plan)
            self.assertIn(base64.b64encode(b"glTF")[:4].decode(), orasp.report(problem).html)
        other = orasp.import_model(STEP, density={model.parts[0]["id"]: 7850}, action="connection", unit="inch")
        self.assertEqual(other.parts[0]["density"], 7850)
        self.assertEqual(other.problem.action, "connection")

    def test_faults(self):
        code, _, error = run("import", "nothing.step", "-o", "-")
        self.assertEqual(code, 30)
        with self.assertRaises(orasp.InputError) as raised:
            orasp.import_model("nothing.step")
        self.assertEqual(str(raised.exception), sentence(error))
        for keywords, said in ((dict(unit="mile"), 'unit: "mile" is not a unit'), (dict(base="no such part"), "no such part"),
                               (dict(duration={"weld": 3}), "weld"), (dict(tolerance=0), "tolerance: ")):
            with self.subTest(keywords), self.assertRaisesRegex(orasp.InputError, said):
                orasp.import_model(STEP, **keywords)


class Pages(unittest.TestCase):
    def test_report(self):
        plan = orasp.solve("hubble", "greedy")
        page = orasp.report("hubble", plan, plan.connections, sample_count=20, title="A <title>")
        self.assertTrue(page.html.startswith("<!doctype html>"))
        self.assertIn("<iframe srcdoc=", page._repr_html_())
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(page.save(Path(folder) / "page.html").read_text(), page.html)
        for name in ("fleet-lattice", "table-hemnes"):
            self.assertTrue(orasp.report(name, time_limit=5).html)
        self.assertTrue(orasp.report("4brick", max_moved_parts=0).html)
        problem = orasp.load("4piece").copy()
        problem["geometry"] = {"file": "no.glb"}
        with self.assertWarnsRegex(orasp.OraspWarning, "the report does without"):
            orasp.report(problem)

    @unittest.skipUnless(shutil.which("dot"), "Graphviz is not there")
    def test_drawings(self):
        result = orasp.solve("lattice")
        drawings = [orasp.load("lattice").svg(), result.svg(), orasp.graph("2x3").svg(), orasp.load("lattice")._repr_svg_(),
                    orasp.tree_svg("4piece", orasp.solve("4piece"))]
        if shutil.which("gnuplot"):
            drawings.append(orasp.distribution_svg(orasp.sample("lattice", 30).rewards, optimum=result.reward))
        for drawing in drawings:
            self.assertIn("<svg", drawing)
        self.assertIsNone(orasp.solve("fleet-lattice")._repr_svg_())
        with tempfile.TemporaryDirectory() as folder:
            names = [name for name, _ in orasp.figures("4piece", folder, plan=orasp.solve("4piece"))]
            self.assertEqual(names, ["structure.svg", "steps.svg", "state-graph.svg", "tree.svg", "growth.svg"])
            self.assertEqual(sorted(path.name for path in Path(folder).iterdir()), sorted(names))

    def test_integer_programs(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, more in (("3piece", {}), ("fleet-lattice", {"steps": 4})):
                here, there = Path(folder) / "here.lp", Path(folder) / "there.lp"
                size = orasp.write_model(name, here, **more)
                options = [word for key, value in more.items() for word in (f"--{key}", str(value))]
                code, out, _ = run("solve", name, "--method", "mip", *options, "--write-model", str(there), "--json")
                self.assertEqual(code, 0)
                self.assertEqual(here.read_text(), there.read_text())
                self.assertEqual(size._asdict().items() - json.loads(out).items(), set())
            with self.assertRaises(orasp.InputError):
                orasp.write_model("3piece", Path(folder) / "model.txt")


if __name__ == "__main__":
    unittest.main()
