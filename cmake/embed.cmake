# Writes a C++ file that holds the bytes of each of FILES (comma-separated paths) for src/orasp/FOLDER/NAME.h, whose
# function is called NAME. A file is called by its name; ".json" and ".html" are left off.
#   cmake -DOUTPUT=embedded_scenarios.cpp -DFOLDER=io -DNAME=embedded_scenarios -DFILES=data/a.json,data/b.json -P embed.cmake
string(REPLACE "," ";" FILES "${FILES}")
set(entries "")
foreach(file IN LISTS FILES)
  get_filename_component(name "${file}" NAME)
  string(REGEX REPLACE "\\.(json|html)$" "" name "${name}")
  file(READ "${file}" text)
  string(FIND "${text}" ")orasp_file\"" clash)
  if(NOT clash EQUAL -1)
    message(FATAL_ERROR "${file} holds the end mark of a raw string")
  endif()
  string(APPEND entries "    {\"${name}\", R\"orasp_file(${text})orasp_file\"sv},\n")
endforeach()
file(WRITE "${OUTPUT}" "// Written by cmake/embed.cmake.
#include \"orasp/${FOLDER}/${NAME}.h\"

namespace orasp::detail {
namespace {
using namespace std::string_view_literals;  // which tell the length: the compiler need not count

constexpr EmbeddedFile kFiles[] = {
${entries}};
}  // namespace

std::span<const EmbeddedFile> ${NAME}() { return kFiles; }

}  // namespace orasp::detail
")
