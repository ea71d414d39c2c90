#include "deja_view/camera/camera_parameters.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/quote.hpp"
#include "deja_view/camera/kannala_brandt_camera.hpp"
#include "deja_view/camera/mei_camera.hpp"
#include "deja_view/camera/pinhole_camera.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/ranges.h>

namespace deja_view {
namespace {

constexpr int kMaxSide = 32768;

void CheckNumbers(const std::vector<double>& values,
                  const char* field,
                  const char* expected,
                  std::size_t count,
                  const std::string& name) {
  const bool is_finite =
      std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  if (values.size() != count || !is_finite) {
    ThrowInputError("{}: {} [{}]: expected {} finite numbers ({})",
                    name,
                    field,
                    fmt::join(values.begin(),
                              values.begin() + static_cast<std::ptrdiff_t>(
                                                   std::min<std::size_t>(values.size(), 16)),
                              ", "),
                    count,
                    expected);
  }
}

void CheckFocalLengths(double x, double y, const std::string& name) {
  if (!(x > 0 && y > 0)) {
    ThrowInputError("{}: projection: focal lengths {} and {}: expected more than 0", name, x, y);
  }
}

std::unique_ptr<Camera> MakePinhole(const CameraParameters& p, const std::string& name) {
  CheckNumbers(p.distortion, "distortion", "k1, k2, p1, p2", 4, name);
  CheckNumbers(p.projection, "projection", "fx, fy, cx, cy", 4, name);
  CheckFocalLengths(p.projection[0], p.projection[1], name);
  return std::make_unique<PinholeCamera>(PinholeParameters{p.width,
                                                           p.height,
                                                           p.projection[0],
                                                           p.projection[1],
                                                           p.projection[2],
                                                           p.projection[3],
                                                           p.distortion[0],
                                                           p.distortion[1],
                                                           p.distortion[2],
                                                           p.distortion[3]});
}

std::unique_ptr<Camera> MakeKannalaBrandt(const CameraParameters& p, const std::string& name) {
  CheckNumbers(p.distortion, "distortion", "k2, k3, k4, k5", 4, name);
  CheckNumbers(p.projection, "projection", "mu, mv, u0, v0", 4, name);
  CheckFocalLengths(p.projection[0], p.projection[1], name);
  return std::make_unique<KannalaBrandtCamera>(KannalaBrandtParameters{p.width,
                                                                       p.height,
                                                                       p.distortion[0],
                                                                       p.distortion[1],
                                                                       p.distortion[2],
                                                                       p.distortion[3],
                                                                       p.projection[0],
                                                                       p.projection[1],
                                                                       p.projection[2],
                                                                       p.projection[3]});
}

std::unique_ptr<Camera> MakeMei(const CameraParameters& p, const std::string& name) {
  CheckNumbers(p.distortion, "distortion", "k1, k2, p1, p2", 4, name);
  CheckNumbers(p.projection, "projection", "xi, gamma1, gamma2, u0, v0", 5, name);
  CheckFocalLengths(p.projection[1], p.projection[2], name);
  if (p.projection[0] < 0) {
    ThrowInputError("{}: projection: xi {}: expected 0 or more", name, p.projection[0]);
  }
  return std::make_unique<MeiCamera>(MeiParameters{p.width,
                                                   p.height,
                                                   p.projection[0],
                                                   p.distortion[0],
                                                   p.distortion[1],
                                                   p.distortion[2],
                                                   p.distortion[3],
                                                   p.projection[1],
                                                   p.projection[2],
                                                   p.projection[3],
                                                   p.projection[4]});
}

}  // namespace

CameraParameters DescribeCamera(const Camera& camera) {
  CameraParameters result;
  result.model = camera.ModelType();
  result.width = camera.width();
  result.height = camera.height();
  if (const auto* pinhole = dynamic_cast<const PinholeCamera*>(&camera)) {
    const PinholeParameters& p = pinhole->parameters();
    result.distortion = {p.k1, p.k2, p.p1, p.p2};
    result.projection = {p.fx, p.fy, p.cx, p.cy};
  } else if (const auto* fisheye = dynamic_cast<const KannalaBrandtCamera*>(&camera)) {
    const KannalaBrandtParameters& p = fisheye->parameters();
    result.distortion = {p.k2, p.k3, p.k4, p.k5};
    result.projection = {p.mu, p.mv, p.u0, p.v0};
  } else {
    const auto* mei = dynamic_cast<const MeiCamera*>(&camera);
    DEJA_VIEW_CHECK(mei != nullptr);
    const MeiParameters& p = mei->parameters();
    result.distortion = {p.k1, p.k2, p.p1, p.p2};
    result.projection = {p.xi, p.gamma1, p.gamma2, p.u0, p.v0};
  }
  return result;
}

std::unique_ptr<Camera> MakeCamera(const CameraParameters& parameters, const std::string& name) {
  if (parameters.width < 1 || parameters.height < 1 || parameters.width > kMaxSide ||
      parameters.height > kMaxSide) {
    ThrowInputError("{}: camera of {} x {} px: expected 1 to {} px a side",
                    name,
                    parameters.width,
                    parameters.height,
                    kMaxSide);
  }
  if (parameters.model == "PINHOLE") {
    return MakePinhole(parameters, name);
  }
  if (parameters.model == "KANNALA_BRANDT") {
    return MakeKannalaBrandt(parameters, name);
  }
  if (parameters.model == "MEI") {
    return MakeMei(parameters, name);
  }
  ThrowInputError("{}: camera model {}: expected PINHOLE, KANNALA_BRANDT or MEI",
                  name,
                  Quote(parameters.model));
}

}  // namespace deja_view
