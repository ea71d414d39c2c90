// instant-ngp's and nerfstudio's transforms.json.
#include "deja_view/nerf/image_readers.hpp"

#include "fuzz.hpp"
#include <opencv2/imgcodecs.hpp>

namespace deja_view::fuzz {
namespace {

std::string File(const std::string& keys) {
  return "{" + keys +
         R"(, "frames": [{"file_path": "images/a.png", "transform_matrix":
            [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]},
            {"file_path": "images/a", "fl_x": 11, "transform_matrix":
            [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]}]})";
}

}  // namespace

std::vector<std::string> Seeds() {
  return {File(R"("w": 16, "h": 12, "fl_x": 10, "fl_y": 10, "cx": 8, "cy": 6, "k1": 0.1, "p1": 0)"),
          File(R"("camera_angle_x": 1.2)"),
          File(R"("w": 16, "h": 12, "fl_x": 10, "camera_model": "OPENCV_FISHEYE", "k3": 0.1)"),
          File(R"("fl_x": 10, "is_fisheye": true, "depth_unit_scale_factor": 0.001)")};
}

void RunOne(const std::string& input) {
  static const bool has_image = [] {
    Write("images/a.png", "");
    return cv::imwrite((Scratch() / "images/a.png").string(), cv::Mat(12, 16, CV_8UC1, 77.0));
  }();
  if (has_image) {
    nerf::ReadTransforms(Write("transforms.json", input));
  }
}

}  // namespace deja_view::fuzz
