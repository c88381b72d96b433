#include "orasp/symmetry/orbit_form.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

namespace orasp {

namespace {

using Points = std::vector<std::uint32_t>;

/// How many elements of a group are listed, and how many of their entries.
constexpr std::size_t kMostElements = 1024;
/// So few are listed whatever else could be done; so many to count the orbits of a group.
constexpr std::size_t kFewElements = 16;
constexpr std::size_t kCountedElements = 5040;
constexpr std::size_t kMostEntries = std::size_t{1} << 19;
/// How many generators are tried one by one where all together are not recognised.
constexpr std::size_t kMostTried = 256;

bool bit(std::span<const std::uint64_t> words, std::size_t point) {
  return (words[point / 64] >> (point % 64) & 1U) != 0;
}
void set_bit(std::span<std::uint64_t> words, std::size_t point, bool value) {
  const std::uint64_t mask = std::uint64_t{1} << (point % 64);
  words[point / 64] = value ? words[point / 64] | mask : words[point / 64] & ~mask;
}

Points support(const Permutation& g) {
  Points moved;
  for (std::uint32_t p = 0; p < g.size(); ++p) {
    if (g[p] != p) moved.push_back(p);
  }
  return moved;
}

class UnionFind {
 public:
  explicit UnionFind(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }
  std::uint32_t find(std::uint32_t x) {
    while (parent_[x] != x) x = parent_[x] = parent_[parent_[x]];
    return x;
  }
  /// The least of a class stands for it.
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace

class OrbitForm::Recogniser {
 public:
  explicit Recogniser(std::size_t points) : size_(points) {}

  /// What brings sets to their form under as much of the group as is recognised.
  Plan some_of(std::vector<Permutation> generators) {
    Plan plan;
    for (std::vector<Permutation>& family : families(std::move(generators))) {
      if (auto all = family_plan(family)) {
        append(plan, std::move(*all));
        continue;
      }
      std::ranges::stable_sort(family, {}, [](const Permutation& g) { return support(g).size(); });
      if (family.size() > kMostTried) family.resize(kMostTried);
      std::vector<Permutation> kept;
      Plan best;
      for (Permutation& g : family) {
        kept.push_back(std::move(g));
        if (auto more = all_of(kept)) {
          best = std::move(*more);
        } else {
          kept.pop_back();
        }
      }
      append(plan, std::move(best));
    }
    return plan;
  }

 private:
  /// The same under all of the group; nothing where that is not recognised.
  std::optional<Plan> all_of(std::vector<Permutation> generators) {
    Plan plan;
    for (const std::vector<Permutation>& family : families(std::move(generators))) {
      auto part = family_plan(family);
      if (!part) return std::nullopt;
      append(plan, std::move(*part));
    }
    return plan;
  }

  static void append(Plan& plan, Plan&& more) {
    std::ranges::move(more.steps, std::back_inserter(plan.steps));
    plan.order.insert(plan.order.end(), more.order.begin(), more.order.end());
    plan.moved += more.moved;
    plan.log_orbits += more.log_orbits;
  }

  // Generators that move points in common, directly or by others.
  std::vector<std::vector<Permutation>> families(std::vector<Permutation> generators) const {
    UnionFind together(size_);
    std::vector<std::uint32_t> first;
    for (const Permutation& g : generators) {
      const Points moved = support(g);
      first.push_back(moved.empty() ? 0 : moved.front());
      for (const std::uint32_t p : moved) together.join(moved.front(), p);
    }
    std::map<std::uint32_t, std::vector<Permutation>> by_class;
    for (std::size_t i = 0; i < generators.size(); ++i) {
      if (support(generators[i]).empty()) continue;
      by_class[together.find(first[i])].push_back(std::move(generators[i]));
    }
    std::vector<std::vector<Permutation>> result;
    for (auto& [least, family] : by_class) result.push_back(std::move(family));
    return result;
  }

  std::optional<Plan> family_plan(const std::vector<Permutation>& family) {
    if (auto plan = blocks_plan(family)) return plan;
    if (auto plan = elements_plan(family, kFewElements)) return plan;
    if (auto plan = product_plan(family)) return plan;
    return elements_plan(family, kMostElements);
  }

  // Generators in two kinds that commute with each other: the group is all products of an element
  // of the one and an element of the other. One must be sorting, the other is listed. Sorting what
  // an element made of a set and taking the least is a form: another set of the orbit differs by
  // one of the listed ones, after which the same images are compared, and by sorting.
  std::optional<Plan> product_plan(const std::vector<Permutation>& family) {
    const auto commute = [](const Permutation& g, const Permutation& h) {
      for (std::size_t p = 0; p < g.size(); ++p) {
        if (g[h[p]] != h[g[p]]) return false;
      }
      return true;
    };
    if (family.size() > kMostTried) return std::nullopt;
    UnionFind kinds(family.size());
    for (std::uint32_t i = 0; i < family.size(); ++i) {
      for (std::uint32_t k = 0; k < i; ++k) {
        if (!commute(family[i], family[k])) kinds.join(i, k);
      }
    }
    std::optional<Plan> best;
    for (std::uint32_t kind = 0; kind < family.size(); ++kind) {
      if (kinds.find(kind) != kind) continue;
      std::vector<Permutation> sorting;
      std::vector<Permutation> listed;
      for (std::uint32_t i = 0; i < family.size(); ++i)
        (kinds.find(i) == kind ? sorting : listed).push_back(family[i]);
      if (listed.empty()) return std::nullopt;
      auto sorted = blocks_plan(sorting);
      auto elements = elements_plan(listed, kMostElements);
      if (!sorted || !elements) continue;
      Step& least = elements->steps.front();
      if (best && best->steps.front().count <= least.count) continue;
      // All points belong to the step, those that are sorted alone too.
      std::set<std::uint16_t> more;
      for (const Step& step : sorted->steps) more.insert(step.points.begin(), step.points.end());
      for (const std::uint16_t p : least.points) more.erase(p);
      extend(least, {more.begin(), more.end()});
      Plan plan;
      plan.moved = least.points.size();
      plan.order = sorted->order;
      plan.order.insert(plan.order.end(), elements->order.begin(), elements->order.end());
      const double all = static_cast<double>(plan.moved) * std::log(2);
      const auto both = elements_plan(family, kCountedElements);
      plan.log_orbits =
          both ? both->log_orbits + all - static_cast<double>(both->moved) * std::log(2)
               : all + sorted->log_orbits - static_cast<double>(sorted->moved) * std::log(2) -
                     std::log(static_cast<double>(least.count));
      least.then = std::move(sorted->steps);
      plan.steps.push_back(std::move(least));
      best = std::move(plan);
    }
    return best;
  }

  // Lets a listed group act on more points, which it does not move.
  static void extend(Step& step, const std::vector<std::uint16_t>& more) {
    const std::size_t length = step.points.size();
    std::vector<std::uint16_t> elements;
    for (std::size_t e = 0; e < step.count; ++e) {
      const auto begin = step.elements.begin() + static_cast<std::ptrdiff_t>(e * length);
      elements.insert(elements.end(), begin, begin + static_cast<std::ptrdiff_t>(length));
      for (std::size_t i = 0; i < more.size(); ++i)
        elements.push_back(static_cast<std::uint16_t>(length + i));
    }
    step.elements = std::move(elements);
    step.points.insert(step.points.end(), more.begin(), more.end());
  }

  static void move_points(std::vector<Step>& steps, const Points& block,
                          const std::vector<std::uint32_t>& place_of) {
    for (Step& step : steps) {
      for (std::uint16_t& p : step.points) p = static_cast<std::uint16_t>(block[place_of[p]]);
      move_points(step.then, block, place_of);
    }
  }

  // The blocks that the generators with the largest supports exchange: in each the points in the
  // same order, so that exchanging two blocks takes each point to the one at the same place.
  std::optional<std::vector<Points>> blocks_of(const std::vector<const Permutation*>& outer,
                                               const std::vector<const Permutation*>& inner) const {
    for (const Permutation* const g : outer) {
      for (const std::uint32_t p : support(*g)) {
        if ((*g)[(*g)[p]] != p) return std::nullopt;
      }
    }
    return outer.size() == 1 ? halves(*outer.front(), inner) : atoms(outer);
  }

  // One exchange: what the others move together stays together.
  std::optional<std::vector<Points>> halves(const Permutation& g,
                                            const std::vector<const Permutation*>& inner) const {
    UnionFind together(size_);
    for (const Permutation* const h : inner) {
      const Points moved = support(*h);
      for (const std::uint32_t p : moved) {
        together.join(moved.front(), p);
        together.join(g[moved.front()], g[p]);
      }
    }
    std::vector<Points> blocks(2);
    for (const std::uint32_t p : support(g)) {
      const std::uint32_t here = together.find(p);
      const std::uint32_t there = together.find(g[p]);
      if (here == there) return std::nullopt;
      if (here > there) continue;
      blocks[0].push_back(p);
      blocks[1].push_back(g[p]);
    }
    return blocks;
  }

  // Several: the points that are moved by the same ones.
  std::optional<std::vector<Points>> atoms(const std::vector<const Permutation*>& outer) const {
    std::vector<std::vector<std::uint32_t>> moved_by(size_);
    for (std::uint32_t i = 0; i < outer.size(); ++i) {
      for (const std::uint32_t p : support(*outer[i])) moved_by[p].push_back(i);
    }
    std::map<std::vector<std::uint32_t>, Points> by_movers;
    for (std::uint32_t p = 0; p < size_; ++p) {
      if (!moved_by[p].empty()) by_movers[moved_by[p]].push_back(p);
    }
    std::vector<Points> found;
    std::vector<std::uint32_t> atom_of(size_, 0);
    for (auto& [movers, points] : by_movers) {
      for (const std::uint32_t p : points) atom_of[p] = static_cast<std::uint32_t>(found.size());
      found.push_back(std::move(points));
    }
    // From the first atom by exchanges to all others.
    std::vector<Points> blocks(found.size());
    std::vector<std::uint32_t> reached{0};
    blocks[0] = found[0];
    for (std::size_t i = 0; i < reached.size(); ++i) {
      const Points from = blocks[reached[i]];
      for (const Permutation* const g : outer) {
        if ((*g)[from.front()] == from.front()) continue;
        const std::uint32_t to = atom_of[(*g)[from.front()]];
        if (!blocks[to].empty() || found[to].size() != from.size()) continue;
        for (const std::uint32_t p : from) blocks[to].push_back((*g)[p]);
        reached.push_back(to);
      }
    }
    if (reached.size() != found.size()) return std::nullopt;
    return blocks;
  }

  std::optional<Plan> blocks_plan(const std::vector<Permutation>& family) {
    std::size_t most = 0;
    for (const Permutation& g : family) most = std::max(most, support(g).size());
    std::vector<const Permutation*> outer;
    std::vector<const Permutation*> inner;
    for (const Permutation& g : family) (support(g).size() == most ? outer : inner).push_back(&g);
    const auto blocks = blocks_of(outer, inner);
    if (!blocks) return std::nullopt;

    // Each point's block and its place there, and whether all is as it looks.
    constexpr std::uint32_t kNone = ~std::uint32_t{0};
    std::vector<std::uint32_t> block_of(size_, kNone);
    std::vector<std::uint32_t> place_of(size_, 0);
    const std::size_t length = blocks->front().size();
    for (std::uint32_t b = 0; b < blocks->size(); ++b) {
      if ((*blocks)[b].size() != length) return std::nullopt;
      for (std::uint32_t i = 0; i < length; ++i) {
        const std::uint32_t p = (*blocks)[b][i];
        if (block_of[p] != kNone) return std::nullopt;
        block_of[p] = b;
        place_of[p] = i;
      }
    }
    for (const Permutation* const g : outer) {
      // Two blocks whole, point by point.
      const Points moved = support(*g);
      if (moved.size() != 2 * length) return std::nullopt;
      const std::uint32_t one = block_of[moved.front()];
      if (one == kNone) return std::nullopt;
      const std::uint32_t other = block_of[(*g)[moved.front()]];
      if (other == kNone || one == other) return std::nullopt;
      for (const std::uint32_t p : moved) {
        const std::uint32_t to = (*g)[p];
        if (block_of[p] != one && block_of[p] != other) return std::nullopt;
        if (block_of[to] != (block_of[p] == one ? other : one)) return std::nullopt;
        if (place_of[p] != place_of[to]) return std::nullopt;
      }
    }
    // What happens inside of blocks, all of it in the first one.
    std::set<Permutation> inside;
    for (const Permutation* const h : inner) {
      const Points moved = support(*h);
      const std::uint32_t here = block_of[moved.front()];
      Permutation in_first(size_);
      std::iota(in_first.begin(), in_first.end(), 0U);
      for (const std::uint32_t p : moved) {
        const std::uint32_t to = (*h)[p];
        if (here == kNone || block_of[p] != here || block_of[to] != here) return std::nullopt;
        in_first[(*blocks)[0][place_of[p]]] = (*blocks)[0][place_of[to]];
      }
      inside.insert(std::move(in_first));
    }
    Plan plan;
    double log_states = static_cast<double>(length) * std::log(2);  // what a block may be
    if (!inside.empty()) {
      const auto first = all_of({inside.begin(), inside.end()});
      if (!first) return std::nullopt;
      log_states += first->log_orbits - static_cast<double>(first->moved) * std::log(2);
      for (const Points& block : *blocks) {
        Plan copy = *first;
        move_points(copy.steps, block, place_of);
        append(plan, std::move(copy));
      }
    }
    Step sort;
    sort.count = blocks->size();
    for (const Points& block : *blocks) {
      for (const std::uint32_t p : block) sort.points.push_back(static_cast<std::uint16_t>(p));
    }
    plan.steps.push_back(std::move(sort));
    for (std::uint64_t i = 2; i <= blocks->size(); ++i) plan.order.push_back(i);
    plan.moved = length * blocks->size();
    plan.log_orbits = log_multisets(log_states, blocks->size());
    return plan;
  }

  // The logarithm of the number of ways to choose so many of exp(log_kinds) kinds, in no order.
  static double log_multisets(double log_kinds, std::size_t chosen) {
    constexpr double kMany = 20;
    const auto k = static_cast<double>(chosen);
    if (log_kinds > kMany) return k * log_kinds - std::lgamma(k + 1);
    const double kinds = std::exp(log_kinds);
    return std::lgamma(kinds + k) - std::lgamma(k + 1) - std::lgamma(kinds);
  }

  std::optional<Plan> elements_plan(const std::vector<Permutation>& family,
                                    std::size_t most) const {
    std::set<std::uint32_t> moved;
    for (const Permutation& g : family) {
      for (const std::uint32_t p : support(g)) moved.insert(p);
    }
    Step least;
    least.sorts = false;
    std::vector<std::uint16_t> place_of(size_, 0);
    for (const std::uint32_t p : moved) {
      place_of[p] = static_cast<std::uint16_t>(least.points.size());
      least.points.push_back(static_cast<std::uint16_t>(p));
    }
    using Element = std::vector<std::uint16_t>;
    std::vector<Element> steps;
    for (const Permutation& g : family) {
      Element& step = steps.emplace_back();
      for (const std::uint16_t p : least.points) step.push_back(place_of[g[p]]);
    }
    Element identity(least.points.size());
    std::iota(identity.begin(), identity.end(), std::uint16_t{0});
    std::set<Element> known{identity};
    std::vector<Element> all{identity};
    for (std::size_t i = 0; i < all.size(); ++i) {
      for (const Element& step : steps) {
        Element next(all[i].size());
        for (std::size_t p = 0; p < next.size(); ++p) next[p] = step[all[i][p]];
        if (!known.insert(next).second) continue;
        all.push_back(std::move(next));
        if (all.size() > most || all.size() * least.points.size() > kMostEntries)
          return std::nullopt;
      }
    }
    least.count = all.size();
    for (const Element& element : all)
      least.elements.insert(least.elements.end(), element.begin(), element.end());
    Plan plan;
    plan.order.push_back(all.size());
    plan.moved = least.points.size();
    // As many sets stay as they are under an element as there are choices for its cycles.
    double fixed = 0;  // as a share of all sets
    for (const Element& element : all) {
      std::size_t cycles = 0;
      std::vector<bool> seen(element.size(), false);
      for (std::size_t p = 0; p < element.size(); ++p) {
        if (seen[p]) continue;
        ++cycles;
        for (std::size_t q = p; !seen[q]; q = element[q]) seen[q] = true;
      }
      fixed += std::exp2(static_cast<double>(cycles) - static_cast<double>(element.size()));
    }
    plan.log_orbits = static_cast<double>(plan.moved) * std::log(2) + std::log(fixed) -
                      std::log(static_cast<double>(all.size()));
    plan.steps.push_back(std::move(least));
    return plan;
  }

  std::size_t size_;
};

OrbitForm::OrbitForm(std::size_t points, std::vector<Permutation> generators) {
  Plan plan = Recogniser(points).some_of(std::move(generators));
  steps_ = std::move(plan.steps);
  order_ = std::move(plan.order);
  saving_ = std::exp(static_cast<double>(plan.moved) * std::log(2) - plan.log_orbits);
  steps_of_.resize(points);
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    for (const std::uint16_t p : steps_[i].points)
      steps_of_[p].push_back(static_cast<std::uint16_t>(i));
  }
}

void OrbitForm::canonical(std::span<std::uint64_t> words) {
  for (const Step& step : steps_) apply(step, words);
}

// Steps that do not look at the point find what they left behind.
void OrbitForm::canonical_but_for(std::size_t point, std::span<std::uint64_t> words) {
  for (const std::uint16_t i : steps_of_[point]) apply(steps_[i], words);
}

void OrbitForm::apply(const Step& step, std::span<std::uint64_t> words) {
  if (!step.sorts) {
    if (step.then.empty()) {
      take_least(step, words);
    } else {
      take_least_sorted(step, words);
    }
    return;
  }
  const std::size_t length = step.points.size() / step.count;
  if (length == 1) {
    sort_points(step, words);
  } else if (length <= 64) {
    sort_blocks(step, words);
  } else {
    sort_long_blocks(step, words);
  }
}

void OrbitForm::sort_points(const Step& step, std::span<std::uint64_t> words) {
  std::size_t there = 0;
  for (const std::uint16_t p : step.points) there += bit(words, p) ? 1 : 0;
  if (there == 0 || there == step.count) return;
  for (std::size_t i = 0; i < step.count; ++i) set_bit(words, step.points[i], i < there);
}

void OrbitForm::sort_blocks(const Step& step, std::span<std::uint64_t> words) {
  const std::size_t length = step.points.size() / step.count;
  patterns_.resize(step.count);
  const std::uint16_t* p = step.points.data();
  for (std::uint64_t& pattern : patterns_) {
    pattern = 0;
    for (std::size_t i = 0; i < length; ++i, ++p)
      pattern |= (words[*p / 64] >> (*p % 64) & 1U) << i;
  }
  if (std::ranges::is_sorted(patterns_)) return;
  std::ranges::sort(patterns_);
  p = step.points.data();
  for (const std::uint64_t pattern : patterns_) {
    for (std::size_t i = 0; i < length; ++i, ++p) set_bit(words, *p, (pattern >> i & 1U) != 0);
  }
}

void OrbitForm::sort_long_blocks(const Step& step, std::span<std::uint64_t> words) {
  const std::size_t length = step.points.size() / step.count;
  long_patterns_.resize(step.count);
  for (std::size_t b = 0; b < step.count; ++b) {
    long_patterns_[b].assign((length + 63) / 64, 0);
    for (std::size_t i = 0; i < length; ++i)
      set_bit(long_patterns_[b], i, bit(words, step.points[b * length + i]));
  }
  if (std::ranges::is_sorted(long_patterns_)) return;
  std::ranges::sort(long_patterns_);
  for (std::size_t b = 0; b < step.count; ++b) {
    for (std::size_t i = 0; i < length; ++i)
      set_bit(words, step.points[b * length + i], bit(long_patterns_[b], i));
  }
}

void OrbitForm::take_least_sorted(const Step& step, std::span<std::uint64_t> words) {
  const std::size_t length = step.points.size();
  // What is sorted inside uses bits_ as well where it lists elements.
  std::vector<unsigned char> bits = std::move(bits_);
  bits.resize(length);
  for (std::size_t i = 0; i < length; ++i) bits[i] = bit(words, step.points[i]) ? 1 : 0;
  std::vector<std::uint64_t> image = std::move(image_);
  std::vector<std::uint64_t> least = std::move(least_);
  least.clear();
  image.assign(words.begin(), words.end());
  for (std::size_t e = 0; e < step.count; ++e) {
    const std::uint16_t* const element = step.elements.data() + e * length;
    for (std::size_t i = 0; i < length; ++i) set_bit(image, step.points[i], bits[element[i]] != 0);
    for (const Step& inner : step.then) apply(inner, image);
    if (least.empty() || image < least) least = image;
  }
  std::ranges::copy(least, words.begin());
  bits_ = std::move(bits);
  image_ = std::move(image);
  least_ = std::move(least);
}

// Images are compared bit by bit, and most differ after a few.
void OrbitForm::take_least(const Step& step, std::span<std::uint64_t> words) {
  const std::size_t length = step.points.size();
  bits_.resize(length);
  for (std::size_t i = 0; i < length; ++i) bits_[i] = bit(words, step.points[i]) ? 1 : 0;
  const std::uint16_t* const first = step.elements.data();
  const std::uint16_t* best = first;  // the identity
  for (const std::uint16_t* e = first + length; e != first + step.elements.size(); e += length) {
    for (std::size_t i = 0; i < length; ++i) {
      const unsigned char here = bits_[e[i]];
      const unsigned char there = bits_[best[i]];
      if (here == there) continue;
      if (here < there) best = e;
      break;
    }
  }
  if (best == first) return;
  for (std::size_t i = 0; i < length; ++i) set_bit(words, step.points[i], bits_[best[i]] != 0);
}

}  // namespace orasp
