#include "deja_view/features/brief_pattern.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/input_file.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <vector>

#include <opencv2/core.hpp>

namespace deja_view {
namespace {

std::vector<std::int8_t> ReadList(const std::filesystem::path& path,
                                  const cv::FileStorage& storage,
                                  const char* key) {
  const cv::FileNode list = storage[key];
  if (!list.isSeq() || list.size() != 256) {
    ThrowInputError("{}: key '{}': expected a list of 256 integers, found {} entries",
                    path.string(),
                    key,
                    list.isSeq() ? list.size() : 0);
  }
  std::vector<std::int8_t> values;
  for (const cv::FileNode node : list) {
    const int value = node.isInt() ? static_cast<int>(node) : 1000;
    if (std::abs(value) > 127) {
      ThrowInputError("{}: key '{}', entry {}: expected an integer in [-127, 127]",
                      path.string(),
                      key,
                      values.size());
    }
    values.push_back(static_cast<std::int8_t>(value));
  }
  return values;
}

}  // namespace

int BriefPattern::Radius() const {
  int radius = 0;
  for (const Pair& pair : pairs) {
    for (const std::int8_t offset : {pair.x1, pair.y1, pair.x2, pair.y2}) {
      radius = std::max(radius, std::abs(static_cast<int>(offset)));
    }
  }
  return radius;
}

const BriefPattern& DefaultBriefPattern() {
  static const BriefPattern pattern = {{{
#include "brief_pattern_data.inc"
  }}};
  return pattern;
}

BriefPattern ReadBriefPattern(const std::filesystem::path& path) {
  CheckInputFile(path);
  try {
    const cv::FileStorage storage(path.string(), cv::FileStorage::READ);
    const std::vector<std::int8_t> x1 = ReadList(path, storage, "x1");
    const std::vector<std::int8_t> y1 = ReadList(path, storage, "y1");
    const std::vector<std::int8_t> x2 = ReadList(path, storage, "x2");
    const std::vector<std::int8_t> y2 = ReadList(path, storage, "y2");
    BriefPattern pattern{};
    for (std::size_t i = 0; i < pattern.pairs.size(); ++i) {
      pattern.pairs[i] = {x1[i], y1[i], x2[i], y2[i]};
    }
    return pattern;
  } catch (const cv::Exception& e) {
    ThrowInputError(
        "{}: expected OpenCV YAML with lists x1, y1, x2, y2: {}", path.string(), e.what());
  }
}

}  // namespace deja_view
