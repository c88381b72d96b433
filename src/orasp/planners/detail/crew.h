#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace orasp::detail {

/// Several copies of a search that go on in step, on the same problem: each does a share of the
/// work that takes long, and all get what each has found. What a member decides must follow from
/// what all were told, and from nothing else: no clock of its own.
class Crew {
 public:
  Crew() = default;
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;
  virtual ~Crew() = default;

  [[nodiscard]] virtual std::size_t size() const = 0;
  /// Which member this is; 0 to size() - 1.
  [[nodiscard]] virtual std::size_t member() const = 0;
  /// What each member has, by member; all of them call it.
  [[nodiscard]] virtual std::vector<std::string> told_by_all(const std::string& mine) = 0;
};

}  // namespace orasp::detail
