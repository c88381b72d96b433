#include "orasp/fleet/fleet.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "orasp/fleet/fleet_expander.h"
#include "orasp/fleet/fleet_validate.h"
#include "orasp/model/random.h"
#include "tests/fault.h"
#include "tests/fleet_oracle.h"
#include "tests/instances.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

/// 1 - 2 - 3 along x, each comes off its successor by going on along +x; two robots, sites at 1 and
/// 2 m.
ProblemSpec row() {
  ProblemSpec spec = instances::assembly(3, {{1, 2}, {2, 3}});
  for (Connection& connection : spec.connections) connection.axis = "+x";
  spec.fleet = Fleet{.robots = 3, .depot = {0, 0}, .sites = {{1, 0}, {2, 0}}};
  spec.objective = Objective::named("makespan");
  return spec;
}

std::string fault(const ProblemSpec& spec) {
  const Problem problem(spec);
  return fault_of([&] { return FleetProblem(problem); });
}

TEST(FleetProblem, SaysInASentenceWhatIsMissing) {
  ProblemSpec spec = row();
  spec.fleet.reset();
  spec.objective = Objective();
  EXPECT_EQ(fault(spec),
            "fleet: the problem has no \"fleet\", which a method for several robots needs: the "
            "number of robots, "
            "the depot and the sites");
  spec = row();
  spec.fleet->sites.clear();
  EXPECT_EQ(fault(spec),
            "fleet.sites: there is no site; the product needs at least one to stand on");
  spec = row();
  spec.connections[1].axis.clear();
  EXPECT_EQ(fault(spec),
            "connections[1].axis: connection \"2-3\" has no axis; in a fleet problem each needs "
            "the direction in "
            "which its first part comes off its second, +x, -x, +y, -y, +z or -z");
  spec = row();
  spec.connections[0].success = 0.5;
  EXPECT_EQ(fault(spec),
            "connections[0].success: an attempt at connection \"1-2\" may fail; methods for fleets "
            "plan for "
            "attempts that always succeed");
  spec = row();
  spec.direction = Direction::Assembly;
  EXPECT_EQ(fault(spec),
            "direction: \"assembly\" is not allowed in a fleet problem, which is stated for "
            "disassembly; its plan "
            "read backwards assembles");
  spec = row();
  spec.connections[1].parts = {"3", "3"};
  EXPECT_EQ(
      fault(spec),
      "connections[1]: connection \"3-3\" joins part \"3\" to itself; no robots can pull it apart");
}

TEST(FleetProblem, KnowsWhatPullsAConnectionApart) {
  const Problem problem(row());
  const FleetProblem fleet(problem);
  const Motion plus = motion_along(0);
  const Motion minus = motion_along(1);
  const Motion aside = motion_along(2);
  EXPECT_TRUE(fleet.pulls_apart(0, plus, kStay));
  EXPECT_TRUE(fleet.pulls_apart(0, plus, minus));
  EXPECT_TRUE(fleet.pulls_apart(0, kStay, minus));
  EXPECT_FALSE(fleet.pulls_apart(0, kStay, plus));
  EXPECT_FALSE(fleet.pulls_apart(0, minus, kStay));
  EXPECT_FALSE(fleet.pulls_apart(0, plus, plus));
  EXPECT_FALSE(fleet.pulls_apart(0, plus, aside));
  EXPECT_FALSE(fleet.pulls_apart(0, aside, kStay));
}

TEST(FleetProblem, SeesWithoutSearchThatThereIsNoPlan) {
  ProblemSpec spec = instances::assembly(4, {{1, 2}, {3, 4}});
  for (Connection& connection : spec.connections) connection.axis = "+x";
  spec.fleet = Fleet{.robots = 4, .depot = {0, 0}, .sites = {{1, 0}}};
  spec.objective = Objective::named("makespan");
  const Problem crowded(spec);
  EXPECT_TRUE(FleetProblem(crowded).infeasibility().has_value());
  spec.fleet->sites.push_back({2, 0});
  const Problem fits(spec);
  EXPECT_FALSE(FleetProblem(fits).infeasibility().has_value());
  spec.limits.max_subassemblies = 1;
  const Problem limited(spec);
  EXPECT_TRUE(FleetProblem(limited).infeasibility().has_value());
  spec = row();
  spec.fleet->robots = 1;
  const Problem alone(spec);
  EXPECT_TRUE(FleetProblem(alone).infeasibility().has_value());
}

/// Part 1 leaves along +x, part 3 along -x, part 2 stays and is held too, since it leaves for the
/// depot: 3 robots, three times the 1 m^2 from site 1.
FleetPlan all_at_once(const FleetProblem& fleet) {
  const std::vector<PlaceIndex> start = {1, 1, 1};
  FleetState state = fleet_start(fleet, start);
  FleetPlan plan{.start = start, .steps = {}};
  plan.steps.push_back(fleet_step(fleet, state,
                                  std::vector<Motion>{motion_along(0), kStay, motion_along(1)},
                                  std::vector<PlaceIndex>{kDepot, kDepot, kDepot}));
  EXPECT_TRUE(state.open.empty());
  return plan;
}

TEST(FleetStep, CutsWhatMovesApartAndGivesEachHeldPartARobot) {
  const Problem problem(row());
  const FleetProblem fleet(problem);
  const FleetPlan plan = all_at_once(fleet);
  const FleetStep& step = plan.steps.front();
  EXPECT_EQ(step.cut, (std::vector<ConnectionIndex>{0, 1}));
  ASSERT_EQ(step.moves.size(), 3U);
  EXPECT_EQ(step.moves[1].motion, kStay);
  EXPECT_EQ(step.moves[2].robots, std::vector<std::size_t>{3});
  EXPECT_EQ(step.robots_used, 3U);
  EXPECT_EQ(plan.travel(), 3);
  EXPECT_TRUE(evaluate(fleet, plan).valid);
  EXPECT_EQ(evaluate(fleet, plan).travel, 3);
}

/// The rules that `plan` breaks, by name, each once.
std::vector<std::string> broken(const FleetProblem& fleet, const FleetPlan& plan) {
  std::vector<std::string> names;
  for (const FleetViolation& violation : evaluate(fleet, plan).violations) {
    const std::string name(rule_name(violation.rule));
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  return names;
}

TEST(FleetValidate, NamesEachBrokenRule) {
  using Names = std::vector<std::string>;
  const Problem problem(row());
  const FleetProblem fleet(problem);
  const FleetPlan good = all_at_once(fleet);

  FleetPlan plan = good;
  plan.steps[0].cut = {0};
  EXPECT_EQ(broken(fleet, plan), (Names{"motion", "places", "end"}));
  plan = good;
  plan.steps[0].moves[0].motion = motion_along(2);
  EXPECT_EQ(broken(fleet, plan), Names{"cut"});
  plan = good;
  plan.steps[0].moves[0].robots = {2};
  EXPECT_EQ(broken(fleet, plan), Names{"robots"});
  plan.steps[0].moves[0].robots = {4};
  EXPECT_EQ(broken(fleet, plan), Names{"robots"});
  plan.steps[0].moves[0].robots = {};
  EXPECT_EQ(broken(fleet, plan), Names{"robots"});
  plan = good;
  plan.steps[0].moves[0].distance = 2;
  EXPECT_EQ(broken(fleet, plan), Names{"distance"});
  plan = good;
  plan.steps[0].moves[0].from = 2;
  plan.steps[0].moves[0].distance = 4;
  EXPECT_EQ(broken(fleet, plan), Names{"places"});
  plan = good;
  plan.steps.push_back(good.steps[0]);
  EXPECT_EQ(broken(fleet, plan), (Names{"places", "cut"}));
  plan = good;
  plan.start = {1, 1, 2};
  EXPECT_EQ(broken(fleet, plan), Names{"places"});
  plan = good;
  plan.steps.clear();
  EXPECT_EQ(broken(fleet, plan), Names{"end"});

  // Parts 1 and 2 stay together at site 1 and cannot go to site 2 without moving.
  plan = good;
  plan.steps[0].cut = {1};
  plan.steps[0].moves = {
      {.parts = {0, 1}, .robots = {1, 2}, .from = 1, .to = 2, .motion = kStay, .distance = 2},
      good.steps[0].moves[2]};
  EXPECT_EQ(broken(fleet, plan), (Names{"motion", "end"}));

  ProblemSpec spec = row();
  spec.precedence = {{.connection = "1-2", .after = {"2-3"}, .after_any = {}}};
  const Problem ordered(spec);
  EXPECT_EQ(broken(FleetProblem(ordered), good), Names{"precedence"});
  spec = row();
  spec.blocking = Blocking{.directions = {"+x", "-x"},
                           .blocked = {{.part = "1", .by = "3", .directions = {"+x"}}}};
  const Problem blocked(spec);
  EXPECT_EQ(broken(FleetProblem(blocked), good), Names{"blocking"});
  spec = row();
  spec.limits.max_moved_mass = 0.5;
  const Problem heavy(spec);
  EXPECT_EQ(broken(FleetProblem(heavy), good), Names{"max_moved_mass"});
  spec.limits = {.max_subassemblies = 0, .max_moved_parts = 0, .max_moved_mass = {}};
  const Problem limited(spec);
  EXPECT_EQ(broken(FleetProblem(limited), good), (Names{"max_subassemblies", "max_moved_parts"}));
}

// Every step that the oracle allows, and random ones that it may not, from states of random
// problems: the checker must say the same of a plan of this one step more.
TEST(FleetValidate, AgreesWithTheOracleOnSingleSteps) {
  std::size_t legal_steps = 0;
  std::size_t illegal_steps = 0;
  for (std::uint64_t seed = 0; seed < some_of(150U); ++seed) {
    const ProblemSpec spec = fleet_oracle::random_fleet(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const FleetProblem fleet(problem);
    const fleet_oracle::World world(spec);
    const std::vector<fleet_oracle::State> starts = world.starts();
    if (starts.empty()) continue;
    SplitMix64 random(seed);
    for (int round = 0; round < 40; ++round) {
      const fleet_oracle::State& start = starts[random.below(starts.size())];
      std::vector<int> motion(problem.num_parts(), 0);
      std::vector<int> place(problem.num_parts(), 0);
      const int common = static_cast<int>(random.below(7));
      for (std::size_t part = 0; part < motion.size(); ++part) {
        motion[part] = random.below(2) == 0 ? common : static_cast<int>(random.below(7));
        place[part] = random.below(3) == 0
                          ? start.place[part]
                          : static_cast<int>(random.below(spec.fleet->sites.size() + 1));
      }
      const std::vector<PlaceIndex> start_places(start.place.begin(), start.place.end());
      // A move for each part, since these may be places that no block could go to.
      FleetStep step;
      for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
        const auto [i, j] = problem.ends(c);
        if (motion[i] != motion[j]) step.cut.push_back(c);
      }
      for (PartIndex part = 0; part < motion.size(); ++part) {
        if (motion[part] == 0 && place[part] == start.place[part]) continue;
        const auto from = static_cast<PlaceIndex>(start.place[part]);
        const auto to = static_cast<PlaceIndex>(place[part]);
        step.moves.push_back({.parts = {part},
                              .robots = {++step.robots_used},
                              .from = from,
                              .to = to,
                              .motion = static_cast<Motion>(motion[part]),
                              .distance = fleet.squared_distance(from, to)});
      }
      const FleetPlan plan{.start = start_places, .steps = {step}};
      const auto after = world.after(start, motion, place);
      const FleetEvaluation evaluation = evaluate(fleet, plan);
      const bool valid = std::ranges::all_of(
          evaluation.violations,
          [](const FleetViolation& violation) { return violation.rule == FleetRule::End; });
      ASSERT_EQ(valid, after.has_value());
      ++(valid ? legal_steps : illegal_steps);
      if (after) {
        FleetState state = fleet_start(fleet, start_places);
        const std::vector<Motion> motions(motion.begin(), motion.end());
        const std::vector<PlaceIndex> places(place.begin(), place.end());
        EXPECT_EQ(fleet_step(fleet, state, motions, places).cut, step.cut);
        EXPECT_EQ(state.places, places);
        for (ConnectionIndex c = 0; c < problem.num_connections(); ++c)
          EXPECT_EQ(after->open[c], state.open.contains(c));
      }
    }
  }
  EXPECT_GE(legal_steps, more_than(100U));
  EXPECT_GE(illegal_steps, more_than(1000U));
}

// One step from the start: the splits are those that the oracle reaches, and motions() makes each
// of them happen.
TEST(FleetExpander, ListsEveryWayOutOfAStepOnce) {
  ProblemSpec spec = row();
  const Problem problem(spec);
  const FleetProblem fleet(problem);
  FleetExpander<std::uint64_t> expander(fleet);
  ASSERT_EQ(expander.start(), std::vector<std::uint64_t>{0b111});
  std::vector<std::string> found;
  expander.for_each_split(
      0b111, 0, {.robots = 3, .held = 3}, [&](const FleetSplit<std::uint64_t>& split) {
        std::string text = std::to_string(split.stays) + "/" + std::to_string(split.freed);
        for (const std::uint64_t block : split.moved) text += "/" + std::to_string(block);
        found.push_back(text);
        std::vector<Motion> motions(3, kStay);
        EXPECT_TRUE(expander.motions(0b111, 0, split, motions));
        for (ConnectionIndex c = 0; c < 2; ++c)
          EXPECT_TRUE(motions[c] == motions[c + 1] ||
                      fleet.pulls_apart(c, motions[c], motions[c + 1]));
        return true;
      });
  std::ranges::sort(found);
  // Waiting; part 1 or part 3 off what stays; the pair that moves off a single part; the whole
  // moves; all come apart.
  EXPECT_EQ(found,
            (std::vector<std::string>{"0/0/7", "0/1/6", "0/4/3", "0/7", "3/4", "6/1", "7/0"}));
}

}  // namespace
}  // namespace orasp
