#include "deja_view/features/vertical_field.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view {
namespace {

constexpr int kCellPx = 16;
constexpr double kMaxAxisCosine = 0.866;  // of 30 degrees

}  // namespace

VerticalField::VerticalField(const Camera& camera, const Eigen::Vector3d& down_C) {
  DEJA_VIEW_CHECK_OP(down_C.norm(), >, 0.0);
  const Eigen::Vector3d down = down_C.normalized();
  if (std::abs(down.z()) > kMaxAxisCosine) {
    return;
  }
  columns_ = (camera.width() + kCellPx - 1) / kCellPx;
  rows_ = (camera.height() + kCellPx - 1) / kCellPx;
  angles_.reserve(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      const Eigen::Vector2d centre((column + 0.5) * kCellPx - 0.5, (row + 0.5) * kCellPx - 0.5);
      Camera::ProjectionJacobian J;
      const bool is_seen = camera.Project(camera.Unproject(centre), &J).has_value();
      const Eigen::Vector2d d = is_seen ? Eigen::Vector2d(J * down) : Eigen::Vector2d(0, 1);
      angles_.push_back(static_cast<float>(std::atan2(-d.x(), d.y())));
    }
  }
}

float VerticalField::Angle(float x, float y) const {
  if (empty()) {
    return 0;
  }
  const auto cell = [](float pixel, int count) {
    const float place = (pixel + 0.5F) / kCellPx;
    // Also of what is no number.
    return place > 0 ? static_cast<int>(std::min(place, static_cast<float>(count) - 0.5F)) : 0;
  };
  return angles_[static_cast<std::size_t>(cell(y, rows_)) * static_cast<std::size_t>(columns_) +
                 static_cast<std::size_t>(cell(x, columns_))];
}

std::size_t VerticalField::NearestStep(float angle) {
  return static_cast<std::size_t>(std::lround(angle / kStepAngle) + kSteps) % kSteps;
}

VerticalField MakeVerticalField(const FeatureOptions& options,
                                const Camera& camera,
                                const Eigen::Quaterniond& q_W_C) {
  if (options.orientation == PatchOrientation::kImage) {
    return {};
  }
  return {camera, q_W_C.conjugate() * -Eigen::Vector3d::UnitZ()};
}

}  // namespace deja_view
