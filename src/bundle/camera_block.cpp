#include "camera_block.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view::internal {
namespace {

std::shared_ptr<const Camera> TryMake(const CameraParameters& parameters) {
  try {
    return MakeCamera(parameters, "adjusted camera");
  } catch (const InputError&) {
    return nullptr;
  }
}

}  // namespace

std::shared_ptr<const Camera> CameraBlock::Make(const double* projection,
                                                const double* distortion) const {
  CameraParameters parameters = parameters_;
  std::copy_n(projection, projection_size(), parameters.projection.begin());
  std::copy_n(distortion, distortion_size(), parameters.distortion.begin());
  return TryMake(parameters);
}

void CameraBlock::Update(const double* projection, const double* distortion) {
  if (camera_ &&
      std::equal(parameters_.projection.begin(), parameters_.projection.end(), projection) &&
      std::equal(parameters_.distortion.begin(), parameters_.distortion.end(), distortion)) {
    return;
  }
  std::copy_n(projection, projection_size(), parameters_.projection.begin());
  std::copy_n(distortion, distortion_size(), parameters_.distortion.begin());
  camera_ = TryMake(parameters_);
  projection_.clear();
  distortion_.clear();
}

void CameraBlock::UpdatePerturbed() {
  // Large enough for rounding, small enough for a lens' polynomial: 1e-9 px of error at most.
  constexpr double kRelativeStep = 1e-6;
  const auto perturb = [&](std::vector<double> CameraParameters::*list,
                           std::vector<Perturbed>* perturbed) {
    for (std::size_t i = 0; i < (parameters_.*list).size(); ++i) {
      Perturbed p;
      p.step = kRelativeStep * std::max(1.0, std::abs((parameters_.*list)[i]));
      CameraParameters moved = parameters_;
      (moved.*list)[i] += p.step;
      p.plus = TryMake(moved);
      (moved.*list)[i] -= 2 * p.step;
      p.minus = TryMake(moved);
      perturbed->push_back(p);
    }
  };
  perturb(&CameraParameters::projection, &projection_);
  perturb(&CameraParameters::distortion, &distortion_);
}

bool CameraBlock::Differentiate(const Eigen::Vector3d& p_C,
                                const std::vector<Perturbed>& perturbed,
                                double* J) {
  const auto columns = static_cast<Eigen::Index>(perturbed.size());
  Eigen::Map<RowMajor2X> jacobian(J, 2, columns);
  for (Eigen::Index i = 0; i < columns; ++i) {
    const Perturbed& p = perturbed[static_cast<std::size_t>(i)];
    const auto plus = p.plus ? p.plus->Project(p_C) : std::nullopt;
    const auto minus = p.minus ? p.minus->Project(p_C) : std::nullopt;
    if (!plus || !minus) {
      return false;
    }
    jacobian.col(i) = (*plus - *minus) / (2 * p.step);
  }
  return true;
}

std::optional<Eigen::Vector2d> CameraBlock::Project(const double* projection,
                                                    const double* distortion,
                                                    const Eigen::Vector3d& p_C,
                                                    Camera::ProjectionJacobian* J_point,
                                                    double* J_projection,
                                                    double* J_distortion) {
  Update(projection, distortion);
  if (!camera_) {
    return std::nullopt;
  }
  const auto pixel = camera_->Project(p_C, J_point);
  if (pixel && (J_projection != nullptr || J_distortion != nullptr)) {
    if (projection_.empty()) {
      UpdatePerturbed();
    }
    if ((J_projection != nullptr && !Differentiate(p_C, projection_, J_projection)) ||
        (J_distortion != nullptr && !Differentiate(p_C, distortion_, J_distortion))) {
      return std::nullopt;
    }
  }
  return pixel;
}

}  // namespace deja_view::internal
