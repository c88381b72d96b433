# Writes a C++ file that holds the bytes of each of FILES (comma-separated paths) for src/orasp/io/embedded_scenarios.h.
#   cmake -DOUTPUT=embedded_scenarios.cpp -DFILES=data/a.json,data/b.json -P embed.cmake
string(REPLACE "," ";" FILES "${FILES}")
set(entries "")
foreach(file IN LISTS FILES)
  get_filename_component(name "${file}" NAME_WLE)
  file(READ "${file}" text)
  string(FIND "${text}" ")orasp_file\"" clash)
  if(NOT clash EQUAL -1)
    message(FATAL_ERROR "${file} holds the end mark of a raw string")
  endif()
  string(APPEND entries "    {\"${name}\", R\"orasp_file(${text})orasp_file\"},\n")
endforeach()
file(WRITE "${OUTPUT}" "// Written by cmake/embed.cmake.
#include \"orasp/io/embedded_scenarios.h\"

namespace orasp::detail {
namespace {
constexpr EmbeddedFile kFiles[] = {
${entries}};
}  // namespace

std::span<const EmbeddedFile> embedded_scenarios() { return kFiles; }

}  // namespace orasp::detail
")
