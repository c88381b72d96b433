#include "orasp/io/formats/detail/xml_document.h"

#include <algorithm>

#include <fmt/format.h>

#include "orasp/io/formats/detail/text_checks.h"
#include "orasp/model/error.h"

namespace orasp::detail {
namespace {

/// Collects what pugixml writes.
struct TextWriter final : pugi::xml_writer {
  void write(const void* data, std::size_t size) override {
    text.append(static_cast<const char*>(data), size);
  }
  std::string text;
};

}  // namespace

XmlDocument::XmlDocument(std::string_view text) : text_(checked_text(text)) {
  const pugi::xml_parse_result result = document_.load_buffer(
      text_.data(), text_.size(),
      pugi::parse_default | pugi::parse_doctype | pugi::parse_ws_pcdata_single,
      pugi::encoding_utf8);
  const auto position = static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0));
  if (result.status == pugi::status_out_of_memory) throw std::bad_alloc();
  if (!result) {
    std::string reason = result.description();
    if (!reason.empty() && reason.front() >= 'A' && reason.front() <= 'Z')
      reason.front() = static_cast<char>(reason.front() - 'A' + 'a');
    throw InputError(fmt::format("line {}: it is not well-formed XML: {}",
                                 line_of(text_, std::min(position, text_.size())), reason));
  }
  for (const pugi::xml_node node : document_.children()) {
    const std::string_view type = node.value();
    if (node.type() == pugi::node_doctype && type.find('[') != std::string_view::npos) {
      throw InputError(
          fmt::format("line {}: a document type with declarations of its own is not read; take the "
                      "<!DOCTYPE ...> out",
                      line_of(text_, std::min(text_.find("<!DOCTYPE"), text_.size()))));
    }
  }
  if (!root()) throw InputError("it is not well-formed XML: it has no element");
}

std::string XmlDocument::place(pugi::xml_node node) const {
  const auto position = static_cast<std::size_t>(std::max<std::ptrdiff_t>(node.offset_debug(), 0));
  return fmt::format("line {}", line_of(text_, position));
}

std::string_view local_name(pugi::xml_node node) {
  const std::string_view name = node.name();
  return name.substr(name.find(':') + 1);  // npos + 1 is 0
}

std::string text_in(pugi::xml_node node) {
  std::string text;
  for (const pugi::xml_node child : node.children()) {
    if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata)
      text += child.value();
  }
  return text;
}

std::string xml_text(const pugi::xml_document& document) {
  TextWriter writer;
  document.save(writer, "  ", pugi::format_default, pugi::encoding_utf8);
  return std::move(writer.text);
}

bool replace_control_characters(std::string& text) {
  bool any = false;
  for (char& c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte >= 0x20 && byte != 0x7f) || c == '\n' || c == '\t') continue;
    c = '?';
    any = true;
  }
  return any;
}

}  // namespace orasp::detail
