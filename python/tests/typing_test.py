"""mypy --strict finds nothing in the package and the notebooks, and the stubs are those of the module.

Skipped where mypy is missing.
"""
import ast
import inspect
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import orasp
import orasp._orasp as module
from program import ROOT

FOLDER = ROOT / "python"
STUBS = FOLDER / "orasp" / "_orasp.pyi"


class Types(unittest.TestCase):
    def test_strict(self):
        if subprocess.run(["/usr/bin/python3", "-c", "import mypy"], capture_output=True, check=False).returncode != 0:
            self.skipTest("mypy is not there")
        notebooks = sorted(str(path) for path in (FOLDER / "notebooks").glob("*.py"))
        with tempfile.TemporaryDirectory() as cache:
            for paths in ([str(FOLDER / "orasp")], *([notebook] for notebook in notebooks)):
                done = subprocess.run(["/usr/bin/python3", "-m", "mypy", "--strict", "--config-file", str(FOLDER / "pyproject.toml"),
                                       "--cache-dir", cache, *paths], capture_output=True, text=True, cwd=FOLDER, check=False)
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_stubs_name_what_the_module_has(self):
        """Every class, function, method and property of the module stands in the stubs, and nothing else."""
        tree = ast.parse(STUBS.read_text(encoding="utf-8"))
        stated = {node.name: node for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
        there = {name for name in dir(module) if not name.startswith("__")}
        self.assertEqual(set(stated), there)
        for name, node in stated.items():
            if not isinstance(node, ast.ClassDef) or name in ("InputError", "Steps"):
                continue
            members = {item.name for item in node.body if isinstance(item, ast.FunctionDef) and not item.name.startswith("__")}
            known = {member for member in vars(getattr(module, name)) if not member.startswith("_")}
            self.assertEqual(members, known, name)

    def test_the_build_knows_every_file(self):
        """Files are named in CMakeLists.txt one by one: looking for them would make every build begin with a look."""
        listed = (FOLDER / "CMakeLists.txt").read_text(encoding="utf-8")
        for path in [*(FOLDER / "orasp").glob("*.py*"), *(FOLDER / "src").glob("*.cpp")]:
            self.assertIn(f"{path.parent.name}/{path.name}\n" if path.suffix == ".cpp" else f"  {path.name}\n", listed)

    def test_what_is_public_is_documented(self):
        for name in orasp.__all__:
            thing = getattr(orasp, name)
            if inspect.isclass(thing) or inspect.isfunction(thing):
                if name not in ("Step", "Steps"):  # in the stubs
                    self.assertTrue((thing.__doc__ or "").strip(), name)
        self.assertTrue((Path(orasp.__file__).parent / "py.typed").exists())


class Import(unittest.TestCase):
    def test_is_quick(self):
        """import orasp takes at most 0.15 s of the processor more than that of NumPy."""
        program = "import time, numpy; began = time.process_time(); import orasp; print(time.process_time() - began)"
        with tempfile.TemporaryDirectory() as cache:
            command = [sys.executable, "-X", f"pycache_prefix={cache}", "-c", program]
            environment = {"PYTHONPATH": str(Path(orasp.__file__).parent.parent), "PATH": "/usr/bin:/bin"}
            times = [float(subprocess.run(command, capture_output=True, text=True, env=environment, check=True).stdout)
                     for _ in range(6)]
        print(f"import orasp: {min(times[1:]):.3f} s more than NumPy")
        self.assertLess(min(times[1:]), 0.15)


if __name__ == "__main__":
    unittest.main()
