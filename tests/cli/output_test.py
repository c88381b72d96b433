#!/usr/bin/env python3
"""Tests where results go: files, standard output, a reader that goes away.

    tests/cli/output_test.py PROGRAM [unittest's arguments]
"""
import json
import os
import resource
import subprocess
import unittest

from program import PROGRAM, Case, orasp, smoke


class Output(Case):
    @smoke
    def test_the_plan_is_written_and_the_summary_printed(self):
        path = self.folder / "plan.json"
        answer = orasp("solve", "hubble", "-o", str(path))
        self.check(answer, 0, out=r"reward   -0\.9902\n")
        self.assertEqual(json.loads(path.read_text())["format"], "orasp-plan/1")
        self.assertEqual(os.listdir(self.folder), ["plan.json"])

    def test_nothing_half_written_stays_behind(self):
        old = self.folder / "old.json"
        old.write_text("old")

        def small_files_only():
            resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
        answer = orasp("solve", "hubble", "-o", str(old), preexec_fn=small_files_only)
        self.check_sentence(answer)
        self.assertRegex(answer.error, r"cannot write .*old\.json: File too large")
        self.assertEqual(old.read_text(), "old")
        self.assertEqual(os.listdir(self.folder), ["old.json"])

        for target in [self.folder, self.folder / "none" / "plan.json", "/proc/plan.json"]:
            with self.subTest(target=target):
                answer = orasp("solve", "hubble", "-o", str(target))
                self.check_sentence(answer)
                self.assertIn(str(target), answer.error)
        self.assertEqual(os.listdir(self.folder), ["old.json"])

    @unittest.skipIf(os.geteuid() == 0, "root may write anywhere")
    def test_a_folder_that_may_not_be_written(self):
        os.chmod(self.folder, 0o555)
        self.addCleanup(os.chmod, self.folder, 0o755)
        self.check_sentence(orasp("solve", "hubble", "-o", str(self.folder / "plan.json")))

    def test_standard_output_that_cannot_be_written_is_reported(self):
        for arguments in (["solve", "hubble"], ["--help"], ["--version"], ["solve", "--help"], ["graph", "2x3", "--json"],
                          ["scenarios"], ["completion", "bash"]):
            with self.subTest(arguments=arguments):
                with open("/dev/full", "wb") as full:
                    done = subprocess.run([PROGRAM, *arguments], stdout=full, stderr=subprocess.PIPE, text=True)
                self.assertEqual(done.returncode, 30)
                self.assertRegex(done.stderr, r"\Aorasp: cannot write to standard output: No space left on device\n\Z")
        done = subprocess.run(["bash", "-c", '"$0" solve hubble >&-', PROGRAM], stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 30)
        self.assertIn("cannot write to standard output", done.stderr)

    def test_a_closed_output_is_not_mistaken_for_a_file(self):
        path = self.folder / "plan.json"
        subprocess.run(["bash", "-c", '"$0" solve jwst --method greedy -o "$1" <&- >&- 2>&-', PROGRAM, path], check=False)
        self.assertEqual(json.loads(path.read_text())["format"], "orasp-plan/1")

    @smoke
    def test_a_reader_that_goes_away_is_no_error(self):
        reader, writer = os.pipe()
        os.close(reader)
        done = subprocess.run([PROGRAM, "solve", "hubble"], stdout=writer, stderr=subprocess.PIPE, text=True)
        os.close(writer)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        done = subprocess.run(["bash", "-o", "pipefail", "-c", '"$0" graph chain:12 --dot - | head -1', PROGRAM],
                              capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "digraph H {\n", ""))


if __name__ == "__main__":
    unittest.main()
