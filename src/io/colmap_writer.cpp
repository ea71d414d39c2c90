#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/camera/camera_parameters.hpp"
#include "deja_view/io/colmap.hpp"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "colmap_parts.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

// COLMAP's (0, 0) is the corner of the top left pixel.
constexpr double kHalfPixel = 0.5;

// "MODEL WIDTH HEIGHT fx fy cx cy k1 ...".
std::string CameraText(const Camera& camera, const fs::path& path) {
  const CameraParameters p = DescribeCamera(camera);
  if (p.model != "PINHOLE" && p.model != "KANNALA_BRANDT") {
    ThrowInputError(
        "{}: camera model {}: COLMAP has none like it; expected PINHOLE or "
        "KANNALA_BRANDT",
        path.string(),
        p.model);
  }
  return fmt::format("{} {} {} {} {} {} {} {}",
                     p.model == "PINHOLE" ? "OPENCV" : "OPENCV_FISHEYE",
                     p.width,
                     p.height,
                     p.projection[0],
                     p.projection[1],
                     p.projection[2] + kHalfPixel,
                     p.projection[3] + kHalfPixel,
                     fmt::join(p.distortion, " "));
}

void WriteCameras(const ColmapModel& model, const fs::path& path) {
  std::vector<std::string> lines;
  for (const auto& [id, camera] : model.cameras) {
    lines.push_back(fmt::format("{} {}\n", id, CameraText(*camera, path)));
  }
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
    for (const std::string& line : lines) {
      out << line;
    }
  });
}

void WriteImages(const ColmapModel& model, const fs::path& path) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME\n# X Y POINT3D_ID ...\n";
    for (const ColmapImage& image : model.images) {
      const Rigid3 T = image.T_W_C.Inverse();
      out << fmt::format("{} {} {} {} {}\n",
                         image.id,
                         fmt::join(ScalarFirst(T.q), " "),
                         fmt::join(Numbers(T.t), " "),
                         image.camera,
                         image.name);
      for (const ColmapObservation& o : image.observations) {
        out << fmt::format(
            "{} {} {} ", o.pixel.x() + kHalfPixel, o.pixel.y() + kHalfPixel, o.point);
      }
      out << "\n";
    }
  });
}

void WritePoints(const ColmapModel& model, const fs::path& path) {
  std::map<std::uint64_t, std::vector<std::pair<std::uint32_t, std::size_t>>> tracks;
  for (const ColmapImage& image : model.images) {
    for (std::size_t i = 0; i < image.observations.size(); ++i) {
      tracks[image.observations[i].point].emplace_back(image.id, i);
    }
  }
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << "# POINT3D_ID X Y Z R G B ERROR (IMAGE_ID POINT2D_IDX) ...\n";
    for (const auto& [id, track] : tracks) {
      const ColmapPoint& point = model.points.at(id);
      out << fmt::format("{} {} {} {} 128 128 128 {}",
                         id,
                         point.p_W.x(),
                         point.p_W.y(),
                         point.p_W.z(),
                         point.error_px);
      for (const auto& [image, index] : track) {
        out << fmt::format(" {} {}", image, index);
      }
      out << "\n";
    }
  });
}

}  // namespace

void WriteColmapModel(const ColmapModel& model, const fs::path& directory) {
  WriteCameras(model, directory / "cameras.txt");
  WriteImages(model, directory / "images.txt");
  WritePoints(model, directory / "points3D.txt");
}

}  // namespace deja_view
