#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/features/feature_options.hpp"

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace deja_view {

/// Where down is at each pixel of an image whose camera knows gravity: the image of the vertical
/// through what the pixel sees. A patch that is described relative to it looks the same from a
/// camera that is turned about its centre in any way, rolled above all (Kurz and Benhimane,
/// "Inertial sensor-aligned visual feature descriptors", CVPR 2011).
class VerticalField {
 public:
  /// No field: down is the image's +y.
  VerticalField() = default;

  /// `down_C`: direction of gravity in the camera's frame, of any length but 0. A camera whose axis
  /// is within 30 degrees of the vertical gets no field: verticals spread from the pixel that looks
  /// straight down, so that a patch of the floor would turn with its place in the image.
  VerticalField(const Camera& camera, const Eigen::Vector3d& down_C);

  bool empty() const { return angles_.empty(); }

  /// Angle by which the image at (x, y) [px] is turned against the vertical [rad], clockwise in the
  /// image, in (-pi, pi]: down is (-sin, cos). Of the nearest pixel of the image where (x, y) is
  /// outside.
  float Angle(float x, float y) const;

  /// Patches are turned by whole steps of a 64th of a turn: the one nearest to `angle` [rad], 0 to
  /// kSteps - 1.
  static constexpr int kSteps = 64;
  static std::size_t NearestStep(float angle);
  static constexpr double kStepAngle = 6.283185307179586 / kSteps;  ///< [rad]

 private:
  int columns_ = 0;
  int rows_ = 0;
  std::vector<float> angles_;  // of the centres of square cells, row by row
};

/// The field that the options ask for, of a camera at `q_W_C` in a world whose z points up.
VerticalField MakeVerticalField(const FeatureOptions& options,
                                const Camera& camera,
                                const Eigen::Quaterniond& q_W_C);

}  // namespace deja_view
