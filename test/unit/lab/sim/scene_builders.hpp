#pragma once

#include "deja_view/lab/sim/random.hpp"
#include "deja_view/lab/sim/scene.hpp"

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

namespace deja_view::sim {

/// A square of `side` metres at `centre` that faces `normal`.
inline Surface MakeSquare(const Eigen::Vector3f& centre,
                          const Eigen::Vector3f& normal,
                          float side) {
  Surface s;
  s.axis_u = normal.unitOrthogonal();
  s.axis_v = normal.cross(s.axis_u);
  s.size_u = side;
  s.size_v = side;
  s.origin = centre - 0.5F * side * (s.axis_u + s.axis_v);
  return s;
}

inline Surface MakeCylinder(const Eigen::Vector3f& base,
                            const Eigen::Vector3f& axis,
                            float radius,
                            float height) {
  Surface s;
  s.shape = Shape::kCylinder;
  s.origin = base;
  s.axis_v = axis;
  s.axis_u = axis.unitOrthogonal();
  s.size_u = 6.2831853F * radius;
  s.size_v = height;
  return s;
}

inline Eigen::Vector3f RandomDirection(Rng* rng) {
  const double x = rng->Normal();
  const double y = rng->Normal();
  return Eigen::Vector3d(x, y, rng->Normal()).normalized().cast<float>();
}

/// Squares, discs and cylinders at random in a ball of 6 m about the origin.
inline Scene MakeClutter(int count, std::uint64_t seed) {
  Rng rng(seed, 7);
  Scene scene;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3f place = static_cast<float>(rng.Uniform(1.5, 6)) * RandomDirection(&rng);
    const Eigen::Vector3f normal = RandomDirection(&rng);
    const auto size = static_cast<float>(rng.Uniform(0.2, 2.0));
    if (i % 3 == 2) {
      scene.surfaces.push_back(MakeCylinder(place, normal, 0.3F * size, 2 * size));
    } else {
      scene.surfaces.push_back(MakeSquare(place, normal, size));
      scene.surfaces.back().shape = i % 3 == 1 ? Shape::kDisc : Shape::kRectangle;
    }
  }
  return scene;
}

/// A texture of one value.
inline Texture MakePlainTexture(float value) {
  return Texture(cv::Mat(4, 4, CV_32FC1, cv::Scalar(value)));
}

}  // namespace deja_view::sim
