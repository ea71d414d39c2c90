#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/nerf/kernel_table.hpp"
#include "deja_view/nerf/radiance_field.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "ray_march.hpp"

namespace deja_view::nerf::internal {

/// Column of the colour network's input where the latent numbers begin.
std::size_t LatentColumn(const RadianceField& field);

BoxView ViewOf(const SceneBox& box);

/// The ray of `origin_N` [m] and unit vector `direction_N` through the box of `field`.
Ray MakeRay(const RadianceField& field,
            const Eigen::Vector3d& origin_N,
            const Eigen::Vector3d& direction_N,
            float jitter);

/// The samples of some rays that bear weight, in order of (ray, t), with what the backward pass
/// needs.
struct Trace {
  std::vector<std::size_t> ray_begin;  ///< rays + 1 offsets into the samples
  std::vector<std::uint32_t> ray;
  std::vector<float> t;  ///< length from the camera
  std::vector<float> dt, sigma;
  std::vector<float> weight;
  std::vector<float> after;  ///< transmittance behind the sample
  std::vector<float> x, y, z;
  std::vector<float> geometry_rows;    ///< n x density.row_stride()
  std::vector<float> appearance_rows;  ///< n x color.row_stride()
  std::vector<float> color;            ///< n x channels
  std::vector<float> transmittance;    ///< per ray, behind its last sample
  std::vector<float> background;       ///< rays x channels; empty without far_background
  std::vector<float> background_x, background_y, background_z;  ///< per ray, where it is looked up
  std::vector<float> background_rows;  ///< rays x background_color.row_stride()
  Network::Activations background_activations;
  std::size_t evaluated = 0;  ///< samples whose density was asked for
  Network::Activations color_activations;

  std::size_t size() const { return t.size(); }
  Positions positions() const { return {x.data(), y.data(), z.data()}; }
  Positions background_positions() const {
    return {background_x.data(), background_y.data(), background_z.data()};
  }
};

/// Marches rays through the occupied cells, in rounds so that none goes far behind the surface that
/// ends it: density of all samples, radiance of those with weight. Keeps its working memory from
/// call to call; one per thread.
class RayTracer {
 public:
  RayTracer(const RadianceField& field, const Kernels& kernels);

  /// Fills `trace` for `rays`. Its result depends on nothing else.
  void Run(const std::vector<Ray>& rays, const TraceOptions& options, Trace* trace);

 private:
  struct State {
    float t = 0;  ///< length from the ray's origin
    float transmittance = 1;
    int samples = 0;
  };
  struct Round {
    std::vector<std::uint32_t> ray;
    std::vector<float> t, dt, x, y, z;
    std::vector<float> rows;
    std::vector<float> raw, sigma, transparency;
    std::size_t count = 0;           ///< samples in use
    void Reserve(std::size_t most);  ///< and forget all
  };

  void March(const Ray& ray, std::uint32_t number, const TraceOptions& options, State* state);
  void EvaluateDensity();
  void Composite(const TraceOptions& options, std::vector<State>* states);
  void SortByRay(std::size_t rays, Trace* trace);
  void EvaluateBackground(const std::vector<Ray>& rays, Trace* trace);
  void EvaluateColor(const std::vector<Ray>& rays, Trace* trace);

  const RadianceField& field_;
  const Kernels& kernels_;
  Round round_;
  Trace unsorted_;
  Network::Activations activations_;
};

}  // namespace deja_view::nerf::internal
