#include "tests/checks.h"

#include <algorithm>
#include <vector>

#include "orasp/io/formula_parser.h"
#include "orasp/model/random.h"
#include "orasp/model/validate.h"

namespace orasp {

void expect_honest(const Problem& problem, const oracle::OracleResult& truth,
                   const Planner& planner, const Result& result) {
  // `auto` proves small problems, by whatever method it chose, and may answer in its name.
  const bool is_auto = planner.role == Role::Chooser;
  // A method that is not exact may prove a plan all the same, where it earns a bound: and-or, dqn.
  const bool may_prove = result.status == Status::Optimal && result.bound.has_value();
  const bool proves = planner.exact || is_auto || may_prove || problem.num_connections() == 0;
  if (!is_auto) {
    EXPECT_EQ(result.method, planner.name);
  }
  if (result.has_plan()) {
    EXPECT_TRUE(truth.feasible);
    EXPECT_EQ(result.sequence.size(), problem.num_connections());
    const oracle::OracleReplay replay = oracle::replay(problem.spec(), result.sequence);
    EXPECT_TRUE(replay.valid);
    EXPECT_NEAR(result.reward, replay.reward, reward_tolerance(replay.reward));
    const Evaluation evaluation =
        evaluate(problem, std::span<const ConnectionIndex>(result.sequence));
    EXPECT_TRUE(evaluation.valid);
    EXPECT_NEAR(result.reward, evaluation.reward, reward_tolerance(replay.reward));
    EXPECT_LE(result.reward, truth.best + reward_tolerance(truth.best));
    EXPECT_GE(result.reward, truth.worst - reward_tolerance(truth.worst));
  } else {
    EXPECT_TRUE(result.sequence.empty());
    EXPECT_EQ(result.reward, -std::numeric_limits<double>::infinity());
  }
  if (result.status == Status::Optimal) {
    EXPECT_TRUE(proves);
    EXPECT_NEAR(result.reward, truth.best, reward_tolerance(truth.best));
    EXPECT_EQ(result.stop, Stop::None);
    ASSERT_TRUE(result.bound.has_value());
  }
  if (result.status == Status::Infeasible) {
    EXPECT_FALSE(truth.feasible);
  }
  if (result.bound) {
    EXPECT_FALSE(std::isnan(*result.bound));
    if (truth.feasible) {
      EXPECT_GE(*result.bound, truth.best - reward_tolerance(truth.best));
    }
    if (result.status == Status::Optimal) {
      EXPECT_NEAR(*result.bound, truth.best, reward_tolerance(truth.best));
    }
  }
  if (result.stop == Stop::None) {
    const Status found = proves ? Status::Optimal : Status::Feasible;
    EXPECT_EQ(status_name(result.status), status_name(truth.feasible ? found : Status::Infeasible));
  } else {
    EXPECT_TRUE(result.status == Status::Feasible || result.status == Status::Unknown)
        << status_name(result.status);
  }
  EXPECT_GE(result.statistics.seconds, 0);
}

void expect_same_answer(const Result& one, const Result& other) {
  EXPECT_EQ(one.method, other.method);
  EXPECT_EQ(status_name(one.status), status_name(other.status));
  EXPECT_EQ(stop_name(one.stop), stop_name(other.stop));
  EXPECT_EQ(one.sequence, other.sequence);
  EXPECT_EQ(one.reward, other.reward);
  EXPECT_EQ(one.bound, other.bound);
  EXPECT_EQ(one.seed, other.seed);
  EXPECT_EQ(one.values, other.values);
  EXPECT_EQ(one.notes, other.notes);
  EXPECT_EQ(one.statistics.states, other.statistics.states);
  EXPECT_EQ(one.statistics.actions, other.statistics.actions);
  EXPECT_EQ(one.statistics.expanded, other.statistics.expanded);
  EXPECT_EQ(one.statistics.generated, other.statistics.generated);
  EXPECT_EQ(one.statistics.reopened, other.statistics.reopened);
  EXPECT_EQ(one.statistics.pruned, other.statistics.pruned);
  EXPECT_EQ(one.statistics.sweeps, other.statistics.sweeps);
}

Objective chance_objective() {
  Callable callable;
  callable.name = "chance";
  callable.least = 0;
  callable.greatest = 1;
  callable.reward = [](const Step& step) {
    return static_cast<double>(mixed(1000 * step.connection + step.before) % 1000) / 1000;
  };
  return {"callable", callable};
}

Objective unbounded_formula() {
  return {"expression",
          Expression{.formula = "before*tan(moved_parts)/100", .compiler = compile_formula}};
}

bool range_is_known(const Objective& objective) {
  if (objective.type == "expression") return false;
  if (const auto* callable = std::get_if<Callable>(&objective.parameters))
    return std::isfinite(callable->greatest);
  if (const auto* sum = std::get_if<WeightedSum>(&objective.parameters)) {
    return std::all_of(sum->terms.begin(), sum->terms.end(), [](const WeightedObjective& term) {
      return range_is_known(term.objective);
    });
  }
  return true;
}

}  // namespace orasp
