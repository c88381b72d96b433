#!/usr/bin/env python3
"""Checks that every C++ file is as clang-format 14 writes it, and that no line is longer than 100 characters.

    tests/format_test.py [--self-test]

clang-format breaks no literals and, with our settings, no comments: that is why the length is looked at too. Without
clang-format 14 the lengths alone are checked, and the test counts as skipped.
"""
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ["src", "cli", "python", "tests", "benchmarks", "examples", "fuzz"]
LONGEST = 100
SKIPPED = 77


def files(root):
    for folder in FOLDERS:
        yield from sorted(file for ending in ("h", "cpp") for file in (root / folder).rglob(f"*.{ending}"))


def long_lines(root):
    for file in files(root):
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            if len(line) > LONGEST:
                yield f"{file.relative_to(root)}:{number}: {len(line)} characters, at most {LONGEST} are allowed"


def program():
    for name in ("clang-format-14", "clang-format"):
        path = shutil.which(name)
        if path and " version 14." in subprocess.run([path, "--version"], capture_output=True, text=True).stdout:
            return path
    return None


def badly_formatted(root, clang_format):
    names = [str(file) for file in files(root)]
    done = subprocess.run([clang_format, f"--style=file:{ROOT / '.clang-format'}", "--dry-run", "--Werror", *names],
                          capture_output=True, text=True)
    found = sorted({line.split(":")[0] for line in done.stderr.splitlines() if "-Wclang-format-violations" in line})
    if done.returncode != 0 and not found:
        yield done.stderr.strip()
    for name in found:
        yield f"{Path(name).relative_to(root)}: not as clang-format writes it; clang-format -i {Path(name).relative_to(root)}"


def self_test(clang_format):
    """A file of each fault is found, and a good one is not."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        (root / "src").mkdir()
        (root / "src/good.h").write_text("#pragma once\n\nint f(int a);\n", encoding="utf-8")
        (root / "src/long.h").write_text(f"#pragma once\n\n// {'x' * 98}\n", encoding="utf-8")
        (root / "src/bad.cpp").write_text("int  f( int a ){return a;}\n", encoding="utf-8")
        assert [line.split(":")[0] for line in long_lines(root)] == ["src/long.h"]
        if clang_format:
            assert [line.split(":")[0] for line in badly_formatted(root, clang_format)] == ["src/bad.cpp"]


def main():
    clang_format = program()
    if sys.argv[1:] == ["--self-test"]:
        self_test(clang_format)
        return
    faults = list(long_lines(ROOT))
    if clang_format:
        faults += badly_formatted(ROOT, clang_format)
    if faults:
        sys.exit("\n".join(faults))
    if not clang_format:
        print("clang-format 14 is not there: only the lengths of lines were checked")
        sys.exit(SKIPPED)


if __name__ == "__main__":
    main()
