// Loads a built-in problem with an installed orasp and prints its name.
#include <iostream>

#include "orasp/orasp.h"

int main() {
  const orasp::Problem problem = orasp::load_scenario("hubble");
  static_cast<void>(problem);
  std::cout << "loaded hubble\n";
}
