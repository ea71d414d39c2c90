#include "deja_view/base/check.hpp"
#include "deja_view/base/input_file.hpp"
#include "deja_view/base/quote.hpp"

#include <charconv>
#include <fstream>
#include <optional>
#include <sstream>

#include "colmap_parts.hpp"
#include "parse_number.hpp"

namespace deja_view::internal {
namespace {

namespace fs = std::filesystem;

// A text file, line by line, and its errors.
class Lines {
 public:
  explicit Lines(const fs::path& path) : path_(path), stream_(OpenInputFile(path)) {}

  // The next line that is neither empty nor a comment, in words; false at the end.
  bool NextRecord(std::vector<std::string>* words) {
    while (NextLine()) {
      *words = Words();
      if (!words->empty() && words->front()[0] != '#') {
        return true;
      }
    }
    return false;
  }

  // The line right after, which may be empty.
  bool NextLine() {
    ++number_;
    return static_cast<bool>(std::getline(stream_, line_));
  }

  std::vector<std::string> Words() const {
    std::istringstream words(line_);
    std::vector<std::string> result;
    for (std::string word; words >> word;) {
      result.push_back(word);
    }
    return result;
  }

  [[noreturn]] void Fail(const std::string& what) const {
    ThrowInputError("{}:{}: {}, found {}", path_.string(), number_, what, Quote(line_));
  }

 private:
  fs::path path_;
  std::ifstream stream_;
  std::string line_;
  int number_ = 0;
};

std::optional<std::uint64_t> ParseId(const std::string& word) {
  std::uint64_t value = 0;
  const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
  const bool is_whole = result.ec == std::errc() && result.ptr == word.data() + word.size();
  return is_whole ? std::make_optional(value) : std::nullopt;
}

std::optional<std::vector<double>> ParseNumbers(const std::vector<std::string>& words,
                                                std::size_t begin,
                                                std::size_t end) {
  std::vector<double> values;
  for (std::size_t i = begin; i < end; ++i) {
    const auto value = i < words.size() ? ParseNumber<double>(words[i]) : std::nullopt;
    if (!value) {
      return std::nullopt;
    }
    values.push_back(*value);
  }
  return values;
}

void ReadTextCameras(ColmapModel* model) {
  Lines lines(model->directory / "cameras.txt");
  const ColmapFail fail = [&](const std::string& what) { lines.Fail(what); };
  for (std::vector<std::string> words; lines.NextRecord(&words);) {
    const auto* kind = words.size() > 4 ? FindColmapCameraModel(words[1]) : nullptr;
    if (kind == nullptr) {
      fail("expected 'CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]' of a model of COLMAP's");
    }
    const auto id = ParseId(words[0]);
    const auto width = ParseId(words[2]);
    const auto height = ParseId(words[3]);
    const auto parameters = ParseNumbers(words, 4, words.size());
    if (!id || !width || !height || !parameters || parameters->size() != kind->parameters) {
      fail(fmt::format("expected 'CAMERA_ID {} WIDTH HEIGHT' and {} finite parameters",
                       kind->name,
                       kind->parameters));
    }
    model->cameras[static_cast<std::uint32_t>(*id)] =
        MakeColmapCamera(*kind, *width, *height, *parameters, fail);
  }
}

void ReadObservations(const Lines& lines, ColmapImage* image) {
  const std::vector<std::string> words = lines.Words();
  if (words.size() % 3 != 0) {
    lines.Fail("expected triples 'X Y POINT3D_ID'");
  }
  for (std::size_t i = 0; i < words.size(); i += 3) {
    const auto pixel = ParseNumbers(words, i, i + 2);
    const auto point = words[i + 2] == "-1" ? kNoColmapPoint : ParseId(words[i + 2]);
    if (!pixel || !point) {
      lines.Fail("expected triples 'X Y POINT3D_ID'");
    }
    if (*point != kNoColmapPoint) {
      image->observations.push_back({{(*pixel)[0] - 0.5, (*pixel)[1] - 0.5}, *point});
    }
  }
}

void ReadTextImages(ColmapModel* model) {
  Lines lines(model->directory / "images.txt");
  const ColmapFail fail = [&](const std::string& what) { lines.Fail(what); };
  for (std::vector<std::string> words; lines.NextRecord(&words);) {
    const auto id = ParseId(words[0]);
    const auto pose = ParseNumbers(words, 1, 8);
    const auto camera = words.size() > 9 ? ParseId(words[8]) : std::nullopt;
    if (!id || !pose || !camera) {
      fail("expected 'IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME'");
    }
    ColmapImage image;
    image.id = static_cast<std::uint32_t>(*id);
    image.camera = static_cast<std::uint32_t>(*camera);
    image.name = words[9];
    for (std::size_t i = 10; i < words.size(); ++i) {
      image.name += " " + words[i];
    }
    image.T_W_C = MakeColmapPose(*pose, fail);
    if (!lines.NextLine()) {
      fail("expected a line of observations after the image");
    }
    ReadObservations(lines, &image);
    model->images.push_back(std::move(image));
  }
}

void ReadTextPoints(ColmapModel* model) {
  Lines lines(model->directory / "points3D.txt");
  for (std::vector<std::string> words; lines.NextRecord(&words);) {
    const auto id = ParseId(words[0]);
    const auto values = ParseNumbers(words, 1, 8);  // X Y Z R G B ERROR
    if (!id || !values || words.size() % 2 != 0) {
      lines.Fail("expected 'POINT3D_ID X Y Z R G B ERROR TRACK[]'");
    }
    model->points[*id] = {
        {(*values)[0], (*values)[1], (*values)[2]}, (*values)[6], (words.size() - 8) / 2};
  }
}

}  // namespace

void ReadColmapText(ColmapModel* model) {
  ReadTextCameras(model);
  ReadTextImages(model);
  ReadTextPoints(model);
}

}  // namespace deja_view::internal
