#include "ray_tracer.hpp"

#include <algorithm>

namespace deja_view::nerf::internal {
std::size_t LatentColumn(const RadianceField& field) {
  const int degree = field.options.direction_degree;
  return static_cast<std::size_t>(field.appearance.outputs() + (degree + 1) * (degree + 1) - 1);
}

BoxView ViewOf(const SceneBox& box) {
  BoxView view;
  view.size = box.Size();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    view.min[axis] = box.min[i];
    view.extent[axis] = (box.max[i] - box.min[i]) / view.size;
  }
  return view;
}

Ray MakeRay(const RadianceField& field,
            const Eigen::Vector3d& origin_N,
            const Eigen::Vector3d& direction_N,
            float jitter) {
  return RayInBox(ViewOf(field.box), origin_N.data(), direction_N.data(), jitter);
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
  const OccupancyView grid = field_.occupancy.view();
  const Eigen::Vector3f extent = field_.Extent();
  std::size_t found = 0;
  float t = state->t;
  MarchSample sample;
  while (found < kSamplesPerRound && NextSample(grid, ray, options, &t, &sample)) {
    const std::size_t s = round_.count++;
    round_.ray[s] = number;
    round_.t[s] = ray.before + sample.middle;
    round_.dt[s] = sample.dt;
    const std::array<float, 3> p = PlaceOf(ray, sample.middle, extent.data());
    round_.x[s] = p[0];
    round_.y[s] = p[1];
    round_.z[s] = p[2];
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
