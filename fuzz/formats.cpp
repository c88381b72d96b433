// Fuzz target: the bytes are a file of another format: GraphML, node-link JSON, .IN2, PyCAALP,
// matrices or MJCF.
//
// Whatever they are, each reader accepts them or refuses them in one sentence. What one accepts is
// a problem that Problem's constructor takes, with notes of one sentence each, and that comes back
// from GraphML as it went, or is refused there in one sentence.
#include "orasp/io/formats.h"

#include <optional>

#include "fuzz/property.h"
#include "orasp/io/problem_json.h"

namespace orasp::fuzz {
namespace {

void check(std::string_view text, const Format& format) {
  const std::optional<Converted> read = accepted([&] { return read_format(text, format.name); });
  if (!read) return;
  for (const std::string& note : read->notes)
    require(is_one_sentence(note), "a note is one sentence");
  const Problem problem(read->problem);
  if (problem.num_parts() == 0) return;
  const std::optional<Written> written = accepted([&] { return write_format(problem, "graphml"); });
  if (!written) return;
  const Problem again(read_format(written->text, "graphml").problem);
  require(problem_digest(again) == problem_digest(problem) || !written->notes.empty(),
          "a problem comes back from GraphML as it went");
}

}  // namespace
}  // namespace orasp::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace orasp::fuzz;
  const std::string_view text = text_of(data, size);
  (void)accepted([&] { return orasp::format_of_input("-", text).name; });
  for (const orasp::Format& format : orasp::formats()) {
    if (format.read != nullptr && format.name != "orasp") check(text, format);
  }
  return 0;
}
