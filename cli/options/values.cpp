#include "cli/options/values.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include "cli/output/text.h"
#include "orasp/model/error.h"

namespace orasp::cli {
namespace {

/// The number that the whole of `text` is, or nothing.
template <class Number>
std::optional<Number> parsed(std::string_view text) {
  Number value{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end ? std::optional(value) : std::nullopt;
}

}  // namespace

std::uint64_t whole_number(std::string_view option, std::string_view text, std::uint64_t least,
                           std::uint64_t greatest) {
  const auto value = parsed<std::uint64_t>(text);
  if (value && *value >= least && *value <= greatest) return *value;
  throw InputError(fmt::format("{}: {} is not a whole number from {} to {}", option,
                               in_quotes(text), least, greatest));
}

std::vector<std::size_t> whole_numbers(std::string_view option, std::string_view text,
                                       std::uint64_t least, std::uint64_t greatest) {
  std::vector<std::size_t> numbers;
  for (const std::string& piece : comma_separated(std::string(text)))
    numbers.push_back(whole_number(option, piece, least, greatest));
  return numbers;
}

double number(std::string_view option, std::string_view text, Sign sign) {
  const auto value = parsed<double>(text);
  const bool finite = value && std::isfinite(*value);
  bool allowed = finite;
  const char* wanted = "a number";
  switch (sign) {
    case Sign::Any: break;
    case Sign::NotNegative:
      allowed = finite && *value >= 0;
      wanted = "a number of 0 or more";
      break;
    case Sign::Positive:
      allowed = finite && *value > 0;
      wanted = "a number above 0";
      break;
    case Sign::Share:
      allowed = finite && *value >= 0 && *value <= 1;
      wanted = "a number from 0 to 1";
      break;
  }
  if (allowed) return *value;
  throw InputError(fmt::format("{}: {} is not {}", option, in_quotes(text), wanted));
}

}  // namespace orasp::cli
