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

// Where a lens keeps the numbers of CameraParameters, in their order, and what files call them.
template <typename Lens>
struct Layout {
  const char* projection_names;
  std::vector<double Lens::*> projection;
  const char* distortion_names;
  std::vector<double Lens::*> distortion;
};

const Layout<PinholeParameters>& LayoutOf(const PinholeParameters& /*lens*/) {
  using P = PinholeParameters;
  static const Layout<P> layout = {"fx, fy, cx, cy",
                                   {&P::fx, &P::fy, &P::cx, &P::cy},
                                   "k1, k2, p1, p2",
                                   {&P::k1, &P::k2, &P::p1, &P::p2}};
  return layout;
}

const Layout<KannalaBrandtParameters>& LayoutOf(const KannalaBrandtParameters& /*lens*/) {
  using P = KannalaBrandtParameters;
  static const Layout<P> layout = {"mu, mv, u0, v0",
                                   {&P::mu, &P::mv, &P::u0, &P::v0},
                                   "k2, k3, k4, k5",
                                   {&P::k2, &P::k3, &P::k4, &P::k5}};
  return layout;
}

const Layout<MeiParameters>& LayoutOf(const MeiParameters& /*lens*/) {
  using P = MeiParameters;
  static const Layout<P> layout = {"xi, gamma1, gamma2, u0, v0",
                                   {&P::xi, &P::gamma1, &P::gamma2, &P::u0, &P::v0},
                                   "k1, k2, p1, p2",
                                   {&P::k1, &P::k2, &P::p1, &P::p2}};
  return layout;
}

template <typename Lens>
Lens ToLens(const CameraParameters& numbers, const std::string& name) {
  Lens lens;
  const Layout<Lens>& layout = LayoutOf(lens);
  const auto assign = [&](const std::vector<double>& values,
                          const char* field,
                          const char* expected,
                          const std::vector<double Lens::*>& members) {
    CheckNumbers(values, field, expected, members.size(), name);
    for (std::size_t i = 0; i < members.size(); ++i) {
      lens.*members[i] = values[i];
    }
  };
  lens.width = numbers.width;
  lens.height = numbers.height;
  assign(numbers.distortion, "distortion", layout.distortion_names, layout.distortion);
  assign(numbers.projection, "projection", layout.projection_names, layout.projection);
  return lens;
}

template <typename Lens>
CameraParameters ToNumbers(const Camera& camera, const Lens& lens) {
  CameraParameters numbers;
  numbers.model = camera.ModelType();
  numbers.width = camera.width();
  numbers.height = camera.height();
  for (const auto member : LayoutOf(lens).distortion) {
    numbers.distortion.push_back(lens.*member);
  }
  for (const auto member : LayoutOf(lens).projection) {
    numbers.projection.push_back(lens.*member);
  }
  return numbers;
}

}  // namespace

CameraParameters DescribeCamera(const Camera& camera) {
  if (const auto* pinhole = dynamic_cast<const PinholeCamera*>(&camera)) {
    return ToNumbers(camera, pinhole->parameters());
  }
  if (const auto* fisheye = dynamic_cast<const KannalaBrandtCamera*>(&camera)) {
    return ToNumbers(camera, fisheye->parameters());
  }
  const auto* mei = dynamic_cast<const MeiCamera*>(&camera);
  DEJA_VIEW_CHECK(mei != nullptr);
  return ToNumbers(camera, mei->parameters());
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
    const auto lens = ToLens<PinholeParameters>(parameters, name);
    CheckFocalLengths(lens.fx, lens.fy, name);
    return std::make_unique<PinholeCamera>(lens);
  }
  if (parameters.model == "KANNALA_BRANDT") {
    const auto lens = ToLens<KannalaBrandtParameters>(parameters, name);
    CheckFocalLengths(lens.mu, lens.mv, name);
    return std::make_unique<KannalaBrandtCamera>(lens);
  }
  if (parameters.model == "MEI") {
    const auto lens = ToLens<MeiParameters>(parameters, name);
    CheckFocalLengths(lens.gamma1, lens.gamma2, name);
    if (lens.xi < 0) {
      ThrowInputError("{}: projection: xi {}: expected 0 or more", name, lens.xi);
    }
    return std::make_unique<MeiCamera>(lens);
  }
  ThrowInputError("{}: camera model {}: expected PINHOLE, KANNALA_BRANDT or MEI",
                  name,
                  Quote(parameters.model));
}

}  // namespace deja_view
