#include "cli/output/conflict.h"

#include <algorithm>

#include <fmt/format.h>

#include "cli/options/problem_source.h"
#include "cli/output/text.h"

namespace orasp::cli {

std::string conflict_text(const ProblemExplanation& found) {
  const std::size_t size = found.conflict.size();
  std::string text = "no plan exists\n\n";
  if (size == 1) {
    text += "one constraint alone rules out every plan:\n";
  } else if (found.minimal) {
    text += fmt::format("{} constraints conflict; any {} of them alone would allow a plan:\n",
                        grouped(size), grouped(size - 1));
  } else {
    text += fmt::format(
        "{} constraints conflict; it is not proved that all of them are needed{}:\n", grouped(size),
        found.stop == Stop::None ? "" : fmt::format(" ({})", stop_text(found.stop)));
  }
  std::size_t width = 0;
  for (const ConflictItem& item : found.conflict)
    width = std::max(width, display_width(item.where));
  for (const ConflictItem& item : found.conflict)
    text += fmt::format("  {:<{}}  {}\n", item.where, width, printable(item.message));
  return text;
}

}  // namespace orasp::cli
