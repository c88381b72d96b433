#include "orasp/io/problem_source.h"

#include <string>

#include <gtest/gtest.h>

#include "orasp/io/problem_json.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

template <class Call>
std::string fault_of(Call&& call) {
  try {
    (void)call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no fault";
}

TEST(ProblemSource, FindsScenariosAndSaysWhatWasMeant) {
  EXPECT_EQ(problem_digest(find_problem("hubble")), problem_digest(load_scenario("hubble")));
  EXPECT_EQ(fault_of([] { return find_problem("hubbel"); }),
            "no problem \"hubbel\": there is neither a file nor a built-in scenario of that name; "
            "did you mean \"hubble\"?");
  EXPECT_EQ(fault_of([] { return find_problem("no/such.json"); }),
            "no/such.json: No such file or directory");
}

TEST(ProblemSource, FindsObjectives) {
  EXPECT_EQ(find_objective("time").type, "time");
  EXPECT_EQ(find_objective("makespan").type, "makespan");
  EXPECT_NE(fault_of([] { return find_objective("tine"); }).find("did you mean \"time\"?"),
            std::string::npos);
  EXPECT_EQ(fault_of([] { return find_objective("no/such.json"); }),
            "cannot read \"no/such.json\": No such file or directory");
  EXPECT_EQ(find_direction("assembly"), Direction::Assembly);
  EXPECT_EQ(fault_of([] { return find_direction("up"); }),
            "unknown direction \"up\"; it is disassembly or assembly");
}

TEST(ProblemSource, EditsAProblem) {
  const Problem problem = load_scenario("fleet-lattice");
  const Problem fewer = edited(problem, {.robots = 2, .sites = 1});
  EXPECT_EQ(fewer.spec().fleet->robots, 2U);
  EXPECT_EQ(fewer.spec().fleet->sites.size(), 1U);
  const Problem alone = edited(problem, {.objective = find_objective("cubesat")});
  EXPECT_FALSE(alone.spec().fleet.has_value());
  EXPECT_EQ(fault_of([&] { return edited(problem, {.sites = 99}, "--"); }),
            "--sites: 99 is more than the 4 sites of the problem");
  EXPECT_EQ(fault_of([&] { return edited(alone, {.robots = 3}); }),
            "robots: the problem has no \"fleet\" to change");
  EXPECT_EQ(edited(alone, {.max_moved_parts = 2}).limits().max_moved_parts, 2U);
  EXPECT_FALSE(ProblemEdits().any());
}

}  // namespace
}  // namespace orasp
