#pragma once

#include <memory>
#include <new>
#include <string>
#include <utility>

#include "device_engine.hpp"
#include "device_occupancy.cuh"
#include "device_training.cuh"
#include "pixel_sum.hpp"

namespace deja_view::nerf::internal {

/// Index: ray.
struct ShadePixel {
  PixelSum sum;
  const float* vignetting = nullptr;
  PixelArrays out;

  DEJA_VIEW_HOST_DEVICE void operator()(std::size_t ray) const {
    const PixelValues pixel = sum(ray, vignetting[ray]);
    for (std::size_t c = 0; c < sum.trace.channels; ++c) {
      out.image[ray * sum.trace.channels + c] = pixel.color[c];
    }
    out.depth[ray] = pixel.depth;
    out.depth_variance[ray] = pixel.depth_variance;
    out.opacity[ray] = pixel.opacity;
  }
};

/// DeviceEngine on the device that System reaches; see device_memory.cuh.
template <typename System>
class Engine final : public DeviceEngine {
 public:
  Engine(int card, std::string name) : card_(card), name_(std::move(name)) {}
  ~Engine() override {
    try {
      System::Select(card_);
    } catch (const DeviceError&) {
      // Gone; so is what it held.
    }
  }

  std::string Name() const override { return name_; }
  std::size_t PeakBytes() const override { return peak_; }

  void LoadField(const FieldLayout& layout, const ConstArrays& values) override {
    Do([&] { field_.Load(layout, values); });
  }
  void SaveField(const Arrays& values) override {
    Do([&] { field_.Save(values); });
  }

  void Render(const RenderJob& job,
              std::size_t first,
              std::size_t count,
              const PixelArrays& out) override {
    Do([&] {
      tracer_->rays.Resize(count);
      vignetting_.Resize(count);
      ForEach<System>(
          count,
          RayOfPixel{job, field_.layout.box, first, tracer_->rays.data(), vignetting_.data()});
      tracer_->Run(job.trace, &field_);
      Shade(job, count, out);
    });
  }

  void StartTraining(const TrainOptions& options,
                     const TrainingSet& set,
                     const std::vector<std::uint64_t>& open) override {
    Do([&] {
      occupancy_ = std::make_unique<DeviceOccupancy<System>>(options, open);
      training_ = std::make_unique<DeviceTraining<System>>(options, set, &field_);
    });
  }
  void SetImages(const ImageState& state) override {
    Do([&] { training_->SetImages(state); });
  }
  StepSums AddRays(const StepPlan& plan,
                   std::size_t first,
                   std::size_t count,
                   RayGradients* out) override {
    StepSums sums;
    Do([&] { sums = training_->AddRays(plan, first, count, out); });
    return sums;
  }
  void DropGradients() override {
    Do([&] { training_->DropGradients(); });
  }
  void UpdateField(float rate) override {
    Do([&] { training_->UpdateField(rate); });
  }
  void UpdateOccupancy(std::uint64_t round, bool full) override {
    Do([&] { occupancy_->Run(round, full, &field_); });
  }

 private:
  // What went wrong shows at the latest here, so that no result of it is used.
  template <typename Work>
  void Do(const Work& work) {
    try {
      System::Select(card_);
      work();
      System::Finish();
    } catch (const DeviceMemoryError&) {
      Release();
      throw;
    } catch (const DeviceError&) {
      throw;
    } catch (const std::bad_alloc& e) {
      Release();
      throw DeviceMemoryError(e.what());
    } catch (const std::exception& e) {
      throw DeviceLostError(e.what());
    }
    peak_ = std::max(peak_, System::UsedBytes());
  }

  // Makes room for fewer rays.
  void Release() {
    tracer_ = std::make_unique<DeviceTracer<System>>();
    field_.Release();
    if (training_ != nullptr) {
      training_->Release();
    }
  }

  void Shade(const RenderJob& job, std::size_t count, const PixelArrays& out) {
    image_.Resize(count * field_.channels());
    for (auto* values : {&depth_, &depth_variance_, &opacity_}) {
      values->Resize(count);
    }
    const PixelSum sum{
        tracer_->View(field_), static_cast<float>(field_.layout.box.size), job.gain, job.bias};
    ForEach<System>(
        count,
        ShadePixel{sum,
                   vignetting_.data(),
                   {image_.data(), depth_.data(), depth_variance_.data(), opacity_.data()}});
    image_.Download(out.image);
    depth_.Download(out.depth);
    depth_variance_.Download(out.depth_variance);
    opacity_.Download(out.opacity);
  }

  int card_;
  std::string name_;
  std::size_t peak_ = 0;
  DeviceField<System> field_;
  std::unique_ptr<DeviceTracer<System>> tracer_ = std::make_unique<DeviceTracer<System>>();
  DeviceArray<System, float> vignetting_, depth_, depth_variance_, opacity_;
  DeviceArray<System, std::uint8_t> image_;
  std::unique_ptr<DeviceOccupancy<System>> occupancy_;
  std::unique_ptr<DeviceTraining<System>> training_;
};

}  // namespace deja_view::nerf::internal
