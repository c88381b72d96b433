#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "orasp/model/problem.h"
#include "orasp/task/result.h"

/// What the reports of one robot and of several have in common.
namespace orasp::detail {

/// A number for people: at most six decimals, no trailing zeros, a true minus sign.
/// web/src/format.js writes the same.
[[nodiscard]] std::string page_number(double number);

/// "1 step", "12,096 states".
[[nodiscard]] std::string counted(std::uint64_t number, std::string_view noun);

/// What ended a search early, to follow another sentence (it begins with a space); empty where
/// nothing did.
[[nodiscard]] std::string stop_sentence(Stop stop);

/// What is proved of a problem, for the page. `sentence` says it where there is a plan, `remark`
/// follows it, what ended the search stands between.
[[nodiscard]] nlohmann::ordered_json proved_facts(const Result& best, std::string sentence,
                                                  std::string_view remark,
                                                  const std::string& effort,
                                                  const std::vector<std::string>& conflict);

/// The problem for the page: names, parts, connections, every constraint in words.
[[nodiscard]] nlohmann::ordered_json report_problem(const Problem& problem);

[[nodiscard]] bool has_positions(const Problem& problem);

/// JSON as the text of a script that holds data: `<` is written \u003c, and bytes that are not
/// UTF-8 become U+FFFD.
[[nodiscard]] std::string script_text(const nlohmann::ordered_json& document);

/// The page with these data; `space`: with what draws in space; `shapes`: the binary glTF file of
/// the parts, or nothing. @throws InputError if it is larger than kMaxReportBytes, the shapes
/// apart.
[[nodiscard]] std::string report_page(std::string_view title, std::string_view data, bool space,
                                      std::string_view shapes = {});

}  // namespace orasp::detail
