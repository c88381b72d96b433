"""Each notebook runs from top to bottom."""
import os
import subprocess
import sys
import unittest
from pathlib import Path

from program import ROOT

FOLDER = ROOT / "python" / "notebooks"


class Notebooks(unittest.TestCase):
    def run_one(self, name):
        done = subprocess.run([sys.executable, "-W", "error::UserWarning", str(FOLDER / f"{name}.py")], capture_output=True, text=True,
                              timeout=300, check=False, env=os.environ)
        if done.returncode == 1 and ("libtorch is not there" in done.stderr or "is not part of this build" in done.stderr):
            self.skipTest(done.stderr.strip())
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)

    def test_none_is_forgotten(self):
        names = {path.stem for path in FOLDER.glob("*.py")}
        self.assertEqual(names, {name.removeprefix("test_run_") for name in dir(self) if name.startswith("test_run_")})
        for path in FOLDER.glob("*.py"):
            text = Path(path).read_text(encoding="utf-8")
            self.assertTrue(text.startswith("# %% [markdown]\n# # "), path)


for notebook in ("first_plan", "own_objective", "graph_by_hand", "replanning", "learning", "from_cad"):
    setattr(Notebooks, f"test_run_{notebook}", lambda self, name=notebook: self.run_one(name))


if __name__ == "__main__":
    unittest.main()
