"""The state-action graph H as arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from orasp import _orasp
from orasp._problem import Problem, ProblemLike, load
from orasp._reward import ObjectiveLike
from orasp._solve import ProgressCallback, Stopper, run_of

if TYPE_CHECKING:
    import networkx
    import scipy.sparse


class GraphSize(NamedTuple):
    """The sizes of H and of the tree H~ that it consolidates.

    ``layers``: (states, actions) by the number of connections handled; ``dead_ends``: states other than the
    goal without a legal action; ``tree_nodes``: legal sequences from the start, partial ones and the empty
    one counted; ``sequences``: those that reach the goal. All exact, however large.
    """

    states: int
    actions: int
    layers: list[tuple[int, int]]
    dead_ends: int
    tree_nodes: int
    sequences: int


class Graph:
    """H: every state that is reachable from the start, once, with its legal actions.

    The arrays show the memory of H itself: nothing is copied, they cannot be written, and they keep H alive.
    States are numbered layer by layer, state 0 is the start; actions are numbered state by state, and by
    connection within a state. So ``successors[row_offsets[s]:row_offsets[s + 1]]`` is where the actions of
    state ``s`` lead, in the layout of a CSR matrix, and a state's successors have larger numbers than it.

    >>> import orasp
    >>> h = orasp.graph("lattice")
    >>> h
    <orasp.Graph: 1296 states, 6048 actions>
    >>> h.successors[h.row_offsets[0] : h.row_offsets[1]]
    array([8, 7, 6, 5, 4, 3, 2, 1], dtype=uint32)
    >>> abs(h.values()[0] - orasp.solve("lattice").reward) < 1e-12
    True
    """

    def __init__(self, problem: Problem, engine: _orasp.Graph) -> None:
        self.problem = problem
        self._engine = engine
        self._rewards: Optional[npt.NDArray[np.float64]] = None

    @property
    def num_states(self) -> int:
        return self._engine.num_states

    @property
    def num_actions(self) -> int:
        return self._engine.num_actions

    @property
    def stopped(self) -> Optional[str]:
        """Why building ended early, so that only whole layers are held; None if H is whole."""
        return self._engine.stopped

    @property
    def goal(self) -> Optional[int]:
        """The state in which everything is handled; None if it cannot be reached."""
        return self._engine.goal

    @property
    def infeasible(self) -> Optional[str]:
        """Why there is no plan, where that is known without search."""
        return self._engine.infeasible

    @property
    def nbytes(self) -> int:
        """The bytes of memory that H holds."""
        return self._engine.bytes

    @property
    def states(self) -> npt.NDArray[np.uint64]:
        """The states as bits, shape ``[states, words]``, uint64: bit ``c % 64`` of word ``c // 64`` is 1 where
        connection ``c`` is open (still to be handled). Words after those, if any, are what steps before left
        behind (changeovers, routes)."""
        return self._engine.states

    @property
    def row_offsets(self) -> npt.NDArray[np.uint64]:
        """Where the actions of each state begin, and after the last state where they end, shape
        ``[states + 1]``, uint64."""
        return self._engine.row_offsets

    @property
    def successors(self) -> npt.NDArray[np.uint32]:
        """Where each action leads, shape ``[actions]``, uint32."""
        return self._engine.successors

    @property
    def connections(self) -> npt.NDArray[Any]:
        """The connection that each action handles (of several the first), shape ``[actions]``, uint8 up to
        256 connections, else uint16."""
        return self._engine.connections

    @property
    def reward_numbers(self) -> Optional[npt.NDArray[Any]]:
        """H holds rewards as places in :attr:`reward_table`, shape ``[actions]``, uint8 or uint16; None where
        more than 65,536 rewards occur."""
        return self._engine.reward_numbers

    @property
    def reward_table(self) -> Optional[npt.NDArray[np.float64]]:
        """The rewards that occur, float64, filled up with zeros; None as above."""
        return self._engine.reward_table

    @property
    def rewards(self) -> npt.NDArray[np.float64]:
        """What each action earns, shape ``[actions]``, float64: ``reward_table[reward_numbers]``, worked out
        when it is first asked for (8 bytes an action) and kept. A view where H has no table."""
        if self._rewards is None:
            self._rewards = self._engine.rewards
            self._rewards.flags.writeable = False
        return self._rewards

    @property
    def layer_offsets(self) -> npt.NDArray[np.int64]:
        """The first state of each layer (of states with as many connections handled), and the number of
        states, shape ``[layers + 1]``."""
        return self._engine.layer_offsets

    def sources(self) -> npt.NDArray[np.int64]:
        """The state that each action leaves, shape ``[actions]``. Made anew at each call."""
        return np.repeat(np.arange(self.num_states), np.diff(self.row_offsets).astype(np.int64))

    def open_connections(self, state: int) -> list[str]:
        """The ids of the connections that are open in a state."""
        words = self.states[state]
        ids = self.problem.connection_ids
        return [id for c, id in enumerate(ids) if int(words[c // 64]) >> (c % 64) & 1]

    def values(
        self,
        *,
        from_start: bool = False,
        time_limit: Optional[float] = None,
        threads: Optional[int] = None,
        progress: Optional[ProgressCallback] = None,
        stop: Optional[Stopper] = None,
    ) -> npt.NDArray[np.float64]:
        """The best reward still to come from each state (value iteration), or with ``from_start`` the best
        reward from the start to it (Bellman-Ford), shape ``[states]``; -inf where the goal cannot be reached.
        Raises InputError where a limit or ``stop`` ended the work."""
        return self._engine.values(from_start, run_of(time_limit, None, threads, progress, stop))

    def size(self) -> GraphSize:
        """The sizes of H and of H~, exactly. O(actions).

        >>> import orasp
        >>> orasp.graph("2x3").size().sequences
        2520
        """
        states, actions, layers, dead_ends, tree_nodes, sequences = self._engine.size()
        return GraphSize(states, actions, layers, dead_ends, int(tree_nodes), int(sequences))

    def best_sequence(self, values: Optional[npt.NDArray[np.float64]] = None) -> npt.NDArray[np.int64]:
        """The connections of a path from the start to the goal that follows ``values`` (the best reward still
        to come from each state; :meth:`values` where none are given), shape ``[steps]``. Ties go to the first.
        Raises InputError where the goal cannot be reached."""
        if values is None:
            values = self.values()
        if self.goal is None or values[0] == -np.inf:
            raise _orasp.InputError("the goal cannot be reached, so there is no best sequence")
        state, steps = 0, []
        offsets, successors, rewards = self.row_offsets, self.successors, self.rewards
        while state != self.goal:
            row = slice(int(offsets[state]), int(offsets[state + 1]))
            best = row.start + int(np.argmax(rewards[row] + values[successors[row]]))
            steps.append(int(self.connections[best]))
            state = int(successors[best])
        return np.array(steps, dtype=np.int64)

    def to_scipy(self) -> scipy.sparse.csr_matrix:
        """H as a CSR matrix of shape ``[states, states]``: entry (s, t) is what the action from s to t earns.
        Rewards of 0 are entries too. The successors are H's own memory where H has fewer than 2^31 states and
        actions; row offsets are copied (4 or 8 bytes a state). Of several actions between two states (costs
        between steps, free directions) it is one that earns most."""
        import scipy.sparse

        indptr, indices, rewards = self.row_offsets, self.successors, self.rewards
        if self._engine.wide:
            indptr, indices, rewards = self._without_parallels()
        small = max(self.num_states, len(indices)) < 2**31
        return scipy.sparse.csr_matrix(
            (
                rewards,
                indices.view(np.int32) if small else indices.astype(np.int64),
                indptr.astype(np.int32 if small else np.int64),
            ),
            shape=(self.num_states, self.num_states),
            copy=False,
        )

    def _without_parallels(self) -> tuple[npt.NDArray[Any], npt.NDArray[np.uint32], npt.NDArray[np.float64]]:
        """Row offsets, successors and rewards with one action, of those that earn most, between two states."""
        sources = self.sources()
        order = np.lexsort([-self.rewards, self.successors.astype(np.float64), sources.astype(np.float64)])
        pairs = np.stack((sources[order], self.successors[order].astype(np.int64)))
        first = np.ones(len(order), dtype=bool)
        first[1:] = np.any(pairs[:, 1:] != pairs[:, :-1], axis=0)
        kept = order[first]
        counts = np.bincount(sources[kept], minlength=self.num_states)
        offsets = np.zeros(self.num_states + 1, dtype=np.int64)
        offsets[1:] = np.cumsum(counts)
        return offsets, self.successors[kept], self.rewards[kept]

    def to_networkx(self) -> networkx.MultiDiGraph:
        """H as a graph of NetworkX: nodes are state numbers with their ``open`` connections (ids), edges are
        actions, with ``connection`` (id), ``reward``, and ``cost = -reward`` for shortest paths. Takes about a
        kilobyte an action.

        >>> import networkx, orasp
        >>> h = orasp.graph("2x3")
        >>> path = networkx.bellman_ford_path_length(h.to_networkx(), 0, h.goal, weight="cost")
        >>> round(-path - orasp.solve("2x3").reward, 12)
        0.0
        """
        import networkx

        ids = self.problem.connection_ids
        graph = networkx.MultiDiGraph(name=self.problem.name)
        graph.add_nodes_from((state, {"open": self.open_connections(state)}) for state in range(self.num_states))
        graph.add_edges_from(
            (source, target, {"connection": ids[connection], "reward": reward, "cost": -reward})
            for source, target, connection, reward in zip(
                self.sources().tolist(), self.successors.tolist(), self.connections.tolist(), self.rewards.tolist()
            )
        )
        return graph

    def dot(self) -> str:
        """H in the DOT language, an optimal plan in green. Raises InputError above 200,000 states."""
        return self._engine.dot(self._highlighted())

    def svg(self) -> str:
        """H as an SVG, an optimal plan in green, drawn by Graphviz. Raises InputError above 5,000 states, or
        where Graphviz is missing."""
        return self._engine.svg(self._highlighted())

    def _highlighted(self) -> list[int]:
        # A path is known by single connections.
        if self._engine.wide or self.goal is None:
            return []
        return [int(c) for c in self.best_sequence()]

    def _repr_svg_(self) -> Optional[str]:
        try:
            return self.svg() if self.num_states <= 400 else None
        except _orasp.InputError:
            return None

    def __repr__(self) -> str:
        stopped = f", stopped ({self.stopped})" if self.stopped is not None else ""
        return f"<orasp.Graph: {self.num_states} states, {self.num_actions} actions{stopped}>"


def graph(
    problem: ProblemLike,
    *,
    objective: Optional[ObjectiveLike] = None,
    direction: Optional[str] = None,
    max_subassemblies: Optional[int] = None,
    max_moved_parts: Optional[int] = None,
    max_moved_mass: Optional[float] = None,
    time_limit: Optional[float] = None,
    memory_limit: Optional[int] = None,
    threads: Optional[int] = None,
    progress: Optional[ProgressCallback] = None,
    stop: Optional[Stopper] = None,
) -> Graph:
    """Builds H. The arguments are those of :func:`solve`.

    A limit or ``stop`` ends it with whole layers held (:attr:`Graph.stopped`); Ctrl-C raises
    KeyboardInterrupt. Raises InputError where H is estimated not to fit in memory, and for several robots.
    """
    given = load(problem).edited(
        objective=objective,
        direction=direction,
        max_subassemblies=max_subassemblies,
        max_moved_parts=max_moved_parts,
        max_moved_mass=max_moved_mass,
    )
    engine = _orasp.build_graph(given._engine(), run_of(time_limit, memory_limit, threads, progress, stop))
    return Graph(given, engine)


class GraphEstimate(NamedTuple):
    """How large H would be; ``exact`` where nothing is constrained, else within a factor of two or so."""

    states: float
    actions: float
    bytes: float
    exact: bool


def estimate_graph(problem: ProblemLike) -> GraphEstimate:
    """How large H of a problem would be, in milliseconds and without building it.

    >>> import orasp
    >>> orasp.estimate_graph("hubble-free").states
    524288.0
    """
    return GraphEstimate(*_orasp.estimate_graph(load(problem)._engine()))
