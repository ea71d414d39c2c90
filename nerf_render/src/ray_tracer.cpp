#include "ray_tracer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deja_view::nerf::internal {
namespace {

constexpr std::size_t kSamplesPerRound = 4;
constexpr float kNudge = 1e-6F;       ///< beyond a face, in unit lengths
constexpr double kLeastSlope = 1e-6;  ///< below, rounding moves a crossing more than the ray does

// Length to where the ray leaves the cube [low, low + size] of cells.
float ExitOf(const Ray& ray, const std::array<int, 3>& low, int size, float cell) {
  float exit = std::numeric_limits<float>::max();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (ray.inverse[axis] != 0) {
      const int face = low[axis] + (ray.inverse[axis] > 0 ? size : 0);
      exit =
          std::min(exit, (static_cast<float>(face) * cell - ray.origin[axis]) * ray.inverse[axis]);
    }
  }
  return exit;
}

// Length to where the ray leaves the empty cells about the empty cell `at`.
float LeapOver(const OccupancyGrid& grid,
               std::size_t index,
               const std::array<int, 3>& at,
               const Ray& ray,
               float cell) {
  const std::uint64_t word = grid.words()[index / 64];
  std::array<int, 3> low = at;
  int size = 1;
  if (word == 0) {
    const int leap = std::max(1, grid.leap(index / 64));
    for (int& x : low) {
      x = 4 * (x / 4 - (leap - 1));
    }
    size = 4 * (2 * leap - 1);
  } else {
    constexpr std::uint64_t kOctant = 0x330033;  // 2x2x2 cells of a block
    constexpr std::size_t kLowestOfOctant = 2 + 8 + 32;
    if ((word >> (index & kLowestOfOctant) & kOctant) == 0) {
      for (int& x : low) {
        x &= ~1;
      }
      size = 2;
    }
  }
  return ExitOf(ray, low, size, cell);
}

}  // namespace

std::size_t LatentColumn(const RadianceField& field) {
  const int degree = field.options.direction_degree;
  return static_cast<std::size_t>(field.appearance.outputs() + (degree + 1) * (degree + 1) - 1);
}

Ray MakeRay(const RadianceField& field,
            const Eigen::Vector3d& origin_N,
            const Eigen::Vector3d& direction_N,
            float jitter) {
  const Eigen::Vector3d origin = (origin_N - field.box.min) / field.box.Size();
  const Eigen::Vector3d extent = (field.box.max - field.box.min) / field.box.Size();
  Ray ray;
  ray.jitter = jitter;
  double begin = 0;
  double end = std::numeric_limits<double>::max();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double d = direction_N[axis];
    ray.direction[static_cast<std::size_t>(axis)] = static_cast<float>(d);
    ray.inverse[static_cast<std::size_t>(axis)] =
        std::abs(d) > kLeastSlope ? static_cast<float>(1 / d) : 0.0F;
    if (std::abs(d) < 1e-12) {
      if (origin[axis] < 0 || origin[axis] > extent[axis]) {
        end = -1;
      }
      continue;
    }
    const double a = -origin[axis] / d;
    const double b = (extent[axis] - origin[axis]) / d;
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    ray.origin[static_cast<std::size_t>(axis)] =
        static_cast<float>(origin[axis] + begin * direction_N[axis]);
  }
  ray.before = static_cast<float>(begin);
  ray.end = end > begin ? static_cast<float>(end - begin) : 0.0F;
  return ray;
}

void RayTracer::Round::Reserve(std::size_t most) {
  count = 0;
  ray.resize(most);
  for (auto* values : {&t, &dt, &x, &y, &z}) {
    values->resize(most);
  }
}

RayTracer::RayTracer(const RadianceField& field, const Kernels& kernels)
    : field_(field), kernels_(kernels) {}

void RayTracer::March(const Ray& ray,
                      std::uint32_t number,
                      const TraceOptions& options,
                      State* state) {
  const OccupancyGrid& grid = field_.occupancy;
  const float scale = grid.scale();
  const float cell = 1 / scale;
  const Eigen::Vector3f extent = field_.Extent();
  std::size_t found = 0;
  float t = state->t;
  while (found < kSamplesPerRound && t < ray.end) {
    std::array<int, 3> at{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float p = ray.origin[axis] + (t + kNudge) * ray.direction[axis];
      at[axis] = std::clamp(static_cast<int>(p * scale), 0, grid.cells()[axis] - 1);
    }
    const std::size_t index = grid.Index(at[0], at[1], at[2]);
    if (!grid.IsOccupied(index)) {
      t = std::max(t + kNudge, LeapOver(grid, index, at, ray, cell));
      continue;
    }
    const float step = options.step_factor * std::clamp((ray.before + t) * options.march.cone_angle,
                                                        options.march.min_step,
                                                        options.march.max_step);
    const float dt = std::min(step, ray.end - t);
    const float middle = t + ray.jitter * dt;
    const std::size_t s = round_.count++;
    round_.ray[s] = number;
    round_.t[s] = ray.before + middle;
    round_.dt[s] = dt;
    round_.x[s] = std::clamp(ray.origin[0] + middle * ray.direction[0], 0.0F, extent.x());
    round_.y[s] = std::clamp(ray.origin[1] + middle * ray.direction[1], 0.0F, extent.y());
    round_.z[s] = std::clamp(ray.origin[2] + middle * ray.direction[2], 0.0F, extent.z());
    t += step;
    ++found;
  }
  state->t = t;
  state->samples += static_cast<int>(found);
}

void RayTracer::EvaluateDensity() {
  const std::size_t count = round_.count;
  const auto stride = static_cast<std::size_t>(field_.density.row_stride());
  round_.rows.resize(count * stride);
  round_.raw.resize(count);
  round_.sigma.resize(count);
  round_.transparency.resize(count);
  field_.geometry.Forward(kernels_,
                          {round_.x.data(), round_.y.data(), round_.z.data()},
                          count,
                          stride,
                          round_.rows.data());
  const float* out = field_.density.Forward(kernels_, round_.rows.data(), count, &activations_);
  const auto out_stride = static_cast<std::size_t>(field_.density.output_stride());
  for (std::size_t s = 0; s < count; ++s) {
    round_.raw[s] = out[s * out_stride];
  }
  kernels_.density(
      round_.raw.data(), round_.dt.data(), count, round_.sigma.data(), round_.transparency.data());
}

// Eq. 5 by quadrature: what each sample adds is its weight T (1 - exp(-sigma dt)).
void RayTracer::Composite(const TraceOptions& options, std::vector<State>* states) {
  const auto stride = static_cast<std::ptrdiff_t>(field_.density.row_stride());
  for (std::size_t s = 0; s < round_.count; ++s) {
    State& state = (*states)[round_.ray[s]];
    if (state.transmittance < options.march.min_transmittance) {
      continue;
    }
    const float after = state.transmittance * round_.transparency[s];
    const float weight = state.transmittance - after;
    state.transmittance = after;
    if (weight <= options.march.min_weight) {
      continue;
    }
    unsorted_.ray.push_back(round_.ray[s]);
    unsorted_.t.push_back(round_.t[s]);
    unsorted_.dt.push_back(round_.dt[s]);
    unsorted_.sigma.push_back(round_.sigma[s]);
    unsorted_.weight.push_back(weight);
    unsorted_.after.push_back(after);
    unsorted_.x.push_back(round_.x[s]);
    unsorted_.y.push_back(round_.y[s]);
    unsorted_.z.push_back(round_.z[s]);
    const auto row = round_.rows.begin() + static_cast<std::ptrdiff_t>(s) * stride;
    unsorted_.geometry_rows.insert(unsorted_.geometry_rows.end(), row, row + stride);
  }
}

// Rounds come one after the other, so that within a ray the samples are in order already.
void RayTracer::SortByRay(std::size_t rays, Trace* trace) {
  const std::size_t count = unsorted_.size();
  trace->ray_begin.assign(rays + 1, 0);
  for (const std::uint32_t ray : unsorted_.ray) {
    ++trace->ray_begin[ray + 1];
  }
  for (std::size_t r = 0; r < rays; ++r) {
    trace->ray_begin[r + 1] += trace->ray_begin[r];
  }
  for (auto* values : {&trace->t,
                       &trace->dt,
                       &trace->sigma,
                       &trace->weight,
                       &trace->after,
                       &trace->x,
                       &trace->y,
                       &trace->z}) {
    values->resize(count);
  }
  const auto stride = static_cast<std::size_t>(field_.density.row_stride());
  trace->ray.resize(count);
  trace->geometry_rows.resize(count * stride);
  std::vector<std::size_t> next(trace->ray_begin.begin(), trace->ray_begin.end() - 1);
  for (std::size_t s = 0; s < count; ++s) {
    const std::size_t to = next[unsorted_.ray[s]]++;
    trace->ray[to] = unsorted_.ray[s];
    trace->t[to] = unsorted_.t[s];
    trace->dt[to] = unsorted_.dt[s];
    trace->sigma[to] = unsorted_.sigma[s];
    trace->weight[to] = unsorted_.weight[s];
    trace->after[to] = unsorted_.after[s];
    trace->x[to] = unsorted_.x[s];
    trace->y[to] = unsorted_.y[s];
    trace->z[to] = unsorted_.z[s];
    std::copy_n(unsorted_.geometry_rows.begin() + static_cast<std::ptrdiff_t>(s * stride),
                stride,
                trace->geometry_rows.begin() + static_cast<std::ptrdiff_t>(to * stride));
  }
}

void RayTracer::EvaluateColor(const std::vector<Ray>& rays, Trace* trace) {
  const std::size_t count = trace->size();
  const auto stride = static_cast<std::size_t>(field_.color.row_stride());
  const auto channels = static_cast<std::size_t>(field_.channels);
  trace->appearance_rows.resize(count * stride);
  field_.appearance.Forward(
      kernels_, trace->positions(), count, stride, trace->appearance_rows.data());
  if (field_.options.direction_degree > 0) {
    const auto column = static_cast<std::size_t>(field_.appearance.outputs());
    for (std::size_t s = 0; s < count; ++s) {
      EncodeDirection(field_.options.direction_degree,
                      rays[trace->ray[s]].direction.data(),
                      trace->appearance_rows.data() + s * stride + column);
    }
  }
  if (field_.options.latent_size > 0) {
    const auto column = LatentColumn(field_);
    for (std::size_t s = 0; s < count; ++s) {
      if (const float* latent = rays[trace->ray[s]].latent) {
        std::copy_n(latent,
                    field_.options.latent_size,
                    trace->appearance_rows.data() + s * stride + column);
      }
    }
  }
  const float* out = field_.color.Forward(
      kernels_, trace->appearance_rows.data(), count, &trace->color_activations);
  const auto out_stride = static_cast<std::size_t>(field_.color.output_stride());
  trace->color.resize(count * channels);
  for (std::size_t s = 0; s < count; ++s) {
    for (std::size_t c = 0; c < channels; ++c) {
      trace->color[s * channels + c] = out[s * out_stride + c];
    }
  }
  kernels_.sigmoid(trace->color.data(), count * channels, trace->color.data());
}

void RayTracer::EvaluateBackground(const std::vector<Ray>& rays, Trace* trace) {
  const std::size_t count = rays.size();
  const auto stride = static_cast<std::size_t>(field_.background_color.row_stride());
  const auto channels = static_cast<std::size_t>(field_.channels);
  for (auto* values : {&trace->background_x, &trace->background_y, &trace->background_z}) {
    values->resize(count);
  }
  for (std::size_t r = 0; r < count; ++r) {
    trace->background_x[r] = 0.5F * (rays[r].direction[0] + 1);
    trace->background_y[r] = 0.5F * (rays[r].direction[1] + 1);
    trace->background_z[r] = 0.5F * (rays[r].direction[2] + 1);
  }
  trace->background_rows.resize(count * stride);
  field_.background.Forward(
      kernels_, trace->background_positions(), count, stride, trace->background_rows.data());
  const float* out = field_.background_color.Forward(
      kernels_, trace->background_rows.data(), count, &trace->background_activations);
  const auto out_stride = static_cast<std::size_t>(field_.background_color.output_stride());
  trace->background.resize(count * channels);
  for (std::size_t r = 0; r < count; ++r) {
    std::copy_n(out + r * out_stride, channels, trace->background.data() + r * channels);
  }
  kernels_.sigmoid(trace->background.data(), count * channels, trace->background.data());
}

void RayTracer::Run(const std::vector<Ray>& rays, const TraceOptions& options, Trace* trace) {
  std::vector<State> states(rays.size());
  std::vector<std::uint32_t> active;
  for (std::size_t r = 0; r < rays.size(); ++r) {
    if (rays[r].end > 0) {
      active.push_back(static_cast<std::uint32_t>(r));
    }
  }
  for (auto* values : {&unsorted_.t,
                       &unsorted_.dt,
                       &unsorted_.sigma,
                       &unsorted_.weight,
                       &unsorted_.after,
                       &unsorted_.x,
                       &unsorted_.y,
                       &unsorted_.z,
                       &unsorted_.geometry_rows}) {
    values->clear();
  }
  unsorted_.ray.clear();
  trace->evaluated = 0;
  while (!active.empty()) {
    round_.Reserve(active.size() * kSamplesPerRound);
    for (const std::uint32_t r : active) {
      March(rays[r], r, options, &states[r]);
    }
    trace->evaluated += round_.count;
    EvaluateDensity();
    Composite(options, &states);
    active.erase(std::remove_if(active.begin(),
                                active.end(),
                                [&](std::uint32_t r) {
                                  return states[r].t >= rays[r].end ||
                                         states[r].transmittance <
                                             options.march.min_transmittance ||
                                         states[r].samples >= options.march.max_samples;
                                }),
                 active.end());
  }
  SortByRay(rays.size(), trace);
  EvaluateColor(rays, trace);
  trace->transmittance.resize(rays.size());
  for (std::size_t r = 0; r < rays.size(); ++r) {
    trace->transmittance[r] = states[r].transmittance;
  }
  if (field_.options.far_background) {
    EvaluateBackground(rays, trace);
  }
}

}  // namespace deja_view::nerf::internal
