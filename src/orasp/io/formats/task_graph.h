#pragma once

#include "orasp/io/formats/conversion.h"

namespace orasp {

/// A plan as a graph of tasks for those who carry it out: JSON, format `orasp-task-graph/1`
/// (docs/convert.md, schemas/orasp-task-graph-1.schema.json). A task is an operation
/// (model/operations.h) with its steps, the parts that it moves, the way in which they go, how long
/// it takes and the tasks that must be done before. Any order that keeps these is a legal plan.
[[nodiscard]] Written write_task_graph(const WriteRequest& request);

}  // namespace orasp
