#include "orasp/io/formats/mjcf.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "orasp/io/formats/detail/text_checks.h"
#include "orasp/io/formats/detail/xml_document.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

using detail::in_quotes;
using pugi::xml_node;

/// The numbers of an attribute such as size="0.1 0.2"; nothing where one is none.
std::optional<std::vector<double>> numbers_in(std::string_view text) {
  std::vector<double> numbers;
  std::string_view rest = detail::trimmed(text);
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    const auto number = detail::number_in(rest.substr(0, end));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    rest = detail::trimmed(rest.substr(end));
  }
  return numbers;
}

/// m^3, where the shape is one of those that MuJoCo measures by `size` alone.
std::optional<double> volume_of(xml_node geom) {
  constexpr double kPi = std::numbers::pi;
  const auto size = numbers_in(geom.attribute("size").value());
  if (!size || geom.attribute("fromto")) return std::nullopt;
  const std::string_view type = geom.attribute("type").as_string("sphere");
  const auto has = [&size](std::size_t count) { return size->size() >= count; };
  const auto s = [&size](std::size_t i) { return (*size)[i]; };
  if (type == "sphere" && has(1)) return 4.0 / 3 * kPi * s(0) * s(0) * s(0);
  if (type == "capsule" && has(2)) return kPi * s(0) * s(0) * (2 * s(1) + 4.0 / 3 * s(0));
  if (type == "cylinder" && has(2)) return kPi * s(0) * s(0) * 2 * s(1);
  if (type == "ellipsoid" && has(3)) return 4.0 / 3 * kPi * s(0) * s(1) * s(2);
  if (type == "box" && has(3)) return 8 * s(0) * s(1) * s(2);
  return std::nullopt;
}

std::optional<double> mass_of_geom(xml_node geom) {
  constexpr double kDefaultDensity = 1000;  // kg/m^3, as MuJoCo's
  if (const auto mass = geom.attribute("mass")) return detail::number_in(mass.value());
  double density = kDefaultDensity;
  if (const auto stated = geom.attribute("density")) {
    const auto number = detail::number_in(stated.value());
    if (!number) return std::nullopt;
    density = *number;
  }
  if (density == 0) return 0;
  const auto volume = volume_of(geom);
  if (!volume) return std::nullopt;
  return *volume * density;
}

class MjcfReader {
 public:
  explicit MjcfReader(std::string_view text) : document_(text) {}

  Converted read() {
    const xml_node root = document_.root();
    if (std::string_view(root.name()) != "mujoco") {
      throw InputError(fmt::format("{}: the outermost element of MJCF is <mujoco>, not <{}>",
                                   document_.place(root), root.name()));
    }
    converted_.problem.name = root.attribute("model").value();
    for (const xml_node section : root.children()) {
      require_written_out(section);
      const std::string_view name = section.name();
      if (name == "default" && section.first_child()) masses_known_ = false;
      if (name == "compiler" &&
          (section.attribute("settotalmass") || section.attribute("inertiafromgeom")))
        masses_known_ = false;
      if (name == "worldbody") read_world(section);
    }
    if (converted_.problem.parts.empty())
      throw InputError("there is no <body> in a <worldbody>, so there are no parts");
    for (const xml_node section : root.children("equality")) {
      for (const xml_node constraint : section.children()) read_constraint(constraint);
    }
    finish();
    return std::move(converted_);
  }

 private:
  /// Refuses what stands for bodies that are not there.
  void require_written_out(xml_node node) const {
    for (const char* name : {"include", "composite", "flexcomp", "replicate", "attach"}) {
      if (std::string_view(node.name()) != name) continue;
      throw InputError(
          fmt::format("{}: <{}> is not followed; let MuJoCo write the whole model out "
                      "first (mj_saveLastXML)",
                      document_.place(node), name));
    }
  }

  /// In the order of the file; a <frame> only moves what stands in it.
  void read_world(xml_node world) {
    std::vector<xml_node> open = {world};
    while (!open.empty()) {
      const xml_node node = open.back();
      open.pop_back();
      require_written_out(node);
      if (std::string_view(node.name()) == "body") {
        read_part(node);
      } else if (node == world || std::string_view(node.name()) == "frame") {
        for (xml_node child = node.last_child(); child; child = child.previous_sibling())
          open.push_back(child);
      }
    }
  }

  /// A body of the world, with all that hangs on it.
  void read_part(xml_node body) {
    std::vector<Part>& parts = converted_.problem.parts;
    if (parts.size() == kMaxParts) {
      throw InputError(
          fmt::format("{}: more than {} bodies, the most parts that a problem may have",
                      document_.place(body), kMaxParts));
    }
    const std::size_t index = parts.size();
    std::string id = body.attribute("name").value();
    if (id.empty()) id = fmt::format("body {}", index + 1);
    if (const auto fault = detail::id_fault(id))
      throw InputError(fmt::format("{}: the name {}", document_.place(body), *fault));
    if (!ids_.insert(id).second) {
      throw InputError(
          fmt::format("{}: the body {} is there already", document_.place(body), in_quotes(id)));
    }
    Part part{.id = id};
    double mass = 0;
    std::vector<xml_node> open = {body};
    while (!open.empty()) {
      const xml_node node = open.back();
      open.pop_back();
      if (std::string_view(node.name()) == "body") name_body(node, index);
      const xml_node inertial = node.child("inertial");
      if (inertial) {
        const auto stated = detail::number_in(inertial.attribute("mass").value());
        add_mass(stated, node, mass);
      }
      for (const xml_node child : node.children()) {
        require_written_out(child);
        const std::string_view kind = child.name();
        if (kind == "body" || kind == "frame") open.push_back(child);
        if (kind == "site" && *child.attribute("name").value() != 0)
          part_of_site_.emplace(child.attribute("name").value(), index);
        if (kind == "geom" && !inertial) add_mass(mass_of_geom(child), child, mass);
      }
    }
    part.mass = mass;
    parts.push_back(std::move(part));
  }

  void name_body(xml_node body, std::size_t part) {
    const std::string name = body.attribute("name").value();
    if (!name.empty()) part_of_body_.emplace(name, part);
  }

  void add_mass(std::optional<double> added, xml_node where, double& mass) {
    if (!added || *added < 0) {
      if (unknown_mass_.empty()) unknown_mass_ = document_.place(where);
    } else {
      mass += *added;
    }
  }

  /// The part at one end of a constraint; nothing for the world.
  std::optional<std::size_t> end_of(xml_node weld, const char* body, const char* site) const {
    const bool by_site = static_cast<bool>(weld.attribute(site));
    const std::string name = weld.attribute(by_site ? site : body).value();
    if (name.empty() || (!by_site && name == "world")) return std::nullopt;
    const auto& known = by_site ? part_of_site_ : part_of_body_;
    const auto found = known.find(name);
    if (found == known.end()) {
      throw InputError(fmt::format("{}: there is no {} {}", document_.place(weld),
                                   by_site ? "site" : "body", in_quotes(name)));
    }
    return found->second;
  }

  void read_constraint(xml_node constraint) {
    require_written_out(constraint);
    if (std::string_view(constraint.name()) != "weld") {
      if (constraint.type() == pugi::node_element) ++others_;
      return;
    }
    const auto a = end_of(constraint, "body1", "site1");
    const auto b = end_of(constraint, "body2", "site2");
    if (!a || !b) {
      ++to_the_world_;
      return;
    }
    if (*a == *b) {
      ++within_;
      return;
    }
    if (!pairs_.emplace(std::min(*a, *b), std::max(*a, *b)).second) {
      ++repeated_;
      return;
    }
    if (converted_.problem.connections.size() == kMaxConnections) {
      throw InputError(
          fmt::format("{}: more than {} welds, the most connections that a problem may have",
                      document_.place(constraint), kMaxConnections));
    }
    const std::vector<Part>& parts = converted_.problem.parts;
    converted_.problem.connections.push_back({.parts = {parts[*a].id, parts[*b].id}});
  }

  void note(std::size_t count, std::string_view one, std::string_view several,
            std::string_view why) {
    if (count > 0)
      converted_.notes.push_back(fmt::format("{} {}: {}", count, count == 1 ? one : several, why));
  }

  void finish() {
    note(repeated_, "weld repeats a pair of bodies", "welds repeat a pair of bodies",
         "each pair is one connection");
    note(to_the_world_, "weld to the world is left out", "welds to the world are left out",
         "the world is no part");
    note(within_, "weld is left out", "welds are left out", "it joins bodies of one part");
    note(others_, "constraint is left out", "constraints are left out",
         "welds alone are connections");
    if (!masses_known_ || !unknown_mass_.empty()) {
      for (Part& part : converted_.problem.parts) part.mass = Part{}.mass;
      converted_.notes.push_back(
          unknown_mass_.empty()
              ? "masses are left out, so each part has 1 kg: they depend on defaults of the model"
              : fmt::format("masses are left out, so each part has 1 kg: {} does not tell its own",
                            unknown_mass_));
    }
  }

  detail::XmlDocument document_;
  Converted converted_;
  std::unordered_set<std::string> ids_;
  std::unordered_map<std::string, std::size_t> part_of_body_;
  std::unordered_map<std::string, std::size_t> part_of_site_;
  std::set<std::pair<std::size_t, std::size_t>> pairs_;
  bool masses_known_ = true;
  std::string unknown_mass_;  ///< where the first one stands that is not known
  std::size_t repeated_ = 0;
  std::size_t to_the_world_ = 0;
  std::size_t within_ = 0;
  std::size_t others_ = 0;
};

}  // namespace

Converted read_mjcf(std::string_view text) {
  return MjcfReader(text).read();
}

}  // namespace orasp
