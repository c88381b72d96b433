#include "tests/fleet_oracle.h"

#include <algorithm>
#include <array>
#include <functional>
#include <set>

#include "orasp/model/random.h"

namespace orasp::fleet_oracle {
namespace {

int direction_number(const std::string& name) {
  constexpr std::array<const char*, 6> kNames = {"+x", "-x", "+y", "-y", "+z", "-z"};
  for (int d = 0; d < 6; ++d) {
    if (name == kNames.at(static_cast<std::size_t>(d))) return d + 1;
  }
  return 0;
}

/// 1 +x, 2 -x, 3 +y, ...
int reversed(int motion) {
  return motion % 2 == 1 ? motion + 1 : motion - 1;
}

}  // namespace

World::World(const ProblemSpec& spec) : spec_(spec) {
  const auto number = [&](const std::string& id) {
    const auto found = std::ranges::find(spec_.parts, id, &Part::id);
    return static_cast<int>(found - spec_.parts.begin());
  };
  for (Connection& connection : spec_.connections) {
    if (connection.id.empty()) connection.id = connection.parts[0] + "-" + connection.parts[1];
    ends_.emplace_back(number(connection.parts[0]), number(connection.parts[1]));
    axis_.push_back(direction_number(connection.axis));
  }
}

int World::motions() const {
  int greatest = 1;
  for (const int axis : axis_) greatest = std::max(greatest, (axis + 1) / 2 * 2);
  return parts() <= 4 ? 6 : greatest;
}

std::vector<int> World::groups(const State& state) const {
  std::vector<int> group(parts());
  for (std::size_t i = 0; i < group.size(); ++i) group[i] = static_cast<int>(i);
  for (std::size_t round = 0; round < parts(); ++round) {
    for (std::size_t c = 0; c < ends_.size(); ++c) {
      if (!state.open[c]) continue;
      int& a = group[static_cast<std::size_t>(ends_[c].first)];
      int& b = group[static_cast<std::size_t>(ends_[c].second)];
      a = b = std::min(a, b);
    }
  }
  return group;
}

bool World::well_placed(const State& state) const {
  const std::vector<int> group = groups(state);
  std::set<int> subassemblies;
  for (std::size_t i = 0; i < parts(); ++i) {
    bool joined = false;
    for (std::size_t c = 0; c < ends_.size(); ++c) {
      const bool touches =
          ends_[c].first == static_cast<int>(i) || ends_[c].second == static_cast<int>(i);
      joined = joined || (state.open[c] && touches);
    }
    if (joined != (state.place[i] != 0)) return false;
    if (joined) subassemblies.insert(group[i]);
    for (std::size_t j = 0; j < i; ++j) {
      if (group[i] == group[j] && state.place[i] != state.place[j]) return false;
      if (group[i] != group[j] && state.place[i] == state.place[j] && state.place[i] != 0)
        return false;
    }
  }
  const auto& most = spec_.limits.max_subassemblies;
  return !most || subassemblies.size() <= *most;
}

bool World::cuttable(std::size_t connection, const std::vector<int>& motion) const {
  const int first = motion[static_cast<std::size_t>(ends_[connection].first)];
  const int second = motion[static_cast<std::size_t>(ends_[connection].second)];
  const int away = axis_[connection];
  const int back = reversed(away);
  return (first == away && (second == 0 || second == back)) ||
         (second == back && (first == 0 || first == away));
}

bool World::precedence_met(std::size_t connection, const std::vector<bool>& open) const {
  const auto is_open = [&](const std::string& id) {
    const auto found = std::ranges::find(spec_.connections, id, &Connection::id);
    return static_cast<bool>(open[static_cast<std::size_t>(found - spec_.connections.begin())]);
  };
  for (const Precedence& rule : spec_.precedence) {
    if (rule.connection != spec_.connections[connection].id) continue;
    if (std::ranges::any_of(rule.after, is_open)) return false;
    if (!rule.after_any.empty() && std::ranges::all_of(rule.after_any, is_open)) return false;
  }
  return true;
}

bool World::blocked(int part, int other, int direction) const {
  if (!spec_.blocking) return false;
  const std::string& part_id = spec_.parts[static_cast<std::size_t>(part)].id;
  const std::string& other_id = spec_.parts[static_cast<std::size_t>(other)].id;
  for (const Blocked& entry : spec_.blocking->blocked) {
    for (const std::string& name : entry.directions) {
      const int d = direction_number(name);
      if (entry.part == part_id && entry.by == other_id && d == direction) return true;
      if (entry.part == other_id && entry.by == part_id && reversed(d) == direction) return true;
    }
  }
  return false;
}

double World::distance(int from, int to) const {
  const auto point = [&](int place) {
    return place == 0 ? spec_.fleet->depot
                      : spec_.fleet->sites[static_cast<std::size_t>(place - 1)];
  };
  const double x = point(from)[0] - point(to)[0];
  const double y = point(from)[1] - point(to)[1];
  return x * x + y * y;
}

std::vector<State> World::starts() const {
  std::vector<State> found;
  State state{std::vector<bool>(ends_.size(), true), std::vector<int>(parts(), 0)};
  const auto place = [&](auto& self, std::size_t part) -> void {
    if (part == parts()) {
      if (well_placed(state)) found.push_back(state);
      return;
    }
    for (int site = 0; site <= static_cast<int>(spec_.fleet->sites.size()); ++site) {
      state.place[part] = site;
      self(self, part + 1);
    }
    state.place[part] = 0;
  };
  place(place, 0);
  return found;
}

std::optional<State> World::after(const State& before, const std::vector<int>& motion,
                                  const std::vector<int>& place) const {
  State next{before.open, place};
  for (std::size_t c = 0; c < ends_.size(); ++c) {
    const bool alike = motion[static_cast<std::size_t>(ends_[c].first)] ==
                       motion[static_cast<std::size_t>(ends_[c].second)];
    if (!before.open[c] || alike) continue;
    if (!cuttable(c, motion) || !precedence_met(c, before.open)) return std::nullopt;
    next.open[c] = false;
  }
  if (!well_placed(next)) return std::nullopt;
  const std::vector<int> group_before = groups(before);
  const std::vector<int> group_after = groups(next);
  std::size_t robots = 0;
  for (std::size_t i = 0; i < parts(); ++i) {
    const bool leaves = place[i] != before.place[i];
    if (motion[i] == 0 && leaves && place[i] != 0) return std::nullopt;
    if (motion[i] == 0 && !leaves) continue;
    ++robots;
    std::size_t block = 0;
    double mass = 0;
    for (std::size_t j = 0; j < parts(); ++j) {
      if (group_after[i] == group_after[j]) {
        if (motion[i] != motion[j]) return std::nullopt;
        ++block;
        mass += spec_.parts[j].mass;
      }
      if (motion[i] != 0 && group_before[i] == group_before[j] && motion[i] != motion[j] &&
          blocked(static_cast<int>(i), static_cast<int>(j), motion[i]))
        return std::nullopt;
    }
    if (spec_.limits.max_moved_parts && block > *spec_.limits.max_moved_parts) return std::nullopt;
    if (spec_.limits.max_moved_mass && mass > *spec_.limits.max_moved_mass) return std::nullopt;
  }
  if (robots > spec_.fleet->robots) return std::nullopt;
  return next;
}

std::map<State, double> World::successors(const State& before) const {
  std::map<State, double> found;
  std::vector<int> motion(parts(), 0);
  std::vector<int> place(parts(), 0);
  const auto place_all = [&] {
    // Which parts end up joined depends on the motions alone.
    State next{before.open, place};
    for (std::size_t c = 0; c < ends_.size(); ++c) {
      next.open[c] = before.open[c] && motion[static_cast<std::size_t>(ends_[c].first)] ==
                                           motion[static_cast<std::size_t>(ends_[c].second)];
    }
    const std::vector<int> group = groups(next);
    const auto choose = [&](auto& self, std::size_t part) -> void {
      if (part == parts()) {
        const std::optional<State> state = after(before, motion, place);
        if (!state) return;
        double cost = 0;
        for (std::size_t i = 0; i < parts(); ++i) cost += distance(before.place[i], place[i]);
        const auto [entry, is_new] = found.emplace(*state, cost);
        if (!is_new) entry->second = std::min(entry->second, cost);
        return;
      }
      if (group[part] != static_cast<int>(part)) {
        place[part] = place[static_cast<std::size_t>(group[part])];
        self(self, part + 1);
        return;
      }
      const bool single = std::ranges::count(group, group[part]) == 1;  // goes to the depot
      const int last = single ? 0 : static_cast<int>(spec_.fleet->sites.size());
      for (int site = single ? 0 : 1; site <= last; ++site) {
        place[part] = site;
        self(self, part + 1);
      }
    };
    choose(choose, 0);
  };
  // Only to save time: whether the motions of the first parts break a rule already.
  const auto forbidden = [&](std::size_t count) {
    const auto moving =
        std::count_if(motion.begin(), motion.begin() + static_cast<std::ptrdiff_t>(count),
                      [](int m) { return m != 0; });
    if (static_cast<std::size_t>(moving) > spec_.fleet->robots) return true;
    for (std::size_t c = 0; c < ends_.size(); ++c) {
      const auto i = static_cast<std::size_t>(ends_[c].first);
      const auto j = static_cast<std::size_t>(ends_[c].second);
      if (before.open[c] && i < count && j < count && motion[i] != motion[j] &&
          !cuttable(c, motion))
        return true;
    }
    return false;
  };
  const auto move = [&](auto& self, std::size_t part) -> void {
    if (forbidden(part)) return;
    if (part == parts()) {
      place_all();
      return;
    }
    // A part in the depot stays there: it has nothing to do.
    const int most = before.place[part] == 0 ? 0 : motions();
    for (motion[part] = 0; motion[part] <= most; ++motion[part]) self(self, part + 1);
    motion[part] = 0;
  };
  move(move, 0);
  return found;
}

bool World::done(const State& state) {
  return std::ranges::none_of(state.open, [](bool open) { return open; });
}

Truth brute_force(const ProblemSpec& spec, std::size_t steps) {
  const World world(spec);
  std::map<State, std::map<State, double>> steps_from;
  std::map<State, double> now;
  for (const State& state : world.starts()) now.emplace(state, 0);
  Truth truth;
  std::set<State> met;
  for (std::size_t t = 0;; ++t) {
    double least = kNever;
    bool fresh = false;
    for (const auto& [state, cost] : now) {
      if (World::done(state)) least = std::min(least, cost);
      fresh = met.insert(state).second || fresh;
    }
    if (least < kNever && !truth.makespan) truth.makespan = t;
    truth.travel.push_back(least);
    if (t >= steps && (truth.makespan || !fresh)) break;
    std::map<State, double> next;
    for (const auto& [state, cost] : now) {
      auto [entry, is_new] = steps_from.try_emplace(state);
      if (is_new) entry->second = world.successors(state);
      for (const auto& [after, more] : entry->second) {
        const auto [place, first] = next.emplace(after, cost + more);
        if (!first) place->second = std::min(place->second, cost + more);
      }
    }
    now = std::move(next);
  }
  return truth;
}

ProblemSpec random_fleet(std::uint64_t seed) {
  SplitMix64 random(seed * 7919 + 1);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random.below(n)); };
  const auto chance = [&](double share) { return random.uniform() < share; };
  ProblemSpec spec;
  spec.name = "fleet seed " + std::to_string(seed);
  const bool crowded =
      seed % 3 == 0;  // corners that cannot leave alone: moving more than once pays
  const std::size_t parts = crowded ? 5 + below(2) : 1 + below(6);
  const std::size_t dimensions = parts <= 3 ? 3 : 2;
  // Parts on a raster; neighbours may be joined along the line between them.
  std::vector<std::array<std::size_t, 2>> at;
  for (std::size_t p = 0; p < parts; ++p) {
    Part part;
    part.id = std::string(1, static_cast<char>('a' + p));
    part.mass = static_cast<double>(1 + below(3));
    spec.parts.push_back(part);
    at.push_back({p % 3, p / 3});
  }
  const bool on_raster = crowded || chance(0.7);
  const auto join = [&](std::size_t i, std::size_t j, std::string axis) {
    Connection connection;
    connection.parts = {spec.parts[i].id, spec.parts[j].id};
    connection.id = "c" + std::to_string(spec.connections.size());
    connection.axis = std::move(axis);
    spec.connections.push_back(connection);
  };
  const auto any_axis = [&] { return std::string(kDirectionNames.at(below(2 * dimensions))); };
  for (std::size_t i = 0; i < parts; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (on_raster) {
        if (at[i][1] == at[j][1] && at[i][0] == at[j][0] + 1 && (crowded || chance(0.9)))
          join(i, j, "+x");
        if (at[i][0] == at[j][0] && at[i][1] == at[j][1] + 1 && (crowded || chance(0.9)))
          join(j, i, "-y");
      } else if (chance(1.6 / static_cast<double>(parts))) {
        join(i, j, any_axis());
      }
    }
  }
  if (!spec.connections.empty() && chance(0.1)) {
    const Connection twin = spec.connections[below(spec.connections.size())];
    join(static_cast<std::size_t>(twin.parts[1][0] - 'a'),
         static_cast<std::size_t>(twin.parts[0][0] - 'a'), any_axis());
  }
  if (!spec.connections.empty() && chance(crowded ? 0.2 : 0.35)) {
    for (std::size_t n = 1 + below(2); n > 0; --n) {
      const auto any = [&] { return spec.connections[below(spec.connections.size())].id; };
      Precedence rule{.connection = any(), .after = {}, .after_any = {}};
      if (chance(0.7)) rule.after = {any()};
      if (chance(0.4)) rule.after_any = {any(), any()};
      spec.precedence.push_back(rule);
    }
  }
  if (parts > 1 && chance(crowded ? 0.05 : 0.35)) {
    Blocking blocking{.directions = {"+x", "-x", "+y", "-y"}, .blocked = {}};
    for (std::size_t n = 1 + below(3); n > 0; --n) {
      const std::size_t i = below(parts);
      const std::size_t j = (i + 1 + below(parts - 1)) % parts;
      blocking.blocked.push_back({.part = spec.parts[i].id,
                                  .by = spec.parts[j].id,
                                  .directions = {blocking.directions[below(4)].id}});
    }
    spec.blocking = blocking;
  }
  if (!crowded && chance(0.2)) spec.limits.max_subassemblies = 1 + below(2);
  if (!crowded && chance(0.2)) spec.limits.max_moved_parts = 1 + below(3);
  if (!crowded && chance(0.15)) spec.limits.max_moved_mass = static_cast<double>(2 + below(5));
  Fleet fleet{.robots = crowded ? 3 : 1 + below(4), .depot = {0, 0}, .sites = {}};
  for (std::size_t n = crowded ? 3 : 1 + below(3); n > 0; --n) {
    const double far = crowded && n > 1 ? static_cast<double>(below(3)) : 0;
    fleet.sites.push_back(
        {static_cast<double>(below(4)) - 1 + far, static_cast<double>(below(3)) - 1});
  }
  spec.fleet = fleet;
  spec.objective = Objective::named("makespan");
  return spec;
}

}  // namespace orasp::fleet_oracle
