#include "orasp/bounds/place_prices.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <queue>
#include <span>
#include <utility>

#include "orasp/model/detail/rules.h"
#include "orasp/model/tolerance.h"

namespace orasp {

namespace {

constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();

/// The best assignment of n rows to n columns, least cost first, and its dual prices. Shortest
/// augmenting paths: Jonker and Volgenant (1987), Computing 38, 325-340. O(n^3).
class Assignment {
 public:
  explicit Assignment(std::size_t size)
      : size_(size), row_price(size, 0.0), column_price(size, 0.0), row_of(size), column_of(size) {}

  /// `cost` is by row and column, infinite where the two do not go together. Returns whether all
  /// rows have a column.
  bool solve(std::span<const double> cost) {
    std::ranges::fill(column_price, 0.0);
    row_of.assign(size_, kNobody);
    column_of.assign(size_, kNobody);
    for (std::size_t row = 0; row < size_; ++row) {
      const auto mine = cost.subspan(row * size_, size_);
      const auto least = std::ranges::min_element(mine);
      if (!std::isfinite(*least)) return false;
      row_price[row] = *least;
      const auto column = static_cast<std::size_t>(least - mine.begin());
      if (row_of[column] == kNobody) match(row, column);
    }
    for (std::size_t row = 0; row < size_; ++row) {
      if (column_of[row] == kNobody && !find_room(row, cost)) return false;
    }
    return true;
  }

 private:
  void match(std::size_t row, std::size_t column) {
    row_of[column] = static_cast<std::uint32_t>(row);
    column_of[row] = static_cast<std::uint32_t>(column);
  }
  bool find_room(std::size_t first, std::span<const double> cost) {
    reach_.assign(size_, kInfinity);
    from_.assign(size_, kNobody);
    reached_.assign(size_, 0);
    std::vector<std::size_t>& tree = tree_;
    tree.clear();
    std::size_t row = first;
    double length = 0;
    std::size_t column = 0;
    for (;;) {
      const auto mine = cost.subspan(row * size_, size_);
      column = size_;
      for (std::size_t k = 0; k < size_; ++k) {
        if (reached_[k] != 0) continue;
        const double way = length + mine[k] - row_price[row] - column_price[k];
        if (way < reach_[k]) {
          reach_[k] = way;
          from_[k] = static_cast<std::uint32_t>(row);
        }
        if (column == size_ || reach_[k] < reach_[column]) column = k;
      }
      if (column == size_ || !std::isfinite(reach_[column])) return false;
      length = reach_[column];
      reached_[column] = 1;
      if (row_of[column] == kNobody) break;
      tree.push_back(column);
      row = row_of[column];
    }
    row_price[first] += length;
    for (const std::size_t k : tree) {
      row_price[row_of[k]] += length - reach_[k];
      column_price[k] -= length - reach_[k];
    }
    // Turn the path round.
    for (;;) {
      const std::size_t of = from_[column];
      const std::uint32_t next = column_of[of];
      match(of, column);
      if (of == first) return true;
      column = next;
    }
  }

  std::size_t size_;
  std::vector<double> reach_;
  std::vector<std::uint32_t> from_;
  std::vector<unsigned char> reached_;
  std::vector<std::size_t> tree_;

 public:
  std::vector<double> row_price;
  std::vector<double> column_price;
  std::vector<std::uint32_t> row_of;     ///< by column
  std::vector<std::uint32_t> column_of;  ///< by row
};

/// Length of a step of Polyak's (1969) by which prices go down the slope of a bound, towards what
/// some plan earns; it shrinks to a few thousandths over all rounds.
class Descent {
 public:
  explicit Descent(std::size_t rounds)
      : shrink_(std::pow(0.003, 1.0 / static_cast<double>(std::max<std::size_t>(1, rounds)))) {}
  [[nodiscard]] double step(double bound, double plan, double squares) {
    share_ *= shrink_;
    return squares > 0 ? share_ * std::max(0.0, bound - plan) / squares : 0;
  }

 private:
  double shrink_;
  double share_ = 1;
};

/// A line with the same slope under all circumstances.
struct Line {
  double at;
  double slope;
  bool flat = false;  ///< time may count, along no line
};

}  // namespace

/// Works the prices out. Steps are numbered in the order of their connections.
class PlacePricing {
 public:
  PlacePricing(PlacePrices& prices, const TransitionSystem& system, PlacePrices::Terms terms)
      : prices_(prices), system_(system), problem_(system.problem()), size_(system.num_steps()) {
    for_each_connection(system.start().view(), [&](ConnectionIndex c) { steps_.push_back(c); });
    for (const WeightedTerm& addend : system.rules().terms) {
      if (addend.weight == 0 || addend.term->sees.looks_back) continue;
      if (terms == PlacePrices::Terms::NotOfPiecesAlone && addend.term->sees.piece_only) continue;
      Addend mine;
      mine.weight = addend.weight;
      mine.own = addend.term->for_one_thread();
      mine.term = mine.own ? mine.own.get() : addend.term.get();
      addends_.push_back(std::move(mine));
    }
  }

  void work_out() {
    prices_.known_ = !addends_.empty();
    if (size_ == 0 || !prices_.known_) return;
    look_at_walk();
    look_at_precedence();
    sort_addends();
    if (!prices_.known_) return;
    std::vector<double> surplus(size_, 0.0);
    const std::size_t connections = problem_.num_connections();
    const auto empty = [&](PlacePrices::Lines& lines) {
      lines.at.assign(connections, 0);
      lines.slope.assign(connections, 0);
      lines.takes.assign(connections, 0);
      lines.used = true;
    };
    bool table = false;
    for (const Addend& addend : addends_) table = table || addend.way == Way::Table;
    if (table && size_ > PlacePrices::kMostPlaces) {
      for (Addend& addend : addends_) {
        if (addend.way == Way::Table) level(addend);
      }
      table = false;
    }
    for (const Addend& addend : addends_) {
      if (addend.way == Way::Table || (table && addend.way == Way::Places)) continue;
      PlacePrices::Lines& lines =
          addend.way == Way::Seconds ? prices_.by_seconds_ : prices_.by_place_;
      if (!lines.used) empty(lines);
      for (std::size_t i = 0; i < size_; ++i) {
        const ConnectionIndex c = steps_[i];
        lines.at[c] += addend.lines[i].at;
        lines.slope[c] += addend.lines[i].slope;
        lines.takes[c] = addend.way == Way::Seconds ? problem_.connections()[c].duration : 1;
        surplus[i] += addend.surplus[i];
      }
    }
    PlacePrices::Values& values = prices_.values_;
    values.steps = steps_;
    values.next = next_;
    values.waits_for.resize(size_);
    for (const auto& [first, second] : before_after_) values.waits_for[second].push_back(first);
    for (const ConnectionIndex c : steps_) {
      if (prices_.by_place_.used) values.by_place.push_back(prices_.by_place_.slope[c]);
      if (!prices_.by_seconds_.used) continue;
      values.by_seconds.push_back(prices_.by_seconds_.slope[c]);
      values.seconds.push_back(problem_.connections()[c].duration);
    }
    prices_.last_surplus_ = *std::ranges::max_element(surplus);
    prices_.most_of_start_ = prices_.last_surplus_;
    if (prices_.by_place_.used) price_lines(prices_.by_place_);
    if (prices_.by_seconds_.used) price_lines(prices_.by_seconds_);
    if (table) price_places();
    prices_.known_ = prices_.known_ && std::isfinite(prices_.most_of_start_);
  }

 private:
  enum class Way { Places, Seconds, Table };
  struct Addend {
    double weight = 1;
    std::unique_ptr<const ObjectiveTerm> own;
    const ObjectiveTerm* term = nullptr;
    Way way = Way::Table;
    // Unless it goes into the table, by step:
    std::vector<Line> lines{};
    std::vector<double> surplus{};  ///< what it earns more when it completes
  };
  using Bits = std::vector<std::uint64_t>;

  // What formulas see of the places of the walk: asked of the rules, at both ends.
  void look_at_walk() {
    const Problem plain =
        problem_.with_objective(Objective("completion", CompletionObjective{0, 0, 0}));
    const TransitionSystem forwards(plain, system_.situation());
    const auto ask = [&](const TransitionSystem& walk) {
      Expander expander(walk);
      const Step first = expander.step(walk.start().view(), steps_.front());
      ConnectionSet one(problem_.num_connections());
      one.insert(steps_.front());
      const Step last = expander.step(one.view(), steps_.front());
      const double places = std::max(1.0, static_cast<double>(size_ - 1));
      const auto line = [&](std::size_t at_first, std::size_t at_last) {
        const double begin = static_cast<double>(at_first);
        const double slope = (static_cast<double>(at_last) - begin) / places;
        return FormulaLine{{begin, begin}, {slope, slope}};
      };
      before_ = line(first.before, last.before);
      after_ = line(first.after, last.after);
    };
    backwards_ = system_.completes_first();
    if (backwards_) {
      ask(forwards.backwards());
    } else {
      ask(forwards);
    }
    const bool assembly = problem_.direction() == Direction::Assembly;
    const ConnectionSet there = system_.present(system_.start().view());
    for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
      if (there.contains(c) == assembly) seconds_of_start_ += problem_.connections()[c].duration;
    }
    for (const ConnectionIndex c : steps_) all_seconds_ += problem_.connections()[c].duration;
    // Backwards all is made at the start; what the walk takes off has not passed yet.
    if (backwards_) seconds_of_start_ -= all_seconds_;
    // A bridge of the whole product always separates, a connection of a part to itself never.
    const detail::AssemblyGraph& graph = system_.rules().graph;
    detail::Connectivity connectivity(graph, false);
    ConnectionSet all(problem_.num_connections());
    for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) all.insert(c);
    connectivity.analyse(all.view(), false);
    for (const ConnectionIndex c : steps_) {
      const auto& ends = problem_.ends(c);
      may_separate_.push_back(ends[0] != ends[1] ? 1 : 0);
      may_keep_.push_back(ends[0] == ends[1] || connectivity.below(c) == 0 ? 1 : 0);
    }
  }

  // Which step must come before which, and what comes before and after each at least.
  void look_at_precedence() {
    const detail::Rules& rules = system_.rules();
    std::vector<std::uint32_t> number(problem_.num_connections(), kNobody);
    for (std::uint32_t i = 0; i < size_; ++i) number[steps_[i]] = i;
    next_.resize(size_);
    std::vector<std::uint32_t> waits(size_, 0);
    if (!rules.after.empty()) {
      for (std::uint32_t i = 0; i < size_; ++i) {
        const SetView listed(rules.after.data() + steps_[i] * rules.words, rules.words);
        for_each_connection(listed, [&](ConnectionIndex other) {
          const std::uint32_t j = number[other];
          if (j == kNobody || j == i) return;
          // Where steps make connections, what is removed after others is made before them.
          const auto pair = rules.making ? std::pair(i, j) : std::pair(j, i);
          before_after_.push_back({pair.first, pair.second});
          next_[pair.first].push_back(pair.second);
          ++waits[pair.second];
        });
      }
    }
    for (std::uint32_t i = 0; i < size_; ++i) {
      if (waits[i] == 0) sorted_.push_back(i);
    }
    for (std::size_t k = 0; k < sorted_.size(); ++k) {
      for (const std::uint32_t j : next_[sorted_[k]]) {
        if (--waits[j] == 0) sorted_.push_back(j);
      }
    }
    if (sorted_.size() < size_) {
      // It goes round in a circle, so there is no plan; what is bounded then is any order.
      before_after_.clear();
      for (auto& list : next_) list.clear();
    }
    constexpr std::size_t kMostInSets = 2048;
    if (before_after_.empty() || size_ > kMostInSets) return;
    const std::size_t words = words_for(size_);
    ahead_.assign(size_, Bits(words, 0));
    behind_.assign(size_, Bits(words, 0));
    for (const std::uint32_t i : sorted_) {
      for (const std::uint32_t j : next_[i]) {
        for (std::size_t w = 0; w < words; ++w) ahead_[j][w] |= ahead_[i][w];
        ahead_[j][i / 64] |= std::uint64_t{1} << (i % 64);
      }
    }
    for (std::size_t k = size_; k-- > 0;) {
      const std::uint32_t i = sorted_[k];
      for (const std::uint32_t j : next_[i]) {
        for (std::size_t w = 0; w < words; ++w) behind_[i][w] |= behind_[j][w];
        behind_[i][j / 64] |= std::uint64_t{1} << (j % 64);
      }
    }
  }

  /// The times at which a step can begin, where each takes so long, and together `all`.
  [[nodiscard]] Interval times_of(std::size_t i, std::span<const double> takes, double all) const {
    Interval times{0, all - takes[i]};
    if (ahead_.empty()) return times;
    for_each_connection(ahead_[i], [&](ConnectionIndex j) { times.least += takes[j]; });
    for_each_connection(behind_[i], [&](ConnectionIndex j) { times.greatest -= takes[j]; });
    return times;
  }

  [[nodiscard]] static Interval at_time(const FormulaLine& line, double time) {
    const double value = line.at.least + line.slope.least * time;
    return {value, value};
  }
  [[nodiscard]] Interval all_of(const FormulaLine& line) const {
    const double first = line.at.least;
    const double last = first + line.slope.least * static_cast<double>(size_ - 1);
    return {std::min(first, last), std::max(first, last)};
  }
  [[nodiscard]] PlaceQuestion question(std::size_t i) const {
    PlaceQuestion asked;
    asked.connection = steps_[i];
    const double duration = problem_.connections()[steps_[i]].duration;
    asked.duration = {duration, duration};
    asked.before = {all_of(before_), {0, 0}};
    asked.after = {all_of(after_), {0, 0}};
    asked.elapsed = {{seconds_of_start_, seconds_of_start_ + all_seconds_ - duration}, {0, 0}};
    return asked;
  }
  /// What `addend` earns of such a step: weighed, its greatest whether it separates or not. Empty
  /// where these are no lines of one slope.
  [[nodiscard]] std::optional<Line> line_of(const Addend& addend, std::size_t i,
                                            PlaceQuestion asked) const {
    std::optional<Line> found;
    for (const bool separates : {false, true}) {
      if ((separates ? may_separate_ : may_keep_)[i] == 0) continue;
      asked.separates = separates;
      const FormulaLine line = addend.term->reward_over(asked);
      if (line.slope.least != line.slope.greatest) return std::nullopt;
      const double at = addend.weight * (addend.weight > 0 ? line.at.greatest : line.at.least);
      const double slope = addend.weight * line.slope.least;
      if (found && found->slope != slope) return std::nullopt;
      const bool flat = slope == 0 && line.at.least != line.at.greatest;
      found = Line{found ? std::max(found->at, at) : at, slope, flat || (found && found->flat)};
    }
    return found;
  }
  /// The most that it earns, where the question is of one time alone or where time is none of its
  /// variables.
  [[nodiscard]] double most_of(const Addend& addend, std::size_t i, PlaceQuestion asked) {
    double most = -kInfinity;
    double least = kInfinity;
    for (const bool separates : {false, true}) {
      if ((separates ? may_separate_ : may_keep_)[i] == 0) continue;
      asked.separates = separates;
      const FormulaLine line = addend.term->reward_over(asked);
      for (const double time : {asked.time.least, asked.time.greatest}) {
        for (const double slope : {line.slope.least, line.slope.greatest}) {
          const double rest = slope == 0 ? 0 : slope * time;
          for (const double at : {line.at.least, line.at.greatest}) {
            most = std::max(most, addend.weight * (at + rest));
            least = std::min(least, addend.weight * (at + rest));
          }
        }
      }
    }
    exact_ = exact_ && least == most;
    return most;
  }

  // How each addend is priced.
  void sort_addends() {
    const std::vector<double> ones(size_, 1.0);
    const auto places = static_cast<double>(size_);
    std::vector<double> seconds;
    for (const ConnectionIndex c : steps_) seconds.push_back(problem_.connections()[c].duration);
    for (Addend& addend : addends_) {
      const TermSight& sees = addend.term->sees;
      if (sees.elapsed && sees.by_place) continue;  // two times in one formula
      const bool by_seconds = sees.elapsed;
      addend.way = by_seconds ? Way::Seconds : Way::Places;
      for (std::size_t i = 0; i < size_; ++i) {
        PlaceQuestion asked = question(i);
        asked.time = by_seconds ? times_of(i, seconds, all_seconds_) : times_of(i, ones, places);
        if (by_seconds) {
          const double begin =
              backwards_ ? seconds_of_start_ + all_seconds_ - seconds[i] : seconds_of_start_;
          const double slope = backwards_ ? -1 : 1;
          asked.elapsed = {{begin, begin}, {slope, slope}};
        } else {
          asked.before = before_;
          asked.after = after_;
        }
        const std::optional<Line> line = line_of(addend, i, asked);
        const bool bent = line && line->flat && (sees.by_place || sees.elapsed);
        if (!line || bent || !std::isfinite(line->at) || !std::isfinite(line->slope)) {
          addend.way = Way::Table;
          break;
        }
        addend.lines.push_back(*line);
        // The step that completes comes first, or last.
        const double time = backwards_   ? 0
                            : by_seconds ? all_seconds_ - seconds[i]
                                         : static_cast<double>(size_ - 1);
        asked.time = {time, time};
        if (!by_seconds) {
          asked.before = {at_time(before_, time), {0, 0}};
          asked.after = {at_time(after_, time), {0, 0}};
        } else {
          asked.elapsed = {at_time(asked.elapsed, time), {0, 0}};
        }
        asked.completes = true;
        addend.surplus.push_back(most_of(addend, i, asked) - (line->at + line->slope * time));
        if (!std::isfinite(addend.surplus.back())) prices_.known_ = false;
      }
    }
  }

  // One price for each connection, whenever it comes.
  void level(Addend& addend) {
    addend.way = Way::Places;
    addend.lines.clear();
    addend.surplus.clear();
    for (std::size_t i = 0; i < size_; ++i) {
      PlaceQuestion asked = question(i);
      const double usual = most_of(addend, i, asked);
      asked.completes = true;
      addend.lines.push_back({usual, 0});
      addend.surplus.push_back(most_of(addend, i, asked) - usual);
      if (!std::isfinite(usual) || !std::isfinite(addend.surplus.back())) prices_.known_ = false;
    }
  }

  /// An order that obeys precedence: of what may come next, that of the least rank. Empty where
  /// there is none.
  template <class Rank>
  [[nodiscard]] std::vector<std::uint32_t> order_by(const Rank& rank) const {
    std::vector<std::uint32_t> order;
    if (sorted_.size() < size_) return order;
    std::vector<std::uint32_t> waits(size_, 0);
    for (const auto& pair : before_after_) ++waits[pair[1]];
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> ready;
    for (std::uint32_t i = 0; i < size_; ++i) {
      if (waits[i] == 0) ready.emplace(rank(i), i);
    }
    while (!ready.empty()) {
      const std::uint32_t i = ready.top().second;
      ready.pop();
      order.push_back(i);
      for (const std::uint32_t j : next_[i]) {
        if (--waits[j] == 0) ready.emplace(rank(j), j);
      }
    }
    return order;
  }
  void keep_order(const std::vector<std::uint32_t>& order) {
    prices_.order_.clear();
    for (const std::uint32_t i : order) prices_.order_.push_back(steps_[i]);
  }

  /// A constraint with its price: t(second) - t(first) >= gap; kNobody is the start, or, as
  /// `second`, the negative of an end.
  struct Priced {
    std::uint32_t first;
    std::uint32_t second;
    double gap;
    double price = 0;
  };

  /// Lines by step.
  struct LineProblem {
    std::vector<double> at;
    std::vector<double> slope;
    std::vector<double> takes;
  };

  // Lowers the bound of `lines` by the prices of `constraints`. Returns the least bound, whose
  // prices it leaves in `constraints`; keeps in `plan` the most that an order was seen to earn.
  double descend(const LineProblem& lines, std::vector<Priced>& constraints, std::size_t rounds,
                 double& plan) {
    const double fixed = std::accumulate(lines.at.begin(), lines.at.end(), 0.0);
    std::vector<double> slope(size_);
    std::vector<double> time(size_);
    std::vector<double> rank(size_);
    std::vector<double> slack(constraints.size());
    std::vector<double> best_prices(constraints.size());
    std::vector<std::uint32_t> order(size_);
    std::iota(order.begin(), order.end(), 0U);
    double least = kInfinity;
    Descent descent(rounds);
    for (std::size_t round = 0; round <= rounds; ++round) {
      slope = lines.slope;
      double bound = fixed;
      for (const Priced& priced : constraints) {
        if (priced.price == 0) continue;
        if (priced.second != kNobody) slope[priced.second] += priced.price;
        if (priced.first != kNobody) slope[priced.first] -= priced.price;
        bound -= priced.price * priced.gap;
      }
      for (std::size_t i = 0; i < size_; ++i) rank[i] = rank_of(slope[i], lines.takes[i]);
      std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
        return rank[a] != rank[b] ? rank[a] < rank[b] : a < b;
      });
      double now = 0;
      for (const std::uint32_t i : order) {
        time[i] = now;
        bound += slope[i] * now;
        now += lines.takes[i];
      }
      if (bound < least) {
        least = bound;
        for (std::size_t k = 0; k < constraints.size(); ++k) best_prices[k] = constraints[k].price;
      }
      if (round % 16 == 0 || round == rounds) {
        const std::vector<std::uint32_t> legal = order_by([&](std::uint32_t i) { return rank[i]; });
        double earned = legal.empty() ? -kInfinity : fixed;
        double when = 0;
        for (const std::uint32_t i : legal) {
          earned += lines.slope[i] * when;
          when += lines.takes[i];
        }
        if (earned > plan) {
          plan = earned;
          keep_order(legal);
        }
      }
      if (round == rounds || !std::isfinite(plan) ||
          least <= plan + kRewardTolerance * std::max(1.0, std::abs(plan)))
        break;
      double squares = 0;
      for (std::size_t k = 0; k < constraints.size(); ++k) {
        const Priced& priced = constraints[k];
        slack[k] = (priced.second == kNobody ? 0 : time[priced.second]) -
                   (priced.first == kNobody ? 0 : time[priced.first]) - priced.gap;
        if (priced.price == 0 && slack[k] > 0) slack[k] = 0;
        squares += slack[k] * slack[k];
      }
      if (squares == 0) break;
      const double step = descent.step(bound, plan, squares);
      for (std::size_t k = 0; k < constraints.size(); ++k)
        constraints[k].price = std::max(0.0, constraints[k].price - step * slack[k]);
    }
    for (std::size_t k = 0; k < constraints.size(); ++k) constraints[k].price = best_prices[k];
    return least;
  }

  /// Where a step stands in the best order of lines: by slope over what it takes; what takes no
  /// time comes first or last, whichever suits it.
  [[nodiscard]] static double rank_of(double slope, double takes) {
    if (takes > 0) return slope / takes;
    return slope > 0 ? kInfinity : slope < 0 ? -kInfinity : 0;
  }

  void price_lines(PlacePrices::Lines& out) {
    LineProblem lines;
    for (const ConnectionIndex c : steps_) {
      lines.at.push_back(out.at[c]);
      lines.slope.push_back(out.slope[c]);
      lines.takes.push_back(out.takes[c]);
    }
    std::vector<Priced> constraints;
    for (const auto& [first, second] : before_after_)
      constraints.push_back({first, second, lines.takes[first]});
    const std::size_t pairs = constraints.size();
    if (!ahead_.empty()) {
      const double all = std::accumulate(lines.takes.begin(), lines.takes.end(), 0.0);
      for (std::uint32_t i = 0; i < size_; ++i) {
        const Interval times = times_of(i, lines.takes, all);
        if (times.least > 0) constraints.push_back({kNobody, i, times.least});
        if (times.greatest < all - lines.takes[i])
          constraints.push_back({i, kNobody, -times.greatest});
      }
    }
    constexpr std::size_t kWork = 4'000'000;
    const std::size_t rounds =
        pairs == 0 ? 0 : std::clamp<std::size_t>(kWork / (size_ + constraints.size()), 40, 4000);
    double plan = -kInfinity;
    double least = descend(lines, constraints, rounds, plan);
    // What was priced, as states see it.
    out.pairs.from.resize(problem_.num_connections());
    out.pairs.to.resize(problem_.num_connections());
    for (std::size_t k = 0; k < constraints.size(); ++k) {
      const Priced& priced = constraints[k];
      if (priced.price == 0) continue;
      if (priced.second != kNobody) out.slope[steps_[priced.second]] += priced.price;
      if (priced.first != kNobody) out.slope[steps_[priced.first]] -= priced.price;
      if (k < pairs) {
        add_pair(out.pairs, priced);
      } else {
        const std::uint32_t one = priced.first == kNobody ? priced.second : priced.first;
        out.at[steps_[one]] -= priced.price * priced.gap;
      }
    }
    out.order = steps_;
    std::ranges::stable_sort(
        out.order, {}, [&](ConnectionIndex c) { return rank_of(out.slope[c], out.takes[c]); });
    if (least > plan + 1e-6 * std::max(1.0, std::abs(plan)))
      least = std::min(least, least_with_gaps(lines, constraints, plan));
    prices_.most_of_start_ += least;
  }

  void add_pair(PlacePrices::Pairs& pairs, const Priced& priced) const {
    const auto number = static_cast<std::uint32_t>(pairs.all.size());
    const ConnectionIndex first = steps_[priced.first];
    const ConnectionIndex second = steps_[priced.second];
    pairs.all.push_back({first, second, priced.price});
    pairs.from[first].push_back(number);
    pairs.to[second].push_back(number);
  }

  // For the start alone there is a price of every two steps, however far apart: all that must come
  // between them does.
  double least_with_gaps(const LineProblem& lines, const std::vector<Priced>& known, double& plan) {
    constexpr std::size_t kMostPairs = 40'000;
    constexpr std::size_t kWork = 20'000'000;
    if (ahead_.empty() || size_ > 1024) return kInfinity;
    std::size_t pairs = 0;
    for (const Bits& bits : ahead_) pairs += count(bits);
    if (pairs > kMostPairs) return kInfinity;
    std::vector<Priced> constraints = known;
    for (std::uint32_t j = 0; j < size_; ++j) {
      for_each_connection(ahead_[j], [&](ConnectionIndex i) {
        double gap = lines.takes[i];
        bool between = false;
        for (std::size_t w = 0; w < ahead_[j].size(); ++w) {
          for (std::uint64_t left = behind_[i][w] & ahead_[j][w]; left != 0; left &= left - 1) {
            gap += lines.takes[64 * w + static_cast<std::size_t>(std::countr_zero(left))];
            between = true;
          }
        }
        if (between) constraints.push_back({i, j, gap});
      });
    }
    return descend(lines, constraints,
                   std::clamp<std::size_t>(kWork / (1 + constraints.size()), 40, 1500), plan);
  }

  // The table of places, and its prices.
  void price_places() {
    const std::vector<double> ones(size_, 1.0);
    std::vector<double> table(size_ * size_, -kInfinity);
    std::vector<std::array<std::size_t, 2>> window;
    for (std::size_t i = 0; i < size_; ++i) {
      const Interval times = times_of(i, ones, static_cast<double>(size_));
      window.push_back({static_cast<std::size_t>(times.least + 0.5),
                        static_cast<std::size_t>(times.greatest + 0.5)});
    }
    // The least and the most that so many other steps last.
    std::vector<double> seconds;
    for (const ConnectionIndex c : steps_) seconds.push_back(problem_.connections()[c].duration);
    std::vector<double> ascending = seconds;
    std::ranges::sort(ascending);
    std::vector<double> shortest(size_ + 1, 0.0);
    std::vector<double> longest(size_ + 1, 0.0);
    for (std::size_t k = 0; k < size_; ++k) {
      shortest[k + 1] = shortest[k] + ascending[k];
      longest[k + 1] = longest[k] + ascending[size_ - 1 - k];
    }
    const auto elapsed = [&](std::size_t i, std::size_t others) -> Interval {
      Interval times = times_of(i, seconds, all_seconds_);
      if (backwards_) {
        const double rest = all_seconds_ - seconds[i];
        times = {rest - times.greatest, rest - times.least};
      }
      return {seconds_of_start_ + std::max(times.least, shortest[others]),
              seconds_of_start_ + std::min(times.greatest, longest[others])};
    };
    exact_ = !prices_.by_seconds_.used;
    for (std::size_t i = 0; i < size_; ++i) {
      for (std::size_t k = window[i][0]; k <= window[i][1] && k < size_; ++k) {
        PlaceQuestion asked = question(i);
        const auto time = static_cast<double>(k);
        asked.time = {time, time};
        asked.before = {at_time(before_, time), {0, 0}};
        asked.after = {at_time(after_, time), {0, 0}};
        asked.elapsed = {elapsed(i, backwards_ ? size_ - 1 - k : k), {0, 0}};
        asked.completes = backwards_ ? k == 0 : k + 1 == size_;
        double sum = 0;
        for (const Addend& addend : addends_) {
          if (addend.way != Way::Seconds) sum += most_of(addend, i, asked);
        }
        if (std::isnan(sum) || sum == kInfinity) {
          prices_.known_ = false;
          return;
        }
        table[i * size_ + k] = sum;
      }
    }
    PlacePrices::Places& out = prices_.places_;
    out.used = true;
    out.pairs.from.resize(problem_.num_connections());
    out.pairs.to.resize(problem_.num_connections());
    out.of_connection.assign(problem_.num_connections(), 0);
    out.of_rest.assign(size_ + 1, 0);
    std::vector<Priced> constraints;
    for (const auto& [first, second] : before_after_) constraints.push_back({first, second, 1});
    const double cube = static_cast<double>(size_ * size_ * size_);
    const auto rounds = constraints.empty()
                            ? 0
                            : static_cast<std::size_t>(std::clamp(3e8 / (cube + 1), 5.0, 100.0));
    Assignment assignment(size_);
    std::vector<double> cost(size_ * size_);
    std::vector<double> slope(size_);
    std::vector<double> slack(constraints.size());
    Descent descent(rounds);
    double least = kInfinity;
    double plan = -kInfinity;
    std::vector<Priced> best;
    for (std::size_t round = 0; round <= rounds; ++round) {
      std::ranges::fill(slope, 0.0);
      double bound = 0;
      for (const Priced& priced : constraints) {
        slope[priced.second] += priced.price;
        slope[priced.first] -= priced.price;
        bound -= priced.price;
      }
      for (std::size_t i = 0; i < size_; ++i) {
        for (std::size_t k = 0; k < size_; ++k)
          cost[i * size_ + k] = 0.0 - (table[i * size_ + k] + slope[i] * static_cast<double>(k));
      }
      if (!assignment.solve(cost)) {
        prices_.known_ = false;
        return;
      }
      // Prices of connections anew, from those of places: whatever rounding did, none is too low.
      std::vector<double> of_step(size_);
      for (std::size_t i = 0; i < size_; ++i) {
        double most = -kInfinity;
        for (std::size_t k = 0; k < size_; ++k)
          most = std::max(most, assignment.column_price[k] - cost[i * size_ + k]);
        of_step[i] = most;
        bound += most - assignment.column_price[i];
      }
      if (bound < least) {
        least = bound;
        best = constraints;
        for (std::size_t i = 0; i < size_; ++i) out.of_connection[steps_[i]] = of_step[i];
        for (std::size_t k = size_; k-- > 0;)
          out.of_rest[k] = out.of_rest[k + 1] - assignment.column_price[k];
      }
      const std::vector<std::uint32_t> legal =
          order_by([&](std::uint32_t i) { return static_cast<double>(assignment.column_of[i]); });
      double earned = legal.empty() ? -kInfinity : 0;
      for (std::size_t k = 0; k < legal.size(); ++k) earned += table[legal[k] * size_ + k];
      if (earned > plan) {
        plan = earned;
        keep_order(legal);
      }
      if (round == rounds || !std::isfinite(plan) ||
          least <= plan + kRewardTolerance * std::max(1.0, std::abs(plan)))
        break;
      double squares = 0;
      for (std::size_t p = 0; p < constraints.size(); ++p) {
        const Priced& priced = constraints[p];
        slack[p] = static_cast<double>(assignment.column_of[priced.second]) -
                   static_cast<double>(assignment.column_of[priced.first]) - 1;
        if (priced.price == 0 && slack[p] > 0) slack[p] = 0;
        squares += slack[p] * slack[p];
      }
      if (squares == 0) break;
      const double step = descent.step(bound, plan, squares);
      for (std::size_t p = 0; p < constraints.size(); ++p)
        constraints[p].price = std::max(0.0, constraints[p].price - step * slack[p]);
    }
    for (const Priced& priced : best) {
      if (priced.price > 0) add_pair(out.pairs, priced);
    }
    PlacePrices::Values& values = prices_.values_;
    values.slack.assign(table.size(), kInfinity);
    std::ranges::fill(slope, 0.0);
    for (const Priced& priced : best) {
      slope[priced.second] += priced.price;
      slope[priced.first] -= priced.price;
    }
    for (std::size_t i = 0; i < size_; ++i) {
      for (std::size_t k = 0; k < size_; ++k) {
        const double earned = table[i * size_ + k];
        if (!std::isfinite(earned)) continue;
        values.slack[i * size_ + k] = out.of_connection[steps_[i]] + out.of_rest[k] -
                                      out.of_rest[k + 1] - earned -
                                      slope[i] * static_cast<double>(k);
      }
    }
    values.exact = exact_;
    values.table = std::move(table);
    prices_.most_of_start_ += least;
  }

  PlacePrices& prices_;
  const TransitionSystem& system_;
  const Problem& problem_;
  std::size_t size_;
  std::vector<ConnectionIndex> steps_;
  std::vector<Addend> addends_;
  bool backwards_ = false;
  FormulaLine before_;  ///< by the number of steps that came before in the walk
  FormulaLine after_;
  double seconds_of_start_ = 0;  ///< what had passed before any step of the plan
  double all_seconds_ = 0;       ///< what all steps last
  bool exact_ = true;            ///< whether most_of() was all that there is
  std::vector<unsigned char> may_separate_;
  std::vector<unsigned char> may_keep_;
  std::vector<std::array<std::uint32_t, 2>> before_after_;  ///< steps: the first before the second
  std::vector<std::vector<std::uint32_t>> next_;
  std::vector<std::uint32_t> sorted_;  ///< steps, each after all that must come before it
  std::vector<Bits> ahead_;            ///< by step: all that must come before it
  std::vector<Bits> behind_;           ///< and after it
};

PlacePrices::PlacePrices(const TransitionSystem& system, Terms terms) {
  PlacePricing pricing(*this, system, terms);
  try {
    pricing.work_out();
  } catch (const InputError&) {
    known_ = false;  // an objective that fails where it is asked for what no plan does
  }
}

}  // namespace orasp
