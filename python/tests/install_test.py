"""pip installs the package into an environment of its own, without a network, and it works from there.

The library is taken from the build that is tested. Skipped where pip or venv is missing.
"""
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from program import PROGRAM, ROOT


class Install(unittest.TestCase):
    def test_pip(self):
        environment = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "PIP_"))}
        environment.update(ORASP_BUILD=str(Path(PROGRAM).parent), PIP_NO_INDEX="1", PIP_DISABLE_PIP_VERSION_CHECK="1")
        with tempfile.TemporaryDirectory() as folder:
            def run(*command, **options):
                return subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, timeout=500, check=False,
                                      **options)

            if run(sys.executable, "-c", "import ensurepip, setuptools, pip").returncode != 0:
                self.skipTest("pip, setuptools or venv is missing")
            made = run(sys.executable, "-m", "venv", "--system-site-packages", "env")
            self.assertEqual(made.returncode, 0, made.stderr)
            # A copy: pip writes beside what it builds.
            copied = run("cp", "-r", str(ROOT / "python"), "python")
            self.assertEqual(copied.returncode, 0, copied.stderr)
            Path(folder, "CMakeLists.txt").write_bytes((ROOT / "CMakeLists.txt").read_bytes())
            installed = run("env/bin/python", "-m", "pip", "install", "--no-build-isolation", "./python")
            self.assertEqual(installed.returncode, 0, installed.stdout + installed.stderr)
            program = ("import orasp; print(orasp.__file__); print(orasp.solve('hubble').reward, orasp.learning_available(), "
                       "orasp.solve('3piece', 'mip').status if orasp.obstacle('3piece', 'mip') is None else 'no mip')")
            done = run("env/bin/python", "-c", program)
            self.assertEqual(done.stderr, "")
            place, facts = done.stdout.splitlines()
            self.assertTrue(place.startswith(folder), place)
            self.assertTrue(facts.startswith("-0.9902 "), facts)


if __name__ == "__main__":
    unittest.main()
