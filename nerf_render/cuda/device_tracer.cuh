#pragma once

#include "device_field.cuh"
#include "grids.cuh"
#include "trace.cuh"

namespace deja_view::nerf::internal {

/// What RayTracer does, for many rays at once.
template <typename System>
class DeviceTracer {
 public:
  /// Traces the rays that lie in `rays`. Their samples and colours are held until the next call.
  void Run(const TraceOptions& options, DeviceField<System>* field) {
    FindSamples(options, *field);
    FindColors(field);
    if (field->has_background()) {
      FindBackground(field);
    }
  }

  std::size_t ray_count() const { return rays.size(); }
  std::size_t sample_count() const { return t.size(); }
  std::size_t CountEvaluated() const {
    std::size_t sum = 0;
    for (const std::uint32_t count : evaluated_.Download()) {
      sum += count;
    }
    return sum;
  }
  PlaceArrays places() const { return {x.data(), y.data(), z.data()}; }
  PlaceArrays background_places() const {
    return {background_x.data(), background_y.data(), background_z.data()};
  }
  FinishRow RowEnds(const DeviceField<System>& field) const {
    FinishRow row;
    row.stride = field.color.inputs();
    row.features = field.appearance.outputs();
    row.direction_degree = field.layout.direction_degree;
    row.latent_size = field.latent_size();
    row.ray_of = ray_of.data();
    row.rays = rays.data();
    return row;
  }
  TraceView View(const DeviceField<System>& field) const {
    TraceView view;
    view.ray_begin = ray_begin.data();
    view.t = t.data();
    view.dt = dt.data();
    view.sigma = sigma.data();
    view.weight = weight.data();
    view.after = after.data();
    view.color = color.data();
    view.transmittance = transmittance.data();
    view.background = field.has_background() ? background.data() : nullptr;
    view.channels = field.channels();
    return view;
  }

  DeviceArray<System, Ray> rays;
  DeviceArray<System, std::size_t> ray_begin;
  DeviceArray<System, float> transmittance;
  DeviceArray<System, std::uint32_t> ray_of;
  DeviceArray<System, float> t, dt, sigma, weight, after, x, y, z;
  DeviceArray<System, float> color, color_rows;
  DeviceArray<System, float> background, background_x, background_y, background_z, background_rows;

 private:
  void FindSamples(const TraceOptions& options, const DeviceField<System>& field) {
    const std::size_t count = rays.size();
    all_sigma_.Resize(count * RayWalk::MostSamples(options.march));
    evaluated_.Resize(count);
    transmittance.Resize(count);
    ray_begin.ResizeToZeros(count + 1);
    const WalkArrays walk{
        rays.data(), count, field.occupancy(), options, field.extent(), all_sigma_.data()};
    constexpr std::size_t kFew = 16;
    constexpr std::size_t kMost = 96;  // 24 levels of 4 features
    if (field.density.inputs() == kFew) {
      Launch<kFew>(walk, field);
    } else {
      Launch<kMost>(walk, field);
    }
    ScanBefore<System>(ray_begin.data(), count + 1, ray_begin.data());
    std::size_t total = 0;
    System::Download(ray_begin.data() + count, sizeof(total), &total);
    ray_of.Resize(total);
    for (auto* values : {&t, &dt, &sigma, &weight, &after, &x, &y, &z}) {
      values->Resize(total);
    }
    const SampleArrays out{ray_of.data(),
                           t.data(),
                           dt.data(),
                           sigma.data(),
                           weight.data(),
                           after.data(),
                           x.data(),
                           y.data(),
                           z.data()};
    ForEach<System>(count, WriteSamples{walk, ray_begin.data(), out});
  }

  template <std::size_t kInputs>
  void Launch(const WalkArrays& walk, const DeviceField<System>& field) {
    ForEach<System>(
        walk.count,
        FindDensities<kInputs>{
            walk, field.density_view(), ray_begin.data(), evaluated_.data(), transmittance.data()});
  }

  void FindColors(DeviceField<System>* field) {
    const std::size_t samples = sample_count();
    FinishRow ends = RowEnds(*field);
    color_rows.Resize(samples * ends.stride);
    ends.rows = color_rows.data();
    const GridView grid = field->appearance.view();
    ForEach<System>(samples * grid.level_count,
                    EncodeLevel{grid, places(), color_rows.data(), ends.stride});
    ForEach<System>(samples, ends);
    const float* out = field->color.Forward(color_rows.data(), samples);
    const std::size_t channels = field->channels();
    color.Resize(samples * channels);
    ForEach<System>(samples * channels,
                    SigmoidOfRows{out, field->color.outputs(), channels, color.data()});
  }

  void FindBackground(DeviceField<System>* field) {
    const std::size_t count = rays.size();
    const std::size_t channels = field->channels();
    for (auto* values : {&background_x, &background_y, &background_z}) {
      values->Resize(count);
    }
    ForEach<System>(
        count,
        BackgroundPlaces{
            rays.data(), background_x.data(), background_y.data(), background_z.data()});
    FinishRow ends;
    ends.stride = field->background_color.inputs();
    ends.features = field->background.outputs();
    background_rows.Resize(count * ends.stride);
    ends.rows = background_rows.data();
    const GridView grid = field->background.view();
    ForEach<System>(count * grid.level_count,
                    EncodeLevel{grid, background_places(), background_rows.data(), ends.stride});
    ForEach<System>(count, ends);
    const float* out = field->background_color.Forward(background_rows.data(), count);
    background.Resize(count * channels);
    ForEach<System>(
        count * channels,
        SigmoidOfRows{out, field->background_color.outputs(), channels, background.data()});
  }

  DeviceArray<System, float> all_sigma_;
  DeviceArray<System, std::uint32_t> evaluated_;
};

}  // namespace deja_view::nerf::internal
