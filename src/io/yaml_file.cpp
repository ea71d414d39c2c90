#include "yaml_file.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/input_file.hpp"

#include <cstring>
#include <fstream>
#include <sstream>

namespace deja_view::internal {

std::string Where(const std::string& path, const YAML::Mark& mark) {
  return mark.is_null() ? path : fmt::format("{}:{}", path, mark.line + 1);
}

YAML::Node LoadYamlMap(const std::filesystem::path& path) {
  const std::ifstream stream = OpenInputFile(path, std::ios::binary);
  std::ostringstream buffer;
  buffer << stream.rdbuf();
  return ParseYamlMap(buffer.str(), path.string());
}

YAML::Node ParseYamlMap(std::string text, const std::string& name) {
  constexpr const char* kOpenCvHeader = "%YAML:";
  if (text.compare(0, std::strlen(kOpenCvHeader), kOpenCvHeader) == 0) {
    text[0] = '#';  // keeps the line numbers
  }
  try {
    YAML::Node root = YAML::Load(text);
    if (!root.IsMap() && !root.IsNull()) {
      ThrowInputError("{}: expected a map of keys at the top level", name);
    }
    return root;
  } catch (const YAML::Exception& e) {
    ThrowInputError("{}: {}", Where(name, e.mark), e.msg);
  }
}

}  // namespace deja_view::internal
