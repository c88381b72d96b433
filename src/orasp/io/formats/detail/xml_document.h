#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <pugixml.hpp>

namespace orasp::detail {

/// An XML text, parsed by pugixml. References to entities are not followed, whatever a document
/// type says of them: only &amp; and its like and the numbers of characters mean something.
class XmlDocument {
 public:
  /// @throws InputError with the line of the first fault: a text that is no UTF-8 or not
  /// well-formed, or has declarations of its own in its document type.
  explicit XmlDocument(std::string_view text);

  /// The outermost element.
  [[nodiscard]] pugi::xml_node root() const { return document_.document_element(); }
  /// `line 12`. O(size of the text).
  [[nodiscard]] std::string place(pugi::xml_node node) const;

 private:
  std::string_view text_;
  pugi::xml_document document_;
};

/// The name of an element without its prefix: "NodeLabel" of <y:NodeLabel>.
[[nodiscard]] std::string_view local_name(pugi::xml_node node);

/// All text directly in the element.
[[nodiscard]] std::string text_in(pugi::xml_node node);

/// The document with an indent of two spaces, in UTF-8.
[[nodiscard]] std::string xml_text(const pugi::xml_document& document);

/// `text` with '?' for each control character that XML 1.0 cannot hold, or would change.
/// @returns whether there was one.
bool replace_control_characters(std::string& text);

}  // namespace orasp::detail
