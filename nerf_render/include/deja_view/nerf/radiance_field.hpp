#pragma once

#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/nerf/feature_grid.hpp"
#include "deja_view/nerf/field_frame.hpp"
#include "deja_view/nerf/network.hpp"
#include "deja_view/nerf/occupancy_grid.hpp"
#include "deja_view/nerf/options.hpp"
#include "deja_view/views/scene_cells.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace deja_view::nerf {

/// The part of space that a field describes: a box in N [m], the frame of the training poses.
struct SceneBox {
  Eigen::Vector3d min = Eigen::Vector3d::Zero();
  Eigen::Vector3d max = Eigen::Vector3d::Ones();

  double Size() const { return (max - min).maxCoeff(); }  ///< longest side [m]
};

/// How the lens darkens towards the border: what is left of the light along a unit ray of the
/// camera with s = 1 - its z is exp(k[0] s + k[1] s^2 + k[2] s^3).
struct Vignetting {
  std::array<float, 3> k = {0, 0, 0};

  float At(float s) const { return std::exp(s * (k[0] + s * (k[1] + s * k[2]))); }
};

/// Exposure of one training image: observed = gain * vignetting * radiance + bias.
struct Exposure {
  std::string image;          ///< its name
  std::int64_t stamp_ns = 0;  ///< 0: unknown
  float gain = 1;
  float bias = 0;
  std::vector<float> latent;  ///< latent_size numbers; their mean over all images is 0
};

/// A trained scene. Unit coordinates: (p_N - box.min) / box.Size(). Densities are per unit length.
struct RadianceField {
  RadianceField() = default;
  /// Untrained. Throws CheckError for options or a box that are not valid.
  RadianceField(const FieldOptions& options,
                const MarchOptions& march,
                const SceneBox& box,
                int channels,
                std::uint64_t seed);

  FieldOptions options;
  MarchOptions march;
  SceneBox box;
  int channels = 1;  ///< 1: grey, 3: blue, green, red
  FeatureGrid geometry;
  FeatureGrid appearance;
  Network density;  ///< geometry features to the logarithm of density
  Network color;    ///< appearance features, direction, latent to radiance before the sigmoid
  FeatureGrid background;    ///< at (direction + 1) / 2; empty without far_background
  Network background_color;  ///< its features to radiance before the sigmoid
  OccupancyGrid occupancy;
  std::vector<Exposure> exposures;
  Vignetting vignetting;  ///< of the training cameras
  float progress = 0;     ///< share of its training that is done, 0 to 1
  SceneCells cells;       ///< where the scene is cut into sub-maps
  FieldFrame frame;       ///< where N lies among poses in metres

  Eigen::Vector3f Extent() const { return ((box.max - box.min) / box.Size()).cast<float>(); }
};

/// Values of the real spherical harmonics of degree 1 to `degree` at a unit direction, up to
/// constant factors, to out[0 .. (degree + 1)^2 - 1).
void EncodeDirection(int degree, const float* direction, float* out);

}  // namespace deja_view::nerf
