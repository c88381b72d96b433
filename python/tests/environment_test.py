"""The environments: what Gymnasium's checker asks of one, what the engine says of plans, arrays and errors."""

from __future__ import annotations

import contextlib
import copy
import doctest
import importlib.util
import inspect
import io
import json
import os
import subprocess
import sys
import tempfile
import threading
import unittest
from pathlib import Path
from typing import Any, Callable, Sequence

import numpy as np

import orasp
import orasp.environment
import orasp.spaces

HUBBLE = -0.9902


def program(*arguments: str, text: str = "") -> Any:
    """What the command line answers, as JSON: an opinion beside that of the package."""
    done = subprocess.run([os.environ["ORASP_PROGRAM"], *arguments, "--json"], input=text, capture_output=True, text=True)
    return json.loads(done.stdout)


def best_plan(problem: str) -> list[str]:
    """An optimal plan."""
    connections: list[str] = program("solve", problem)["disassembly"]
    return connections


def evaluated(problem: str, plan: Sequence[str]) -> float:
    """What a plan earns; nothing is wrong with it."""
    found = program("evaluate", problem, "-", text=json.dumps(list(plan)))
    assert found["valid"], found["violations"]
    return float(found["reward"])


def random_episode(environment: orasp.Environment, seed: int) -> tuple[list[str], float, bool]:
    """The plan of a random episode, what it earned, and whether it was ended."""
    _, info = environment.reset(seed=seed)
    random = np.random.default_rng(seed)
    total = 0.0
    while True:
        action = int(random.choice(np.flatnonzero(info["action_mask"])))
        _, reward, terminated, truncated, info = environment.step(action)
        total += reward
        if terminated or truncated:
            return environment.plan, total, terminated


class AsGymnasiumChecks(unittest.TestCase):
    """What gymnasium.utils.env_checker.check_env and the passive checker look at, in their order."""

    def check(self, environment: orasp.Environment) -> None:
        # check_action_space, check_observation_space, check_space_limit
        actions, observations = environment.action_space, environment.observation_space
        self.assertGreater(actions.n, 0)
        self.assertEqual(actions.shape, ())
        self.assertEqual(observations.low.shape, observations.shape)
        self.assertEqual(observations.high.shape, observations.shape)
        self.assertFalse(np.any(observations.high <= observations.low))
        self.assertTrue(np.all(np.isfinite(observations.low)) and np.all(np.isfinite(observations.high)))
        # check_seed_deprecation, check_reset_return_info_deprecation
        self.assertFalse(callable(getattr(environment, "seed", None)))
        signature = inspect.signature(environment.reset)
        self.assertNotIn("return_info", signature.parameters)
        # check_reset_return_type
        result = environment.reset()
        self.assertIsInstance(result, tuple)
        self.assertEqual(len(result), 2)
        self.assertIn(result[0], observations)
        self.assertIsInstance(result[1], dict)
        # check_reset_seed
        self.assertIsNone(signature.parameters["seed"].default)
        first, _ = environment.reset(seed=123)
        self.assertIn(first, observations)
        self.assertIsNotNone(environment.unwrapped._np_random)
        random = copy.deepcopy(environment.unwrapped._np_random)
        second, _ = environment.reset(seed=123)
        self.assertTrue(np.array_equal(first, second))
        self.assertEqual(environment.unwrapped._np_random.bit_generator.state, random.bit_generator.state)
        environment.reset(seed=456)
        self.assertNotEqual(environment.unwrapped._np_random.bit_generator.state, random.bit_generator.state)
        # check_reset_options
        environment.reset(options={})
        # check_step_determinism
        environment.action_space.seed(123)
        action = environment.action_space.sample()
        environment.reset(seed=123)
        one = environment.step(action)
        environment.reset(seed=123)
        again = environment.step(action)
        self.assertTrue(np.array_equal(one[0], again[0]))
        self.assertEqual(one[1:4], again[1:4])
        self.assertTrue(np.array_equal(one[4].pop("action_mask"), again[4].pop("action_mask")))
        self.assertEqual(one[4], again[4])
        # env_reset_passive_checker, env_step_passive_checker
        observation, info = environment.reset()
        self.check_observation(environment, observation)
        stepped = environment.step(environment.action_space.sample())
        self.assertEqual(len(stepped), 5)
        observation, reward, terminated, truncated, info = stepped
        self.check_observation(environment, observation)
        self.assertIsInstance(reward, float)
        self.assertTrue(np.isfinite(reward))
        self.assertIsInstance(terminated, bool)
        self.assertIsInstance(truncated, bool)
        self.assertIsInstance(info, dict)
        # env_render_passive_checker
        self.assertGreater(environment.metadata["render_fps"], 0)
        for mode in environment.metadata["render_modes"]:
            shown = orasp.Environment(environment.problem, render_mode=mode)
            shown.reset()
            frame = shown.render()
            if mode == "rgb_array":
                self.assertIsInstance(frame, np.ndarray)
                self.assertEqual((frame.dtype, frame.ndim, frame.shape[2]), (np.dtype(np.uint8), 3, 3))
            else:
                self.assertIsInstance(frame, str)
            shown.close()
        environment.close()
        environment.close()

    def check_observation(self, environment: orasp.Environment, observation: Any) -> None:
        self.assertIsInstance(observation, np.ndarray)
        self.assertEqual(observation.dtype, environment.observation_space.dtype)
        self.assertIn(observation, environment.observation_space)

    def test_environments(self) -> None:
        for name in ("lattice", "hubble", "jwst", "table-hemnes"):
            for dtype in (np.float32, np.uint8):
                with self.subTest(name=name, dtype=dtype):
                    self.check(orasp.Environment(name, observation_dtype=dtype))


class OneEpisode(unittest.TestCase):
    def test_earns_what_evaluate_says(self) -> None:
        for name in ("lattice", "hubble", "iss", "table-hemnes"):
            environment = orasp.Environment(name)
            for seed in range(10):
                plan, total, ended = random_episode(environment, seed)
                self.assertTrue(ended)
                self.assertAlmostEqual(environment.total, total)
                self.assertAlmostEqual(evaluated(name, plan), total, places=9)

    def test_the_optimal_plan_earns_the_optimum(self) -> None:
        environment = orasp.Environment("hubble")
        environment.reset()
        total = 0.0
        plan = best_plan("hubble")
        for connection in plan:
            _, reward, terminated, _, info = environment.step(environment.action_of(connection))
            total += reward
        self.assertTrue(terminated)
        self.assertAlmostEqual(total, HUBBLE)
        self.assertEqual(info["plan"], plan)

    def test_observations_and_masks_are_the_callers(self) -> None:
        environment = orasp.Environment("lattice")
        observation, info = environment.reset()
        before, mask = observation.copy(), info["action_mask"].copy()
        environment.step(environment.action_space.sample())
        self.assertTrue(np.array_equal(observation, before))
        self.assertTrue(np.array_equal(info["action_mask"], mask))

    def test_draws_legal_actions_by_the_seed(self) -> None:
        def draws(seed: int) -> list[int]:
            environment = orasp.Environment("hubble")
            environment.reset()
            environment.action_space.seed(seed)
            drawn = []
            over = False
            while not over:
                drawn.append(int(environment.action_space.sample()))
                _, _, terminated, truncated, _ = environment.step(drawn[-1])
                over = terminated or truncated
            return drawn

        self.assertEqual(draws(3), draws(3))
        self.assertNotEqual(draws(3), draws(4))

    def test_refuses_what_is_not_legal(self) -> None:
        environment = orasp.Environment("hubble")
        _, info = environment.reset()
        illegal = int(np.flatnonzero(info["action_mask"] == 0)[0])
        name = environment.action_names[illegal]
        with self.assertRaisesRegex(
            orasp.InputError, f'action {illegal}: connection "{name}" cannot be handled now: "{name}" may be removed only after'
        ):
            environment.step(illegal)
        with self.assertRaisesRegex(orasp.InputError, "action 19: there is no action 19; actions are 0 to 18"):
            environment.step(19)
        with self.assertRaisesRegex(orasp.InputError, "action: 0.5 is no whole number"):
            environment.step(0.5)  # type: ignore[arg-type]
        self.assertEqual(environment.plan, [])
        random_episode(environment, 1)
        with self.assertRaisesRegex(orasp.InputError, "the episode is over"):
            environment.step(0)

    def test_refuses_wrong_input(self) -> None:
        cases: list[tuple[Callable[[], Any], str]] = [
            (lambda: orasp.Environment("hubble", render_mode="human"), 'render_mode: "human" is none of'),
            (lambda: orasp.Environment("hubble", observation_dtype=np.int64), "observation_dtype: int64 is none of"),
            (lambda: orasp.Environment("hubble").reset(seed=-1), "seed: -1 is no whole number"),
            (lambda: orasp.Environment("hubble").reset(options={"start": []}), 'options: no "start"; there is done'),
            (lambda: orasp.Environment("hubble").reset(options={"done": ["x"]}), r'done\[0\]: no action "x"'),
            (lambda: orasp.Environment("hubble").reset(options={"done": [0.5]}), r"done\[0\]: 0.5 is no whole number"),
            (lambda: orasp.Environment("hubble").action_of("x"), 'action: no action "x"; action_names lists them'),
            (
                lambda: orasp.VectorEnvironment("hubble", 2).sample_actions(np.zeros(2, np.int32)),
                r"out: an array of int32 \[2\] is given, int64 \[2\] in one piece is needed",
            ),
            (lambda: orasp.VectorEnvironment("hubble", 0), "episodes: 0 is not a number of episodes"),
            (lambda: orasp.VectorEnvironment("hubble", 1, autoreset="never"), 'autoreset: "never" is none of'),
            (lambda: orasp.VectorEnvironment("hubble", 2).step([0]), r"actions: an array of int64 \[1\] is given"),
            (lambda: orasp.VectorEnvironment("hubble", 1).step([0.5]), r"actions: an array of float64 \[1\] is given"),
            (
                lambda: orasp.VectorEnvironment("hubble", 1).reset(options={"reset_mask": np.array([1])}),
                r"reset_mask: an array of int64 \[1\] is given",
            ),
        ]
        for call, message in cases:
            with self.subTest(message=message), self.assertRaisesRegex(orasp.InputError, message):
                call()

    def test_begins_after_steps_that_are_done(self) -> None:
        environment = orasp.Environment("hubble")
        plan = best_plan("hubble")
        observation, _ = environment.reset(options={"done": plan[:17]})
        self.assertEqual(int(observation.sum()), 2)
        self.assertEqual(environment.plan, plan[:17])
        environment.step(environment.action_of(plan[17]))
        *_, info = environment.step(environment.action_of(plan[18]))
        self.assertEqual(info["plan"], plan)
        self.assertEqual(int(environment.reset()[0].sum()), 2)
        self.assertEqual(int(environment.reset(options={"done": []})[0].sum()), 19)

    def test_shows_itself(self) -> None:
        environment = orasp.Environment("lattice", render_mode="ansi")
        environment.reset()
        environment.step(environment.action_of("1-2"))
        text = environment.render()
        self.assertTrue(text.startswith("Lattice: 1 steps, earned 0\nhandled  1-2\nopen     "), text)
        for name in ("hubble", "lattice", "jwst"):
            environment = orasp.Environment(name, render_mode="rgb_array")
            environment.reset()
            before = environment.render()
            environment.step(environment.action_space.sample())
            self.assertFalse(np.array_equal(before, environment.render()))
        self.assertIsNone(orasp.Environment("lattice").render())


class MoreThanConnections(unittest.TestCase):
    """Problems where there is more to states and steps than connections."""

    def setUp(self) -> None:
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def file(self, **keys: Any) -> str:
        problem = {
            "format": "orasp-problem/1",
            "parts": [{"id": part} for part in "abc"],
            "connections": [
                {"parts": ["a", "b"], "attributes": {"tool": "driver"}, "numbers": {"value": 5}},
                {"parts": ["b", "c"], "attributes": {"tool": "pliers"}, "numbers": {"value": -1}},
            ],
            **keys,
        }
        file = Path(self.folder.name) / "problem.json"
        file.write_text(json.dumps(problem), encoding="utf-8")
        return str(file)

    def test_what_the_step_before_left_behind_is_observed(self) -> None:
        environment = orasp.Environment(self.file(objective={"type": "changeover", "attribute": "tool", "cost": 2}))
        observation, _ = environment.reset()
        self.assertEqual(environment.observation_names, ["open a-b", "open b-c", "tool driver", "tool pliers"])
        self.assertEqual(observation.tolist(), [1, 1, 0, 0])
        observation, reward, *_ = environment.step(0)
        self.assertEqual((observation.tolist(), reward), ([0, 1, 1, 0], 0))
        _, reward, terminated, _, _ = environment.step(1)
        self.assertEqual((reward, terminated), (-2, True))

    def test_directions_are_chosen(self) -> None:
        blocking = {"directions": ["+x", "-x"], "blocked": [{"part": "a", "by": "b", "directions": ["+x"]}]}
        change = {"type": "changeover", "attribute": "direction", "cost": 1, "start": "+x"}
        environment = orasp.Environment(self.file(objective=change, blocking=blocking))
        _, info = environment.reset()
        self.assertEqual(environment.action_names, ["a-b", "a-b +x", "a-b -x", "b-c", "b-c +x", "b-c -x"])
        self.assertEqual(info["action_mask"].tolist(), [0, 0, 1, 0, 1, 1])
        with self.assertRaisesRegex(orasp.InputError, 'action 1: .*"a-b" cannot be handled so that .* direction "\\+x"'):
            environment.step(1)
        self.assertEqual(environment.step(environment.action_of("a-b -x"))[1], -1)
        _, reward, terminated, _, _ = environment.step(environment.action_of("b-c -x"))
        self.assertEqual((reward, terminated), (0, True))
        self.assertEqual((environment.plan, environment.directions), (["a-b", "b-c"], ["-x", "-x"]))

    def test_a_plan_may_end_early(self) -> None:
        value = {"type": "expression", "formula": "value"}
        environment = orasp.Environment(self.file(objective=value, goal={"removed": [], "stop": "best"}))
        environment.reset()
        self.assertEqual(environment.action_names, ["a-b", "b-c", "end"])
        self.assertEqual(environment.step(0)[1], 5)
        _, reward, terminated, _, info = environment.step(environment.action_of("end"))
        self.assertEqual((reward, terminated, info["plan"]), (0, True, ["a-b"]))

    def test_steps_that_take_parts_off_are_refused(self) -> None:
        with self.assertRaisesRegex(orasp.InputError, "action: the environment knows steps that take one connection each"):
            orasp.Environment(self.file(action="part"))

    def test_a_dead_end_is_truncated(self) -> None:
        # b lies between c and a, so it cannot leave both; and b-c waits for a-b: a-c first is a dead end.
        file = self.file(
            connections=[{"parts": ["b", "c"]}, {"parts": ["b", "a"]}, {"parts": ["a", "c"]}],
            precedence=[{"connection": "a-c", "after": ["b-a"]}],
            blocking={
                "directions": ["+x", "-x"],
                "blocked": [
                    {"part": "b", "by": "a", "directions": ["+x"]},
                    {"part": "b", "by": "c", "directions": ["-x"]},
                ],
            },
        )
        environment = orasp.Environment(file, render_mode="ansi")
        environment.reset()
        _, _, terminated, truncated, info = environment.step(0)
        self.assertEqual((terminated, truncated, info["action_mask"].tolist()), (False, True, [0, 0, 0]))
        self.assertNotIn("plan", info)
        self.assertIn("a dead end\n", environment.render())
        many = orasp.VectorEnvironment(file, 2)
        many.reset()
        observations, _, terminated_too, truncated_too, info = many.step([0, 1])
        self.assertEqual((terminated_too.tolist(), truncated_too.tolist()), ([False, False], [True, False]))
        self.assertEqual(info["final_obs"][0].tolist(), [0, 1, 1])
        self.assertEqual(observations.tolist(), [[1, 1, 1], [1, 0, 1]])
        self.assertIsNone(many.best_plan)


class RewardsOfYourOwn(unittest.TestCase):
    def test_a_function_of_python_is_earned(self) -> None:
        one = orasp.Reward(lambda step: -step.moved_mass - step.after, name="mine")
        many = orasp.Reward(lambda steps: -steps.moved_mass - steps.after, vectorized=True, name="mine")
        for reward in (one, many):
            problem = orasp.load("hubble").edited(objective=reward)
            environment = orasp.VectorEnvironment(problem, 8)
            environment.reset(seed=1)
            for _ in range(19):
                *_, info = environment.step(environment.sample_actions())
            plan, best = environment.best_plan, environment.best_reward
            assert plan is not None and best is not None
            self.assertAlmostEqual(orasp.evaluate(problem, plan).reward, best)
            self.assertAlmostEqual(float(info["episode"]["r"].max()), best)

    def test_what_it_raises_comes_out_and_nothing_changes(self) -> None:
        broken = True

        def reward(step: Any) -> float:
            if broken and step.after == 17:
                raise KeyError("mine")
            return 1.0

        environment = orasp.Environment(orasp.load("hubble").edited(objective=orasp.Reward(reward)))
        observation, _ = environment.reset()
        with self.assertRaisesRegex(KeyError, "mine"):
            environment.step(environment.action_space.sample())
        self.assertEqual(environment.plan, [])
        broken = False
        self.assertEqual(environment.step(environment.action_space.sample())[1], 1.0)
        self.assertEqual(len(environment.plan), 1)


class ManyEpisodes(unittest.TestCase):
    def test_says_what_one_episode_says(self) -> None:
        many = orasp.VectorEnvironment("hubble", 8)
        single = [orasp.Environment("hubble") for _ in range(8)]
        observations, info = many.reset(seed=5)
        for one in single:
            one.reset()
        for _ in range(60):
            actions = many.sample_actions()
            observations, rewards, terminated, truncated, info = many.step(actions)
            for i, one in enumerate(single):
                observation, reward, ended, stuck, own = one.step(actions[i])
                self.assertEqual((reward, ended, stuck), (rewards[i], terminated[i], truncated[i]))
                if ended:
                    self.assertTrue(info["_final_obs"][i])
                    self.assertTrue(np.array_equal(info["final_obs"][i], observation))
                    self.assertEqual(info["episode"]["r"][i], one.total)
                    self.assertEqual(info["episode"]["l"][i], 19)
                    observation, own = one.reset()
                self.assertTrue(np.array_equal(observations[i], observation))
                self.assertTrue(np.array_equal(info["action_mask"][i], own["action_mask"]))

    def test_shapes_and_types(self) -> None:
        many = orasp.VectorEnvironment("hubble", 3, observation_dtype=np.uint8)
        observations, info = many.reset()
        self.assertEqual((observations.shape, observations.dtype), ((3, 19), np.dtype(np.uint8)))
        self.assertEqual((info["action_mask"].shape, info["action_mask"].dtype), ((3, 19), np.dtype(np.int8)))
        self.assertIn(observations, many.observation_space)
        self.assertIn(observations[0], many.single_observation_space)
        actions = many.action_space.sample()
        self.assertIn(actions, many.action_space)
        self.assertTrue(all(info["action_mask"][i, action] for i, action in enumerate(actions)))
        _, rewards, terminated, truncated, _ = many.step(actions)
        self.assertEqual((rewards.shape, rewards.dtype), ((3,), np.dtype(np.float64)))
        for flags in (terminated, truncated):
            self.assertEqual((flags.shape, flags.dtype), ((3,), np.dtype(np.bool_)))
        self.assertEqual(many.num_envs, 3)

    def test_arrays_are_the_same_and_outlive_the_environment(self) -> None:
        many = orasp.VectorEnvironment("hubble", 4)
        first, info = many.reset(seed=1)
        second, *_ = many.step(many.sample_actions())
        self.assertIs(first, second)
        kept = first.copy()
        del many, info, second
        self.assertTrue(np.array_equal(first, kept))
        copying = orasp.VectorEnvironment("hubble", 4, copy=True)
        first, _ = copying.reset()
        second, *_ = copying.step(copying.sample_actions())
        self.assertTrue(first.all() and not second.all())

    def test_the_seed_says_what_is_drawn(self) -> None:
        def draws(seed: int) -> np.ndarray[Any, Any]:
            many = orasp.VectorEnvironment("hubble", 16)
            many.reset(seed=seed)
            drawn = np.empty(16, np.int64)
            rows = []
            for _ in range(5):
                self.assertIs(many.sample_actions(drawn), drawn)
                rows.append(drawn.copy())
                many.step(drawn)
            return np.array(rows)

        self.assertTrue(np.array_equal(draws(7), draws(7)))
        self.assertFalse(np.array_equal(draws(7), draws(8)))

    def test_every_kind_of_autoreset(self) -> None:
        plan = best_plan("lattice")
        for kind in ("same_step", "next_step", "disabled"):
            many = orasp.VectorEnvironment("lattice", 2, autoreset=kind)
            many.reset()
            for name in plan:
                action = many.action_names.index(name)
                observations, rewards, terminated, _, info = many.step([action, action])
            self.assertTrue(terminated.all())
            self.assertTrue(info["_episode"].all())
            self.assertEqual(list(many.best_plan or []), plan)
            self.assertEqual(bool(observations.any()), kind == "same_step")
            if kind == "next_step":
                observations, rewards, terminated, _, _ = many.step([0, 0])
                self.assertTrue(observations.all())
                self.assertEqual((rewards.tolist(), terminated.tolist()), ([0.0, 0.0], [False, False]))
            elif kind == "disabled":
                with self.assertRaisesRegex(orasp.InputError, "episode 0 is over; reset it before its next step"):
                    many.step([0, 0])
                observations, _ = many.reset(options={"reset_mask": np.array([False, True])})
                self.assertEqual(observations.any(axis=1).tolist(), [False, True])

    def test_refuses_an_illegal_action_of_one(self) -> None:
        many = orasp.VectorEnvironment("hubble", 3)
        _, info = many.reset()
        legal, illegal = (int(np.flatnonzero(info["action_mask"][0] == flag)[0]) for flag in (1, 0))
        with self.assertRaisesRegex(orasp.InputError, rf"actions\[2\] is {illegal}: connection .* may be removed only after"):
            many.step([legal, legal, illegal])
        self.assertEqual([many.plan(i) for i in range(3)], [[], [], []])

    def test_memory_is_limited(self) -> None:
        free = orasp.VectorEnvironment("iss", 16)
        tight = orasp.VectorEnvironment("iss", 16, max_bytes=50_000)
        free.reset(seed=1)
        tight.reset(seed=1)
        for _ in range(200):
            actions = free.sample_actions()
            self.assertTrue(np.array_equal(actions, tight.sample_actions()))
            self.assertTrue(np.array_equal(free.step(actions)[1], tight.step(actions)[1]))
        self.assertEqual(free.statistics["forgotten"], 0)
        self.assertGreater(tight.statistics["forgotten"], 0)
        self.assertLess(tight.statistics["bytes"], free.statistics["bytes"])

    def test_takes_one_call_at_a_time(self) -> None:
        many = orasp.VectorEnvironment("jwst", 4096)
        many.reset(seed=1)
        errors: list[BaseException] = []

        def work() -> None:
            try:
                for _ in range(3):
                    many.step(many.sample_actions())
            except orasp.InputError as error:
                errors.append(error)

        threads = [threading.Thread(target=work) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        # A call that came in between was refused, for that or because its action was no longer legal.
        for error in errors:
            self.assertRegex(str(error), "at work|cannot be handled now")


class Spaces(unittest.TestCase):
    def test_discrete(self) -> None:
        space = orasp.spaces.Discrete(4, seed=1)
        self.assertEqual((space.n, space.shape, space.dtype), (4, (), np.dtype(np.int64)))
        self.assertTrue(all(value in space for value in (0, 3, np.int64(2), np.array(1))))
        self.assertFalse(any(value in space for value in (-1, 4, 0.5, "1", np.array([1]))))
        self.assertEqual({int(space.sample()) for _ in range(100)}, {0, 1, 2, 3})
        mask = np.array([0, 1, 0, 1], np.int8)
        self.assertEqual({int(space.sample(mask)) for _ in range(100)}, {1, 3})
        self.assertEqual(space.sample(np.zeros(4, np.int8)), 0)
        with self.assertRaisesRegex(AssertionError, "int8"):
            space.sample(np.ones(4))  # type: ignore[arg-type]
        space.seed(9)
        drawn = [int(space.sample()) for _ in range(20)]
        space.seed(9)
        self.assertEqual(drawn, [int(space.sample()) for _ in range(20)])
        self.assertEqual(space, orasp.spaces.Discrete(4))

    def test_box(self) -> None:
        space = orasp.spaces.Box(0, 1, (2, 3), np.float32, seed=1)
        self.assertEqual(space.sample().shape, (2, 3))
        self.assertIn(space.sample(), space)
        self.assertNotIn(np.full((2, 3), 1.5, np.float32), space)
        self.assertNotIn(np.zeros((3, 2), np.float32), space)
        self.assertNotIn([[0, 0, 0], [0, 0, 0]], space)
        self.assertEqual(orasp.spaces.Box(0, 1, (64,), np.uint8, seed=2).sample().max(), 1)

    def test_multi_discrete(self) -> None:
        space = orasp.spaces.MultiDiscrete([2, 3], seed=1)
        self.assertEqual({tuple(space.sample().tolist()) for _ in range(200)}, {(a, b) for a in range(2) for b in range(3)})
        self.assertIn(np.array([1, 2]), space)
        self.assertNotIn(np.array([2, 2]), space)
        one = space.sample([np.array([0, 1], np.int8), np.array([0, 0, 1], np.int8)])
        self.assertEqual(one.tolist(), [1, 2])

    def test_spaces_of_environments_are_copied_plain(self) -> None:
        environment = orasp.Environment("lattice")
        self.assertEqual(copy.deepcopy(environment.action_space).n, environment.action_space.n)


class WithGymnasium(unittest.TestCase):
    """Where a package of that name is there, its classes are those of the environments. This one has nothing but them."""

    STUB = """
import sys, types
import orasp.spaces as own
def module(name, **names):
    made = types.ModuleType(name)
    vars(made).update(names)
    sys.modules[name] = made
class Env:
    def reset(self, *, seed=None, options=None):
        self.seeded = seed
class VectorEnv(Env):
    pass
class Discrete(own.Discrete):
    pass
class AutoresetMode:
    def __class_getitem__(cls, name):
        return "mode " + name
del sys.modules["orasp.environment"], sys.modules["orasp"]
module("gymnasium", Env=Env)
module("gymnasium.spaces", Box=own.Box, Discrete=Discrete, MultiDiscrete=own.MultiDiscrete)
module("gymnasium.vector", VectorEnv=VectorEnv, AutoresetMode=AutoresetMode)
import orasp
one, many = orasp.Environment("lattice"), orasp.VectorEnvironment("lattice", 2, autoreset="disabled")
assert isinstance(one, Env) and isinstance(many, VectorEnv)
assert isinstance(one.action_space, Discrete) and isinstance(many.single_action_space, Discrete)
assert many.metadata["autoreset_mode"] == "mode DISABLED"
one.reset(seed=4)
assert one.seeded == 4
"""

    def test_its_classes_are_used(self) -> None:
        done = subprocess.run([sys.executable, "-c", self.STUB], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)


class Learning(unittest.TestCase):
    def test_reinforce_learns_hubble(self) -> None:
        path = Path(__file__).resolve().parent.parent / "examples" / "reinforce.py"
        loaded = importlib.util.spec_from_file_location("reinforce", path)
        assert loaded is not None and loaded.loader is not None
        reinforce = importlib.util.module_from_spec(loaded)
        loaded.loader.exec_module(reinforce)
        with contextlib.redirect_stdout(io.StringIO()):
            environment, means = reinforce.learn("hubble", 40, seed=1)
        # Random episodes earn -1.36 in the mean; the last 512 come near to the plan of greedy, -1.0022.
        self.assertLess(means[0], -1.3)
        self.assertGreater(means[-1], -1.01)
        self.assertAlmostEqual(environment.best_reward, HUBBLE, places=9)
        self.assertAlmostEqual(evaluated("hubble", environment.best_plan), HUBBLE, places=9)


def load_tests(loader: unittest.TestLoader, tests: unittest.TestSuite, pattern: str) -> unittest.TestSuite:
    for module in (orasp.environment, orasp.spaces):
        tests.addTests(doctest.DocTestSuite(module))
    return tests


if __name__ == "__main__":
    unittest.main()
