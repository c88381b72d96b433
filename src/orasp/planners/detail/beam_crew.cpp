// What a crew does in place of a search that is alone: its members share out states by their hash.

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "orasp/model/error.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/detail/beam_search.h"
#include "orasp/planners/detail/crew_cut.h"

namespace orasp::detail {

// A member whose machine lacks the module for it knows no symmetry: then none uses it.
bool BeamSearch::all_found_the_same(const std::optional<Symmetry>& symmetry) const {
  std::string mine;
  if (symmetry) {
    for (const Permutation& exchange : symmetry->generators()) {
      for (const auto image : exchange) mine += std::to_string(image) + ' ';
      mine += '\n';
    }
  }
  return std::ranges::all_of(crew_->told_by_all(mine),
                             [&](const std::string& told) { return told == mine; });
}

// The first member's plan, for all of the crew: it was improved against a clock.
void BeamSearch::take_plan_of_first() {
  std::string mine(sizeof(double), '\0');
  std::memcpy(mine.data(), &result_.reward, sizeof(double));
  mine += result_.has_plan() ? '+' : '-';
  for (const ConnectionIndex c : result_.sequence)
    mine.append(reinterpret_cast<const char*>(&c), sizeof c);
  const std::string first = crew_->told_by_all(mine).front();
  std::memcpy(&result_.reward, first.data(), sizeof(double));
  if (first[sizeof(double)] == '+' && !result_.has_plan()) result_.status = Status::Feasible;
  constexpr std::size_t kHead = sizeof(double) + 1;
  result_.sequence.resize((first.size() - kHead) / sizeof(ConnectionIndex));
  if (first.size() > kHead)
    std::memcpy(result_.sequence.data(), first.data() + kHead, first.size() - kHead);
}

// As expand_layer, of a layer of which each member of the crew holds the states that belong to
// it. The members go through the same rounds, in each of which they expand some of their states
// and send the successors to where they belong. What is kept depends on no order of arrival.
double BeamSearch::expand_layer_with_crew(std::size_t width, bool last) {
  double left_out = -kInfinity;
  survivors_.clear();
  arrived_.clear();
  slots_.assign(64, 0);
  at_most_ = 0;
  width_ = width;
  const std::size_t size = layer_.size();
  // Few enough states a round that what they lead to takes little beside the layer, and many
  // enough that rounds are few.
  constexpr std::size_t kMostBytes = std::size_t{64} << 20U;
  const std::size_t bytes_of_state = (sizeof(Record) + 8 * words_) * system_.num_connections();
  const std::size_t chunk = std::max<std::size_t>(
      1, std::min(kMostBytes / bytes_of_state, std::clamp<std::size_t>(width / 32, 128, 1024)));
  std::size_t begin = 0;
  for (std::uint64_t left = 1; left > 0;) {
    const std::size_t survivors_before = survivors_.size();
    const std::size_t end = std::min(size, begin + chunk);
    left = exchange_found(begin, end, last);
    begin = end;
    grew_by_ = survivors_.size() - survivors_before;
    if (result_.stop != Stop::None) return left_out;
    if (left > 0 && at_most_ > 2 * width) {
      if (width > kNarrow) count_survivors();
      if (at_most_ > 2 * width) left_out = std::max(left_out, cut_down_together(width));
    }
    poll();
  }
  if (at_most_ > width && width > kNarrow) count_survivors();
  if (at_most_ > width) left_out = std::max(left_out, cut_down_together(width));
  return left_out;
}

// One round: expands states, exchanges what was found, and takes over what belongs here. A stop
// or a fault of any member is one of all, at this place. Returns how many states all members
// still have to expand.
std::uint64_t BeamSearch::exchange_found(std::size_t begin, std::size_t end, bool last) {
  CrewHead head;
  head.stop = own_stop_;
  head.left = layer_.size() - end;
  std::string fault;
  std::size_t used = 0;
  if (head.stop == Stop::None) {
    try {
      used = expand(begin, end, last);
    } catch (const InputError& error) {
      fault = error.what();
      head.fault = true;
    }
  }
  for (std::size_t t = 0; t < used; ++t) {
    Worker& worker = workers_[t];
    head.expanded += worker.expanded;
    head.generated += worker.generated;
    head.pruned += worker.pruned;
    for (const std::string& found : worker.found_for) head.found += found.size();
    worker.expanded = worker.generated = worker.pruned = 0;
    if (head.stop == Stop::None) head.stop = worker.stop;
  }
  head.found /= sizeof(Record) + 8 * words_;
  std::vector<std::string> texts(crew_->size());
  exchanged_bytes_ = 0;
  for (std::size_t member = 0; member < texts.size(); ++member) {
    texts[member].assign(reinterpret_cast<const char*>(&head), sizeof head);
    for (std::size_t t = 0; t < used; ++t) {
      texts[member] += workers_[t].found_for[member];
      workers_[t].found_for[member].clear();
    }
    exchanged_bytes_ += texts[member].size();
  }
  texts = crew_->exchange(std::move(texts));
  std::uint64_t left = 0;
  bool any_fault = false;
  for (const std::string& text : texts) {
    std::memcpy(&head, text.data(), sizeof head);
    result_.statistics.expanded += head.expanded;
    result_.statistics.generated += head.generated;
    result_.statistics.pruned += head.pruned;
    if (result_.stop == Stop::None) result_.stop = head.stop;
    at_most_ += head.found;
    left += head.left;
    any_fault |= head.fault;
    exchanged_bytes_ += text.size();
  }
  if (any_fault) throw_first_fault(fault);
  if (result_.stop == Stop::None && result_.statistics.expanded >= budget_.max_expansions)
    result_.stop = Stop::ExpansionLimit;
  if (result_.stop != Stop::None) return left;
  for (std::size_t member = 0; member < texts.size(); ++member) take_over(member, texts[member]);
  return left;
}

void BeamSearch::append_record(Worker& worker, std::uint32_t parent, ConnectionIndex connection,
                               double reward, double rest) const {
  write_successor(state_of(layer_, parent), connection, worker.form, worker.next);
  const std::uint64_t parent_hash = layer_.hashes[parent];
  const Record record{.reward = reward,
                      .rest = rest,
                      .parent_promise = layer_.rewards[parent] + layer_.rests[parent],
                      .parent_hash = parent_hash,
                      .parent = parent,
                      .connection = connection};
  std::string& found = worker.found_for[member_of(worker.form ? hash_value(worker.next)
                                                              : parent_hash ^ mark_of(connection))];
  found.append(reinterpret_cast<const char*>(&record), sizeof record);
  found.append(reinterpret_cast<const char*>(worker.next.data()), 8 * words_);
}

// Takes over what `member` found of the states that belong here.
void BeamSearch::take_over(std::size_t member, const std::string& text) {
  for (std::size_t at = sizeof(CrewHead); at < text.size();) {
    Record record;
    std::memcpy(&record, text.data() + at, sizeof record);
    at += sizeof record;
    const auto slot = static_cast<std::uint32_t>(arrived_.origins.size());
    arrived_.states.resize(arrived_.states.size() + words_);
    std::uint64_t* const state = arrived_.states.data() + slot * words_;
    std::memcpy(state, text.data() + at, 8 * words_);
    at += 8 * words_;
    arrived_.origins.push_back({.parent = record.parent,
                                .member = static_cast<std::uint32_t>(member),
                                .promise = record.parent_promise,
                                .hash = record.parent_hash});
    const std::uint64_t hash = form_ ? hash_value(SetView(state, words_))
                                     : record.parent_hash ^ mark_of(record.connection);
    if (merge({record.reward + record.rest, record.reward, record.rest, hash, slot,
               record.connection}))
      continue;
    arrived_.states.resize(slot * words_);
    arrived_.origins.resize(slot);
  }
}

// Keeps the best `width` survivors of all members together, where there are more. Returns the
// greatest promise of those of this member that are left out.
double BeamSearch::cut_down_together(std::size_t width) {
  std::ranges::sort(survivors_,
                    [this](const Candidate& a, const Candidate& b) { return before(a, b); });
  const std::size_t kept = width > kNarrow ? kept_of_width(width) : kept_of_narrow(width);
  const double left_out = drop_from(kept);
  Arrived packed;
  packed.states.reserve(kept * words_);
  packed.origins.reserve(kept);
  for (Candidate& candidate : survivors_) {
    const SetView state = bits_of(candidate, one_);
    packed.states.insert(packed.states.end(), state.begin(), state.end());
    packed.origins.push_back(arrived_.origins[candidate.parent]);
    candidate.parent = static_cast<std::uint32_t>(packed.origins.size() - 1);
  }
  arrived_ = std::move(packed);
  index(slots_.size());
  at_most_ = std::min<std::uint64_t>(at_most_, width);
  return left_out;
}

// How many of this member's survivors, which are sorted, are among the best `width` of all, where
// there may be fewer: all tell their best ones. Sets at_most_.
std::size_t BeamSearch::kept_of_narrow(std::size_t width) {
  const std::size_t words = 2 + words_;
  std::vector<std::vector<std::uint64_t>> mine;
  std::string text;
  for (std::size_t i = 0; i < std::min(width, survivors_.size()); ++i) {
    std::vector<std::uint64_t>& one = mine.emplace_back();
    one = {promise_key(i), hash_key(i)};
    const SetView state = bits_of(survivors_[i], one_);
    one.insert(one.end(), state.begin(), state.end());
    text.append(reinterpret_cast<const char*>(one.data()), 8 * words);
  }
  std::vector<std::vector<std::uint64_t>> all = words_told(text, words);
  at_most_ = all.size();
  if (all.size() <= width) return mine.size();
  std::ranges::nth_element(all, all.begin() + static_cast<std::ptrdiff_t>(width - 1));
  return static_cast<std::size_t>(std::ranges::upper_bound(mine, all[width - 1]) - mine.begin());
}

// What all members tell, each so many words long.
std::vector<std::vector<std::uint64_t>> BeamSearch::words_told(const std::string& mine,
                                                               std::size_t words) {
  std::vector<std::vector<std::uint64_t>> all;
  for (const std::string& told : crew_->told_by_all(mine)) {
    for (std::size_t at = 0; at < told.size(); at += 8 * words) {
      all.emplace_back(words);
      std::memcpy(all.back().data(), told.data() + at, 8 * words);
    }
  }
  return all;
}

// The same of a wide beam, of which there are more than `width`.
std::size_t BeamSearch::kept_of_width(std::size_t width) {
  // By promise; those that promise as much as the last by hash; then by the states themselves.
  std::size_t begin = 0;
  std::size_t end = survivors_.size();
  std::uint64_t wanted = width;
  // Goes on with the stretch of equal keys in which the last one lies, or is done.
  const auto narrow = [&](auto key_of) {
    const CrewCut cut = cut_of_all(
        *crew_, end - begin, [&](std::size_t i) { return key_of(begin + i); }, wanted);
    end = begin + cut.end;
    begin += cut.begin;
    const bool done = cut.up_to == wanted;
    wanted -= cut.below;
    return done;
  };
  if (narrow([&](std::size_t i) { return promise_key(i); }) ||
      narrow([&](std::size_t i) { return hash_key(i); }))
    return end;
  std::string mine;
  for (std::size_t i = begin; i < end; ++i) {
    const SetView state = bits_of(survivors_[i], one_);
    mine.append(reinterpret_cast<const char*>(state.data()), 8 * words_);
  }
  std::vector<std::vector<std::uint64_t>> states = words_told(mine, words_);
  std::ranges::sort(states);
  const std::vector<std::uint64_t>& last = states[wanted - 1];
  while (begin < end &&
         !std::ranges::lexicographical_compare(last, bits_of(survivors_[begin], one_)))
    ++begin;
  return begin;
}

}  // namespace orasp::detail
