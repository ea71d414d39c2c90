#pragma once

#include "deja_view/base/check.hpp"
#include "deja_view/camera/kannala_brandt_camera.hpp"
#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/io/vins_config.hpp"

#include <string>
#include <vector>

#include "temporary_directory.hpp"
#include <gmock/gmock.h>

namespace deja_view {

// The camera of all files here: it looks along the body's x, its x is the body's -y, and it is
// mounted at (0.1, 0.2, 0.3) m. So T_B_C and its inverse, T_C_B, which a file of Kalibr has.
inline constexpr const char* kData =
    "data: [0, 0, 1, 0.1,  -1, 0, 0, 0.2,  0, -1, 0, 0.3,  0, 0, 0, 1]\n";
inline constexpr const char* kRows =
    "  - [0, 0, 1, 0.1]\n  - [-1, 0, 0, 0.2]\n  - [0, -1, 0, 0.3]\n  - [0, 0, 0, 1]\n";
inline constexpr const char* kInverseRows =
    "  - [0, -1, 0, 0.2]\n  - [0, 0, -1, 0.3]\n  - [1, 0, 0, -0.1]\n  - [0, 0, 0, 1]\n";

inline std::string OpenCvMatrix(const std::string& key) {
  return key + ": !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: f\n   " + kData;
}

inline std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  bool is_found = false;
  for (std::size_t at = text.find(from); at != std::string::npos;
       at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
    is_found = true;
  }
  EXPECT_TRUE(is_found) << from;
  return text;
}

// A point at (0.5, 0.25, 1) m in the camera: s = 0.25 + 0.0625 = 0.3125,
// 1 + 0.1 s + 0.01 s^2 = 1.0322265625,
// x = 0.5 * 1.0322265625 + 2 * 0.001 * 0.125 + 0.002 (s + 0.5)     = 0.51798828125,
// y = 0.25 * 1.0322265625 + 0.001 (s + 0.125) + 2 * 0.002 * 0.125  = 0.258994140625,
// u = 400 x + 320, v = 410 y + 240.
inline void ExpectRadTan(const VinsConfig& config) {
  const auto* camera = dynamic_cast<const PinholeCamera*>(config.camera.get());
  ASSERT_NE(camera, nullptr);
  EXPECT_EQ(camera->width(), 640);
  EXPECT_EQ(camera->height(), 480);
  const auto pixel = camera->Project({0.5, 0.25, 1.0});
  ASSERT_TRUE(pixel.has_value());
  EXPECT_NEAR(pixel->x(), 527.1953125, 1e-9);
  EXPECT_NEAR(pixel->y(), 346.18759765625, 1e-9);
}

// (1, 0, 1) m is 45 degrees off the axis: with a = pi / 4,
// d = a + 0.1 a^3 + 0.01 a^5 + 0.001 a^7 + 0.0001 a^9
//   = 0.7853981634 + 0.0484473073 + 0.0029884735 + 0.0001843441 + 0.0000113713 = 0.8370296595,
// u = 400 d + 320, v = 240.
inline void ExpectEquidistant(const VinsConfig& config) {
  const auto* camera = dynamic_cast<const KannalaBrandtCamera*>(config.camera.get());
  ASSERT_NE(camera, nullptr);
  EXPECT_EQ(camera->width(), 640);
  const auto pixel = camera->Project({1.0, 0.0, 1.0});
  ASSERT_TRUE(pixel.has_value());
  EXPECT_NEAR(pixel->x(), 654.811863813, 1e-8);
  EXPECT_NEAR(pixel->y(), 240, 1e-9);
}

// The camera sees 2 m ahead, 0.5 m to the right and 0.25 m below what is at (2.1, -0.3, 0.05) m in
// the body.
inline void ExpectExtrinsic(const VinsConfig& config) {
  const Eigen::Vector3d p_B = config.T_B_C * Eigen::Vector3d(0.5, 0.25, 2.0);
  EXPECT_NEAR((p_B - Eigen::Vector3d(2.1, -0.3, 0.05)).norm(), 0, 1e-12);
}

/// A file with one part replaced, and what its error says.
struct WrongFile {
  std::string from;
  std::string to;
  std::string message;
};

class CameraFilesTest : public TemporaryDirectoryTest {
 protected:
  VinsConfig Read(const std::string& text) const {
    return ReadVinsConfig(Write("file.yaml", text));
  }

  // The message of the error that the text must give; it names the file in question.
  std::string Error(const std::string& text, const std::string& file = "file.yaml") const {
    const std::string message = MessageOf<InputError>([&] { Read(text); });
    EXPECT_THAT(message, Says((directory_ / file).string())) << text;
    return message;
  }

  void ExpectErrors(const std::string& text, const std::vector<WrongFile>& cases) const {
    for (const WrongFile& wrong : cases) {
      EXPECT_THAT(Error(Replaced(text, wrong.from, wrong.to)), Says(wrong.message)) << wrong.from;
    }
  }
};

}  // namespace deja_view
