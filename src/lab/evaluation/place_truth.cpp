#include "deja_view/lab/evaluation/place_truth.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/input_file.hpp"

#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>

namespace deja_view {
namespace {

struct Line {
  std::size_t number = 0;  ///< from 1
  std::string text;
};

std::vector<Line> ReadLines(const std::filesystem::path& path) {
  std::ifstream stream = OpenInputFile(path, std::ios::binary);
  std::string text;
  std::vector<Line> lines;
  for (std::size_t number = 1; std::getline(stream, text); ++number) {
    if (number == 1 && (path.extension() == ".mat" || text.rfind("MATLAB", 0) == 0)) {
      ThrowInputError(
          "{}: MATLAB's files can't be read; convert it, e.g. in Python: "
          "numpy.savetxt('truth.txt', scipy.io.loadmat('{}')['NAME'], '%d')",
          path.string(),
          path.filename().string());
    }
    const std::size_t first = text.find_first_not_of(" \t\r");
    if (first != std::string::npos && text[first] != '#') {
      lines.push_back({number, text});
    }
  }
  return lines;
}

class NumberReader {
 public:
  NumberReader(const std::filesystem::path& path, const Line& line, std::string_view text)
      : path_(path), line_(line), text_(text) {}

  /// The next whole number; false at the end. Throws InputError unless it is in [0, end).
  bool Next(int end, int* value) {
    const std::size_t first = text_.find_first_not_of(" \t\r,");
    if (first == std::string_view::npos) {
      return false;
    }
    text_.remove_prefix(first);
    const std::string_view word = text_.substr(0, text_.find_first_of(" \t\r,"));
    text_.remove_prefix(word.size());
    const auto [last, error] = std::from_chars(word.data(), word.data() + word.size(), *value);
    if (error != std::errc() || last != word.data() + word.size() || *value < 0 || *value >= end) {
      ThrowInputError("{}: line {}: {}: expected a whole number from 0 to {}",
                      path_.string(),
                      line_.number,
                      word.substr(0, 40),
                      end - 1);
    }
    return true;
  }

 private:
  const std::filesystem::path& path_;
  const Line& line_;
  std::string_view text_;
};

PlaceTruth ReadMatrix(const std::filesystem::path& path,
                      const std::vector<Line>& lines,
                      std::size_t images) {
  if (lines.size() != images) {
    ThrowInputError(
        "{}: {} rows, expected one for each of {} images", path.string(), lines.size(), images);
  }
  PlaceTruth truth(images);
  for (std::size_t i = 0; i < images; ++i) {
    NumberReader numbers(path, lines[i], lines[i].text);
    std::size_t count = 0;
    for (int value = 0; numbers.Next(2, &value); ++count) {
      if (value == 1 && count < i) {
        truth[i].push_back(static_cast<int>(count));
      }
    }
    if (count != images) {
      ThrowInputError("{}: line {}: {} numbers, expected one for each of {} images",
                      path.string(),
                      lines[i].number,
                      count,
                      images);
    }
  }
  return truth;
}

PlaceTruth ReadRows(const std::filesystem::path& path,
                    const std::vector<Line>& lines,
                    std::size_t images) {
  PlaceTruth truth(images);
  const int end = static_cast<int>(images);
  for (const Line& line : lines) {
    const std::string_view text = line.text;
    const std::size_t colon = text.find(':');
    int query = 0;
    if (colon == std::string_view::npos ||
        !NumberReader(path, line, text.substr(0, colon)).Next(end, &query)) {
      ThrowInputError(
          "{}: line {}: expected \"image: image image ...\"", path.string(), line.number);
    }
    NumberReader numbers(path, line, text.substr(colon + 1));
    std::vector<int>& row = truth[static_cast<std::size_t>(query)];
    for (int match = 0; numbers.Next(end, &match);) {
      if (match < query) {
        row.push_back(match);
      }
    }
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
  }
  return truth;
}

}  // namespace

PlaceTruth ReadPlaceTruth(const std::filesystem::path& path, std::size_t images) {
  const std::vector<Line> lines = ReadLines(path);
  const bool has_rows = !lines.empty() && lines.front().text.find(':') != std::string::npos;
  return has_rows ? ReadRows(path, lines, images) : ReadMatrix(path, lines, images);
}

bool IsTrueMatch(const PlaceTruth& truth, int query, int match) {
  const std::vector<int>& row = truth.at(static_cast<std::size_t>(query));
  return std::binary_search(row.begin(), row.end(), match);
}

int CountRevisits(const PlaceTruth& truth) {
  return static_cast<int>(
      std::count_if(truth.begin(), truth.end(), [](const auto& row) { return !row.empty(); }));
}

}  // namespace deja_view
