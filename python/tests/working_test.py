"""What happens while the library works: Ctrl-C, progress, other threads, limits."""
import os
import signal
import subprocess
import sys
import threading
import time
import unittest

import orasp

# A search that no machine finishes; the limit is for where a test fails.
ENDLESS = dict(method="orasp-search", bound="none", time_limit=30)


def slow(steps):
    time.sleep(0.1)
    return -steps.before


def interrupt_after(seconds):
    timer = threading.Timer(seconds, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    return timer


def setUpModule():
    # A shell without job control leaves SIGINT ignored in what it starts in the background.
    signal.signal(signal.SIGINT, signal.default_int_handler)


class Stopping(unittest.TestCase):
    def test_ctrl_c_gives_the_best_plan_so_far(self):
        began = time.perf_counter()
        timer = interrupt_after(0.5)
        result = orasp.solve("iss", **ENDLESS)
        taken = time.perf_counter() - began - 0.5
        timer.join()
        self.assertEqual(result.stopped, "interrupted")
        self.assertEqual(result.status, "feasible")
        self.assertTrue(orasp.evaluate("iss", result).valid)
        self.assertLess(taken, 0.2 + 0.3 * (os.getloadavg()[0] > 2))

    def test_ctrl_c_raises_where_there_is_no_answer(self):
        timer = interrupt_after(0.3)
        with self.assertRaises(KeyboardInterrupt):
            orasp.graph("hubble-free", objective=orasp.Reward(slow, vectorized=True), time_limit=30)
        timer.join()

    def test_ctrl_c_stops_integer_programs(self):
        """CBC takes SIGINT for itself; it is taken back, also for the time after."""
        if orasp.obstacle("table-hemnes", "mip") is not None:
            self.skipTest("CBC is not there")
        timer = interrupt_after(1.0)
        began = time.perf_counter()
        result = orasp.solve("table-hemnes", "mip", time_limit=30)
        timer.join()
        self.assertEqual(result.stopped, "interrupted")
        self.assertLess(time.perf_counter() - began, 10)
        with self.assertRaises(KeyboardInterrupt):
            interrupt_after(0.1)
            time.sleep(5)

    def test_ctrl_c_never_makes_an_integer_program_look_solved(self):
        """A linear program that is ended looks infeasible, and the plan at hand proved best."""
        if orasp.obstacle("table-hemnes", "mip") is not None:
            self.skipTest("CBC is not there")
        best = orasp.solve("table-hemnes").reward
        for moment in (0.1, 0.3, 0.6, 0.7, 1.5, 1.6):
            timer = interrupt_after(moment)
            result = orasp.solve("table-hemnes", "mip", time_limit=30)
            timer.join()
            if result.status == "optimal":
                self.assertAlmostEqual(result.reward, best)
            else:
                self.assertEqual(result.stopped, "interrupted")

    def test_ctrl_c_does_not_wait_for_a_slow_reward(self):
        """H is built thousands of states at a time, which a function of one step makes a matter of seconds."""
        def dawdle(step):
            time.sleep(0.0002)
            return -1.0

        timer = interrupt_after(0.3)
        began = time.perf_counter()
        with self.assertRaises(KeyboardInterrupt):
            orasp.graph("hubble-free", objective=dawdle, time_limit=30)
        self.assertLess(time.perf_counter() - began - 0.3, 0.5)
        timer.join()

    def test_ctrl_c_stops_work_in_another_thread(self):
        """As a program would see it: the main thread gets KeyboardInterrupt, and the work in the other thread ends."""
        program = """
import signal, threading, orasp
signal.signal(signal.SIGINT, signal.default_int_handler)
results = []
ended = threading.Event()
def work():
    results.append(orasp.solve("iss", method="orasp-search", bound="none", time_limit=30))
    ended.set()
threading.Thread(target=work).start()
print("ready", flush=True)
try:
    ended.wait()
except KeyboardInterrupt:
    print(ended.wait(5), results[0].stopped, results[0].status)
"""
        done = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
        self.assertEqual(done.stdout.readline(), "ready\n")
        time.sleep(0.5)
        done.send_signal(signal.SIGINT)
        out, _ = done.communicate(timeout=60)
        self.assertEqual(out, "True interrupted feasible\n")

    def test_python_may_end_meanwhile(self):
        """A thread that nobody waits for solves while the program ends: it ends at once, without a word."""
        program = """
import threading, time, orasp
threading.Thread(target=lambda: orasp.solve("iss", method="orasp-search", bound="none", time_limit=30), daemon=True).start()
time.sleep(0.3)
"""
        began = time.perf_counter()
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))
        self.assertLess(time.perf_counter() - began, 10)

    def test_a_handler_of_the_program_decides(self):
        """Where SIGINT has another handler that raises nothing, the work goes on."""
        heard = []
        before = signal.signal(signal.SIGINT, lambda number, frame: heard.append(number))
        try:
            timer = interrupt_after(0.2)
            result = orasp.solve("iss", **(ENDLESS | {"time_limit": 0.8}))
            timer.join()
        finally:
            signal.signal(signal.SIGINT, before)
        self.assertEqual((heard, result.stopped), ([signal.SIGINT], "time limit"))

    def test_stop(self):
        stop = threading.Event()
        threading.Timer(0.3, stop.set).start()
        self.assertEqual(orasp.solve("iss", stop=stop, **ENDLESS).stopped, "interrupted")

    def test_limits(self):
        self.assertEqual(orasp.solve("iss", **(ENDLESS | {"time_limit": 0.2})).stopped, "time limit")
        self.assertEqual(orasp.solve("iss", memory_limit=1, **ENDLESS).stopped, "memory limit")


class Progress(unittest.TestCase):
    def test_is_told_in_the_callers_thread(self):
        told, threads = [], set()

        def tell(progress):
            told.append(progress)
            threads.add(threading.get_ident())

        orasp.solve("iss", progress=tell, **(ENDLESS | {"time_limit": 0.5}))
        self.assertGreater(len(told), 3)
        self.assertEqual(threads, {threading.get_ident()})
        self.assertTrue(all(isinstance(one, orasp.Progress) and one.phase for one in told))
        self.assertGreater(told[-1].states, 0)

    def test_what_it_raises_comes_out(self):
        class Enough(Exception):
            pass

        def tell(progress):
            raise Enough("that will do")

        began = time.perf_counter()
        with self.assertRaisesRegex(Enough, "that will do"):
            orasp.solve("iss", progress=tell, **ENDLESS)
        self.assertLess(time.perf_counter() - began, 5)


class Threads(unittest.TestCase):
    def test_python_runs_meanwhile(self):
        """A thread of Python counts while another one solves."""
        counted, finished = [0], threading.Event()

        def count():
            while not finished.is_set():
                counted[0] += 1

        counter = threading.Thread(target=count)
        counter.start()
        before = counted[0]
        orasp.solve("iss", threads=1, **(ENDLESS | {"time_limit": 0.5}))
        finished.set()
        counter.join()
        self.assertGreater(counted[0] - before, 10_000)

    def test_two_at_once(self):
        """Two threads solve side by side: both get their answers, in the time of the longer one."""
        results = {}

        def work(name):
            results[name] = orasp.solve("iss", threads=1, seed=name, **(ENDLESS | {"time_limit": 1.0}))

        threads = [threading.Thread(target=work, args=(i,)) for i in range(2)]
        began = time.perf_counter()
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertLess(time.perf_counter() - began, 1.7)
        self.assertEqual([results[i].stopped for i in range(2)], ["time limit"] * 2)

    def test_many_at_once_agree(self):
        names = ["hubble", "lattice", "2x3", "4piece"] * 4
        expected = {name: orasp.solve(name).reward for name in names}
        found = []
        threads = [threading.Thread(target=lambda n=name: found.append((n, orasp.solve(n).reward))) for name in names]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(found), len(names))
        self.assertTrue(all(expected[name] == reward for name, reward in found))


if __name__ == "__main__":
    unittest.main()
