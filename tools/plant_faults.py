#!/usr/bin/env python3
"""Plants faults in a copy of the tree, one at a time, and says which test catches each.

    tools/plant_faults.py              all of them; the copy and its builds stay in build/faults
    tools/plant_faults.py NAME...      some of them
    tools/plant_faults.py --list       their names
    tools/plant_faults.py --check      only whether each still finds its place in the sources

A check that has never failed proves little. Each fault here is one that a hurried change could bring in, and names the
build and the tests that must notice it. Where a fault's place is found by a piece of text, that text must occur exactly
once in all of src/ and cli/, so that moving code from file to file does not matter; where it occurs no more, the fault
is to be planted elsewhere, not dropped.
"""
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
COPY = ROOT / "build/faults/tree"


@dataclass
class Fault:
    name: str
    search: str
    replace: str
    preset: str
    tests: list  # a filter of GoogleTest, or a script and its arguments


FAULTS = [
    Fault("threads that nobody waits for",
          "guarded(0);", "guarded(0);\n    for (std::jthread& other : others) other.detach();",
          "tsan", ["StateGraph*:Dense*"]),
    Fault("two threads that share an element",
          "changes[t] = bellman_update(", "changes[0] = bellman_update(",
          "tsan", ["*ThreadsDoNotChangeTheAnswer*"]),
    Fault("an array that grows one element too late",
          "if (size_ == capacity_) reserve(", "if (size_ == capacity_ + (capacity_ == 0 ? 0 : 1)) reserve(",
          "asan", ["StateTable*"]),
    Fault("memory that is freed twice",
          "static_cast<void>(data_.release());", "",
          "asan", ["StateTable*"]),
    Fault("a shift by all 64 bits",
          "return size == 0 ? 0 : ~std::uint64_t{0} >>", "return ~std::uint64_t{0} >>",
          "asan", ["SubsetRank*:*Dense*"]),
    Fault("prices that are raised beyond what is known",
          "double room = left_beyond_ - raise.sum_;", "double room = left_beyond_;",
          "release", ["RaisedPrices.*"]),
    Fault("a price that is raised although a condition holds it down",
          "if (left >= room) continue;", "if (left >= room || r % 7 == 3) continue;",
          "release", ["RaisedPrices.*"]),
    Fault("a side that waits for its last step in no room",
          "- (completes != 0 ? 0 : 1);", "- 1;",
          "release", ["AndOr.FindsTheBestPlanWhereConnectionsDiffer"]),
    Fault("a last step that is a cut of the core alone",
          "std::min(least + loss_off_core_[parts], look_at_cores(cores_[1]))", "look_at_cores(cores_[1])",
          "release", ["AndOr.FindsTheBestPlanWhereConnectionsDiffer"]),
    Fault("a tree that saves less than it does where parts count as one",
          "if (node != kNone) sum += nodes_[node].cost;",
          "if (node != kNone && nodes_[node].above != kNone) sum += nodes_[node].cost;",
          "release", ["AndOr.FindsTheBestPlanWhereConnectionsDiffer"]),
    Fault("gains that are repeated as if they were losses",
          "shared > 0 ? shared - gain : gain - shared;", "gain - shared;",
          "release", ["AndOr.FindsTheBestPlanWhereConnectionsDiffer"]),
    Fault("a bound that forgets the reward for completing",
          "return completes_later(left) ? sum + last_surplus_ : sum;", "return sum;",
          "release", ["*Agreement.ConnectionBound*"]),
    Fault("a precedence that is lost on every eighth connection",
          "if ((mine[w] & (there_without(open, c, w) | self)) != 0) return false;",
          "if ((mine[w] & (there_without(open, c, w) | self)) != 0 && c % 8 != 7) return false;",
          "release", ["*Agreement.StateGraph*:TransitionSystem*"]),
    Fault("a symmetry that does not look at the directions of blocking",
          "join(here, vertex_of_direction.at(d.value()));", "join(here, vertex_of_direction.begin()->second);",
          "release", ["Symmetry.*"]),
    Fault("a symmetry that does not look at the directions of blocking where there are many",
          'vertex("blocked " + std::min(here, there))', 'vertex("blocked")',
          "release", ["Symmetry.*"]),
    Fault("a symmetry that does not look at what is still to be handled",
          "key.number(system_.start().contains(c) ? 1 : system_.kept().contains(c) ? 2 : 0);", "",
          "release", ["Symmetry.*"]),
    Fault("a symmetry that does not look at which connection must come first",
          'join(subject, of(connection));', "",
          "release", ["Symmetry.*"]),
    Fault("blocks that are sorted before what is inside of them",
          "plan.steps.push_back(std::move(sort));", "plan.steps.insert(plan.steps.begin(), std::move(sort));",
          "release", ["OrbitForm*"]),
    Fault("a reward that takes the kept side for the moved one",
          "const double moved_parts = movement.moved_parts;",
          "const double moved_parts = movement.kept_parts;",
          "release", ["*Agreement.ValuesOfEveryState*:TransitionSystem*"]),
    Fault("a way that is bounded too low",
          "return 0.0 - way.cost * length_of_way(way, from);",
          "return 0.0 - 1.05 * way.cost * length_of_way(way, from);",
          "release", ["*WideAgreement*"]),
    Fault("companions that need not leave together",
          "for (std::size_t w = 0; w < words; ++w) always[w] &= set[w];",
          "for (std::size_t w = 0; w < words; ++w) always[w] = set[w];",
          "release", ["CompanionBound*"]),
    Fault("a plan cut anew that forgets what one side loses",
          "const double below = groups[side].loss + groups[rest].loss;",
          "const double below = groups[rest].loss;",
          "release", ["AndOr.CutsAPlanAnew*"]),
    Fault("a piece that may lose what its last way leaves it, not its best",
          "left_[side] = std::max(left_[side], left + loss_[side]);", "left_[side] = left + loss_[side];",
          "release", ["AndOr.FindsTheBestPlanBySweeps"]),
    Fault("a layer that a run had to leave and that is not looked at again",
          "layers_[parts] = reached;", "static_cast<void>(reached);",
          "release", ["AndOr.FindsTheBestPlanBySweeps"]),
    Fault("a piece taken for solved while another cut may lose less",
          "best <= left || best <= next + slack(scale_)", "best < kInfinity",
          "release", ["AndOr.FindsTheBestPlanBySweeps"]),
    Fault("a step before that is forgotten",
          "if (matters) word += value * layout.stride[i];",
          "if (matters && i % 2 == 1) word += value * layout.stride[i];",
          "release", ["*WideAgreement*"]),
    Fault("a replanner that forgets what is inaccessible",
          "return !now.inaccessible.contains(c) && !(first", "return !(first",
          "release", ["*InTheMiddle*:Replanner*"]),
    Fault("a step of a fleet that cuts nothing",
          "if (motions[i] != motions[j]) step.cut.push_back(c);", "if (motions[i] > motions[j]) step.cut.push_back(c);",
          "release", ["Fleet*"]),
    Fault("a temporary file that stays behind",
          "if (error == 0) return true;\n", "if (error == 0 && ::link(target.c_str(), temporary.c_str()) == 0) return true;\n",
          "release", ["WriteFile*"]),
    Fault("a signal that stops nothing",
          "  stop.request_stop();\n  if (isatty(", "  static_cast<void>(stop.stop_requested());\n  if (isatty(",
          "release", ["tests/cli/stopping_test.py", "Stopping.test_ctrl_c_prints_the_best_plan_so_far"]),
]


def sources(root):
    return [file for folder in ("src", "cli") for ending in ("h", "cpp") for file in sorted((root / folder).rglob(f"*.{ending}"))]


def place_of(fault, root):
    """The one file that holds the text of a fault, or what is wrong with it."""
    found = [(file, count) for file in sources(root) if (count := file.read_text(encoding="utf-8").count(fault.search))]
    times = sum(count for _, count in found)
    if times != 1:
        where = ", ".join(str(file.relative_to(root)) for file, _ in found) or "nowhere"
        return None, f"its place is gone: \"{fault.search}\" stands {times} times ({where}), and once is needed"
    return found[0][0], None


def copy_tree():
    """Brings the copy up to date; files that are as they were keep their times, so that little is built anew."""
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT,
                            capture_output=True, check=True).stdout.decode().split("\0")
    names = {name for name in listed if name and (ROOT / name).is_file()}
    for name in names:
        here, there = ROOT / name, COPY / name
        if there.exists() and there.read_bytes() == here.read_bytes():
            continue
        there.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(here, there)
    for file in sources(COPY):
        if file.relative_to(COPY).as_posix() not in names:
            file.unlink()


def build(preset):
    if not (COPY / "build" / preset / "build.ninja").exists():
        subprocess.run(["cmake", "--preset", preset], cwd=COPY, check=True, capture_output=True)
    done = subprocess.run(["cmake", "--build", "--preset", preset, "--target", "orasp_tests"], cwd=COPY,
                          capture_output=True, text=True)
    return done.stdout + done.stderr if done.returncode != 0 else None


def run_tests(fault):
    """What caught it: the name of a test and why, or nothing."""
    presets = json.loads((COPY / "CMakePresets.json").read_text(encoding="utf-8"))["testPresets"]
    settings = next(preset.get("environment", {}) for preset in presets if preset["name"] == fault.preset)
    folder = COPY / "build" / fault.preset
    steady = ["setarch", "-R"] if subprocess.run(["setarch", "-R", "true"], capture_output=True).returncode == 0 else []
    if fault.tests[0].endswith(".py"):
        command = [sys.executable, COPY / fault.tests[0], folder / "orasp", *fault.tests[1:]]
    else:
        command = [folder / "tests/orasp_tests", f"--gtest_filter={fault.tests[0]}", "--gtest_fail_fast"]
    try:
        done = subprocess.run([*steady, *command], env=dict(os.environ, **settings), capture_output=True, text=True,
                              errors="replace", timeout=900)
    except subprocess.TimeoutExpired:
        return f"{fault.tests[-1]} (no end)"
    if done.returncode == 0:
        return None
    text = done.stdout + done.stderr
    names = (re.findall(r"^\[  FAILED  \] ([\w/.]+)", text, re.MULTILINE) or
             re.findall(r"^\[ RUN      \] ([\w/.]+)", text, re.MULTILINE)[-1:] or
             re.findall(r"^(?:FAIL|ERROR): (\w+)", text, re.MULTILINE) or ["a run that did not begin"])
    reason = re.search(r"(?:ERROR|WARNING): (\w+Sanitizer: [\w -]+?)(?: on| \(|$)|runtime error: (.*)", text, re.MULTILINE)
    return names[0] + (f" ({reason[1] or reason[2]})" if reason else "")


def main():
    words = sys.argv[1:]
    known = {fault.name: fault for fault in FAULTS}
    if words == ["--list"]:
        print("\n".join(known))
        return
    if words == ["--check"]:
        wrong = [f"{fault.name}: {why}" for fault in FAULTS if (why := place_of(fault, ROOT)[1])]
        sys.exit("\n".join(wrong) or None)
    if unknown := [word for word in words if word not in known]:
        sys.exit(f"no fault \"{unknown[0]}\"; --list names them\n\n{__doc__}")
    chosen = [known[word] for word in words] or FAULTS

    copy_tree()
    missed = 0
    for preset in sorted({fault.preset for fault in chosen}):
        if errors := build(preset):
            sys.exit(f"{preset}: the tree does not build without a fault\n{errors[-4000:]}")
        of_preset = [fault for fault in chosen if fault.preset == preset]
        # Before anything is planted: what is built later holds a fault until the next one is.
        before = {fault.name: run_tests(fault) for fault in of_preset}
        for fault in of_preset:
            file, why = place_of(fault, COPY)
            if not why and before[fault.name]:
                why = f"its tests fail without it: {before[fault.name]}"
            if not why:
                good = file.read_text(encoding="utf-8")
                file.write_text(good.replace(fault.search, fault.replace), encoding="utf-8")
                try:
                    errors = build(preset)
                    caught = None if errors else run_tests(fault)
                finally:
                    file.write_text(good, encoding="utf-8")
                why = f"it does not compile\n{errors[-2000:]}" if errors else None
            if why:
                print(f"{fault.name}: NOT PLANTED, {why}", flush=True)
            else:
                print(f"{fault.name} ({preset}): {'caught by ' + caught if caught else 'MISSED'}", flush=True)
            missed += bool(why) or not caught
    sys.exit(f"{missed} of {len(chosen)} were not caught" if missed else None)


if __name__ == "__main__":
    main()
