#pragma once

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace orasp {

/// The root of the sources.
[[nodiscard]] inline std::filesystem::path source_folder() {
  return ORASP_SOURCE_DIR;
}

/// The folder with the published material that is not part of the project: the variable
/// ORASP_SHARED, or shared/ beside the sources. It may not exist; a test that needs it then skips.
[[nodiscard]] inline std::filesystem::path shared_folder() {
  const char* folder = std::getenv("ORASP_SHARED");
  return folder != nullptr ? std::filesystem::path(folder)
                           : source_folder().parent_path() / "shared";
}

/// All problem files below a folder, in the order of their names.
[[nodiscard]] inline std::vector<std::filesystem::path> json_files(
    const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

[[nodiscard]] inline std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// The blocks marked as JSON in a page of docs/ that hold `word`.
[[nodiscard]] inline std::vector<std::string> json_examples(const std::string& page,
                                                            const std::string& word) {
  const std::string text = bytes_of(source_folder() / "docs" / page);
  const std::string fence = "```json\n";
  std::vector<std::string> examples;
  for (std::size_t at = text.find(fence); at != std::string::npos; at = text.find(fence, at + 1)) {
    const std::size_t begin = at + fence.size();
    const std::string example = text.substr(begin, text.find("```", begin) - begin);
    if (example.find(word) != std::string::npos) examples.push_back(example);
  }
  return examples;
}

/// A folder of its own for one test, gone at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "orasp-test-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// A file in it with these bytes.
  [[nodiscard]] std::filesystem::path file(const std::string& name,
                                           const std::string& bytes) const {
    std::ofstream(path_ / name, std::ios::binary) << bytes;
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

}  // namespace orasp
