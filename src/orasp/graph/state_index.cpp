#include "orasp/graph/state_index.h"

#include <algorithm>
#include <bit>

namespace orasp {

StateIndex::StateIndex(const StateGraph& graph)
    : states_(graph.states()),
      words_(graph.system().words()),
      mask_(std::bit_ceil(2 * graph.num_states()) - 1) {
  slots_.resize(mask_ + 1);
  std::ranges::fill(slots_.span(), kEmpty);
  const auto fill = [this](const auto& hash_of) {
    const std::size_t states = states_.size() / words_;
    for (std::size_t s = 0; s < states; ++s) {
      std::size_t i = hash_of(s) & mask_;
      while (slots_[i] != kEmpty) i = (i + 1) & mask_;
      slots_[i] = static_cast<StateId>(s);
    }
  };
  if (words_ == 1) {
    fill([this](std::size_t s) { return mixed(states_[s]); });
  } else {
    fill([this](std::size_t s) { return hash_value(states_.subspan(s * words_, words_)); });
  }
}

std::optional<StateId> StateIndex::find(SetView open) const {
  const auto probe = [this](std::uint64_t hash, const auto& matches) -> std::optional<StateId> {
    for (std::size_t i = hash & mask_; slots_[i] != kEmpty; i = (i + 1) & mask_) {
      if (matches(slots_[i])) return slots_[i];
    }
    return std::nullopt;
  };
  if (words_ == 1) {
    const std::uint64_t word = open.front();
    return probe(mixed(word), [this, word](StateId s) { return states_[s] == word; });
  }
  return probe(hash_value(open), [this, open](StateId s) {
    return std::ranges::equal(states_.subspan(s * words_, words_), open);
  });
}

}  // namespace orasp
