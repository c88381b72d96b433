"""What the tests of the command line share: the program, a class of tests, small problems.

Each file of this folder is run on its own, tests/cli/NAME_test.py PROGRAM [unittest's arguments]; this one is only
imported by them. A test marked @smoke is also run under the address sanitizer, and one marked @threads under the
thread sanitizer (smoke_test.py).
"""
import json
import os
import re
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
    sys.exit(f"{sys.argv[0]}: the program to test comes first, as in build/release/orasp")

ROOT = Path(__file__).resolve().parent.parent.parent
PROGRAM = str(Path(sys.argv.pop(1)).resolve())
# A search that no machine finishes: ORASP Search on 31 connections without constraints.
ENDLESS = ["solve", "iss", "--method", "orasp-search", "--bound", "none"]


class Answer:
    def __init__(self, code, out, error):
        self.code, self.out, self.error = code, out, error


def orasp(*arguments, stdin="", environment=None, **options):
    """Runs the program; `stdin` is text or bytes."""
    data = stdin if isinstance(stdin, bytes) else stdin.encode()
    done = subprocess.run([PROGRAM, *arguments], input=data, capture_output=True, timeout=300,
                          env=None if environment is None else dict(os.environ, **environment), **options)
    return Answer(done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace"))


def time_used(process):
    """Seconds of processor time; 0 where the process is over."""
    try:
        fields = Path("/proc", str(process), "stat").read_text().rsplit(")", 1)[1].split()
    except OSError:
        return 0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def wait_until(is_so, within=60):
    """Waits until is_so() is true, and returns that; fails after `within` seconds."""
    end = time.monotonic() + within
    while not (answer := is_so()):
        if time.monotonic() > end:
            raise AssertionError(f"not so after {within} s: {is_so.__doc__ or is_so}")
        time.sleep(0.01)
    return answer


def wait_for_work(process, seconds):
    """Waits until a process that was started has worked for so many seconds, however busy the machine is, or is over.
    """
    wait_until(lambda: process.poll() is not None or time_used(process.pid) >= seconds)


def assembly(connections, **more):
    """A problem file of parts "1", "2", ... joined by pairs such as "1-2"."""
    pairs = [connection.split("-") for connection in connections]
    parts = sorted({part for pair in pairs for part in pair}, key=int)
    return json.dumps({"format": "orasp-problem/1", "name": "test", "parts": [{"id": part} for part in parts],
                       "connections": [{"parts": pair} for pair in pairs], **more})


def commands():
    block = orasp("--help").out.split("\nCommands:\n", 1)[1].split("\n\n", 1)[0]
    return re.findall(r"^  (\S+)", block, re.MULTILINE)


def options_of(command):
    listing = orasp(command, "--help").out
    return sorted(set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", listing)))


def methods():
    block = orasp("solve", "--help").out.split("\nMethods:\n", 1)[1].split("\n\n", 1)[0]
    return re.findall(r"^  (\S+)", block, re.MULTILINE)


CHAIN = assembly(["1-2", "2-3", "3-4"])
CYCLE = assembly(["1-2", "2-3"], precedence=[{"connection": "1-2", "after": ["2-3"]},
                                             {"connection": "2-3", "after": ["1-2"]}])


class Case(unittest.TestCase):
    maxDiff = None

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def not_beyond(self, process):
        """The process, which ends with the test, also where that fails before it has ended."""
        def end():
            if process.poll() is not None:
                return
            process.terminate()  # mpirun then ends its ranks
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.addCleanup(end)
        return process

    def file(self, name, content):
        path = self.folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return str(path)

    def check(self, answer, code, *, out=r"\A", error=r"\A"):
        """`out` and `error` are expressions that must be found."""
        self.assertEqual(answer.code, code, answer.out + answer.error)
        self.assertRegex(answer.out, out)
        self.assertRegex(answer.error, error)

    def check_sentence(self, answer, code=30):
        """An error is one line on standard error and nothing else."""
        self.assertEqual(answer.code, code, answer.out + answer.error)
        self.assertEqual(answer.out, "")
        self.assertRegex(answer.error, r"\Aorasp: [^\n]+\n\Z")
        self.assertNotIn("internal error", answer.error)


def smoke(test):
    """Marks a test that is to run under the address sanitizer too."""
    test.smoke = True
    return test


def threads(test):
    """Marks a test that is to run under the thread sanitizer too."""
    test.threads = True
    return test
