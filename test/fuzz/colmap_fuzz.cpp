// COLMAP's files, binary and text: the first byte says which of the three, and whether it is text;
// the other two are sound.
#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/io/colmap.hpp"

#include <array>
#include <cstring>

#include "fuzz.hpp"

namespace deja_view::fuzz {
namespace {

constexpr std::array<const char*, 3> kNames = {"cameras", "images", "points3D"};
using Files = std::array<std::string, 3>;

const Files& TextFiles() {
  static const Files files = [] {
    ColmapModel model;
    model.cameras[1] =
        std::make_shared<PinholeCamera>(PinholeParameters{64, 48, 50, 51, 32, 24, 0.1, 0, 0, 0});
    model.points[7] = {{1, 2, 3}, 0.5, 2};
    for (std::uint32_t id : {1U, 2U}) {
      ColmapImage image;
      image.id = id;
      image.camera = 1;
      image.name = "140363662763856000" + std::to_string(id) + ".png";
      image.observations = {{{10, 12.5}, 7}};
      model.images.push_back(image);
    }
    WriteColmapModel(model, Scratch() / "text");
    Files result;
    for (std::size_t i = 0; i < result.size(); ++i) {
      result[i] = ReadAll(Scratch() / "text" / (std::string(kNames[i]) + ".txt"));
    }
    return result;
  }();
  return files;
}

template <typename... Values>
std::string Bytes(const Values&... values) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&values), sizeof(values)), ...);
  return bytes;
}

// As COLMAP writes them: the package reads these, and writes text.
const Files& BinaryFiles() {
  static const Files files = [] {
    const std::uint64_t one = 1;
    const std::uint64_t point = 7;
    const std::string camera = Bytes(one,
                                     std::uint32_t{1},
                                     std::int32_t{1},
                                     std::uint64_t{64},
                                     std::uint64_t{48},
                                     50.0,
                                     51.0,
                                     32.0,
                                     24.0);
    const std::string image = Bytes(one, std::uint32_t{1}, 1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0) +
                              Bytes(std::uint32_t{1}) + std::string("1.png\0", 6) +
                              Bytes(one, 10.0, 12.5, point);
    const std::string points = Bytes(one, point, 1.0, 2.0, 3.0) + "rgb" +
                               Bytes(0.5, one, std::uint32_t{1}, std::uint32_t{0});
    return Files{camera, image, points};
  }();
  return files;
}

}  // namespace

std::vector<std::string> Seeds() {
  std::vector<std::string> seeds;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    seeds.push_back(static_cast<char>(i) + BinaryFiles()[i]);
    seeds.push_back(static_cast<char>(i + kNames.size()) + TextFiles()[i]);
  }
  return seeds;
}

void RunOne(const std::string& input) {
  const auto [prefix, content] = SplitPrefix(input);
  const bool is_text = prefix / kNames.size() % 2 == 1;
  const std::string folder = is_text ? "model_text/" : "model_binary/";
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    Write(folder + kNames[i] + (is_text ? ".txt" : ".bin"),
          i == prefix % kNames.size() ? content : (is_text ? TextFiles() : BinaryFiles())[i]);
  }
  ToTrajectory(ReadColmapModel(Scratch() / folder));
}

}  // namespace deja_view::fuzz
