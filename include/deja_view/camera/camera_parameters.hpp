#pragma once

#include "deja_view/camera/camera.hpp"

#include <memory>
#include <string>
#include <vector>

namespace deja_view {

/// A camera as plain numbers, for messages and files.
struct CameraParameters {
  std::string model;               ///< "PINHOLE", "KANNALA_BRANDT" or "MEI"
  int width = 0;                   ///< [px]
  int height = 0;                  ///< [px]
  std::vector<double> distortion;  ///< PINHOLE, MEI: k1 k2 p1 p2; KANNALA_BRANDT: k2 k3 k4 k5
  std::vector<double> projection;  ///< PINHOLE: fx fy cx cy; KANNALA_BRANDT: mu mv u0 v0;
                                   ///< MEI: xi gamma1 gamma2 u0 v0
};

/// Throws CheckError for a camera of a class that is not the package's.
CameraParameters DescribeCamera(const Camera& camera);

/// Throws InputError that begins with `name` and names the field, its value and what was expected:
/// unknown model, sizes outside 1 to 32768 px, lists of another length, numbers that are not
/// finite, focal lengths that are not positive, a negative xi.
std::unique_ptr<Camera> MakeCamera(const CameraParameters& parameters, const std::string& name);

}  // namespace deja_view
