#pragma once

#include "deja_view/camera/camera_parameters.hpp"

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace deja_view::internal {

/// A camera as two vectors of numbers for a solver, `projection` and `distortion` of
/// CameraParameters, with derivatives. Keeps the cameras made for the numbers seen last, so that
/// many points are projected with the same numbers at little cost; not thread-safe.
class CameraBlock {
 public:
  using RowMajor2X = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;

  explicit CameraBlock(const Camera& camera) : parameters_(DescribeCamera(camera)) {}

  int projection_size() const { return static_cast<int>(parameters_.projection.size()); }
  int distortion_size() const { return static_cast<int>(parameters_.distortion.size()); }
  const CameraParameters& parameters() const { return parameters_; }

  /// The camera with these numbers; null for numbers that make none (a negative focal length).
  std::shared_ptr<const Camera> Make(const double* projection, const double* distortion) const;

  /// Pixel of p_C [m], or nothing where these numbers do not see it. What is given receives
  /// derivatives, row-major: `J_point` (2 x 3) analytic, `J_projection` (2 x projection_size) and
  /// `J_distortion` (2 x distortion_size) by central differences.
  std::optional<Eigen::Vector2d> Project(const double* projection,
                                         const double* distortion,
                                         const Eigen::Vector3d& p_C,
                                         Camera::ProjectionJacobian* J_point,
                                         double* J_projection,
                                         double* J_distortion);

 private:
  struct Perturbed {
    std::shared_ptr<const Camera> plus;
    std::shared_ptr<const Camera> minus;
    double step = 0;
  };
  void Update(const double* projection, const double* distortion);
  void UpdatePerturbed();
  static bool Differentiate(const Eigen::Vector3d& p_C,
                            const std::vector<Perturbed>& perturbed,
                            double* J);

  CameraParameters parameters_;  ///< numbers of camera_
  std::shared_ptr<const Camera> camera_;
  std::vector<Perturbed> projection_;  ///< empty: not made yet for these numbers
  std::vector<Perturbed> distortion_;
};

}  // namespace deja_view::internal
