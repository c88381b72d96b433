#include "orasp/model/problem.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/model/transition_system.h"
#include "tests/fault.h"

namespace orasp {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

///   1 - 2 - 3
///       |   |
///       4 - 5
ProblemSpec five_parts() {
  ProblemSpec spec;
  for (const char* id : {"1", "2", "3", "4", "5"}) spec.parts.emplace_back().id = id;
  for (const auto& [a, b] : std::vector<std::pair<const char*, const char*>>{
           {"1", "2"}, {"2", "3"}, {"2", "4"}, {"3", "5"}, {"4", "5"}}) {
    spec.connections.emplace_back().parts = {a, b};
  }
  return spec;
}

/// The fault of five_parts() after `change`.
std::string fault_with(const std::function<void(ProblemSpec&)>& change) {
  ProblemSpec spec = five_parts();
  change(spec);
  return fault_of([&] { return Problem(spec); });
}

std::string fault_of_objective(Objective objective) {
  return fault_with([&](ProblemSpec& spec) { spec.objective = std::move(objective); });
}

TEST(Problem, IndexesPartsAndConnectionsInTheOrderGiven) {
  const Problem problem(five_parts());
  EXPECT_EQ(problem.num_parts(), 5U);
  EXPECT_EQ(problem.num_connections(), 5U);
  EXPECT_EQ(problem.part_id(3), "4");
  EXPECT_EQ(problem.ends(3), (std::array<PartIndex, 2>{2, 4}));
  EXPECT_EQ(problem.find_part("5", ""), 4U);
  EXPECT_EQ(problem.find_connection("2-4", ""), 2U);
  EXPECT_TRUE(problem.warnings().empty());
}

TEST(Problem, FillsInTheDefaultIdOfAConnection) {
  ProblemSpec spec = five_parts();
  spec.connections[1].id = "hinge";
  const Problem problem(std::move(spec));
  EXPECT_EQ(problem.connection_id(0), "1-2");
  EXPECT_EQ(problem.connection_id(1), "hinge");
}

TEST(Problem, WithoutPartsIsAProblem) {
  EXPECT_EQ(Problem(ProblemSpec{}).num_parts(), 0U);
}

TEST(Problem, NamesAnUnknownPartAndThePartsThereAre) {
  const auto join_to_17 = [](ProblemSpec& spec) { spec.connections[3].parts[1] = "17"; };
  EXPECT_EQ(fault_with(join_to_17),
            "connections[3].parts[1]: no part \"17\"; parts are \"1\" to \"5\"");
  const auto with_parts = [&](std::size_t parts) {
    return fault_with([parts](ProblemSpec& spec) {
      spec.parts.resize(parts);
      spec.connections[0].parts[0] = "17";
    });
  };
  EXPECT_EQ(with_parts(3),
            "connections[0].parts[0]: no part \"17\"; parts are \"1\", \"2\" and \"3\"");
  EXPECT_EQ(with_parts(2), "connections[0].parts[0]: no part \"17\"; parts are \"1\" and \"2\"");
  EXPECT_EQ(with_parts(1), "connections[0].parts[0]: no part \"17\"; the only part is \"1\"");
  EXPECT_EQ(with_parts(0), "connections[0].parts[0]: no part \"17\"; there are no parts");
}

TEST(Problem, NamesBothPlacesOfADuplicateId) {
  EXPECT_EQ(fault_with([](ProblemSpec& spec) { spec.parts[4].id = "2"; }),
            "parts[4].id: \"2\" is the id of parts[1] too");
  EXPECT_EQ(fault_with([](ProblemSpec& spec) { spec.connections[4].id = "1-2"; }),
            "connections[4].id: \"1-2\" is the id of connections[0] too");
  EXPECT_EQ(fault_with([](ProblemSpec& spec) {
              spec.connections[2].parts = {"1", "2"};
            }),
            "connections[2]: its default id \"1-2\" is the id of connections[0] too; give it an "
            "\"id\"");
}

TEST(Problem, RefusesIdsThatAPlanCouldNotCarry) {
  const auto with_id = [](const std::string& id) {
    return fault_with([&](ProblemSpec& spec) { spec.parts[0].id = id; });
  };
  EXPECT_EQ(with_id(""), "parts[0].id: an id must not be empty");
  EXPECT_EQ(with_id("a\nb"),
            "parts[0].id: \"a\\x0ab\" is not an id; ids hold no control characters");
  EXPECT_EQ(with_id("a "),
            "parts[0].id: \"a \" is not an id; ids do not begin or end with a space");
  EXPECT_EQ(with_id("\xff"), "parts[0].id: \"\\xff\" is not valid UTF-8");
}

TEST(Problem, RefusesNumbersOutOfRange) {
  const auto with_mass = [](double mass) {
    return fault_with([mass](ProblemSpec& spec) { spec.parts[2].mass = mass; });
  };
  EXPECT_EQ(with_mass(-1), "parts[2].mass: -1 is not allowed; it must be 0 or more");
  EXPECT_EQ(with_mass(kNan), "parts[2].mass: NaN is not a finite number");
  EXPECT_EQ(with_mass(kInfinity), "parts[2].mass: infinity is not a finite number");
  EXPECT_EQ(with_mass(0), "no fault");
  EXPECT_EQ(fault_with([](ProblemSpec& spec) {
              spec.parts[1].position = {0, kNan, 0};
            }),
            "parts[1].position[1]: NaN is not a finite number");
  EXPECT_EQ(fault_with([](ProblemSpec& spec) { spec.connections[1].duration = -0.5; }),
            "connections[1].duration: -0.5 is not allowed; it must be 0 or more");
  for (const double success : {0.0, -0.5, 1.5, kNan}) {
    EXPECT_NE(fault_with([=](ProblemSpec& spec) {
                spec.connections[1].success = success;
              }).find("connections[1].success: "),
              std::string::npos)
        << success;
  }
  EXPECT_EQ(fault_with([](ProblemSpec& spec) { spec.connections[1].success = 1; }), "no fault");
  EXPECT_EQ(fault_with([](ProblemSpec& spec) { spec.limits.max_moved_mass = -2; }),
            "limits.max_moved_mass: -2 is not allowed; it must be 0 or more");
  EXPECT_EQ(
      fault_with([](ProblemSpec& spec) { spec.connections[0].axis = "up"; }),
      "connections[0].axis: \"up\" is not a direction; directions are +x, -x, +y, -y, +z and -z");
}

TEST(Problem, RefusesMoreThanItCanHold) {
  ProblemSpec spec;
  spec.parts.resize(kMaxParts + 1);
  EXPECT_EQ(fault_of([&] { return Problem(spec); }),
            "parts: more than 16384 parts, the most a problem may have");
  spec.parts.resize(1);
  spec.parts[0].id = "1";
  spec.connections.resize(kMaxConnections + 1);
  EXPECT_EQ(fault_of([&] { return Problem(spec); }),
            "connections: more than 16384 connections, the most a problem may have");
}

TEST(Problem, WarnsOfAConnectionOfAPartToItself) {
  ProblemSpec spec = five_parts();
  spec.connections.emplace_back().parts = {"4", "4"};
  const Problem problem(std::move(spec));
  EXPECT_EQ(problem.warnings(),
            std::vector<std::string>{
                "connection \"4-4\" joins part \"4\" to itself; removing it separates nothing"});
}

TEST(Problem, ChecksItsFleet) {
  ProblemSpec spec = five_parts();
  spec.fleet = Fleet{.robots = 4, .depot = {}, .sites = {}};
  EXPECT_EQ(
      fault_of([&] { return Problem(spec); }),
      "objective.type: \"cubesat\" judges plans of one robot, and a problem with \"fleet\" has "
      "an objective of several, makespan or fleet_travel; without \"fleet\" it is planned for "
      "one");
  spec.objective = Objective::named("makespan");
  spec.connections[1].duration = 2;
  EXPECT_EQ(fault_of([&] { return Problem(spec); }),
            "connections[1].duration: robots of a fleet work in steps, whose number and travel "
            "count; a duration would mean nothing, leave it out");
  spec.connections[1].duration = 1;
  EXPECT_TRUE(Problem(spec).warnings().empty());
  spec.fleet->robots = 0;
  EXPECT_EQ(fault_of([&] { return Problem(spec); }),
            "fleet.robots: 0 is not allowed; a fleet has at least 1 robot");
  spec.fleet = Fleet{.robots = 1, .depot = {}, .sites = {{0, 0}, {kInfinity, 0}}};
  EXPECT_EQ(fault_of([&] { return Problem(spec); }),
            "fleet.sites[1][0]: infinity is not a finite number");
}

TEST(Problem, SortsAndMergesTheListsOfPrecedence) {
  ProblemSpec spec = five_parts();
  spec.precedence = {{"1-2", {"4-5", "2-3", "4-5"}, {}}, {"2-3", {}, {"3-5", "2-4"}}};
  const Problem problem(std::move(spec));
  ASSERT_EQ(problem.precedence().size(), 2U);
  EXPECT_EQ(problem.precedence()[0].connection, 0U);
  EXPECT_EQ(problem.precedence()[0].after, (std::vector<ConnectionIndex>{1, 4}));
  EXPECT_EQ(problem.precedence()[1].after_any, (std::vector<ConnectionIndex>{2, 3}));
  EXPECT_EQ(problem.precedence()[1].entry, 1U);
}

TEST(Problem, NamesAnUnknownConnectionOfAPrecedence) {
  const auto with = [](Precedence rule) {
    return fault_with([&](ProblemSpec& spec) {
      spec.precedence = {{"1-2", {"2-3"}, {}}, std::move(rule)};
    });
  };
  EXPECT_EQ(with({"9-9", {}, {}}),
            "precedence[1].connection: no connection \"9-9\"; connections are \"1-2\" to \"4-5\"");
  EXPECT_EQ(with({"1-2", {"2-3", "x"}, {}}),
            "precedence[1].after[1]: no connection \"x\"; connections are \"1-2\" to \"4-5\"");
  EXPECT_EQ(with({"1-2", {}, {"x"}}),
            "precedence[1].after_any[0]: no connection \"x\"; connections are \"1-2\" to \"4-5\"");
}

TEST(Problem, LoadsACycleOfPrecedence) {
  const auto cycle = [](ProblemSpec& spec) {
    spec.precedence = {{"1-2", {"2-3"}, {}}, {"2-3", {"1-2"}, {}}, {"4-5", {"4-5"}, {}}};
  };
  EXPECT_EQ(fault_with(cycle), "no fault");
}

// Part 1 cannot leave 2 along +x: then 2 cannot leave 1 along -x. The second entry says the latter
// again, and that 2 cannot leave 1 along +y: then 1 cannot leave 2 along -y.
TEST(Problem, ClosesBlockingUnderAntisymmetryAndMergesEntries) {
  ProblemSpec spec = five_parts();
  spec.blocking =
      Blocking{.directions = {"+y", "-y", "-x", "+x"},
               .blocked = {{"1", "2", {"+x", "+x"}}, {"2", "1", {"-x", "+y"}}, {"3", "4", {}}}};
  const Problem problem(std::move(spec));
  EXPECT_EQ(problem.directions(), (std::vector<DirectionIndex>{2, 3, 1, 0}));
  EXPECT_EQ(problem.direction_mask(), 0b001111U);
  ASSERT_EQ(problem.blockers().size(), 5U);
  ASSERT_EQ(problem.blockers()[0].size(), 1U);
  EXPECT_EQ(problem.blockers()[0][0].by, 1U);
  EXPECT_EQ(problem.blockers()[0][0].directions, 0b001001);  // +x and -y
  ASSERT_EQ(problem.blockers()[1].size(), 1U);
  EXPECT_EQ(problem.blockers()[1][0].by, 0U);
  EXPECT_EQ(problem.blockers()[1][0].directions, 0b000110);  // -x and +y
  EXPECT_TRUE(problem.blockers()[2].empty());
}

TEST(Problem, HasNoDirectionsWithoutBlocking) {
  const Problem problem(five_parts());
  EXPECT_TRUE(problem.directions().empty());
  EXPECT_EQ(problem.direction_mask(), 0U);
  ASSERT_EQ(problem.blockers().size(), 5U);
  for (const std::vector<Blocker>& blockers : problem.blockers()) EXPECT_TRUE(blockers.empty());
}

TEST(Problem, RefusesDirectionsThatAreNotPairs) {
  const auto with = [](std::vector<BlockingDirection> directions,
                       std::vector<Blocked> blocked = {}) {
    return fault_with([&](ProblemSpec& spec) {
      spec.blocking = Blocking{.directions = directions, .blocked = blocked};
    });
  };
  EXPECT_EQ(with({}),
            "blocking.directions: at least one pair of directions is needed, or no part could ever "
            "leave another");
  EXPECT_EQ(with({"+x", "-x", "+z"}),
            "blocking.directions: \"+z\" is listed without its opposite \"-z\"");
  EXPECT_EQ(with({"+x", "-x", "-x"}), "blocking.directions[2]: \"-x\" is listed twice");
  EXPECT_EQ(with({"x"}),
            "blocking.directions[0]: \"x\" is not a direction; those without a vector are +x, -x, "
            "+y, -y, "
            "+z and -z");
  EXPECT_EQ(
      with({"+x", "-x"}, {{"1", "2", {"+x"}}, {"1", "2", {"-x", "+y"}}}),
      "blocking.blocked[1].directions[1]: \"+y\" is not in blocking.directions, which are +x, -x");
  EXPECT_EQ(with({"+x", "-x"}, {{"1", "1", {"+x"}}}),
            "blocking.blocked[0]: part \"1\" cannot be blocked by itself");
  EXPECT_EQ(with({"+x", "-x"}, {{"1", "8", {"+x"}}}),
            "blocking.blocked[0].by: no part \"8\"; parts are \"1\" to \"5\"");
}

TEST(Problem, NumbersNamedDirectionsByName) {
  ProblemSpec spec = five_parts();
  const Vector3 slant{3, 0, 4};
  spec.blocking = Blocking{{"+z", {"up", {0, 0, 2}}, "-z", {"a lid's", slant}},
                           {{"1", "2", {"up", "-a lid's"}}, {"2", "1", {"up"}}}};
  const Problem problem(std::move(spec));
  EXPECT_EQ(problem.directions(), (std::vector<DirectionIndex>{4, 8, 9, 5, 6, 7}));
  std::vector<std::string> names;
  for (const DirectionIndex d : problem.directions()) names.push_back(problem.direction_name(d));
  EXPECT_EQ(names, (std::vector<std::string>{"+z", "up", "-up", "-z", "a lid's", "-a lid's"}));
  EXPECT_EQ(problem.direction_vector(5), (Vector3{0, 0, -1}));
  EXPECT_EQ(problem.direction_vector(8), (Vector3{0, 0, 1}));
  EXPECT_NEAR(problem.direction_vector(7)[0], -0.6, 1e-15);
  EXPECT_NEAR(problem.direction_vector(7)[2], -0.8, 1e-15);
  EXPECT_EQ(problem.find_direction("-a lid's"), DirectionIndex(7));
  EXPECT_EQ(problem.find_direction("+x"), std::nullopt);
  EXPECT_EQ(problem.find_direction("lid"), std::nullopt);
  ASSERT_TRUE(problem.has_direction_masks());
  EXPECT_EQ(problem.blockers()[0][0].directions, 0b1110000000U);  // -a lid's, up, -up
  EXPECT_EQ(problem.blockers()[1][0].directions, 0b1101000000U);
}

TEST(Problem, ManyDirectionsAreHeldAsSets) {
  static_assert(sizeof(Blocker) == 8);
  ProblemSpec spec = five_parts();
  spec.blocking = Blocking{{"+x", "-x"}, {}};
  std::vector<std::string> odd;
  for (int i = 0; i < 100; ++i) {
    const std::string name = "d" + std::to_string(100 + i);
    spec.blocking->directions.push_back({name, Vector3{1, 0, static_cast<double>(i)}});
    if (i % 2 == 1) odd.push_back(name);
  }
  spec.blocking->blocked = {{"1", "2", odd},
                            {"2", "1", {"d100", "+x"}},
                            {"3", "4", odd},
                            {"3", "4", {"-d100"}},
                            {"4", "5", {}}};
  const Problem problem(std::move(spec));
  ASSERT_FALSE(problem.has_direction_masks());
  ASSERT_EQ(problem.direction_bits().size(), 4U);
  ASSERT_EQ(problem.blockers()[0].size(), 1U);
  const Blocker by_2 = problem.blockers()[0][0];
  const Blocker by_4 = problem.blockers()[2][0];
  EXPECT_NE(by_2.directions, by_4.directions);
  for (const DirectionIndex d : problem.directions()) {
    const std::string& name = problem.direction_name(d);
    const bool is_odd = std::ranges::find(odd, name) != odd.end();
    EXPECT_EQ(problem.blocks(by_2, d), is_odd || name == "-d100" || name == "-x") << name;
    EXPECT_EQ(problem.blocks(by_4, d), is_odd || name == "-d100") << name;
    EXPECT_EQ(problem.blocks(problem.blockers()[1][0], opposite(d)), problem.blocks(by_2, d));
  }
  std::vector<std::uint64_t> free(problem.direction_bits().begin(), problem.direction_bits().end());
  EXPECT_TRUE(problem.take_out(by_2, free));
  for (const DirectionIndex d : problem.directions())
    EXPECT_EQ((free[d / 64U] >> d % 64U & 1U) != 0, !problem.blocks(by_2, d));
  EXPECT_TRUE(problem.blockers()[3].size() == 1U && problem.blockers()[4].empty());
}

TEST(Problem, RefusesNamedDirections) {
  const auto with = [](std::vector<BlockingDirection> directions,
                       std::vector<Blocked> blocked = {}) {
    return fault_with([&](ProblemSpec& spec) {
      spec.blocking = Blocking{.directions = directions, .blocked = blocked};
    });
  };
  const Vector3 up{0, 0, 1};
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(with({{"a", up}}), "no fault");
  EXPECT_EQ(with({{"a", {1e-320, 0, 1e-320}}, {"b", {1e308, 1e308, 1e308}}}), "no fault");
  EXPECT_EQ(with({{"a", {0, -0.0, 0}}}),
            "blocking.directions[0].vector: a vector of length 0 points nowhere");
  EXPECT_EQ(with({{"a", {0, kInfinite, 0}}}),
            "blocking.directions[0].vector[1]: infinity is not a finite number");
  EXPECT_EQ(with({{"a", up}, {"b", up}, {"a", up}}),
            "blocking.directions[2].id: \"a\" is listed twice");
  EXPECT_EQ(with({{"a", up}, "-a"}),
            "blocking.directions[1]: \"-a\" is there already, as the opposite of \"a\"; leave it "
            "out");
  EXPECT_EQ(with({{"a", up}, "a"}), "blocking.directions[1]: \"a\" is listed twice");
  EXPECT_EQ(with({{"-x", up}}),
            "blocking.directions[0].id: \"-x\" is an axis and has no vector of its own; list it as "
            "\"-x\", without one");
  EXPECT_EQ(with({{"x", up}}),
            "blocking.directions[0].id: \"x\" is not the id of a direction, since its opposite "
            "would be the axis \"-x\"");
  EXPECT_EQ(with({{"", up}}), "blocking.directions[0].id: an id must not be empty");
  EXPECT_EQ(with({{"a ", up}}),
            "blocking.directions[0].id: \"a \" is not an id; ids do not begin or end with a space");
  for (const char* id : {"-a", "+a"})
    EXPECT_EQ(with({{"a", up}, {id, up}}),
              std::string("blocking.directions[1].id: \"") + id +
                  "\" begins with a sign; an id does not, and the opposite of \"a\" is there with "
                  "it, as \"-a\"");
  EXPECT_EQ(with({"+x", "-x", {"slant", up}}, {{"1", "2", {"slan"}}}),
            "blocking.blocked[0].directions[0]: \"slan\" is not in blocking.directions, which are "
            "+x, -x, slant, -slant; did you mean \"slant\"?");
  std::vector<BlockingDirection> many;
  for (int i = 0; i < 4096; ++i) many.emplace_back("d" + std::to_string(i), up);
  EXPECT_EQ(with(many), "no fault");
  EXPECT_EQ(with(many, {{"1", "2", {"e"}}}),
            "blocking.blocked[0].directions[0]: \"e\" is not in blocking.directions, which are d0, "
            "-d0, d1, -d1, d2, -d2, d3, -d3, d4, -d4, d5, -d5 and 8180 more");
  many.emplace_back("+x");
  many.emplace_back("-x");
  EXPECT_EQ(with(many),
            "blocking.directions: more than 4096 pairs of directions, the most a problem may have");
}

TEST(Problem, NeedsPositionsForTravel) {
  ProblemSpec spec = five_parts();
  spec.objective = Objective::named("travel");
  spec.parts[0].position = Vector3{};
  EXPECT_EQ(fault_of([&] { return Problem(spec); }),
            "objective: \"travel\" needs the position of every part, and part \"2\" has none");
  spec.objective = {"sum",
                    WeightedSum{{{1, Objective::named("time")}, {2, Objective::named("travel")}}}};
  EXPECT_EQ(
      fault_of([&] { return Problem(spec); }),
      "objective.terms[1]: \"travel\" needs the position of every part, and part \"2\" has none");
  for (Part& part : spec.parts) part.position = Vector3{};
  EXPECT_EQ(fault_of([&] { return Problem(spec); }), "no fault");
}

TEST(Problem, ChangesOneThingAndKeepsTheRest) {
  const Problem problem(five_parts());
  EXPECT_EQ(problem.with_direction(Direction::Assembly).direction(), Direction::Assembly);
  EXPECT_EQ(problem.with_objective(Objective::named("time")).objective().type, "time");
  EXPECT_EQ(
      problem.with_limits({.max_subassemblies = 2, .max_moved_parts = {}, .max_moved_mass = {}})
          .limits()
          .max_subassemblies,
      2U);
  EXPECT_EQ(problem.with_direction(Direction::Assembly).connection_id(4), "4-5");
  EXPECT_NE(fault_of([&] { return problem.with_objective(Objective::named("travel")); }),
            "no fault");
}

// The numbers of docs/format.md, section "Objectives".
TEST(Objective, HasTheNumbersOfTheFormatPage) {
  const auto cost = [](const char* type) {
    return std::get<PieceCost>(Objective::named(type).parameters);
  };
  const std::map<std::size_t, double> cubesat = {{1, 0.0967}, {2, 0.1248}, {3, 0.1368}};
  const std::map<std::size_t, double> custom = {{1, 1}, {2, 1.5}, {3, 1.75}};
  EXPECT_EQ(cost("cubesat").operation, 0);
  EXPECT_EQ(cost("cubesat").pieces, cubesat);
  EXPECT_EQ(cost("cubesat").completion, 1);
  EXPECT_EQ(cost("custom").operation, 0.1);
  EXPECT_EQ(cost("custom").pieces, custom);
  EXPECT_EQ(cost("custom").completion, 1);
  EXPECT_TRUE(cost("piece_cost").pieces.empty());
  const auto fuel = std::get<Fuel>(Objective::named("fuel").parameters);
  EXPECT_EQ(fuel.dry_mass, 6);
  EXPECT_EQ(fuel.delta_v, 30);
  EXPECT_EQ(fuel.isp, 200);
  const auto completion = std::get<CompletionObjective>(Objective::named("completion").parameters);
  EXPECT_EQ(completion.join, 100);
  EXPECT_EQ(completion.step, 1);
  EXPECT_EQ(completion.bonus, 1000);
  EXPECT_EQ(std::get<TimeObjective>(Objective::named("time").parameters).speed, 1);
  EXPECT_EQ(std::get<TimeObjective>(Objective::named("time").parameters).transfer, 1);
}

TEST(Objective, IsCubesatIfNothingIsSaid) {
  EXPECT_EQ(Objective{}.type, "cubesat");
  EXPECT_EQ(fault_of_objective(Objective{}), "no fault");
  EXPECT_EQ(ProblemSpec{}.objective.type, "cubesat");
}

TEST(Objective, NamesTheKnownTypesAndTheNearest) {
  EXPECT_EQ(
      fault_of([] { return Objective::named("cubsat"); }),
      "no objective \"cubsat\"; objectives are piece_cost, cubesat, cubesat_zone, custom, indexed, "
      "time, travel, fuel, completion, changeover, route, expression, sum, makespan, "
      "fleet_travel; did you mean "
      "\"cubesat\"?");
  EXPECT_EQ(fault_of([] { return Objective::named("expression"); }),
            "the objective \"expression\" needs a formula");
  EXPECT_EQ(fault_of([] { return Objective::named("sum"); }),
            "the objective \"sum\" needs its terms");
}

TEST(Objective, HasTheTypesOfTheTableInItsOrder) {
  const std::vector<std::string_view> one_robot(kObjectiveTypes.begin(), kObjectiveTypes.end());
  EXPECT_EQ(one_robot,
            (std::vector<std::string_view>{"piece_cost", "cubesat", "cubesat_zone", "custom",
                                           "indexed", "time", "travel", "fuel", "completion",
                                           "changeover", "route", "expression", "sum"}));
  EXPECT_EQ(kFileObjectiveTypes.size(), one_robot.size() + kFleetObjectiveTypes.size());
  for (const ObjectiveRow& row : kObjectiveRows) {
    SCOPED_TRACE(row.type);
    EXPECT_EQ(objective_row(row.type), &row);
    if (row.needs.empty()) {
      EXPECT_NO_THROW(check_objective(Objective::named(row.type), "objective"));
    }
  }
  EXPECT_EQ(objective_row("cubsat"), nullptr);
}

TEST(Objective, OfAFleetNeedsAFleetAndStandsInNoSum) {
  for (const std::string_view type : kFleetObjectiveTypes) {
    SCOPED_TRACE(type);
    EXPECT_TRUE(Objective::named(type).of_fleet());
    ProblemSpec spec = five_parts();
    spec.objective = Objective::named(type);
    EXPECT_EQ(fault_of([&] { return Problem(spec); }),
              "objective.type: \"" + std::string(type) +
                  "\" judges plans of several robots, and the problem has no \"fleet\"");
    spec.fleet = Fleet{};
    spec.fleet->robots = 2;
    EXPECT_EQ(fault_of([&] { return Problem(spec); }), "no fault");
    spec.objective = {"sum", WeightedSum{{{1, Objective{}}, {1, Objective::named(type)}}}};
    EXPECT_EQ(fault_of([&] { return Problem(spec); }),
              "objective.terms[1].type: \"" + std::string(type) +
                  "\" judges plans of several robots and cannot stand in a sum");
  }
  for (const std::string_view type : kObjectiveTypes) {
    if (!objective_row(type)->needs.empty()) continue;
    EXPECT_FALSE(Objective::named(type).of_fleet());
  }
}

TEST(Objective, RefusesATypeThatDoesNotFitItsParameters) {
  EXPECT_EQ(fault_of_objective({"time", Fuel{}}),
            "objective.type: \"time\" does not go with the objective's parameters");
  EXPECT_EQ(
      fault_of_objective({"cubesat", PieceCost{.operation = 2, .pieces = {}, .completion = 0}}),
      "objective: \"cubesat\" has fixed numbers and these parameters are others; use "
      "\"piece_cost\"");
}

TEST(Objective, RefusesNumbersOutOfRange) {
  EXPECT_EQ(fault_of_objective({"time", TimeObjective{.depot = {}, .speed = 0, .transfer = 1}}),
            "objective.speed: 0 is not allowed; it must be above 0");
  EXPECT_EQ(fault_of_objective({"time", TimeObjective{.depot = {}, .speed = 1, .transfer = -1}}),
            "objective.transfer: -1 is not allowed; it must be 0 or more");
  EXPECT_EQ(fault_of_objective({"fuel", Fuel{.dry_mass = 6, .delta_v = 30, .isp = 0}}),
            "objective.isp: 0 is not allowed; it must be above 0");
  EXPECT_EQ(fault_of_objective({"travel", Travel{.depot = {0, kNan, 0}}}),
            "objective.depot[1]: NaN is not a finite number");
  EXPECT_EQ(fault_of_objective(
                {"piece_cost", PieceCost{.operation = 0, .pieces = {{0, 1}}, .completion = 0}}),
            "objective.pieces: \"0\" is not a piece size; sizes are \"1\" to \"16384\"");
  EXPECT_EQ(fault_of_objective(
                {"piece_cost", PieceCost{.operation = 0, .pieces = {{2, kNan}}, .completion = 0}}),
            "objective.pieces.2: NaN is not a finite number");
  EXPECT_EQ(fault_of_objective({"sum", WeightedSum{{{kInfinity, Objective{}}}}}),
            "objective.terms[0].weight: infinity is not a finite number");
}

TEST(Objective, RefusesASumOfNothingAndSumsTooDeep) {
  EXPECT_EQ(fault_of_objective({"sum", WeightedSum{}}),
            "objective.terms: a sum needs at least one term");
  const auto nested = [](std::size_t depth) {
    Objective objective;
    for (std::size_t i = 0; i < depth; ++i) objective = {"sum", WeightedSum{{{1, objective}}}};
    return objective;
  };
  EXPECT_EQ(fault_of_objective(nested(kMaxSumDepth)), "no fault");
  EXPECT_NE(
      fault_of_objective(nested(kMaxSumDepth + 1)).find("sums stand in sums more than 16 deep"),
      std::string::npos);
}

TEST(Objective, ChecksTheNamesOfConstants) {
  class One final : public Formula {
   public:
    [[nodiscard]] double value(const FormulaVariables&) override { return 1; }
  };
  const auto with = [](std::map<std::string, double> constants) {
    return fault_of_objective(
        {"expression", Expression{.formula = "1",
                                  .constants = std::move(constants),
                                  .depot = {},
                                  .compiler = [](const auto&, const auto&, const auto&) {
                                    return std::make_unique<One>();
                                  }}});
  };
  EXPECT_EQ(with({{"rate", 2}}), "no fault");
  const std::string rule =
      " is not a name; names are up to 64 letters, digits and _, not a digit first";
  EXPECT_EQ(with({{"my rate", 2}}), "objective.constants: \"my rate\"" + rule);
  EXPECT_EQ(with({{"2x", 2}}), "objective.constants: \"2x\"" + rule);
  EXPECT_EQ(with({{"duration", 2}}),
            "objective.constants: \"duration\" is a variable of every formula; give the constant "
            "another name");
  EXPECT_EQ(with({{std::string(64, 'a'), 2}}), "no fault");
  EXPECT_NE(with({{std::string(65, 'a'), 2}}), "no fault");
  EXPECT_EQ(with({{"rate", kNan}}), "objective.constants.rate: NaN is not a finite number");
}

TEST(Objective, NeedsACompilerForAnExpression) {
  EXPECT_EQ(
      fault_of_objective(
          {"expression", Expression{.formula = "1", .constants = {}, .depot = {}, .compiler = {}}}),
      "objective.formula: no compiler is set; set Expression::compiler to compile_formula of "
      "io/formula_parser.h");
}

TEST(Objective, NeedsAFunctionForACallable) {
  EXPECT_EQ(fault_of_objective({"callable", Callable{}}),
            "objective.reward: the callable holds no function");
  Callable callable;
  callable.reward = [](const Step&) { return 0.0; };
  EXPECT_EQ(fault_of_objective({"callable", callable}), "no fault");
  callable.least = 2;
  callable.greatest = 1;
  EXPECT_EQ(fault_of_objective({"callable", callable}),
            "objective: least 2 and greatest 1 are not a range");
}

}  // namespace
}  // namespace orasp
