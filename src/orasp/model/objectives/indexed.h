#pragma once

namespace orasp {

class ObjectiveKind;

/// `indexed`: n - i if i < n - 1, else -1; n connections are present, i is the connection's index
/// in the file. No parameters.
struct Indexed {};

[[nodiscard]] const ObjectiveKind& indexed_kind();

}  // namespace orasp
