#include "orasp/io/certificate_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "orasp/io/detail/json_document.h"
#include "orasp/io/detail/json_text.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/detail/wording.h"

namespace orasp {
namespace {

using detail::in_quotes;
using detail::inline_text;
using detail::JsonDocument;
using detail::JsonKind;
using detail::JsonValue;
using detail::number_or_null;

constexpr std::string_view kCertificateFormat = "orasp-certificate/1";
constexpr std::string_view kHexDigits = "0123456789abcdef";
constexpr std::array kKinds = {Certificate::Kind::Sizes,  Certificate::Kind::Prices,
                               Certificate::Kind::Places, Certificate::Kind::Pieces,
                               Certificate::Kind::States, Certificate::Kind::Waits,
                               Certificate::Kind::Locked};

/// A digit for four of `count` things, the first one for the first four; its lowest bit is the
/// first.
template <class Indices>
std::string digits_of(const Indices& members, std::size_t count) {
  std::string digits((count + 3) / 4, '0');
  std::vector<unsigned> values(digits.size(), 0);
  for (const std::size_t i : members) values[i / 4] |= 1U << (i % 4);
  for (std::size_t i = 0; i < digits.size(); ++i) digits[i] = kHexDigits[values[i]];
  return digits;
}

std::string digits_of(const ConnectionSet& present, std::size_t connections) {
  std::vector<ConnectionIndex> members;
  for_each_connection(present.view(), [&](ConnectionIndex c) { members.push_back(c); });
  return digits_of(members, connections);
}

/// Reads one file; every member throws InputError that names the place.
class CertificateReader {
 public:
  CertificateReader(const Problem& problem, JsonValue root) : problem_(problem) {
    if (!root.is(JsonKind::Object))
      throw InputError("expected an object, found " + root.description());
    root.for_each([this](JsonValue member) { members_.emplace(member.key(), member); });
  }

  Certificate read() {
    const std::string format = text(member("format"), "format");
    if (format != kCertificateFormat)
      throw InputError(fmt::format("format: {} is not the format of a certificate; that is \"{}\"",
                                   in_quotes(format), kCertificateFormat));
    if (text(member("problem_digest"), "problem_digest") != problem_digest(problem_))
      throw InputError(
          "problem_digest: the certificate was made for another problem than this one, objective, "
          "limits and direction included");
    if (members_.contains("problem")) text(member("problem"), "problem");
    const std::string kind = text(member("kind"), "kind");
    const auto* const known =
        std::ranges::find_if(kKinds, [&](Certificate::Kind one) { return kind_name(one) == kind; });
    if (known == kKinds.end())
      throw InputError(fmt::format(
          "kind: {} is none; kinds are \"sizes\", \"prices\", \"places\", \"pieces\", \"states\", "
          "\"waits\" and \"locked\"",
          in_quotes(kind)));
    certificate_.kind = *known;
    certificate_.bound = number(member("bound"), "bound");
    switch (certificate_.kind) {
      case Certificate::Kind::Sizes: certificate_.sizes = numbers("sizes"); break;
      case Certificate::Kind::Prices:
        certificate_.sizes = numbers("sizes");
        certificate_.prices = numbers("prices");
        if (members_.contains("together")) read_together();
        break;
      case Certificate::Kind::Places:
        certificate_.connections = numbers("connections");
        certificate_.places = numbers("places");
        break;
      case Certificate::Kind::Pieces:
        certificate_.sizes = numbers("sizes");
        read_pieces();
        break;
      case Certificate::Kind::States: read_layers(); break;
      case Certificate::Kind::Waits: read_waiting(); break;
      case Certificate::Kind::Locked: read_parts(); break;
    }
    for (const auto& [key, value] : members_) {
      static_cast<void>(value);
      if (!asked_.contains(key) && key != "problem" && key != "note" && !key.starts_with("x-"))
        throw InputError(fmt::format("unknown key {}", in_quotes(key)));
    }
    return std::move(certificate_);
  }

 private:
  JsonValue member(const std::string& key) {
    const auto found = members_.find(key);
    if (found == members_.end())
      throw InputError(fmt::format("the key {} is missing", in_quotes(key)));
    asked_.emplace(key, true);
    return found->second;
  }
  static JsonValue expect(JsonValue value, JsonKind kind, const std::string& place,
                          std::string_view wanted) {
    if (!value.is(kind))
      throw InputError(
          detail::at(place, fmt::format("expected {}, found {}", wanted, value.description())));
    return value;
  }
  static std::string text(JsonValue value, const std::string& place) {
    return std::string(expect(value, JsonKind::String, place, "a string").string());
  }
  /// null stands for -infinity.
  static double number(JsonValue value, const std::string& place) {
    if (value.is(JsonKind::Null)) return -kInfinity;
    return expect(value, JsonKind::Number, place, "a number or null").number();
  }

  std::vector<double> numbers(const std::string& key) {
    std::vector<double> values;
    expect(member(key), JsonKind::Array, key, "an array of numbers").for_each([&](JsonValue value) {
      values.push_back(number(value, fmt::format("{}[{}]", key, values.size())));
    });
    return values;
  }
  void read_pieces() {
    expect(member("pieces"), JsonKind::Array, "pieces", "an array of pieces")
        .for_each([&](JsonValue entry) {
          certificate_.pieces.push_back(
              piece(entry, fmt::format("pieces[{}]", certificate_.pieces.size())));
        });
  }
  [[nodiscard]] Certificate::Piece piece(JsonValue entry, const std::string& place) const {
    expect(entry, JsonKind::Array, place, "a set of parts, a number of subassemblies and a value");
    if (entry.size() != 3)
      throw InputError(detail::at(
          place, fmt::format("expected a set of parts, a number of subassemblies and a value, "
                             "found {} values",
                             entry.size())));
    Certificate::Piece piece;
    std::size_t at = 0;
    entry.for_each([&](JsonValue value) {
      const std::string here = fmt::format("{}[{}]", place, at);
      if (at == 0) {
        for (const std::size_t part :
             members(text(value, here), problem_.num_parts(), "parts", here))
          piece.parts.push_back(static_cast<PartIndex>(part));
      } else if (at == 1) {
        const double allowed = number(value, here);
        if (!(allowed >= 0) || allowed > static_cast<double>(kMaxParts) ||
            allowed != std::floor(allowed))
          throw InputError(detail::at(here, "expected a number of subassemblies"));
        piece.allowed = static_cast<std::size_t>(allowed);
      } else {
        piece.value = number(value, here);
      }
      ++at;
    });
    return piece;
  }
  void read_layers() {
    auto& layers = certificate_.layers;
    expect(member("layers"), JsonKind::Array, "layers", "an array of arrays")
        .for_each([&](JsonValue layer) {
          const std::string place = fmt::format("layers[{}]", layers.size());
          layers.emplace_back();
          expect(layer, JsonKind::Array, place, "an array of states")
              .for_each([&](JsonValue entry) {
                layers.back().push_back(
                    state(entry, fmt::format("{}[{}]", place, layers.back().size())));
              });
        });
  }
  [[nodiscard]] Certificate::State state(JsonValue entry, const std::string& place) const {
    expect(entry, JsonKind::Array, place, "a state and its number");
    if (entry.size() != 2)
      throw InputError(detail::at(place, "expected a state and its number, found " +
                                             std::to_string(entry.size()) + " values"));
    Certificate::State state;
    bool first = true;
    entry.for_each([&](JsonValue value) {
      if (first) {
        state.present = set(text(value, place + "[0]"), place + "[0]");
      } else {
        state.value = number(value, place + "[1]");
      }
      first = false;
    });
    return state;
  }
  [[nodiscard]] ConnectionSet set(const std::string& digits, const std::string& place) const {
    ConnectionSet present(problem_.num_connections());
    for (const std::size_t c : members(digits, present.universe(), "connections", place))
      present.insert(static_cast<ConnectionIndex>(c));
    return present;
  }
  /// The set that digits stand for, ascending.
  static std::vector<std::size_t> members(const std::string& digits, std::size_t count,
                                          std::string_view things, const std::string& place) {
    std::vector<std::size_t> found;
    bool fits = digits.size() == (count + 3) / 4;
    for (std::size_t i = 0; fits && i < digits.size(); ++i) {
      const std::size_t value = kHexDigits.find(digits[i]);
      if (value == std::string_view::npos) fits = false;
      for (std::size_t bit = 0; fits && bit < 4; ++bit) {
        if ((value >> bit & 1U) == 0) continue;
        fits = 4 * i + bit < count;
        if (fits) found.push_back(4 * i + bit);
      }
    }
    if (!fits)
      throw InputError(detail::at(place, fmt::format("{} is no set of {} {}: a hexadecimal digit "
                                                     "stands for four of them",
                                                     in_quotes(digits), count, things)));
    return found;
  }
  void read_waiting() {
    const std::string end = text(member("end"), "end");
    if (end != "first removed" && end != "first made")
      throw InputError("end: expected \"first removed\" or \"first made\", found " +
                       in_quotes(end));
    certificate_.first = end == "first removed";
    expect(member("waiting"), JsonKind::Array, "waiting", "an array of connection ids")
        .for_each([this](JsonValue id) {
          const std::string place = fmt::format("waiting[{}]", certificate_.waiting.size());
          certificate_.waiting.push_back(problem_.find_connection(text(id, place), place));
        });
  }
  void read_together() {
    expect(member("together"), JsonKind::Array, "together", "an array of parts and groups")
        .for_each([&](JsonValue entry) {
          const std::string place = fmt::format("together[{}]", certificate_.together.size());
          expect(entry, JsonKind::Array, place, "the part that stays, and groups of parts");
          Certificate::Together together;
          std::size_t at = 0;
          entry.for_each([&](JsonValue value) {
            const std::string here = fmt::format("{}[{}]", place, at);
            if (at++ == 0) {
              together.stays = problem_.find_part(text(value, here), here);
              return;
            }
            std::vector<PartIndex>& group = together.groups.emplace_back();
            expect(value, JsonKind::Array, here, "part ids").for_each([&](JsonValue id) {
              const std::string one = fmt::format("{}[{}]", here, group.size());
              group.push_back(problem_.find_part(text(id, one), one));
            });
          });
          if (at == 0) throw InputError(detail::at(place, "the part that stays is missing"));
          certificate_.together.push_back(std::move(together));
        });
  }
  void read_parts() {
    const JsonValue parts = expect(member("parts"), JsonKind::Array, "parts", "two part ids");
    if (parts.size() != 2)
      throw InputError(fmt::format("parts: expected two part ids, found {}", parts.size()));
    std::size_t i = 0;
    parts.for_each([&](JsonValue id) {
      const std::string place = fmt::format("parts[{}]", i);
      certificate_.locked.at(i++) = problem_.find_part(text(id, place), place);
    });
  }

  const Problem& problem_;
  Certificate certificate_;
  std::map<std::string, JsonValue, std::less<>> members_;
  std::map<std::string, bool, std::less<>> asked_;
};

nlohmann::ordered_json together_json(const Problem& problem, const Certificate& certificate) {
  auto all = nlohmann::ordered_json::array();
  for (const Certificate::Together& together : certificate.together) {
    auto entry = nlohmann::ordered_json::array({problem.part_id(together.stays)});
    for (const std::vector<PartIndex>& group : together.groups) {
      auto ids = nlohmann::ordered_json::array();
      for (const PartIndex part : group) ids.push_back(problem.part_id(part));
      entry.push_back(std::move(ids));
    }
    all.push_back(std::move(entry));
  }
  return all;
}

}  // namespace

std::string certificate_text(const Problem& problem, const Certificate& certificate) {
  std::string text = "{\n  \"format\": " + inline_text(kCertificateFormat);
  const auto put = [&text](std::string_view key, const nlohmann::ordered_json& value) {
    text.append(",\n  \"").append(key).append("\": ").append(inline_text(value));
  };
  put("problem", problem.name());
  put("problem_digest", problem_digest(problem));
  put("kind", kind_name(certificate.kind));
  put("bound", number_or_null(certificate.bound));
  const auto put_numbers = [&](std::string_view key, const std::vector<double>& values) {
    auto numbers = nlohmann::ordered_json::array();
    for (const double value : values) numbers.push_back(number_or_null(value));
    put(key, numbers);
  };
  switch (certificate.kind) {
    case Certificate::Kind::Sizes: put_numbers("sizes", certificate.sizes); break;
    case Certificate::Kind::Prices:
      put_numbers("sizes", certificate.sizes);
      put_numbers("prices", certificate.prices);
      if (!certificate.together.empty()) put("together", together_json(problem, certificate));
      break;
    case Certificate::Kind::Places:
      put_numbers("connections", certificate.connections);
      put_numbers("places", certificate.places);
      break;
    case Certificate::Kind::Pieces: {
      put_numbers("sizes", certificate.sizes);
      text += ",\n  \"pieces\": [";
      const char* between = "\n    ";
      for (const Certificate::Piece& piece : certificate.pieces) {
        text += between;
        between = ",\n    ";
        text += "[\"" + digits_of(piece.parts, problem.num_parts()) + "\", " +
                std::to_string(piece.allowed) + ", " + inline_text(number_or_null(piece.value)) +
                "]";
      }
      text += "\n  ]";
      break;
    }
    case Certificate::Kind::States: {
      text += ",\n  \"layers\": [";
      const char* between_layers = "\n    [";
      for (const auto& layer : certificate.layers) {
        text += between_layers;
        between_layers = ",\n    [";
        const char* between = "\n      ";
        for (const Certificate::State& state : layer) {
          text += between;
          between = ",\n      ";
          text += "[\"" + digits_of(state.present, problem.num_connections()) + "\", " +
                  inline_text(number_or_null(state.value)) + "]";
        }
        text += "]";
      }
      text += "\n  ]";
      break;
    }
    case Certificate::Kind::Waits: {
      put("end", certificate.first ? "first removed" : "first made");
      auto ids = nlohmann::ordered_json::array();
      for (const ConnectionIndex c : certificate.waiting) ids.push_back(problem.connection_id(c));
      put("waiting", ids);
      break;
    }
    case Certificate::Kind::Locked:
      put("parts",
          {problem.part_id(certificate.locked[0]), problem.part_id(certificate.locked[1])});
      break;
  }
  return text + "\n}\n";
}

Certificate parse_certificate(const Problem& problem, std::string_view text) {
  const JsonDocument document = JsonDocument::parse(text);
  return CertificateReader(problem, document.root()).read();
}

OptimalityCheck check_optimality(const Problem& problem, const PlanFile& plan,
                                 const Certificate& certificate) {
  std::vector<ConnectionIndex> sequence;
  for (const PlanStep& step : plan_steps(problem, plan))
    sequence.insert(sequence.end(), step.connections.begin(), step.connections.end());
  return check_optimality(problem, sequence, certificate);
}

}  // namespace orasp
