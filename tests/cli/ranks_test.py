#!/usr/bin/env python3
"""Tests the program on several processes that mpirun starts; skips where there is no mpirun or no module with MPI.

    tests/cli/ranks_test.py PROGRAM [unittest's arguments]
"""
import json
import os
import shutil
import signal
import subprocess
import time
import unittest
from pathlib import Path
from random import Random

from program import PROGRAM, Case, orasp, time_used, wait_until

MPIRUN = shutil.which("mpirun")
MODULE = Path(PROGRAM).parent / "orasp_mpi.so"
# More ranks than cores, as root, on a machine that does other things.
ENVIRONMENT = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_mpi_yield_when_idle="1",
                   OMPI_MCA_hwloc_base_binding_policy="none")
MPMD = ":"


# How many seconds mpirun leaves its ranks between SIGTERM and SIGKILL: enough for a machine that does other things.
PATIENT = {"OMPI_MCA_odls_base_sigkill_timeout": "5"}


def start(count, *arguments, **environment):
    """Starts `count` ranks; where the arguments hold ":", the ranks after it have others."""
    words = [MPIRUN, "-n", str(count), PROGRAM]
    for argument in arguments:
        words += [MPMD, "-n", "1", PROGRAM] if argument == MPMD else [argument]
    return subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                            env=dict(ENVIRONMENT, **environment))


def on_ranks(count, *arguments, stdin=""):
    process = start(count, *arguments)
    out, error = process.communicate(stdin, timeout=120)
    return process.returncode, out, error


def children_of(process):
    return subprocess.run(["pgrep", "-P", str(process)], capture_output=True, text=True, check=False).stdout.split()


def wait_for_ranks(process, count, seconds):
    """Waits until so many ranks are there and each has worked for so many seconds; returns their processes."""
    def all_work():
        ranks = children_of(process.pid)
        return process.poll() is not None or (len(ranks) == count and min(map(time_used, ranks)) >= seconds) and ranks
    return wait_until(all_work)


def workers_of(process):
    """The processes in which the ranks of `compare` do their work."""
    return [worker for rank in children_of(process.pid) for waiting in children_of(rank) for worker in children_of(waiting)]


def answer(text):
    plan = json.loads(text)
    return {key: plan.get(key) for key in ("status", "reward", "bound", "steps", "disassembly", "problem_digest")}


@unittest.skipUnless(MPIRUN and MODULE.exists(), "no mpirun, or no module with MPI")
class Ranks(Case):
    def test_any_number_of_ranks_gives_the_plan_of_one_process(self):
        tree = orasp("scenarios", "tree:20:1").out
        for problem, text in (("hubble", ""), ("-", tree)):
            for direction in ("disassembly", "assembly"):
                words = ["solve", problem, "--direction", direction, "--method", "value-iteration", "--json"]
                expected = answer(orasp(*words, stdin=text).out)
                for count in (2, 3) if direction == "assembly" else (4, 8):
                    with self.subTest(problem=problem, direction=direction, ranks=count):
                        code, out, error = on_ranks(count, *words, stdin=text)
                        self.assertEqual(code, 0, error)
                        self.assertEqual(answer(out), expected)

    def test_beam_gives_the_plan_of_one_process(self):
        fuel = ["--objective", "fuel", "--bound", "connections"]
        for words, counts in ((["hubble", "--direction", "assembly"], (3,)), (["hubble-free", "--objective", "indexed"], (2,)),
                              (["jwst", "--objective", "time", "--memory-limit", "900"], (4,)),
                              # Here symmetry is used by itself, after a while.
                              (["hubble-free", *fuel], (2, 3)), (["lattice", *fuel, "--symmetry", "on"], (8,))):
            words = ["solve", *words, "--method", "beam", "--json"]
            one = orasp(*words).out
            for count in counts:
                with self.subTest(words=words, ranks=count):
                    code, out, error = on_ranks(count, *words)
                    self.assertEqual(code, 0, error)
                    self.assertEqual(answer(out), answer(one))
                    exchanges = [note for note in json.loads(one).get("notes", []) if "exchange" in note]
                    self.assertEqual([note for note in json.loads(out)["notes"] if "exchange" in note], exchanges)

    def test_a_star_proves_the_optimum_of_one_process(self):
        for words in (["hubble", "--direction", "assembly"], ["hubble-free", "--objective", "fuel", "--bound", "connections"]):
            words = ["solve", *words, "--method", "a-star", "--json"]
            one = orasp(*words)
            for count in (3,):
                with self.subTest(words=words, ranks=count):
                    code, out, error = on_ranks(count, *words)
                    self.assertEqual(code, one.code, error)
                    if code != 0:
                        continue
                    plan, expected = json.loads(out), json.loads(one.out)
                    self.assertEqual((plan["status"], expected["status"]), ("optimal", "optimal"))
                    self.assertAlmostEqual(plan["reward"], expected["reward"], 9)
                    self.assertAlmostEqual(plan["bound"], expected["bound"], 9)

    def test_limits_stop_a_beam_on_ranks(self):
        words = ["solve", "iss", "--objective", "fuel", "--bound", "connections", "--method", "beam", "--json"]
        for limit, stopped in ((["--time-limit", "1"], "time limit"), (["--memory-limit", "1"], "memory limit")):
            with self.subTest(limit=limit):
                code, out, error = on_ranks(3, *words, *limit)
                self.assertEqual(code, 20, error)
                plan = json.loads(out)
                self.assertEqual((plan["status"], plan["stopped"]), ("feasible", stopped))
                self.assertGreaterEqual(plan["bound"], plan["reward"])
                self.assertLessEqual(plan["statistics"]["peak_bytes"], 1 << 20 if stopped == "memory limit" else 1 << 40)

    def test_a_stopped_a_star_has_a_proved_bound(self):
        words = ["solve", "iss", "--objective", "fuel", "--bound", "connections", "--method", "a-star", "--json", "--time-limit", "1"]
        code, out, error = on_ranks(3, *words)
        self.assertEqual(code, 20, error)
        plan = json.loads(out)
        self.assertEqual((plan["status"], plan["stopped"]), ("feasible", "time limit"))
        self.assertGreaterEqual(plan["bound"], plan["reward"])

    def test_the_plan_is_printed_once_and_written(self):
        file = self.folder / "plan.json"
        code, out, _ = on_ranks(3, "solve", "lattice", "--method", "value-iteration", "-o", str(file))
        self.assertEqual(code, 0)
        self.assertEqual(out.count("optimal (proved)"), 1)
        self.assertNotIn("\x1b", out)
        self.assertRegex(out, r"the table lay on 3 ranks, with \d+ bytes on the fullest; \d+ bytes of values were sent")
        self.assertEqual(json.loads(file.read_text())["status"], "optimal")

    def test_no_plan_and_limits_have_their_exit_codes(self):
        code, out, _ = on_ranks(2, "solve", "hubble", "--max-moved-parts", "0", "--method", "value-iteration")
        self.assertEqual(code, 10, out)
        tree = orasp("scenarios", "tree:30:1").out
        code, out, _ = on_ranks(2, "solve", "-", "--method", "value-iteration", "--time-limit", "0.3", stdin=tree)
        self.assertEqual(code, 20, out)
        self.assertIn("feasible (stopped by the time limit; not proved best)", out)
        code, _, error = on_ranks(2, "solve", "-", "--method", "value-iteration", "--memory-limit", "9", stdin=tree)
        self.assertEqual(code, 30)
        self.assertRegex(error, r"orasp: value-iteration: rank 0 on \S+ needs \d+ MiB for its share of the table, and 9 MiB are")

    def test_faults_are_said_once(self):
        work = ["--method", "value-iteration"]
        for words, sentence in (
                (["solve", "nowhere.json", *work], "nowhere.json: No such file or directory"),
                (["solve", "hubble", *work, MPMD, "solve", "hubble", *work, "--seed", "2"], "all ranks must run the same"),
                (["solve", "hubble"], "auto does its work in one process"),
                (["solve", "hubble", *work, "--threads", "2"], "--threads: several processes do not share that"),
                (["solve", "hubble", "--method", "a-star", "--symmetry", "on"], "--symmetry on: several processes do not share that"),
                (["check", "hubble", "x"], "check does its work in one process: start it without mpirun"),
                (["solve", "hubble", "--nonsense"], 'unknown option "--nonsense"')):
            with self.subTest(words=words):
                code, out, error = on_ranks(2, *words)
                self.assertEqual((code, out), (30, ""), error)
                self.assertEqual(error.count("orasp: "), 1, error)
                self.assertIn(sentence, error)

    def test_a_missing_module_is_said_once_with_what_to_install(self):
        alone = shutil.copy(PROGRAM, self.folder / "orasp")
        done = subprocess.run([MPIRUN, "-n", "2", alone, "solve", "hubble", "--method", "value-iteration"], capture_output=True,
                              text=True, env=ENVIRONMENT, timeout=60, check=False)
        self.assertEqual(done.returncode, 30, done.stderr)
        self.assertEqual(done.stderr.count("install the packages libopenmpi-dev and openmpi-bin"), 1, done.stderr)

    def test_one_process_needs_no_module(self):
        loaded = subprocess.run(["ldd", PROGRAM], capture_output=True, text=True, check=True).stdout
        self.assertNotIn("mpi", loaded)

    def test_compare_shares_the_problems_out_and_prints_one_table_in_order(self):
        def rows(text):
            """All but the times."""
            return [[cell for key, cell in row.items() if key != "seconds"] for row in json.loads(text)["rows"]]

        chain = self.file("chain.json", orasp("scenarios", "tree:9:2").out)
        words = ["compare", "hubble", "3piece", chain, "fleet-lattice", "lattice", "2x3", "--methods",
                 "value-iteration,a-star,greedy,fleet-search", "--objective", "time", "--json"]
        expected = rows(orasp(*words).out)
        for count in (2, 4):
            code, out, error = on_ranks(count, *words)
            self.assertEqual(code, 0, error)
            self.assertEqual(rows(out), expected)
        code, _, error = on_ranks(2, "compare", "hubble", "nowhere.json")
        self.assertEqual((code, error.count("orasp: ")), (30, 1), error)

    def kill_workers(self, process, times):
        """Kills the process that does the long problem, as often as it is begun."""
        killed = 0
        end = time.monotonic() + 60
        while killed < times and time.monotonic() < end:
            for worker in workers_of(process):
                if time_used(worker) >= 0.1:
                    os.kill(int(worker), signal.SIGKILL)
                    killed += 1
            time.sleep(0.02)
        self.assertEqual(killed, times)

    def test_compare_has_what_was_killed_done_again(self):
        for times, status in ((1, "feasible"), (2, "failed")):
            with self.subTest(times=times):
                # Of these only the second takes a while.
                process = self.not_beyond(start(2, "compare", "3piece", "lattice", "2x3", "--methods", "exhaustive", "--csv",
                                                "--time-limit", "1"))
                self.kill_workers(process, times)
                out, error = process.communicate(timeout=60)
                rows = [line.split(",") for line in out.splitlines()[1:]]
                self.assertEqual([row[:3] for row in rows], [["3piece", "exhaustive", "optimal"], ["lattice", "exhaustive", status],
                                                             ["2x3", "exhaustive", "optimal"]], error)
                self.assertEqual(process.returncode, 0 if times == 1 else 40)
                if times == 2:
                    self.assertEqual(rows[1][11], "failed on two ranks: killed by signal 9 (Killed)")
                    self.assertIn("lattice failed on two ranks: killed by signal 9 (Killed)", error)

    def test_the_processes_of_a_killed_rank_end_with_it(self):
        process = self.not_beyond(start(2, "compare", "lattice", "lattice", "--methods", "exhaustive", "--time-limit", "60"))
        workers = wait_until(lambda: len(found := workers_of(process)) >= 2 and found)
        os.kill(int(children_of(process.pid)[1]), signal.SIGKILL)
        process.communicate(timeout=60)
        self.assertNotEqual(process.returncode, 0)
        wait_until(lambda: not any(Path("/proc", worker).exists() for worker in workers), within=10)

    def test_a_stop_of_compare_prints_the_rows_so_far(self):
        process = self.not_beyond(start(2, "compare", "2x3", "lattice", "lattice", "lattice", "--methods", "exhaustive", "--csv",
                                        **PATIENT))
        # The first row takes a moment; then both ranks are at the second and third.
        wait_until(lambda: len(found := workers_of(process)) == 2 and min(map(time_used, found)) >= 0.5)
        process.send_signal(signal.SIGINT)
        out, error = process.communicate(timeout=60)
        self.assertIn("2x3,exhaustive,optimal,", out, error)
        self.assertIn("lattice,exhaustive,feasible,", out)
        self.assertEqual(out.count("problem,method,"), 1)

    def long_run(self, method, **environment):
        """A run that is not over in ten seconds, and its file."""
        file = self.folder / "plan.json"
        if method == "value-iteration":
            words = [self.file("tree.json", orasp("scenarios", "tree:30:1").out)]
        else:
            words = ["iss", "--objective", "fuel", "--bound", "connections", "--memory-limit", "300"]
        return self.not_beyond(start(3, "solve", *words, "--method", method, "-o", str(file), **environment)), file

    def test_a_killed_rank_ends_all_and_leaves_no_half_file(self):
        random = Random(7)
        for method in ("value-iteration", "beam", "a-star"):
            with self.subTest(method=method):
                process, file = self.long_run(method)
                ranks = wait_for_ranks(process, 3, 0.2 + random.random())
                self.assertIsInstance(ranks, list, "the run was over before a rank was killed")
                os.kill(int(random.choice(ranks)), signal.SIGKILL)
                begin = time.monotonic()
                _, error = process.communicate(timeout=60)
                self.assertLess(time.monotonic() - begin, 5)
                self.assertNotEqual(process.returncode, 0)
                self.assertIn("exited on signal 9", error)
                self.assertFalse(file.exists() and not file.read_text().endswith("}\n"))
                self.assertEqual([path.name for path in self.folder.iterdir() if path.name not in ("tree.json", "plan.json")], [])

    def test_a_stop_prints_the_best_plan_once(self):
        for method in ("value-iteration", "beam"):
            with self.subTest(method=method):
                process, file = self.long_run(method, **PATIENT)
                wait_for_ranks(process, 3, 0.5)
                process.send_signal(signal.SIGINT)  # as Ctrl-C: mpirun ends its ranks with SIGTERM
                out, _ = process.communicate(timeout=60)
                self.assertEqual(out.count("feasible (interrupted; not proved best)"), 1)
                self.assertEqual(json.loads(file.read_text())["status"], "feasible")


if __name__ == "__main__":
    unittest.main()
