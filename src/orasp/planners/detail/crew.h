#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace orasp::detail {

/// Several copies of a search that go on in step, on the same problem: each holds a share of the
/// states and does their work. What a member decides must follow from
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
  /// Gives each member what stands for it in `texts`; returns what each, by member, has for this
  /// one.
  [[nodiscard]] virtual std::vector<std::string> exchange(std::vector<std::string> texts) = 0;
  /// Replaces each number by the sum, or the greatest, of what the members have there.
  virtual void take_sums(std::span<std::uint64_t> numbers) = 0;
  virtual void take_greatest(std::span<double> numbers) = 0;
};

}  // namespace orasp::detail
