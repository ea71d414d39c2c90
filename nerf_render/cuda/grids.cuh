#pragma once

#include "field_views.cuh"
#include "ray_march.hpp"
#include "spherical_harmonics.hpp"

// What feature grids give to rows of samples, and take from their derivatives.

namespace deja_view::nerf::internal {

/// Index: sample x levels. Features to rows.
struct EncodeLevel {
  GridView grid;
  PlaceArrays places;
  float* rows = nullptr;
  std::size_t stride = 0;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t index) const {
    const std::size_t s = index / grid.level_count;
    const std::size_t l = index % grid.level_count;
    const GridLevel& level = grid.levels[l];
    ReadLevel(level, grid.values + level.offset, places[s], rows + s * stride + l * grid.features);
  }
};

/// Index: sample. The columns behind the features: 0, direction, latent numbers.
struct FinishRow {
  float* rows = nullptr;
  std::size_t stride = 0;
  std::size_t features = 0;  ///< of all levels
  int direction_degree = 0;
  std::size_t latent_size = 0;
  const std::uint32_t* ray_of = nullptr;  ///< per sample
  const Ray* rays = nullptr;

  DEJA_VIEW_HOST_DEVICE std::size_t LatentColumn() const {
    const auto degree = static_cast<std::size_t>(direction_degree);
    return features + (degree + 1) * (degree + 1) - 1;
  }
  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t s) const {
    float* row = rows + s * stride;
    for (std::size_t i = features; i < stride; ++i) {
      row[i] = 0;
    }
    if (direction_degree > 0) {
      WriteHarmonics(direction_degree, rays[ray_of[s]].direction.data(), row + features);
    }
    if (latent_size > 0 && rays[ray_of[s]].latent != nullptr) {
      for (std::size_t i = 0; i < latent_size; ++i) {
        row[LatentColumn() + i] = rays[ray_of[s]].latent[i];
      }
    }
  }
};

/// Where derivatives of features come from and go to.
struct ScatterArrays {
  GridView grid;
  PlaceArrays places;
  const float* d_rows = nullptr;
  std::size_t stride = 0;
  float* gradient = nullptr;
  std::uint8_t* touched = nullptr;  ///< per brick of the whole grid
};

/// Index: sample x levels. Adds to entries as they come: quick, but sums differ by rounding from
/// run to run.
struct ScatterLevel {
  ScatterArrays a;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t index) const {
    const std::size_t s = index / a.grid.level_count;
    const std::size_t l = index % a.grid.level_count;
    const GridLevel& level = a.grid.levels[l];
    const std::size_t features = a.grid.features;
    const std::array<float, 3> p = a.places[s];
    const Corners corners = FindCorners(level, p[0], p[1], p[2]);
    const float* d = a.d_rows + s * a.stride + l * features;
    for (std::size_t c = 0; c < 8; ++c) {
      const std::size_t entry = level.offset / features + corners.entry[c];
      a.touched[entry / 8] = 1;
      for (std::size_t f = 0; f < features; ++f) {
        AtomicAdd(a.gradient + entry * features + f, corners.weight[c] * d[f]);
      }
    }
  }
};

/// Index: sample x levels. Writes which entry each of the eight corners adds to, and by which
/// weight, to be sorted.
struct ListCorners {
  ScatterArrays a;
  std::uint32_t* entries = nullptr;  ///< samples x levels x 8
  std::uint32_t* items = nullptr;
  float* weights = nullptr;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t index) const {
    const GridLevel& level = a.grid.levels[index % a.grid.level_count];
    const std::array<float, 3> p = a.places[index / a.grid.level_count];
    const Corners corners = FindCorners(level, p[0], p[1], p[2]);
    for (std::size_t c = 0; c < 8; ++c) {
      const std::size_t item = index * 8 + c;
      entries[item] = static_cast<std::uint32_t>(level.offset / a.grid.features) + corners.entry[c];
      items[item] = static_cast<std::uint32_t>(item);
      weights[item] = corners.weight[c];
    }
  }
};

/// Index: place in the sorted list. The first of an entry's items adds them all, in order: the same
/// bits every time.
struct SumSorted {
  ScatterArrays a;
  const std::uint32_t* entries = nullptr;  ///< sorted
  const std::uint32_t* items = nullptr;    ///< in the entries' order
  const float* weights = nullptr;          ///< by item
  std::size_t count = 0;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t first) const {
    const std::uint32_t entry = entries[first];
    if (first > 0 && entries[first - 1] == entry) {
      return;
    }
    const std::size_t features = a.grid.features;
    float* to = a.gradient + entry * features;
    a.touched[entry / 8] = 1;
    for (std::size_t i = first; i < count && entries[i] == entry; ++i) {
      const std::size_t level_of_sample = items[i] / 8;
      const std::size_t s = level_of_sample / a.grid.level_count;
      const std::size_t l = level_of_sample % a.grid.level_count;
      const float* d = a.d_rows + s * a.stride + l * features;
      for (std::size_t f = 0; f < features; ++f) {
        to[f] += weights[items[i]] * d[f];
      }
    }
  }
};

}  // namespace deja_view::nerf::internal
