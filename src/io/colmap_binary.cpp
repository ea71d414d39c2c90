#include "deja_view/base/check.hpp"
#include "deja_view/base/input_file.hpp"

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <type_traits>

#include "colmap_parts.hpp"

namespace deja_view::internal {
namespace {

namespace fs = std::filesystem;

// The content of a binary file (little endian, as this machine), read from front to back.
class Records {
 public:
  explicit Records(const fs::path& path) : path_(path) {
    std::ifstream stream = OpenInputFile(path, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(stream), {});
  }

  // How many records of at least `min_bytes` follow.
  std::uint64_t Count(std::size_t min_bytes) {
    const auto count = Take<std::uint64_t>();
    if (count > (bytes_.size() - at_) / min_bytes) {
      Fail(fmt::format("is cut off: {} records can't be in {} bytes", count, bytes_.size() - at_));
    }
    return count;
  }

  template <typename T>
  T Take() {
    static_assert(std::is_arithmetic_v<T>);
    T value{};
    std::memcpy(&value, Skip(sizeof(T)), sizeof(T));
    return value;
  }

  double TakeFinite() {
    const auto value = Take<double>();
    if (!std::isfinite(value)) {
      Fail("expected a finite number");
    }
    return value;
  }

  std::string TakeName() {
    const std::size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos) {
      Fail("is cut off in an image's name");
    }
    std::string name = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return name;
  }

  const char* Skip(std::size_t count) {
    if (count > bytes_.size() - at_) {
      Fail("is cut off");
    }
    const char* start = bytes_.data() + at_;
    at_ += count;
    return start;
  }

  void RequireEnd() const {
    if (at_ != bytes_.size()) {
      Fail(fmt::format("has {} bytes too many", bytes_.size() - at_));
    }
  }

  [[noreturn]] void Fail(const std::string& what) const {
    ThrowInputError("{}: byte {}: {}", path_.string(), at_, what);
  }

 private:
  fs::path path_;
  std::string bytes_;
  std::size_t at_ = 0;
};

void ReadBinaryCameras(ColmapModel* model) {
  Records file(model->directory / "cameras.bin");
  const ColmapFail fail = [&](const std::string& what) { file.Fail(what); };
  for (std::uint64_t left = file.Count(24); left > 0; --left) {
    const auto id = file.Take<std::uint32_t>();
    const auto model_id = file.Take<std::int32_t>();
    const ColmapCameraModel* kind = FindColmapCameraModel(model_id);
    if (kind == nullptr) {
      fail(fmt::format("camera model {}: expected one of COLMAP's, 0 to 10", model_id));
    }
    const auto width = file.Take<std::uint64_t>();
    const auto height = file.Take<std::uint64_t>();
    std::vector<double> parameters(kind->parameters);
    for (double& parameter : parameters) {
      parameter = file.Take<double>();
    }
    model->cameras[id] = MakeColmapCamera(*kind, width, height, parameters, fail);
  }
  file.RequireEnd();
}

void ReadBinaryImages(ColmapModel* model) {
  Records file(model->directory / "images.bin");
  const ColmapFail fail = [&](const std::string& what) { file.Fail(what); };
  for (std::uint64_t left = file.Count(73); left > 0; --left) {
    ColmapImage image;
    image.id = file.Take<std::uint32_t>();
    std::vector<double> pose(7);
    for (double& value : pose) {
      value = file.Take<double>();
    }
    image.T_W_C = MakeColmapPose(pose, fail);
    image.camera = file.Take<std::uint32_t>();
    image.name = file.TakeName();
    for (std::uint64_t observations = file.Count(24); observations > 0; --observations) {
      const double x = file.TakeFinite() - 0.5;
      const double y = file.TakeFinite() - 0.5;
      const auto point = file.Take<std::uint64_t>();
      if (point != kNoColmapPoint) {
        image.observations.push_back({{x, y}, point});
      }
    }
    model->images.push_back(std::move(image));
  }
  file.RequireEnd();
}

void ReadBinaryPoints(ColmapModel* model) {
  Records file(model->directory / "points3D.bin");
  for (std::uint64_t left = file.Count(51); left > 0; --left) {
    const auto id = file.Take<std::uint64_t>();
    ColmapPoint point;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      point.p_W[axis] = file.TakeFinite();
    }
    file.Skip(3);  // colour
    point.error_px = file.TakeFinite();
    point.track = file.Count(8);
    file.Skip(8 * point.track);
    model->points[id] = point;
  }
  file.RequireEnd();
}

}  // namespace

void ReadColmapBinary(ColmapModel* model) {
  ReadBinaryCameras(model);
  ReadBinaryImages(model);
  ReadBinaryPoints(model);
}

}  // namespace deja_view::internal
