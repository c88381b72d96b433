#include "orasp/geometry/detail/package_3mf.h"

#include <algorithm>
#include <memory>
#include <string_view>

#include <minizip/unzip.h>
#include <pugixml.hpp>

namespace orasp::detail {

namespace {

struct CloseArchive {
  void operator()(void* archive) const { unzClose(archive); }
};
using Archive = std::unique_ptr<void, CloseArchive>;

/// The bytes of a member of an archive, as many as are read without an error; none where it is not
/// there.
std::string member(const Archive& archive, const std::string& name) {
  constexpr std::size_t kMost = std::size_t{1} << 29U;
  constexpr std::size_t kBlock = std::size_t{1} << 20U;
  constexpr int kEitherCase = 2;
  std::string bytes;
  if (unzLocateFile(archive.get(), name.c_str(), kEitherCase) != UNZ_OK ||
      unzOpenCurrentFile(archive.get()) != UNZ_OK)
    return bytes;
  int read = 1;
  while (read > 0 && bytes.size() < kMost) {
    const std::size_t begin = bytes.size();
    bytes.resize(begin + kBlock);
    read = unzReadCurrentFile(archive.get(), bytes.data() + begin, static_cast<unsigned>(kBlock));
    bytes.resize(begin + static_cast<std::size_t>(std::max(read, 0)));
  }
  unzCloseCurrentFile(archive.get());
  return bytes;
}

/// The name of an element or attribute without its namespace.
std::string_view local(std::string_view name) {
  return name.substr(name.find(':') + 1);
}

/// Which member holds the model, as the package's relations say.
std::string model_of(const Archive& archive) {
  const std::string relations = member(archive, "_rels/.rels");
  pugi::xml_document document;
  static_cast<void>(document.load_buffer(relations.data(), relations.size()));
  for (const pugi::xml_node& relation : document.document_element()) {
    if (!std::string_view(relation.attribute("Type").value()).ends_with("/3dmodel")) continue;
    const std::string target = relation.attribute("Target").value();
    return target.substr(target.starts_with('/') ? 1 : 0);
  }
  return "3D/3dmodel.model";
}

}  // namespace

Package3mf read_3mf(const std::filesystem::path& file) {
  Package3mf package{"millimeter", {}};
  const Archive archive(unzOpen64(file.c_str()));
  if (!archive) return package;
  const std::string model = member(archive, model_of(archive));
  pugi::xml_document document;
  // Of a text that ends too early what stands before its end is there all the same.
  static_cast<void>(document.load_buffer(model.data(), model.size()));
  const pugi::xml_node root = document.document_element();
  if (const pugi::xml_attribute unit = root.attribute("unit")) package.unit = unit.value();
  for (const pugi::xml_node& resources : root) {
    if (local(resources.name()) != "resources") continue;
    for (const pugi::xml_node& object : resources) {
      if (local(object.name()) != "object" || !object.attribute("name")) continue;
      package.names.emplace(object.attribute("id").value(), object.attribute("name").value());
    }
  }
  return package;
}

}  // namespace orasp::detail
