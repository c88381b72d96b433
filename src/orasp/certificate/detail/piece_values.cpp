#include "orasp/certificate/detail/piece_values.h"

#include <algorithm>
#include <bit>
#include <optional>

#include "orasp/certificate/detail/outward.h"
#include "orasp/model/tolerance.h"

namespace orasp::detail {

PieceValues::PieceValues(const Problem& problem, const SizeRewards& rewards,
                         const std::vector<double>& sizes)
    : problem_(problem),
      rewards_(rewards),
      sizes_(sizes),
      limited_(problem.limits().max_subassemblies.has_value()),
      allowed_(problem.limits().max_subassemblies.value_or(0)) {
  if (!problem.uncertain()) return;
  around_.resize(problem.num_parts());
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    for (const PartIndex part : problem.ends(c)) around_[part].push_back(c);
  }
}

std::size_t PieceValues::useful(std::size_t allowed, std::size_t parts) const {
  if (!limited_) return 0;
  return std::min(allowed, static_cast<std::size_t>(std::bit_width(parts)) - 1);
}

PieceValues::Key PieceValues::key(Parts parts, std::size_t allowed) const {
  static_assert(kMaxParts < std::size_t{1} << 16U);
  Key key(parts.begin(), parts.end());
  key.push_back(static_cast<char16_t>(useful(allowed, parts.size())));
  return key;
}

void PieceValues::list(Parts parts, std::size_t allowed, double value) {
  listed_.emplace(key(parts, allowed), value);
}

double PieceValues::of(Parts parts, std::size_t allowed) const {
  if (parts.size() < 2) return 0;
  if (limited_ && allowed == 0) return -kInfinity;
  const double by_size = sizes_[parts.size()];
  const auto found = listed_.find(key(parts, allowed));
  return found == listed_.end() ? by_size : std::min(found->second, by_size);
}

std::vector<PieceValues::Halves> PieceValues::halves(std::size_t a, std::size_t b,
                                                     std::size_t allowed) const {
  if (!limited_) return {{0, 0}};
  if (a < 2 || b < 2) return {{allowed, allowed}};
  if (allowed < 2) return {};
  return {{allowed, allowed - 1}, {allowed - 1, allowed}};
}

double PieceValues::of_both(Parts a, Parts b, std::size_t allowed) const {
  double most = -kInfinity;
  for (const Halves& half : halves(a.size(), b.size(), allowed))
    most = std::max(most, add_up(of(a, half.a), of(b, half.b)));
  return most;
}

double PieceValues::cut(std::size_t a, std::size_t b) const {
  return std::max(rewards_.cut(a, b), rewards_.cut(b, a));
}

double PieceValues::cut(Parts a, Parts b) const {
  if (around_.empty()) return cut(a.size(), b.size());
  std::optional<Attempts> attempts;
  for (const PartIndex part : a) {
    for (const ConnectionIndex c : around_[part]) {
      const auto [one, other] = problem_.ends(c);
      if (!std::ranges::binary_search(b, one == part ? other : one)) continue;
      const Attempts here = attempts_at(problem_, c);
      attempts = attempts ? united(*attempts, here) : here;
    }
  }
  if (!attempts) return cut(a.size(), b.size());
  return std::max(rewards_.cut(a.size(), b.size(), *attempts),
                  rewards_.cut(b.size(), a.size(), *attempts));
}

std::vector<bool> PieceValues::sizes_above(std::size_t parts, double value) const {
  std::vector<bool> above(parts / 2 + 1, false);
  for (std::size_t a = 1; a <= parts / 2; ++a) {
    const double both = add_up(sizes_[a], sizes_[parts - a]);
    above[a] = add_up(cut(a, parts - a), both) > value;
  }
  return above;
}

}  // namespace orasp::detail
