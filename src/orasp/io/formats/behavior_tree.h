#pragma once

#include "orasp/io/formats/conversion.h"

namespace orasp {

/// A behaviour tree of BehaviorTree.CPP 4 that carries out a plan: an action for each step, a
/// Sequence for each operation (model/operations.h). The actions are TakeOff and Loosen in
/// disassembly, Bring and Fasten in assembly; their ports say what and how, and the file models
/// them (TreeNodesModel).
///
/// write_behavior_tree keeps the plan's own order: one robot, one operation after another.
/// write_parallel_behavior_tree puts operations that do not wait for each other
/// side by side, in layers: an operation stands in the first layer behind all that it waits for.
/// Any order in which they end is a legal plan, and each moves what it moves in the plan
/// (io/formats/task_graph.h); that there are hands for all of them, and room, is for the executor
/// to see.
/// Reference. Colledanchise and Oegren (2018), Behavior trees in robotics and AI; the XML schema of
/// BehaviorTree.CPP 4.
/// @throws InputError where an id would mean something else in a port: with ';', or in braces.
[[nodiscard]] Written write_behavior_tree(const WriteRequest& request);
[[nodiscard]] Written write_parallel_behavior_tree(const WriteRequest& request);

}  // namespace orasp
