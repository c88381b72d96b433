#include "orasp/geometry/blocking.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tuple>
#include <utility>

#include "orasp/geometry/detail/for_each_index.h"
#include "orasp/geometry/detail/frame.h"
#include "orasp/geometry/detail/pair_blocking.h"
#include "orasp/geometry/detail/part_shape.h"

namespace orasp {
namespace {

using detail::PairVerdict;
using detail::PartShape;
using detail::View;

// A direction that was asked for, and its opposite where that was asked for as well.
struct Line {
  Vector3 direction{};
  std::vector<std::uint32_t> along, against;
};

std::vector<Line> lines_of(std::span<const Vector3> directions) {
  std::vector<Line> lines;
  for (std::uint32_t i = 0; i < directions.size(); ++i) {
    const Vector3 d = detail::normalized(directions[i]);
    bool placed = false;
    for (Line& line : lines) {
      const double apart = detail::length(detail::minus(d, line.direction));
      const double opposite = detail::length(detail::plus(d, line.direction));
      if (apart > 1e-9 && opposite > 1e-9) continue;
      (apart <= 1e-9 ? line.along : line.against).push_back(i);
      placed = true;
      break;
    }
    if (!placed && detail::dot(d, d) > 0) lines.push_back({d, {i}, {}});
  }
  return lines;
}

// What the contacts say of pairs, by pair.
struct Touching {
  std::uint32_t a, b;
  double thickness;
};

std::vector<Touching> touching_pairs(std::span<const Contact> contacts) {
  std::vector<Touching> pairs;
  for (const Contact& contact : contacts) {
    if (contact.proposed) continue;
    pairs.push_back({std::min(contact.a, contact.b), std::max(contact.a, contact.b),
                     contact.overlap ? contact.overlap->thickness : 0.0});
  }
  std::sort(pairs.begin(), pairs.end(), [](const Touching& x, const Touching& y) {
    return std::pair(x.a, x.b) < std::pair(y.a, y.b);
  });
  return pairs;
}

struct PairInSight {
  std::uint32_t a, b;
};

// The pairs whose shadows' boxes overlap by more than `least` both ways, by a sweep along u.
std::vector<PairInSight> pairs_in_sight(const std::vector<View>& views, double least) {
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < views.size(); ++i) {
    if (!views[i].tree->empty()) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](std::uint32_t x, std::uint32_t y) {
    return std::pair(views[x].box.low[0], x) < std::pair(views[y].box.low[0], y);
  });
  std::vector<PairInSight> pairs;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Box& box = views[order[i]].box;
    for (std::size_t j = i + 1; j < order.size(); ++j) {
      const Box& other = views[order[j]].box;
      if (!(other.low[0] + least < box.high[0])) break;
      const double across =
          std::min(box.high[1], other.high[1]) - std::max(box.low[1], other.low[1]);
      if (across > least) {
        pairs.push_back({std::min(order[i], order[j]), std::max(order[i], order[j])});
      }
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const PairInSight& x, const PairInSight& y) {
    return std::pair(x.a, x.b) < std::pair(y.a, y.b);
  });
  return pairs;
}

// All parts turned so that w runs along the direction of a frame.
class Scene {
 public:
  Scene(const std::vector<PartShape>& shapes, const GeometrySettings& settings)
      : shapes_(shapes), settings_(settings), points_(shapes.size()), views_(shapes.size()) {}

  void turn(const detail::Frame& frame) {
    detail::for_each_index(shapes_.size(), settings_, [&](std::size_t, std::size_t i) {
      const detail::TriangleTree& tree = shapes_[i].tree;
      views_[i] = {&tree, &points_[i], {}};
      if (tree.empty()) return;
      points_[i].resize(tree.vertices().size());
      for (std::size_t v = 0; v < points_[i].size(); ++v) {
        points_[i][v] = frame.turned(tree.vertices()[v]);
      }
      for (std::size_t t = 0; t < tree.size(); ++t) {
        for (const std::uint32_t vertex : tree.triangle(t)) views_[i].box.add(points_[i][vertex]);
      }
    });
  }
  [[nodiscard]] const std::vector<View>& views() const { return views_; }

 private:
  const std::vector<PartShape>& shapes_;
  const GeometrySettings& settings_;
  std::vector<std::vector<Vector3>> points_;
  std::vector<View> views_;
};

void add_facts(std::vector<BlockingFact>& facts, const Line& line, const PairInSight& pair,
               const std::array<PairVerdict, 2>& verdicts) {
  const auto add = [&](std::uint32_t part, std::uint32_t by, const PairVerdict& verdict,
                       const std::vector<std::uint32_t>& directions) {
    if (!verdict.blocked) return;
    for (const std::uint32_t direction : directions) {
      facts.push_back({part, by, direction, verdict.width, verdict.depth});
    }
  };
  // What keeps a from leaving b one way keeps b from leaving a the other way.
  add(pair.a, pair.b, verdicts[0], line.along);
  add(pair.b, pair.a, verdicts[0], line.against);
  add(pair.b, pair.a, verdicts[1], line.along);
  add(pair.a, pair.b, verdicts[1], line.against);
}

}  // namespace

std::vector<BlockingFact> find_blocking(std::span<const CadPart> parts,
                                        std::span<const Contact> contacts,
                                        std::span<const Vector3> directions,
                                        const GeometrySettings& settings) {
  const std::vector<PartShape> shapes = detail::part_shapes(parts, settings);
  const std::vector<Touching> touching = touching_pairs(contacts);
  const double least = 2 * settings.tolerance;
  Scene scene(shapes, settings);
  std::vector<detail::PairBlocking> workers(std::max(1U, settings.threads));
  std::vector<BlockingFact> facts;
  for (const Line& line : lines_of(directions)) {
    const detail::Frame frame = detail::frame_along(line.direction);
    scene.turn(frame);
    const std::vector<PairInSight> pairs = pairs_in_sight(scene.views(), least);
    std::vector<std::array<PairVerdict, 2>> verdicts(pairs.size());
    detail::for_each_index(pairs.size(), settings, [&](std::size_t thread, std::size_t i) {
      const PairInSight& pair = pairs[i];
      detail::PairView view;
      view.a = &scene.views()[pair.a];
      view.b = &scene.views()[pair.b];
      view.frame = frame;
      view.closed = {shapes[pair.a].closed, shapes[pair.b].closed};
      view.inside_out = {shapes[pair.a].inside_out, shapes[pair.b].inside_out};
      view.tolerance = settings.tolerance;
      view.width_limit = least;
      const auto touch = std::lower_bound(touching.begin(), touching.end(), pair,
                                          [](const Touching& x, const PairInSight& y) {
                                            return std::pair(x.a, x.b) < std::pair(y.a, y.b);
                                          });
      if (touch != touching.end() && touch->a == pair.a && touch->b == pair.b && view.closed[0] &&
          view.closed[1]) {
        view.overlap = true;
        view.width_limit = std::max(least, 1.5 * touch->thickness);
      }
      verdicts[i] = workers[thread].decide(view);
    });
    for (std::size_t i = 0; i < pairs.size(); ++i) add_facts(facts, line, pairs[i], verdicts[i]);
  }
  std::sort(facts.begin(), facts.end(), [](const BlockingFact& x, const BlockingFact& y) {
    return std::tuple(x.direction, x.part, x.by) < std::tuple(y.direction, y.part, y.by);
  });
  return facts;
}

}  // namespace orasp
