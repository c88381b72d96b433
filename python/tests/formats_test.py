"""Other formats: what is written is what `orasp convert` writes."""
import tempfile
import unittest
import warnings
from pathlib import Path

import orasp
from program import ROOT, run, sentence


class Formats(unittest.TestCase):
    def test_writes_as_the_command_line(self):
        """Every format, a problem and where it is one of plans a plan, with the same notes."""
        for format in orasp.formats():
            if not format.writes:
                continue
            with self.subTest(format.name), warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                code, out, error = run("convert", "hubble", "--to", format.name, "-o", "-")
                if code >= 30:
                    with self.assertRaises(orasp.InputError) as raised:
                        orasp.format_text("hubble", format.name)
                    self.assertEqual("hubble: " + str(raised.exception), sentence(error))
                    continue
                self.assertEqual(orasp.format_text("hubble", format.name), out)
                notes = [line.removeprefix("orasp: warning: ") for line in error.splitlines() if "warning" in line]
                self.assertEqual([str(warning.message) for warning in caught], notes)

    def test_reads_the_examples(self):
        found = 0
        for file in sorted((ROOT / "examples" / "formats").glob("*")):
            code, out, error = run("convert", str(file), "-o", "-")
            if file.is_dir() or code >= 30 and "format" in error:
                continue
            with self.subTest(file.name), warnings.catch_warnings():
                warnings.simplefilter("ignore", orasp.OraspWarning)
                self.assertEqual(orasp.read_format(file), orasp.Problem.from_json(out))
                found += 1
        self.assertGreater(found, 2)

    def test_files_and_faults(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "p.graphml"
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", orasp.OraspWarning)
                orasp.write_format("4piece", file)
                self.assertEqual(orasp.read_format(file).part_ids, orasp.load("4piece").part_ids)
            with self.assertRaisesRegex(orasp.InputError, "p.graphml: "):
                orasp.read_format(file, "graphlm")
            with self.assertRaisesRegex(orasp.InputError, 'unknown format "graphlm"'):
                orasp.format_text("4piece", "graphlm")
            with self.assertRaisesRegex(orasp.InputError, "cannot read"):
                orasp.read_format(Path(folder) / "none.graphml")
            plans = [format.name for format in orasp.formats() if format.of_plan]
            with self.assertRaisesRegex(orasp.InputError, "the plan breaks a rule at step"):
                orasp.format_text("hubble", plans[0], plan=list(reversed(orasp.solve("hubble").connections)))


if __name__ == "__main__":
    unittest.main()
