#include "orasp/io/formats/behavior_tree.h"

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "orasp/io/formats/detail/plan_tasks.h"
#include "orasp/io/formats/detail/text_checks.h"
#include "orasp/io/formats/detail/xml_document.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

using detail::StepAct;
using pugi::xml_node;

const char* action_id(StepAct act) {
  switch (act) {
    case StepAct::TakeOff: return "TakeOff";
    case StepAct::Loosen: return "Loosen";
    case StepAct::Bring: return "Bring";
    case StepAct::Fasten: break;
  }
  return "Fasten";
}

struct Port {
  const char* name;
  const char* meaning;
  bool moving;  ///< whether only steps that move something have it
};
constexpr auto kPorts = std::to_array<Port>({
    {"connections", "ids of the connections that are handled, with ; between them", false},
    {"duration", "s", false},
    {"moved", "ids of the parts that move, with ; between them", true},
    {"direction",
     "the way in which the moved piece leaves, by its name in the problem; empty where "
     "none is known",
     true},
    {"motion", "the way in which it goes here, x;y;z of length 1; empty where none is known", true},
});

/// A value of a port, which must not look like a name on the blackboard.
std::string literal(std::string text) {
  const bool pointer = text.starts_with('{') && text.ends_with('}');
  if (pointer || text.starts_with("json:")) {
    throw InputError(fmt::format(
        "behavior-tree: {} means something else in a port than the text that it is; give the ids "
        "other names",
        detail::in_quotes(text)));
  }
  return text;
}

class TreeWriter {
 public:
  explicit TreeWriter(const WriteRequest& request)
      : problem_(request.problem), steps_(request.plan->steps) {
    xml_node declaration = document_.append_child(pugi::node_declaration);
    declaration.append_attribute("version") = "1.0";
    declaration.append_attribute("encoding") = "UTF-8";
    root_ = document_.append_child("root");
    root_.append_attribute("BTCPP_format") = "4";
    const char* id = problem_.direction() == Direction::Assembly ? "Assembly" : "Disassembly";
    root_.append_attribute("main_tree_to_execute") = id;
    tree_ = root_.append_child("BehaviorTree");
    tree_.append_attribute("ID") = id;
  }

  /// The node that holds the plan; nothing to do succeeds at once.
  xml_node main() {
    if (steps_.empty()) return tree_.append_child("AlwaysSuccess");
    xml_node main = tree_.append_child("Sequence");
    std::string name = problem_.name();
    detail::replace_control_characters(name);
    std::ranges::replace_if(
        name, [](char c) { return c == '\n' || c == '\t'; }, ' ');
    if (!name.empty()) main.append_attribute("name") = name.c_str();
    return main;
  }

  void operation(xml_node parent, const detail::PlanTask& task, std::size_t number) {
    if (task.steps.end - task.steps.first > 1) {
      parent = parent.append_child("Sequence");
      parent.append_attribute("name") = fmt::format("operation {}", number).c_str();
    }
    for (std::size_t i = task.steps.first; i < task.steps.end; ++i) action(parent, i);
  }

  std::string finish() {
    if (!used_.empty()) {
      xml_node models = root_.append_child("TreeNodesModel");
      for (const StepAct act : used_) {
        xml_node model = models.append_child("Action");
        model.append_attribute("ID") = action_id(act);
        for (const Port& port : kPorts) {
          if (port.moving && !moves(act)) continue;
          xml_node declared = model.append_child("input_port");
          declared.append_attribute("name") = port.name;
          if (port.moving) declared.append_attribute("default") = "";
          declared.text().set(port.meaning);
        }
      }
    }
    return detail::xml_text(document_);
  }

 private:
  static bool moves(StepAct act) { return act == StepAct::TakeOff || act == StepAct::Bring; }

  void action(xml_node parent, std::size_t index) {
    const Step& step = steps_[index];
    const StepAct act = detail::act_of(step, problem_.direction());
    used_.insert(act);
    xml_node action = parent.append_child("Action");
    action.append_attribute("ID") = action_id(act);
    action.append_attribute("name") = fmt::format("step {}", index + 1).c_str();
    const auto put = [&action](const char* port, const std::string& value) {
      action.append_attribute(port) = literal(value).c_str();
    };
    put("connections", detail::joined_ids(detail::connection_ids(problem_, step), "behavior-tree"));
    put("duration", detail::number_text(detail::step_duration(problem_, step)));
    if (!step.moves()) return;
    put("moved", detail::joined_ids(detail::moved_ids(problem_, step), "behavior-tree"));
    if (step.direction) put("direction", problem_.direction_name(*step.direction));
    if (const auto motion = detail::motion_of(problem_, step)) {
      put("motion",
          fmt::format("{};{};{}", detail::number_text((*motion)[0]),
                      detail::number_text((*motion)[1]), detail::number_text((*motion)[2])));
    }
  }

  const Problem& problem_;
  const std::vector<Step>& steps_;
  pugi::xml_document document_;
  xml_node root_;
  xml_node tree_;
  std::set<StepAct> used_;
};

/// The tasks of each layer: a task stands behind all that it waits for.
std::vector<std::vector<std::size_t>> layers_of(const std::vector<detail::PlanTask>& tasks) {
  std::vector<std::size_t> layer(tasks.size(), 0);
  std::vector<std::vector<std::size_t>> layers;
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    for (const std::size_t early : tasks[t].after) layer[t] = std::max(layer[t], layer[early] + 1);
    if (layers.size() <= layer[t]) layers.resize(layer[t] + 1);
    layers[layer[t]].push_back(t);
  }
  return layers;
}

}  // namespace

Written write_behavior_tree(const WriteRequest& request) {
  const detail::PlanTasks plan = detail::plan_tasks(request);
  TreeWriter writer(request);
  const xml_node main = writer.main();
  for (std::size_t t = 0; t < plan.tasks.size(); ++t) writer.operation(main, plan.tasks[t], t + 1);
  return {.text = writer.finish(), .notes = plan.notes};
}

Written write_parallel_behavior_tree(const WriteRequest& request) {
  const detail::PlanTasks plan = detail::plan_tasks(request);
  TreeWriter writer(request);
  const xml_node main = writer.main();
  for (const std::vector<std::size_t>& layer : layers_of(plan.tasks)) {
    xml_node parent = main;
    if (layer.size() > 1) {
      parent = parent.append_child("Parallel");
      parent.append_attribute("success_count") = "-1";
      parent.append_attribute("failure_count") = "1";
    }
    for (const std::size_t t : layer) writer.operation(parent, plan.tasks[t], t + 1);
  }
  return {.text = writer.finish(), .notes = plan.all_notes()};
}

}  // namespace orasp
