#!/usr/bin/env python3
"""Tests `orasp convert`: what it writes is read by other readers, and what is wrong is one sentence.

    tests/cli/convert_test.py PROGRAM [unittest's arguments]

What needs python3-networkx, python3-pydot or python3-lxml is skipped where they are missing.
"""
import csv
import functools
import io
import json
import re
import shutil
import subprocess
import unittest
import warnings
from pathlib import Path

from program import CHAIN, CYCLE, ROOT, Case, assembly, orasp, smoke

try:
    import networkx
except ImportError:
    networkx = None
try:
    import pydot
except ImportError:
    pydot = None
try:
    from lxml import etree
except ImportError:
    etree = None

FORMATS = ROOT / "examples/formats"
needs_networkx = unittest.skipUnless(networkx, "the module networkx is missing (Debian: python3-networkx)")
needs_pydot = unittest.skipUnless(networkx and pydot, "the module pydot is missing (Debian: python3-pydot)")
needs_lxml = unittest.skipUnless(etree, "the module lxml is missing (Debian: python3-lxml)")

# All ways of stating what comes before what, without dead ends for one direction only.
ORDERED = assembly(["1-2", "2-3", "3-4", "1-4", "2-4"],
                   precedence=[{"connection": "1-2", "after": ["3-4"]}, {"connection": "2-3", "after_any": ["1-4", "2-4"]},
                               {"connection": "2-4", "made_after": ["1-4"]},
                               {"connection": "3-4", "made_after_any": ["2-3", "2-4"]}])


def listed():
    """The rows of the table of formats: name -> what it does."""
    rows = orasp("convert", "--list").out.split("\n\n")[0].splitlines()
    columns = [match.start() for match in re.finditer(r"(?:^|(?<=  ))\S", rows[0])]
    return {row.split()[0]: [row[begin:end].strip() for begin, end in zip(columns[1:], [*columns[2:], None])] for row in rows[1:]}


# ---------------------------------------------------------------------------------------------------------------------
# a reader of PDDL, and all plans of what it reads

def tokens_of(text):
    return re.findall(r"[()]|[^\s()]+", re.sub(r";[^\n]*", "", text).lower())


def parsed(tokens):
    stack = [[]]
    for token in tokens:
        if token == "(":
            stack.append([])
        elif token == ")":
            done = stack.pop()
            stack[-1].append(done)
        else:
            stack[-1].append(token)
    assert len(stack) == 1 and len(stack[0]) == 1, "parentheses do not match"
    return stack[0][0]


def section(definition, name):
    return next(part[1:] for part in definition[1:] if part[0] == name)


def holds(condition, state):
    head = condition[0]
    if head == "and":
        return all(holds(part, state) for part in condition[1:])
    if head == "or":
        return any(holds(part, state) for part in condition[1:])
    if head == "not":
        return not holds(condition[1], state)
    return tuple(condition) in state


def plans_of(domain_text, problem_text):
    """How many shortest ways there are from the initial state to the goal, and the names of the actions."""
    domain, problem = parsed(tokens_of(domain_text)), parsed(tokens_of(problem_text))
    assert domain[1][0] == "domain" and section(problem, ":domain") == domain[1][1:]
    constants = [word for word in section(domain, ":constants") if word not in ("-", "connection")]
    requirements = section(domain, ":requirements")
    actions = []
    for part in domain[1:]:
        if part[0] == ":action":
            fields = dict(zip(part[2::2], part[3::2]))
            assert fields[":parameters"] == []
            assert fields[":effect"][0] == "done" and fields[":effect"][1] in constants
            assert ":disjunctive-preconditions" in requirements or "or" not in str(fields[":precondition"])
            actions.append((part[1], fields[":precondition"], tuple(fields[":effect"])))
    goal = section(problem, ":goal")[0]

    @functools.cache
    def ways(state):
        if holds(goal, state):
            return 1
        return sum(ways(state | {effect}) for _, condition, effect in actions if holds(condition, state))

    return ways(frozenset(tuple(fact) for fact in section(problem, ":init"))), [name for name, _, _ in actions]


def read_dot(file):
    """A graph of networkx, read by pydot."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PendingDeprecationWarning)  # that pydot is hardly kept up
        return networkx.nx_pydot.read_dot(file)


class Convert(Case):
    def converted(self, source, target="out.txt", *words, code=0):
        """The written file's text, and what was said on standard error."""
        file = self.folder / target
        answer = orasp("convert", str(source), "-o", str(file), *words)
        self.check(answer, code)
        self.assertEqual(answer.out, "")
        return file.read_text(encoding="utf-8"), answer.error

    def refused(self, source, said, *words, code=30, target="refused.json"):
        """One sentence, and nothing is written."""
        file = self.folder / target
        answer = orasp("convert", str(source), "-o", str(file), *words)
        self.check_sentence(answer, code)
        self.assertIn(said, answer.error)
        self.assertFalse(file.exists())

    def digest(self, file):
        return json.loads(orasp("solve", str(file), "--method", "greedy", "--json", "--quiet").out)["problem_digest"]

    # -----------------------------------------------------------------------------------------------------------------
    # reading

    @smoke
    def test_every_example_becomes_a_problem_that_can_be_solved(self):
        count = {}
        for file in sorted(FORMATS.iterdir()):
            if file.is_dir() or file.suffix == ".md":
                continue
            with self.subTest(file=file.name):
                text, _ = self.converted(file, "problem.json")
                problem = json.loads(text)
                self.assertEqual(problem["format"], "orasp-problem/1")
                self.assertEqual(orasp("solve", str(self.folder / "problem.json"), "--quiet").code, 0)
                named = next(name for name, row in listed().items() if row[0] == "yes" and
                             (name == file.stem.split("_", 1)[-1].replace("_", "-") or row[2] == file.suffix.lower() != ".json"))
                count[named] = count.get(named, 0) + 1
        self.assertEqual(count, {name: 3 for name, row in listed().items() if row[0] == "yes" and name != "orasp"})

    @smoke
    def test_every_broken_example_is_one_sentence_with_the_file_and_the_place(self):
        files = sorted((FORMATS / "broken").iterdir())
        self.assertEqual(len(files), 6)
        for file in files:
            with self.subTest(file=file.name):
                self.refused(file, f"{file.name}: ")
                self.assertRegex(orasp("convert", str(file), "-o", "-").error, r"(line \d+|nodes\[2\]|joints\.seam)")

    def test_the_precedence_graph_of_mertens_has_as_many_orders_as_is_known(self):
        self.converted(FORMATS / "MERTENS.IN2", "mertens.json")
        graph = json.loads(orasp("graph", str(self.folder / "mertens.json"), "--json").out)
        self.assertEqual((graph["states"], graph["sequences"]), (22, 45))

    def test_standard_input_and_standard_output(self):
        text = (FORMATS / "lamp.graphml").read_bytes()
        answer = orasp("convert", "-", "-o", "-", "--to", "orasp", stdin=text)
        self.check(answer, 0)
        self.assertEqual(json.loads(answer.out)["name"], "Desk lamp")
        self.assertEqual(orasp("convert", "hubble", "-o", "-", "--to", "orasp").out, orasp("scenarios", "hubble").out)

    def test_a_note_says_what_is_left_out_unless_it_is_to_be_quiet(self):
        _, said = self.converted(FORMATS / "stool_mjcf.xml", "stool.json")
        self.assertEqual(said, "orasp: warning: 1 weld repeats a pair of bodies: each pair is one connection\n")
        _, said = self.converted(FORMATS / "stool_mjcf.xml", "stool.json", "--quiet")
        self.assertEqual(said, "")

    @needs_networkx
    def test_what_networkx_writes_is_read_with_the_same_digest_either_way(self):
        graph = networkx.Graph(name="four")
        for i in range(4):
            graph.add_node(f"p {i}", mass=i + 0.5, position=f"{i},0,{i / 3}", value=i)
        graph.add_edges_from([("p 0", "p 1", {"duration": 3, "tool": "ä"}), ("p 1", "p 2"), ("p 2", "p 3", {"w": 0.1}), ("p 3", "p 3")])
        networkx.write_graphml(graph, self.folder / "g.graphml")
        (self.folder / "g.json").write_text(json.dumps(networkx.node_link_data(graph)))
        first, _ = self.converted(self.folder / "g.graphml", "a.json")
        second, _ = self.converted(self.folder / "g.json", "b.json")
        self.assertEqual(first, second)
        self.assertEqual(json.loads(first)["parts"][1], {"id": "p 1", "mass": 1.5, "position": [1.0, 0.0, 1 / 3], "numbers": {"value": 1.0}})

    # -----------------------------------------------------------------------------------------------------------------
    # wrong input

    @smoke
    def test_what_is_wrong_with_the_words_is_said_in_a_sentence(self):
        lamp = str(FORMATS / "lamp.graphml")
        for words, sentence in [
            ([], r"INPUT is missing, a file; `orasp convert --list` lists the formats"),
            ([lamp], r"-o OUTPUT is missing"),
            ([lamp, "-o", "x.json", "--from", "grphml"], r'unknown format "grphml"; known: .*; did you mean "graphml"'),
            ([lamp, "-o", "x.json", "--to", "pdf"], r'unknown format "pdf"'),
            ([lamp, "-o", "x.json", "--from", "dot"], r"lamp.graphml: dot is written, not read; what is read is"),
            ([lamp, "-o", "x.json", "--to", "in2"], r"in2 is read, not written; what is written is"),
            ([lamp, "-o", "x.csv"], r'the ending of "x.csv" is that of several formats; --to says which to write: parts-csv'),
            ([lamp, "-o", "x.docx"], r'the ending of "x.docx" tells no format'),
            (["-", "-o", "-", "--to", "steps-csv", "--plan", "-"], r"INPUT and --plan cannot both be read from standard input"),
            (["none.graphml", "-o", "x.json"], r'cannot read "none.graphml": No such file'),
            ([lamp, "-o", "none/x.json"], r"none/x.json"),
        ]:
            with self.subTest(words=words):
                answer = orasp("convert", *words, cwd=self.folder)
                self.check_sentence(answer)
                self.assertRegex(answer.error, sentence)
        self.assertEqual(list(self.folder.iterdir()), [])

    @smoke
    def test_hostile_files_are_one_sentence_each(self):
        for name, content, said in [
            ("empty.graphml", b"", "the file is empty"), ("empty.csv", b"\n\n", "the file is empty"),
            ("empty.json", b"", "the file is empty"), ("none.json", b"{}", "neither its ending nor what stands in it tells its format"),
            ("a.txt", b"hello", "--from says which it is"),
            ("a.xml", b"<robot/>", "--from says which it is"),
            ("latin.graphml", b"<graphml>\n<graph><node id='\xe9'/></graph></graphml>", "line 2: the byte 0xe9 is not valid UTF-8"),
            ("wide.graphml", "<graphml/>".encode("utf-16"), "line 1: the byte 0xff is not valid UTF-8"),
            ("zero.in2", b"1\n\0\n", "line 2: a zero byte"),
            ("none.graphml", b"<graphml><graph/></graphml>", "there are no parts"),
            ("bomb.graphml", b"<!DOCTYPE g [<!ENTITY a 'x'><!ENTITY b '&a;&a;'>]><graphml><graph><node id='&b;'/></graph></graphml>",
             "a document type with declarations of its own is not read"),
            ("deep.graphml", b"<a>" * 500_000, "not well-formed XML"),
            ("deep.json", b'{"nodes":' + b"[" * 500_000, "nested more than 64 deep"),
            ("twice.json", b'{"nodes": [], "nodes": [], "links": []}', 'the key "nodes" appears twice'),
            ("nan.json", b'{"nodes": [{"id": 1, "mass": NaN}], "links": []}', '"NaN" is not JSON'),
            ("many.graphml", b"<graphml><graph>" + b"".join(b"<node id='%d'/>" % i for i in range(20_000)) + b"</graph></graphml>",
             "more than 16384 nodes"),
        ]:
            with self.subTest(name=name):
                self.refused(self.file(name, content), said)

    def test_a_file_of_100_megabytes_is_read_or_refused_in_seconds(self):
        data = b"<data key='k'>" + b"x" * 1000 + b"</data>"
        node = b"<node id='%d'>" + data * 10 + b"</node>\n"
        text = (b"<graphml><key id='k' for='node' attr.name='note' attr.type='string'/><graph>" +
                b"".join(node % i for i in range(10_000)) + b"</graph></graphml>")
        self.assertGreater(len(text), 100_000_000)
        _, said = self.converted(self.file("large.graphml", text), "large.json")
        self.assertIn('"note" is left out (10000 parts)', said)

    # -----------------------------------------------------------------------------------------------------------------
    # writing problems

    def test_every_built_in_problem_comes_back_from_graphml_with_the_same_digest(self):
        for name in ["hubble-upc", "jwst", "lattice", "table-hemnes", "iss-upc"]:
            with self.subTest(name=name):
                self.converted(name, "p.graphml")
                self.converted(self.folder / "p.graphml", "p.json")
                self.assertEqual(self.digest(self.folder / "p.json"), self.digest(name))

    @needs_networkx
    def test_graphml_is_read_by_networkx(self):
        self.converted(ROOT / "examples/shelf.json", "shelf.graphml")
        graph = networkx.read_graphml(self.folder / "shelf.graphml", force_multigraph=True)
        problem = json.loads((ROOT / "examples/shelf.json").read_text())
        self.assertEqual(list(graph.nodes), [part["id"] for part in problem["parts"]])
        self.assertEqual(sorted(key for _, _, key in graph.edges(keys=True)),
                         sorted(entry.get("id", "-".join(entry["parts"])) for entry in problem["connections"]))
        for part in problem["parts"]:
            self.assertEqual(graph.nodes[part["id"]].get("mass", 1), part.get("mass", 1))
        # And written again by networkx it is the same problem, but for the order of its connections.
        networkx.write_graphml(networkx.read_graphml(self.folder / "shelf.graphml"), self.folder / "again.graphml")
        again = json.loads(self.converted(self.folder / "again.graphml", "again.json")[0])
        before = json.loads(self.converted(ROOT / "examples/shelf.json", "before.json")[0])

        def by_id(text):
            return {entry.get("id", "-".join(entry["parts"])): dict(entry, id=None, parts=set(entry["parts"]))
                    for entry in text.pop("connections")}

        # The parts of an undirected edge may have changed places, and then its id is no default.
        self.assertEqual({"-".join(sorted(key.split("-"))): value for key, value in by_id(again).items()},
                         {"-".join(sorted(key.split("-"))): value for key, value in by_id(before).items()})
        self.assertEqual(again, before)

    @needs_pydot
    def test_dot_is_read_by_networkx_and_drawn_by_graphviz(self):
        odd = json.dumps({"format": "orasp-problem/1", "name": 'a "b"', "parts": [{"id": "x y"}, {"id": "2;"}, {"id": "ü"}],
                          "connections": [{"parts": ["x y", "2;"]}, {"id": "strict", "parts": ["2;", "ü"], "duration": 2}]})
        for source, nodes, edges in [(self.file("odd.json", odd), 3, 2), ("hubble", 11, None)]:
            self.converted(source, "p.dot")
            graph = read_dot(self.folder / "p.dot")
            with self.subTest(source=source):
                self.assertFalse(graph.is_directed())
                problem = json.loads(orasp("convert", source, "-o", "-", "--to", "orasp").out)
                names = {name.strip('"') for name in graph.nodes} - {"\\n"}  # pydot 1.4 takes the end of the file for a node
                self.assertEqual(names, {part["id"] for part in problem["parts"]})
                self.assertEqual(graph.number_of_edges(), len(problem["connections"]))
            if shutil.which("dot"):
                drawn = subprocess.run(["dot", "-Tplain", self.folder / "p.dot"], capture_output=True, text=True, check=True)
                self.assertEqual(len(re.findall(r"^node ", drawn.stdout, re.MULTILINE)), len(problem["parts"]))
                self.assertEqual(drawn.stderr, "")

    def test_tables_are_read_by_the_csv_module(self):
        text, said = self.converted("jwst-upc", "parts.csv", "--to", "parts-csv")
        rows = list(csv.DictReader(io.StringIO(text)))
        problem = json.loads(orasp("scenarios", "jwst-upc").out)
        self.assertEqual([row["id"] for row in rows], [part["id"] for part in problem["parts"]])
        self.assertIn("left out of what the problem says: limits", said.replace("precedence, ", ""))
        text, _ = self.converted("jwst-upc", "connections.csv", "--to", "connections-csv")
        rows = list(csv.DictReader(io.StringIO(text)))
        self.assertEqual([[row["part_a"], row["part_b"]] for row in rows], [entry["parts"] for entry in problem["connections"]])

    def test_pddl_has_as_many_plans_as_the_problem_has_orders(self):
        chain_after = assembly(["1-2", "2-3", "3-4"], precedence=[{"connection": "1-2", "after": ["3-4"]}])
        free = json.loads(ORDERED)
        free["precedence"] = free["precedence"][:2]
        goal = json.dumps(dict(free, precedence=free["precedence"][:1], goal={"removed": ["1-2"]}))
        seen = set()
        for name, text in [("chain", CHAIN), ("after", chain_after), ("ordered", ORDERED), ("free", json.dumps(free)), ("cycle", CYCLE),
                           ("goal", goal)]:
            for direction in ["disassembly", "assembly"]:
                if name == "goal" and direction == "assembly":
                    continue
                file = self.file(f"{name}.json", json.dumps(dict(json.loads(text), direction=direction)))
                domain, said = self.converted(file, "domain.pddl", "--to", "pddl-domain")
                problem, _ = self.converted(file, "problem.pddl", "--to", "pddl-problem")
                self.assertIn("left out of what the problem says: objective", said)
                ways, actions = plans_of(domain, problem)
                with self.subTest(name=name, direction=direction):
                    verb = "make" if direction == "assembly" else "remove"
                    self.assertTrue(all(action.startswith(verb + "-c-") for action in actions))
                    graph = json.loads(orasp("graph", file, "--json").out)
                    self.assertEqual(ways, graph["sequences"])
                    seen.add(ways)
        self.assertIn(0, seen)
        self.assertGreater(len(seen), 3)

    def test_pddl_names_are_names_whatever_the_ids(self):
        text = json.dumps({"format": "orasp-problem/1", "parts": [{"id": "1"}, {"id": "2"}],
                           "connections": [{"id": "M4 (left)", "parts": ["1", "2"]}, {"id": "m4", "parts": ["1", "2"]},
                                           {"id": "M4", "parts": ["1", "2"]}, {"id": "c-1", "parts": ["1", "2"]}]})
        file = self.file("odd.json", text)
        domain, _ = self.converted(file, "domain.pddl", "--to", "pddl-domain")
        problem, _ = self.converted(file, "problem.pddl", "--to", "pddl-problem")
        ways, actions = plans_of(domain, problem)
        self.assertEqual(ways, 24)
        self.assertEqual(actions, ["remove-c1", "remove-c-m4", "remove-c3", "remove-c-c-1"])
        self.assertIn('remove-c1  ; "M4 (left)"', domain)

    def test_what_pddl_cannot_say_is_refused(self):
        self.refused("hubble-upc", "hubble-upc: pddl cannot say it: the limits of the problem", "--to", "pddl-domain")

    # -----------------------------------------------------------------------------------------------------------------
    # writing plans

    def plan(self, problem, *words):
        file = self.folder / "plan.json"
        self.check(orasp("solve", str(problem), "-o", str(file), "--quiet", *words), 0)
        return str(file), json.loads(file.read_text())

    @needs_networkx
    def test_the_order_is_that_of_the_plan_file(self):
        for problem in ["hubble-upc", "lattice", str(ROOT / "examples/shelf.json")]:
            file, plan = self.plan(problem)
            self.converted(problem, "order.graphml", "--to", "order-graphml", "--plan", file)
            graph = networkx.read_graphml(self.folder / "order.graphml")
            with self.subTest(problem=problem):
                self.assertTrue(graph.is_directed())
                self.assertEqual([graph.nodes[str(i + 1)]["connections"] for i in range(len(plan["steps"]))], plan["disassembly"])
                self.assertEqual(sorted((int(a), int(b)) for a, b in graph.edges), sorted(map(tuple, plan["order"])))
            if pydot:
                self.converted(problem, "order.dot", "--to", "order-dot", "--plan", file)
                drawn = read_dot(self.folder / "order.dot")
                self.assertEqual(sorted((int(a.strip('"')), int(b.strip('"'))) for a, b, _ in drawn.edges), sorted(map(tuple, plan["order"])))

    def test_the_steps_of_a_plan_as_a_table(self):
        file, plan = self.plan("hubble")
        text, said = self.converted("hubble", "steps.csv", "--to", "steps-csv", "--plan", file)
        self.assertEqual(said, "")
        rows = list(csv.DictReader(io.StringIO(text)))
        self.assertEqual([row["connections"] for row in rows], plan["disassembly"])
        self.assertEqual([row["moved"].split(";") if row["moved"] else [] for row in rows], [step["moved"] for step in plan["steps"]])
        self.assertAlmostEqual(float(rows[-1]["total"]), plan["reward"], 9)

    @needs_lxml
    def test_behaviour_trees_fit_their_schema_and_hold_the_plan(self):
        schema = etree.XMLSchema(etree.parse(str(Path(__file__).parent / "behavior_tree.xsd")))
        for problem in ["hubble", "lattice", str(ROOT / "examples/shelf.json"), str(ROOT / "examples/modelling/05_wall.json")]:
            for words in [[], ["--direction", "assembly"]]:
                if words:
                    text = json.loads(orasp("convert", problem, "-o", "-", "--to", "orasp").out)
                    if "goal" in text:
                        continue
                    problem = self.file("assembly.json", json.dumps(dict(text, direction="assembly")))
                file, plan = self.plan(problem)
                key = "assembly" if words else "disassembly"
                for target in ["behavior-tree", "behavior-tree-parallel"]:
                    self.converted(problem, "tree.xml", "--to", target, "--plan", file)
                    tree = etree.parse(str(self.folder / "tree.xml"))
                    with self.subTest(problem=problem, target=target):
                        self.assertTrue(schema.validate(tree), schema.error_log)
                        actions = tree.xpath("//BehaviorTree//Action")
                        done = [action.get("connections") for action in actions]
                        if target == "behavior-tree":
                            self.assertEqual(done, [c if isinstance(c, str) else ";".join(c) for c in plan[key]])
                            self.assertEqual(tree.xpath("//Parallel"), [])
                            # An operation of several steps is a Sequence of them.
                            sizes = [len(node.xpath(".//Action | self::Action")) for node in tree.xpath("/root/BehaviorTree/Sequence/*")]
                            self.assertEqual(sizes, [len(operation["steps"]) for operation in plan["operations"]])
                        self.assertEqual(sorted(done), sorted(c if isinstance(c, str) else ";".join(c) for c in plan[key]))
                        models = {model.get("ID"): {port.get("name") for port in model} for model in tree.xpath("//TreeNodesModel/Action")}
                        for action in actions:
                            self.assertLessEqual(set(action.attrib) - {"ID", "name"}, models[action.get("ID")])

    @needs_lxml
    def test_a_parallel_tree_does_side_by_side_what_need_not_wait(self):
        # Three parts on a base, each by one connection: none waits for another, so there is one layer.
        star = self.file("star.json", json.dumps({
            "format": "orasp-problem/1", "parts": [{"id": i} for i in "0123"], "base": ["0"],
            "connections": [{"parts": ["0", i]} for i in "123"], "precedence": [{"connection": "0-3", "after": ["0-1", "0-2"]}]}))
        self.converted(star, "tree.xml", "--to", "behavior-tree-parallel")
        tree = etree.parse(str(self.folder / "tree.xml"))
        layers = [[action.get("connections") for action in node.xpath(".//Action | self::Action")]
                  for node in tree.xpath("/root/BehaviorTree/Sequence/*")]
        self.assertEqual([sorted(layer) for layer in layers], [["0-1", "0-2"], ["0-3"]])
        self.assertEqual([node.tag for node in tree.xpath("/root/BehaviorTree/Sequence/*")], ["Parallel", "Action"])

    def test_a_plan_is_found_where_none_is_given_and_that_is_said(self):
        text, said = self.converted("hubble", "tasks.json", "--to", "task-graph")
        self.assertEqual(said, "orasp: no --plan was given; the plan is that of the method auto (optimal)\n")
        self.assertEqual(json.loads(text)["format"], "orasp-task-graph/1")
        self.assertAlmostEqual(json.loads(text)["reward"], -0.9902, 9)

    def test_without_a_legal_plan_nothing_is_written(self):
        target = self.folder / "none.json"
        answer = orasp("convert", self.file("cycle.json", CYCLE), "-o", target, "--to", "task-graph")
        self.check(answer, 10, out=r"\A\Z", error=r"\Aorasp: test: no plan exists, so nothing was written\n\Z")
        self.assertFalse(target.exists())
        chain = self.file("chain.json", CHAIN)
        self.refused(chain, "plan.txt: the plan breaks a rule at step 3, so nothing was written: ", "--to", "task-graph",
                     "--plan", self.file("plan.txt", "1-2\n2-3\n2-3\n"), code=10)
        self.refused(chain, 'the problem has no connection "7-8"', "--to", "steps-csv", "--plan", self.file("other.txt", "7-8\n"), code=10)

    def test_a_plan_for_a_format_of_problems_is_checked_and_left_out(self):
        file, _ = self.plan("hubble")
        _, said = self.converted("hubble", "p.graphml", "--plan", file)
        self.assertIn("graphml holds a problem: the plan is checked, and left out", said)

    def test_plans_of_several_robots_are_refused(self):
        self.refused("fleet-lattice", "a plan of one robot is written, and makespan is an objective of several", "--to", "task-graph")

    # -----------------------------------------------------------------------------------------------------------------
    # one table

    def test_help_completion_and_pages_name_every_format(self):
        help_text = orasp("convert", "--help").out
        script = orasp("completion", "bash").out
        page = (ROOT / "docs/convert.md").read_text(encoding="utf-8")
        self.assertGreater(len(listed()), 15)
        for name, row in listed().items():
            with self.subTest(name=name):
                self.assertRegex(help_text, rf"(?m)^  {name} ")
                self.assertRegex(script, rf"\b{name}\b")
                self.assertTrue(f"`{name}`" in page, "docs/convert.md does not describe it")


if __name__ == "__main__":
    unittest.main()
