#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

/// Every number of the paper, and of the code published with it, that `orasp paper` sets beside its
/// own. Nothing else is written down: what stands beside them is computed. Paper: Nagpal and Mehr,
/// "Optimal Robotic Assembly Sequence Planning (ORASP): A Sequential Decision-Making Approach";
/// code: github.com/labicon/ORASP-Code.
namespace orasp::cli::printed {

/// Table I: seconds, in Python on an AMD Ryzen 9 5900X.
struct Time {
  std::string_view problem;  ///< our name for it
  std::string_view method;
  double seconds;
};
inline constexpr std::array<Time, 20> kTimes = {{
    {"4brick", "orasp-search", 0.001000},
    {"4brick", "value-iteration", 0.002939},
    {"4brick", "dijkstra", 0.001997},
    {"4brick", "bellman-ford", 0.001997},
    {"2x3", "orasp-search", 0.023030},
    {"2x3", "value-iteration", 0.070786},
    {"2x3", "dijkstra", 0.069553},
    {"2x3", "bellman-ford", 0.070827},
    {"lattice", "orasp-search", 0.472041},
    {"lattice", "value-iteration", 1.354401},
    {"lattice", "dijkstra", 1.322265},
    {"lattice", "bellman-ford", 1.345777},
    {"hubble", "orasp-search", 6.284114},
    {"hubble", "value-iteration", 108.454639},
    {"hubble", "dijkstra", 107.847125},
    {"hubble", "bellman-ford", 107.877225},
    {"table-hemnes", "orasp-search", 0.024000},
    {"table-hemnes", "value-iteration", 0.143997},
    {"table-hemnes", "dijkstra", 0.139000},
    {"table-hemnes", "bellman-ford", 0.138998},
}};

/// Table I, column "State of the Art (ILP)": seconds, in Julia with CPLEX on 8 virtual CPUs, for
/// several robots.
struct IlpTime {
  std::string_view problem;
  std::string_view objective;  ///< as the paper calls it
  double seconds;
  /// Our name for that problem of several robots; empty: there is no file of it.
  std::string_view fleet;
  std::string_view fleet_objective;  ///< our name for the objective
  std::string_view steps;            ///< horizon of the published program, in moves; empty: none
};
inline constexpr std::array<IlpTime, 6> kIlpTimes = {{
    {"4brick", "min-time", 0.46, "", "", ""},
    {"2x3", "min-time", 1.32, "", "", ""},
    {"lattice", "min-time", 4, "fleet-lattice", "makespan", ""},
    {"lattice", "min-travel", 5800, "fleet-lattice", "fleet_travel", "5"},
    {"hubble", "min-time", 5000, "fleet-hubble", "makespan", ""},
    {"hubble", "min-travel", 20000, "fleet-hubble", "fleet_travel", "5"},
}};

/// Figures 1, 2 and 5: (parts, connections).
struct Structure {
  std::string_view problem;
  std::string_view label;
  std::size_t parts;
  std::size_t connections;
};
inline constexpr std::array<Structure, 7> kStructures = {{
    {"4brick", "4Brick", 4, 3},
    {"2x3", "2x3", 6, 7},
    {"lattice", "Lattice", 9, 12},
    {"hubble", "Hubble", 20, 19},
    {"iss", "ISS", 32, 31},
    {"jwst", "JWST", 180, 256},
    {"table-hemnes", "IKEA Table", 9, 8},
}};

/// Sizes of H that the published notebook prints.
struct Size {
  std::string_view problem;
  std::uint64_t states;
  std::uint64_t actions;
};
inline constexpr std::array<Size, 2> kSizes = {{
    {"lattice", 1296, 6048},
    {"hubble", 12096, 67824},
}};

/// What the published learning reports for its best plan, what the best of the plans stored with it
/// earns when it is replayed, and the training: section "Reinforcement Learning Methods", and the
/// notebook.
struct Learned {
  std::string_view problem;
  double reported;
  double replayed;
  unsigned episodes;
  unsigned minutes;
};
inline constexpr std::array<Learned, 3> kLearned = {{
    {"hubble-upc", -1.127, -1.9118, 5000, 15},
    {"iss-upc", -2.81, -3.98, 5000, 15},
    {"jwst-upc", -22.311, -23.9, 20000, 35},
}};

}  // namespace orasp::cli::printed
