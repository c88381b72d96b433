#!/usr/bin/env python3
"""Tests `orasp import`.

    tests/cli/import_test.py PROGRAM [unittest's arguments]

What needs a module (OpenCASCADE, assimp) is skipped where the build has none, and what needs models of others where
they do not lie beside the tree.
"""
import io
import json
import os
import shutil
import signal
import struct
import subprocess
import unittest
import zipfile
from pathlib import Path

from program import PROGRAM, ROOT, Answer, Case, orasp, wait_for_work

BUILD = Path(PROGRAM).parent
EXAMPLES = ROOT / "examples/cad"
MODELS = ROOT.parent / "shared/cad"
has_step = unittest.skipUnless((BUILD / "orasp_occt.so").exists(), "this build has no OpenCASCADE")
has_meshes = unittest.skipUnless((BUILD / "orasp_assimp.so").exists(), "this build has no assimp")
has_models = unittest.skipUnless(MODELS.exists(), f"there are no models in {MODELS}")

# Corners of a box in the order x, y, z, and its outward triangles.
TRIANGLES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
             (1, 5, 7), (1, 7, 3)]


def corners(low, size=(10, 10, 10)):
    return [(low[0] + size[0] * i, low[1] + size[1] * j, low[2] + size[2] * k)
            for i in (0, 1) for j in (0, 1) for k in (0, 1)]


def package_3mf(boxes, model=""):
    """Boxes (name or None, low) as a 3MF file; `model`: attributes of its model."""
    objects = ""
    for number, (name, low) in enumerate(boxes, 1):
        vertices = "".join('<vertex x="%g" y="%g" z="%g"/>' % corner for corner in corners(low))
        triangles = "".join('<triangle v1="%d" v2="%d" v3="%d"/>' % triangle for triangle in TRIANGLES)
        named = f' name="{name}"' if name else ""
        objects += (f'<object id="{number}" type="model"{named}><mesh><vertices>{vertices}</vertices>'
                    f"<triangles>{triangles}</triangles></mesh></object>")
    items = "".join(f'<item objectid="{number}"/>' for number in range(1, len(boxes) + 1))
    bytes_ = io.BytesIO()
    with zipfile.ZipFile(bytes_, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"/>')
        archive.writestr("_rels/.rels",
                         '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship '
                         'Target="/3D/box.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>'
                         "</Relationships>")
        archive.writestr("3D/box.model",
                         f'<?xml version="1.0" encoding="UTF-8"?><model {model} xmlns="http://schemas.microsoft.com/'
                         f'3dmanufacturing/core/2015/02"><resources>{objects}</resources><build>{items}</build></model>')
    return bytes_.getvalue()


def stl(low, size=(10, 10, 10)):
    """A box as a binary STL file."""
    points = corners(low, size)
    data = b"\0" * 80 + struct.pack("<I", len(TRIANGLES))
    for triangle in TRIANGLES:
        data += struct.pack("<3f", 0, 0, 0) + b"".join(struct.pack("<3f", *points[i]) for i in triangle) + b"\0\0"
    return data


def obj(low, size=(10, 10, 10), name="", first=1):
    lines = [f"o {name}"] if name else []
    lines += ["v {} {} {}".format(*point) for point in corners(low, size)]
    lines += ["f " + " ".join(str(first + i) for i in triangle) for triangle in TRIANGLES]
    return "\n".join(lines) + "\n"


def nodes_of(glb):
    length = struct.unpack_from("<I", glb, 12)[0]
    return [node["name"] for node in json.loads(glb[20:20 + length])["nodes"]]


class Import(Case):
    def written(self, *words, code=0):
        """Imports, and gives the problem and the report as documents."""
        target = self.folder / "product.json"
        answer = orasp("import", *map(str, words), "-o", target, "--json")
        self.check(answer, code)
        self.assertEqual(nodes_of(target.with_suffix(".glb").read_bytes()),
                         [part["id"] for part in json.loads(target.read_text())["parts"]])
        return json.loads(target.read_text()), json.loads(answer.out)

    def check_refused(self, words, said):
        """One sentence, and nothing is written."""
        target = self.folder / "refused.json"
        answer = orasp("import", *map(str, words), "-o", target)
        self.check_sentence(answer)
        self.assertIn(said, answer.error)
        self.assertFalse(target.exists() or target.with_suffix(".glb").exists())

    def solved(self, *words):
        return json.loads(orasp("solve", self.folder / "product.json", "--json", *words).out)

    # -----------------------------------------------------------------------------------------------------------------
    # STEP

    @has_step
    def test_a_step_file_becomes_a_problem_with_names_masses_colours_and_blocking(self):
        problem, report = self.written(EXAMPLES / "sensor_box.step", "--base", "housing")
        self.assertEqual([part["id"] for part in problem["parts"]],
                         ["housing", "board", "battery", "screw M3x10", "screw M3x10 2", "screw M3x10 3",
                          "screw M3x10 4", "gasket", "lid"])
        self.assertEqual(problem["name"], "sensor box")
        self.assertEqual((problem["action"], problem["base"]), ("part", ["housing"]))
        # Battery: 20 x 20 x 8 mm of 2,400 kg/m^3, its centre at z = 4.6 + 4 mm.
        battery = problem["parts"][2]
        self.assertAlmostEqual(battery["mass"], 0.02 * 0.02 * 0.008 * 2400, 9)
        self.assertAlmostEqual(battery["position"][2], 0.0086, 9)
        self.assertEqual(report["parts"][2]["density_source"], "file")
        self.assertEqual(report["parts"][3]["density_source"], "name")
        self.assertEqual(report["equal"], [["screw M3x10", "screw M3x10 2", "screw M3x10 3", "screw M3x10 4"]])
        self.assertEqual({entry["verdict"] for entry in report["overlaps"]}, {"thread"})
        self.assertEqual((report["locked"], report["stuck"], len(report["groups"])), ([], [], 1))
        # The lid is held by the screws and leaves upward alone, as the screws do.
        lid = [entry for entry in problem["blocking"]["blocked"] if {entry["part"], entry["by"]} == {"gasket", "lid"}]
        self.assertEqual(lid[0]["directions"], ["+z"])
        self.assertEqual(len(lid[0]["x-width"]), 1)
        self.assertEqual(problem["blocking"]["x-tolerance"], 1e-4)

    @has_step
    def test_its_plan_is_what_a_mechanic_would_do(self):
        problem, _ = self.written(EXAMPLES / "sensor_box.step")
        self.assertEqual((problem["base"], problem["limits"]), (["housing"], {"max_moved_parts": 1, "grounded": True}))
        plan = self.solved()
        self.assertEqual(plan["status"], "optimal")
        moved = [step["moved"][0] for step in plan["steps"]]
        self.assertEqual(len(moved), 8)
        for screw in moved[:4]:
            self.assertTrue(screw.startswith("screw"), moved)
        self.assertEqual(moved[4], "lid")

    @has_step
    def test_units_are_stated_or_given(self):
        _, report = self.written(EXAMPLES / "sensor_box.step")
        self.assertEqual((report["unit"], report["tolerance"]), ("mm", 0.1))
        _, report = self.written(EXAMPLES / "sensor_box.step", "--unit", "inch")
        self.assertAlmostEqual(report["parts"][0]["size"][0], 60 * 25.4, 3)
        whole = (EXAMPLES / "sensor_box.step").read_bytes()
        for unit, millimetres in [(b".CENTI.,.METRE.", 10), (b"$,.METRE.", 1000)]:
            file = self.file("other.step", whole.replace(b".MILLI.,.METRE.", unit))
            _, report = self.written(file)
            self.assertEqual(report["millimetres_per_unit"], millimetres)
            self.assertAlmostEqual(report["parts"][0]["size"][0], 60 * millimetres, 3)

    @has_step
    def test_ap242_is_read_as_ap214_is(self):
        first, _ = self.written(EXAMPLES / "sensor_box.step")
        text = (EXAMPLES / "sensor_box.step").read_text()
        schema = "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }"
        changed = text.replace("AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }", schema)
        self.assertNotEqual(changed, text)
        second, _ = self.written(self.file("box.step", changed))
        self.assertEqual(first["parts"], second["parts"])

    @has_step
    def test_faulty_step_files_are_one_sentence_each(self):
        whole = (EXAMPLES / "sensor_box.step").read_bytes()
        head = b"ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n" \
               b"FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n"
        for name, content, said in [
            ("cut.step", whole[:len(whole) // 2], "cut.step: it is cut off"),
            ("none.step", head + b"#1=CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;\nEND-ISO-10303-21;\n",
             "none.step: it holds no shape"),
            ("words.stp", b"hello\n", "words.stp: it is not a STEP file"),
            ("empty.stp", b"", "empty.stp: it is not a STEP file"),
        ]:
            with self.subTest(name):
                self.check_refused([self.file(name, content)], said)

    @has_step
    def test_files_that_a_step_file_refers_to_are_read_and_missed(self):
        for file in (ROOT / "tests/cli/references").iterdir():
            shutil.copy(file, self.folder)
        problem, _ = self.written(self.folder / "references.step")
        self.assertEqual([part["id"] for part in problem["parts"]], ["peg", "plate"])
        # From another folder too.
        target = self.folder / "elsewhere.json"
        self.check(orasp("import", "references.step", "-o", target, cwd=self.folder), 0)
        (self.folder / "part_peg.stp").unlink()
        self.check_refused([self.folder / "references.step"], "references.step: it refers to part_peg.stp, which is not")

    # -----------------------------------------------------------------------------------------------------------------
    # Meshes

    @has_meshes
    def test_an_obj_file_has_a_part_for_each_object_whatever_its_name(self):
        problem, report = self.written(EXAMPLES / "sensor_box.obj")
        self.assertEqual([part["id"] for part in problem["parts"]][5:],
                         ["screw M3x10", "screw M3x10 2", "screw M3x10 3", "screw M3x10 4"])
        self.assertEqual(len(report["equal"]), 1)
        twins = obj((0, 0, 0), name="part of it") + obj((10, 0, 0), name="part of it", first=9)
        problem, _ = self.written(self.file("twins.obj", twins))
        self.assertEqual([part["id"] for part in problem["parts"]], ["part of it", "part of it 2"])

    @has_meshes
    def test_a_folder_has_a_part_for_each_file_in_the_order_of_their_numbers(self):
        folder = self.folder / "parts"
        folder.mkdir()
        for number in (1, 2, 10):
            (folder / f"part{number}.stl").write_bytes(stl((10 * number, 0, 0)))
        (folder / "part3.obj").write_text(obj((30, 0, 0)))
        (folder / "notes.txt").write_text("not a mesh")
        problem, report = self.written(folder)
        self.assertEqual([part["id"] for part in problem["parts"]], ["part1", "part2", "part3", "part10"])
        self.assertEqual(problem["name"], "parts")
        self.assertEqual([contact["proposed"] for contact in report["contacts"]], [False, False, True])

    @has_meshes
    def test_the_shapes_that_were_written_are_read_back(self):
        first, _ = self.written(EXAMPLES / "sensor_box.obj")
        shutil.copy(self.folder / "product.glb", self.folder / "shapes.glb")
        second, report = self.written(self.folder / "shapes.glb")
        self.assertEqual([part["id"] for part in second["parts"]], [part["id"] for part in first["parts"]])
        for a, b in zip(first["parts"], second["parts"]):
            self.assertAlmostEqual(a["mass"], b["mass"], 6)
        self.assertEqual([connection["parts"] for connection in second["connections"]],
                         [connection["parts"] for connection in first["connections"]])
        self.assertEqual(len(report["equal"][0]), 4)
        self.assertEqual(report["unit"], "m")

    @has_meshes
    def test_a_3mf_file_says_its_unit_and_the_names_of_its_objects(self):
        boxes = [("base", (0, 0, 0)), (None, (0, 0, 10))]
        problem, report = self.written(self.file("inches.3mf", package_3mf(boxes, 'unit="inch"')))
        self.assertEqual([part["id"] for part in problem["parts"]], ["base", "part 2"])
        self.assertEqual(report["unit"], "inch")
        self.assertAlmostEqual(problem["parts"][0]["mass"], 1200 * (10 * 0.0254) ** 3, 4)
        self.assertEqual(len(problem["connections"]), 1)
        self.assertNotIn("do not say their unit", str(report["warnings"]))
        for stated, millimetres in (("", 1), ('unit="micron"', 0.001), ('unit="meter"', 1000)):
            problem, _ = self.written(self.file("other.3mf", package_3mf(boxes[:1], stated)), "--density", "1000000000")
            self.assertAlmostEqual(problem["parts"][0]["mass"] / (1e9 * (0.01 * millimetres) ** 3), 1, 4)
        problem, _ = self.written(self.folder / "inches.3mf", "--unit", "mm")
        self.assertAlmostEqual(problem["parts"][0]["mass"], 0.0012, 6)
        self.check_refused([self.file("furlongs.3mf", package_3mf(boxes, 'unit="furlong"'))],
                           'its unit of length is "furlong"')

    @has_meshes
    def test_gltf_and_ply_files_are_read(self):
        points = b"".join(struct.pack("<3f", *(x / 1000 for x in corner)) for corner in corners((0, 0, 0)))
        triangles = b"".join(struct.pack("<3H", *triangle) for triangle in TRIANGLES)
        self.file("box.bin", points + triangles)
        document = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
            "nodes": [{"mesh": 0, "name": "base"}, {"mesh": 0, "name": "lid", "translation": [0, 0, 0.01]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0],
                           "max": [0.01, 0.01, 0.01]},
                          {"bufferView": 1, "componentType": 5123, "count": 3 * len(TRIANGLES), "type": "SCALAR"}],
            "bufferViews": [{"buffer": 0, "byteLength": len(points)},
                            {"buffer": 0, "byteOffset": len(points), "byteLength": len(triangles)}],
            "buffers": [{"uri": "box.bin", "byteLength": len(points) + len(triangles)}]}
        problem, report = self.written(self.file("product.gltf", json.dumps(document)))
        self.assertEqual([part["id"] for part in problem["parts"]], ["base", "lid"])
        self.assertAlmostEqual(problem["parts"][1]["mass"], 0.0012, 6)
        self.assertEqual((len(problem["connections"]), len(report["equal"])), (1, 1))
        ply = ("ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
               f"element face {len(TRIANGLES)}\nproperty list uchar int vertex_indices\nend_header\n")
        ply += "".join("%g %g %g\n" % corner for corner in corners((0, 0, 0)))
        ply += "".join("3 %d %d %d\n" % triangle for triangle in TRIANGLES)
        problem, report = self.written(self.file("box.ply", ply))
        self.assertAlmostEqual(problem["parts"][0]["mass"], 0.0012, 6)
        self.assertIn("do not say their unit", str(report["warnings"]))

    @has_meshes
    def test_poses_place_the_parts_of_a_folder(self):
        folder = self.folder / "parts"
        folder.mkdir()
        for name in ("a", "b", "c"):
            (folder / f"{name}.stl").write_bytes(stl((-5, -5, -5)))
        answer = orasp("import", folder, "-o", self.folder / "x.json")
        self.check(answer, 0, error="poses are missing")
        poses = self.file("poses.json", json.dumps({
            "a": {"position": [0, 0, 0]}, "b": {"position": [10, 0, 0], "euler": [0, 0, 1.5707963267948966]},
            "c": {"position": [20, 0, 0]}}))
        problem, _ = self.written(folder, "--pose", poses)
        self.assertEqual([part["position"] for part in problem["parts"]], [[0, 0, 0], [0.01, 0, 0], [0.02, 0, 0]])
        self.assertEqual(len(problem["connections"]), 2)
        self.check_refused([folder, "--pose", self.file("other.json", '{"d": {"position": [0, 0, 0]}}')],
                           'there is a pose of "d", but no such part')
        self.check_refused([folder, "--pose", self.file("bad.json", '{"a": {"position": [0, 0]}}')], "bad.json: a.position")
        self.check_refused([folder, "--pose", self.folder / "none.json"], "none.json: it cannot be opened")

    @has_meshes
    def test_faulty_meshes_are_one_sentence_each(self):
        nan = stl((0, 0, 0))
        nan = nan[:96] + struct.pack("<f", float("nan")) + nan[100:]
        (self.folder / "hollow").mkdir()
        for name, content, said in [
            ("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "points.obj: it holds no triangle"),
            ("nan.stl", nan, "nan.stl: a vertex has a coordinate that is not a finite number"),
            ("cut.stl", stl((0, 0, 0))[:-70], "cut.stl: it cannot be read"),
            ("none.stl", b"\0" * 84, "none.stl: it holds no triangle"),
            ("empty.glb", b"", "empty.glb: it is empty"),
            ("words.glb", b"hello\n", "words.glb: it cannot be read"),
            ("cut.glb", b"glTF" + struct.pack("<II", 2, 1000), "cut.glb: it cannot be read"),
            ("table.csv", b"1,2\n", "table.csv: its name ends in none of"),
        ]:
            with self.subTest(name):
                self.check_refused([self.file(name, content)], said)
        self.check_refused([self.folder / "hollow"], "hollow: no file in this folder ends in")
        self.check_refused([self.folder / "nowhere.stl"], "nowhere.stl: there is no such file or folder")

    @has_meshes
    def test_a_thousand_files_are_imported(self):
        folder = self.folder / "many"
        folder.mkdir()
        for i in range(1000):
            (folder / f"{i}.stl").write_bytes(stl((20 * (i % 10), 20 * (i // 10 % 10), 20 * (i // 100))))
        problem, report = self.written(folder)
        self.assertEqual(len(problem["parts"]), 1000)
        self.assertEqual(len(report["equal"]), 1)

    # -----------------------------------------------------------------------------------------------------------------
    # The command

    @has_meshes
    def test_the_report_is_for_people(self):
        answer = orasp("import", EXAMPLES / "sensor_box.obj", "-o", self.folder / "x.json")
        self.check(answer, 0, out=r"\Asensor_box: 9 parts, 12 connections, \d+ blocking facts\n")
        self.assertRegex(answer.out, r"apart +part by part, by straight motions")
        self.assertRegex(answer.out, r" +4  screw M3x10 +")
        self.assertRegex(answer.error, r"warning: nothing tells the density of 5 parts: 1200 kg/m\^3 is assumed")
        self.assertEqual(orasp("import", EXAMPLES / "sensor_box.obj", "-o", self.folder / "x.json", "--quiet").error, "")

    @has_meshes
    def test_options_reach_the_problem(self):
        box = EXAMPLES / "sensor_box.obj"
        problem, _ = self.written(box, "--exclude", "screw*,gasket", "--action", "connection", "--duration", "contact=2",
                                  "--density", "3000,lid=1000")
        self.assertEqual([part["id"] for part in problem["parts"]], ["housing", "board", "battery", "lid"])
        self.assertNotIn("action", problem)
        self.assertEqual({connection["duration"] for connection in problem["connections"]
                          if connection["x-kind"] == "contact"}, {2})
        self.assertEqual([part["x-density"] for part in problem["parts"]], [3000, 3000, 3000, 1000])
        problem, _ = self.written(box, "--directions", "geometry", "--flexible", "gasket")
        self.assertTrue(problem["parts"][3]["x-flexible"])
        self.assertNotIn("gasket", {entry["part"] for entry in problem["blocking"]["blocked"]})
        printed = orasp("import", box, "-o", "-", "--quiet")
        self.assertNotIn("geometry", json.loads(printed.out))

    def test_what_makes_no_sense_is_refused_in_a_sentence(self):
        target = str(self.folder / "x.json")
        for words, said in [
            ([], "MODEL"),
            (["a.step"], "-o FILE is missing"),
            (["a.step", "-o", "-", "--json"], "only one of"),
            (["a.step", "-o", target, "--unit", "ell"], '--unit: "ell" is not a unit of length'),
            (["a.step", "-o", target, "--directions", "all"], "neither axes nor geometry"),
            (["a.step", "-o", target, "--action", "piece"], "neither part nor connection"),
            (["a.step", "-o", target, "--duration", "glue=3"], "kinds are contact, fit and fastener"),
            (["a.step", "-o", target, "--tolerance", "0"], "--tolerance"),
            (["a.step", "-o", target, "--density", "x=0"], "--density"),
        ]:
            with self.subTest(words=words):
                answer = orasp("import", *words)
                self.check_sentence(answer)
                self.assertIn(said, answer.error)

    def test_a_model_is_not_written_over(self):
        model = self.file("pump.glb", b"precious")
        answer = orasp("import", model, "-o", self.folder / "pump.json")
        self.check_sentence(answer)
        self.assertIn("would be written over", answer.error)
        self.assertEqual(Path(model).read_bytes(), b"precious")

    @has_meshes
    def test_neither_file_is_written_where_one_cannot_be(self):
        target = self.folder / "there" / "x.json"
        self.check_sentence(orasp("import", EXAMPLES / "sensor_box.obj", "-o", target, "--quiet"))
        folder = self.folder / "x.json"
        folder.mkdir()
        self.check_sentence(orasp("import", EXAMPLES / "sensor_box.obj", "-o", folder, "--quiet"))
        self.assertFalse((self.folder / "x.glb").exists())

    def test_without_a_module_a_sentence_says_how_to_get_it(self):
        alone = self.folder / "bin" / "orasp"
        alone.parent.mkdir()
        shutil.copy(PROGRAM, alone)
        for file, package in [("a.step", "libocct-data-exchange-dev"), ("a.stl", "libassimp-dev")]:
            done = subprocess.run([alone, "import", self.file(file, "x"), "-o", self.folder / "x.json"],
                                  capture_output=True, text=True)
            answer = Answer(done.returncode, done.stdout, done.stderr)
            self.check_sentence(answer)
            self.assertIn("./run import", answer.error)
            self.assertIn(package, answer.error)

    @has_step
    @has_models
    def test_ctrl_c_stops_with_nothing_written(self):
        target = self.folder / "x.json"
        running = self.not_beyond(subprocess.Popen([PROGRAM, "import", MODELS / "Nema23_LeadScrew.step", "-o", target],
                                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE))
        wait_for_work(running, 0.4)
        running.send_signal(signal.SIGINT)
        out, error = running.communicate(timeout=60)
        self.assertEqual((running.returncode, out), (20, b""), error)
        self.assertIn(b"nothing was written", error)
        self.assertEqual(os.listdir(self.folder), [])

    # -----------------------------------------------------------------------------------------------------------------
    # Real models


    @has_step
    @has_meshes
    @has_models
    def test_real_products_are_imported_and_solved_to_proof(self):
        for words, parts, connections in [
            (["AeroAssembly.step"], 8, 8),
            (["XtremeVWheel.step"], 7, 7),
            (["openDog_internals.stp"], 8, 6),
            (["openDog_foot.stp", "--flexible", "silicone"], 7, 11),
            (["openDog_remote.stp"], 4, 3),
            (["beam", "--pose", MODELS / "beam/config.json", "--unit", "cm"], 5, 4),
        ]:
            with self.subTest(words[0]):
                problem, report = self.written(MODELS / words[0], *words[1:])
                self.assertEqual((len(problem["parts"]), len(problem["connections"])), (parts, connections))
                self.assertEqual((report["stuck"], report["moved_at_once"]), ([], 1))
                self.assertEqual(self.solved()["status"], "optimal")

    @has_step
    @has_models
    def test_the_same_bytes_for_any_number_of_threads(self):
        written = []
        for threads in ("1", "2", "5"):
            target = self.folder / threads / "x.json"
            target.parent.mkdir()
            self.check(orasp("import", MODELS / "XtremeVWheel.step", "-o", target, "--threads", threads), 0)
            written.append((target.read_bytes(), target.with_suffix(".glb").read_bytes()))
        self.assertEqual(written[0], written[1])
        self.assertEqual(written[0], written[2])

    @has_step
    @has_models
    def test_pairs_that_cannot_part_are_named(self):
        _, report = self.written(MODELS / "openDog_foot.stp")
        self.assertEqual([pair["parts"] for pair in report["locked"]], [["silicone", "openDog V3_foot v17"]])
        self.assertIn("block each other along every direction", " ".join(report["questions"]))
        self.assertEqual(self.solved()["status"], "infeasible")


if __name__ == "__main__":
    unittest.main()
