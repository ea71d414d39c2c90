#pragma once

#include <algorithm>

#include "field_views.cuh"
#include "ray_march.hpp"

// Rays through the field, a thread each; what RayTracer does in rounds. A ray is walked twice: to
// find its densities and count the samples with weight, then to write these where they belong.

namespace deja_view::nerf::internal {

/// A ray on its way, from sample to sample.
struct RayWalk {
  float t = 0;
  float transmittance = 1;
  std::size_t samples = 0;

  /// RayTracer looks at a ray's limits once a round.
  DEJA_VIEW_HOST_DEVICE static std::size_t MostSamples(const MarchOptions& march) {
    return (static_cast<std::size_t>(march.max_samples) + kSamplesPerRound - 1) / kSamplesPerRound *
           kSamplesPerRound;
  }
  DEJA_VIEW_HOST_DEVICE bool Next(const OccupancyView& grid,
                                  const Ray& ray,
                                  const TraceOptions& options,
                                  MarchSample* sample) {
    if (samples >= MostSamples(options.march) || !NextSample(grid, ray, options, &t, sample)) {
      return false;
    }
    ++samples;
    return true;
  }
  /// Returns the sample's weight.
  DEJA_VIEW_HOST_DEVICE float Pass(float sigma, float dt) {
    const float before = transmittance;
    transmittance = before * TransparencyOf(sigma, dt);
    return before - transmittance;
  }
  DEJA_VIEW_HOST_DEVICE bool IsDark(const TraceOptions& options) const {
    return transmittance < options.march.min_transmittance;
  }
};

/// What both walks need.
struct WalkArrays {
  const Ray* rays = nullptr;
  std::size_t count = 0;  ///< of rays
  OccupancyView grid;
  TraceOptions options;
  std::array<float, 3> extent{};
  float* sigma = nullptr;  ///< MostSamples x rays
};

/// Index: ray.
template <std::size_t kInputs>
struct FindDensities {
  WalkArrays walk;
  DensityView density;
  std::size_t* weighted = nullptr;  ///< per ray
  std::uint32_t* evaluated = nullptr;
  float* transmittance = nullptr;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t r) const {
    const Ray ray = walk.rays[r];
    RayWalk state;
    MarchSample sample;
    std::size_t found = 0;
    while (ray.end > 0 && state.Next(walk.grid, ray, walk.options, &sample)) {
      const float log_density =
          density.template LogDensity<kInputs>(PlaceOf(ray, sample.middle, walk.extent.data()));
      const float sigma = DensityOf(log_density);
      walk.sigma[(state.samples - 1) * walk.count + r] = sigma;
      found += state.Pass(sigma, sample.dt) > walk.options.march.min_weight ? 1 : 0;
      if (state.IsDark(walk.options)) {
        break;
      }
    }
    // The round is counted to its end, so that the number of rays follows as on the CPU.
    while (state.IsDark(walk.options) && state.samples % kSamplesPerRound != 0 &&
           state.Next(walk.grid, ray, walk.options, &sample)) {
    }
    weighted[r] = found;
    evaluated[r] = static_cast<std::uint32_t>(state.samples);
    transmittance[r] = state.transmittance;
  }
};

/// Where samples with weight are written, as Trace has them.
struct SampleArrays {
  std::uint32_t* ray = nullptr;
  float* t = nullptr;
  float* dt = nullptr;
  float* sigma = nullptr;
  float* weight = nullptr;
  float* after = nullptr;
  float* x = nullptr;
  float* y = nullptr;
  float* z = nullptr;

  DEJA_VIEW_HOST_DEVICE PlaceArrays places() const { return {x, y, z}; }
};

/// Index: ray.
struct WriteSamples {
  WalkArrays walk;
  const std::size_t* ray_begin = nullptr;  ///< rays + 1
  SampleArrays out;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t r) const {
    const Ray ray = walk.rays[r];
    RayWalk state;
    MarchSample sample;
    for (std::size_t to = ray_begin[r];
         to < ray_begin[r + 1] && state.Next(walk.grid, ray, walk.options, &sample);) {
      const float sigma = walk.sigma[(state.samples - 1) * walk.count + r];
      const float weight = state.Pass(sigma, sample.dt);
      if (weight <= walk.options.march.min_weight) {
        continue;
      }
      const std::array<float, 3> p = PlaceOf(ray, sample.middle, walk.extent.data());
      out.ray[to] = static_cast<std::uint32_t>(r);
      out.t[to] = ray.before + sample.middle;
      out.dt[to] = sample.dt;
      out.sigma[to] = sigma;
      out.weight[to] = weight;
      out.after[to] = state.transmittance;
      out.x[to] = p[0];
      out.y[to] = p[1];
      out.z[to] = p[2];
      ++to;
    }
  }
};

/// Index: ray. Where its direction is looked up in the far background.
struct BackgroundPlaces {
  const Ray* rays = nullptr;
  float* x = nullptr;
  float* y = nullptr;
  float* z = nullptr;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t r) const {
    x[r] = 0.5F * (rays[r].direction[0] + 1);
    y[r] = 0.5F * (rays[r].direction[1] + 1);
    z[r] = 0.5F * (rays[r].direction[2] + 1);
  }
};

}  // namespace deja_view::nerf::internal
