#pragma once

#include <memory>
#include <optional>
#include <string>

#include <Eigen/Core>

namespace deja_view {

/// A calibrated camera: maps between points in frame C [m] and pixels; (0, 0) is the centre of the
/// top left pixel. Immutable, so that threads may share it.
class Camera {
 public:
  using ProjectionJacobian = Eigen::Matrix<double, 2, 3>;

  virtual ~Camera() = default;

  int width() const { return width_; }    ///< [px]
  int height() const { return height_; }  ///< [px]

  /// "PINHOLE", "KANNALA_BRANDT" or "MEI", as `model_type` of VINS-Mono's YAML.
  virtual std::string ModelType() const = 0;

  /// Pixel of p_C, or nothing where the model does not see it (behind a pinhole, beyond the lens'
  /// largest angle). The pixel may lie outside the image. `J`, when given, receives d pixel / d
  /// p_C.
  virtual std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_C,
                                                 ProjectionJacobian* J = nullptr) const = 0;

  /// Unit vector in C towards what `pixel` sees; inverse of Project to 1e-9 px within the image.
  virtual Eigen::Vector3d Unproject(const Eigen::Vector2d& pixel) const = 0;

  /// Mean focal length [px]: pixels per radian near the axis.
  virtual double FocalLength() const = 0;

  /// The same lens on an image scaled by `scale` (0.5: half resolution), pixel centres kept.
  virtual std::unique_ptr<Camera> Scaled(double scale) const = 0;

  bool IsInImage(const Eigen::Vector2d& pixel, double border = 0.0) const {
    return pixel.x() >= border && pixel.y() >= border && pixel.x() <= width_ - 1 - border &&
           pixel.y() <= height_ - 1 - border;
  }

 protected:
  Camera(int width, int height) : width_(width), height_(height) {}

 private:
  int width_;
  int height_;
};

}  // namespace deja_view
