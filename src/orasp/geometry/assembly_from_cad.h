#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "orasp/geometry/blocking.h"
#include "orasp/geometry/cad_parts.h"
#include "orasp/geometry/contacts.h"
#include "orasp/model/problem.h"
#include "orasp/task/budget.h"

namespace orasp {

/// Which directions blocking looks at.
enum class ImportDirections {
  Axes,      ///< the six axes
  Geometry,  ///< and those that the faces suggest: normals of planes, axes of cylinders and cones
};

/// How a model becomes a problem.
struct ImportSettings {
  double tolerance = 0.1;  ///< mm
  Densities densities;
  std::string exclude;   ///< parts to leave out, as parts_listed() reads them
  std::string flexible;  ///< parts that block nothing and that nothing blocks, such as belts
  /// Parts that are fixed. Empty: of each group the part with most connections, if all others come
  /// off it one by one; "none": none.
  std::string base;
  ImportDirections directions = ImportDirections::Axes;
  StepKind action = StepKind::Part;
  /// Seconds that it takes to open a connection, by Contact::Kind.
  std::array<double, 3> durations{0, 5, 10};
  unsigned threads = 1;                           ///< the answer is the same for any number
  std::stop_token stop;                           ///< a stopped import throws Interrupted
  std::function<void(const Progress&)> progress;  ///< told which phase begins; may be empty
};

/// What an overlap of two parts in the drawing is taken for.
enum class OverlapVerdict {
  Thread,    ///< a screw or nut in its thread
  PressFit,  ///< a ring or a flank that is drawn a little too large
  Drawing,   ///< faces that only touch are drawn over each other: a fault, most likely
  Inside,    ///< more than a fifth of the smaller part lies inside of the other
};

struct ImportedOverlap {
  std::size_t contact = 0;  ///< position in ImportedAssembly::contacts
  OverlapVerdict verdict = OverlapVerdict::PressFit;
};

/// Two parts that block each other along every direction.
struct LockedPair {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  bool joined = false;  ///< by a connection of their own
};

/// A product as a problem, and all that is known of where it comes from. Positions of parts are
/// those in `parts`, `model.parts` and `problem.parts`, which are the same.
struct ImportedAssembly {
  ProblemSpec problem;
  CadModel model;  ///< without the parts that were left out
  std::vector<CadPartFacts> parts;
  std::vector<Contact> contacts;  ///< one for each connection
  /// One of each pair of opposites: x, y, z, then the named ones.
  std::vector<Vector3> directions;
  std::vector<std::string> direction_ids;  ///< "+x", "+y", "+z", "d1", ...
  /// Along `directions`; those along their opposites are the same facts with the parts exchanged.
  std::vector<BlockingFact> facts;
  std::vector<bool> flexible;  ///< by part

  std::vector<ImportedOverlap> overlaps;
  std::vector<LockedPair> locked;
  std::vector<std::size_t> near_facts;  ///< facts that are little wider than the tolerance allows
  std::vector<std::uint32_t> base;
  bool base_chosen = false;  ///< and not named by the user
  std::size_t moved = 1;     ///< parts that must move at once somewhere; 1: all come off one by one
  bool moved_hang_together = true;  ///< each set that must move at once
  /// Parts of one piece that no order of straight motions takes apart; sorted.
  std::vector<std::vector<std::uint32_t>> stuck;
  std::vector<std::vector<std::uint32_t>> groups;  ///< that no connection joins; largest first
  std::vector<std::string> questions;  ///< what only the user can answer, each a sentence
  std::vector<std::string> warnings;   ///< what was left out or assumed, each a sentence
};

/// Makes a problem of a model: unique ids, masses, connections where parts touch, and what blocks
/// what. The same model and settings give the same bytes.
///
/// Guarantee.  Facts are those of find_blocking() at the tolerance; see there.
/// @throws InputError with one sentence; Interrupted.
[[nodiscard]] ImportedAssembly assembly_from_cad(CadModel model, const ImportSettings& settings);

/// The facts of `part` and `by` along all directions, opposites included: id of the direction, and
/// the fact. In the order of the directions.
struct DirectedFact {
  std::string direction;
  const BlockingFact* fact;
};
struct PairFacts {
  std::uint32_t part = 0;
  std::uint32_t by = 0;  ///< greater than `part`
  std::vector<DirectedFact> facts;
};
/// All pairs with a fact, sorted.
[[nodiscard]] std::vector<PairFacts> facts_by_pair(const ImportedAssembly& assembly);

}  // namespace orasp
