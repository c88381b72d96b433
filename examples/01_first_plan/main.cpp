// 01: a first plan. Describes a small product by hand, asks for the best order in which to take it
// apart, and prints the order with its proof.
//
// The product is a box with a lid that holds a battery. The lid is screwed on, so the battery can
// only come out after the lid.
#include <iostream>
#include <string>
#include <utility>

#include "orasp/orasp.h"

namespace {

orasp::Part part(const std::string& id, double mass) {
  orasp::Part part;
  part.id = id;
  part.mass = mass;  // kg
  return part;
}

orasp::Connection connection(const std::string& id, const std::string& first,
                             const std::string& second, double seconds) {
  orasp::Connection connection;
  connection.id = id;
  connection.parts = {first, second};
  connection.duration = seconds;
  return connection;
}

}  // namespace

int main() {
  // What a problem file would say: parts, what joins them, what must come before what, and what
  // counts. Here each step costs the seconds that it takes, and one more where a piece is carried
  // away.
  orasp::ProblemSpec spec;
  spec.name = "Box";
  spec.parts = {part("box", 2.0), part("lid", 0.5), part("battery", 0.2), part("board", 0.1)};
  spec.connections = {
      connection("screws", "box", "lid", 20), connection("clip", "box", "battery", 5),
      connection("plug", "battery", "board", 3), connection("rails", "box", "board", 8)};
  orasp::Precedence lid_first;
  lid_first.connection = "clip";
  lid_first.after = {"screws"};
  spec.precedence = {lid_first};
  spec.objective = orasp::Objective::named("time");

  // The constructor checks everything. A mistake above would be an InputError that names its place.
  const orasp::Problem problem(std::move(spec));

  // "auto" picks a method that suits the problem. The status says what was proved.
  const orasp::Result result = orasp::solve(problem, "auto");
  std::cout << problem.name() << ": " << orasp::status_name(result.status) << ", " << -result.reward
            << " s\n";
  for (const orasp::ConnectionIndex c : result.sequence)
    std::cout << "  " << problem.connection_id(c) << '\n';
  return result.status == orasp::Status::Optimal ? 0 : 1;
}
