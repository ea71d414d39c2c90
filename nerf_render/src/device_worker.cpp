#include "device_worker.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "device_renderer.hpp"
#include "plain_field.hpp"

namespace deja_view::nerf::internal {
namespace {

/// The images as the device takes them; copies of those whose rows have gaps.
struct PlainSet {
  TrainingSet set;
  std::vector<cv::Mat> images;
};

void AddPoints(const TrainingView& view, std::uint32_t v, float box_size, TrainingSet* set) {
  for (const DepthPoint& point : view.points) {
    PlainPoint plain;
    plain.view = v;
    plain.x = std::clamp(static_cast<int>(std::lround(point.u)), 0, view.image.cols - 1);
    plain.y = std::clamp(static_cast<int>(std::lround(point.v)), 0, view.image.rows - 1);
    plain.range = point.range / box_size;
    set->points.push_back(plain);
  }
}

PlainSet MakeSet(const std::vector<TrainingView>& views, float box_size) {
  PlainSet plain;
  std::map<const Camera*, std::uint32_t> lenses;
  for (const TrainingView& view : views) {
    const auto number = static_cast<std::uint32_t>(lenses.size());
    const auto [lens, is_new] = lenses.emplace(view.camera.get(), number);
    if (is_new) {
      plain.set.lenses.push_back(LensOf(*view.camera));
    }
    const auto v = static_cast<std::uint32_t>(plain.images.size());
    plain.images.push_back(view.image.isContinuous() ? view.image : view.image.clone());
    plain.set.images.push_back({plain.images.back().ptr(),
                                view.image.cols,
                                view.image.rows,
                                view.image.channels(),
                                lens->second});
    AddPoints(view, v, box_size, &plain.set);
  }
  return plain;
}

// What training takes on a device however few rays there are: the field, and of each number its
// gradient and Adam's two; a density per cell; the images.
std::size_t FixedBytes(const RadianceField& field, const std::vector<TrainingView>& views) {
  std::size_t bytes = 4 * BytesOf(field) + field.occupancy.cell_count() * sizeof(float);
  for (const TrainingView& view : views) {
    bytes += view.image.total() * view.image.elemSize();
  }
  return bytes;
}

}  // namespace

DeviceWorker::DeviceWorker(const DeviceChoice& device,
                           const TrainOptions& options,
                           const std::vector<TrainingView>& views,
                           const ImageParameters& image_parameters,
                           const OccupancyUpdate& occupancy,
                           RadianceField* field)
    : image_parameters_(image_parameters),
      field_(*field),
      views_(views.size()),
      engine_(OpenDevice(*field, device)),
      batches_(engine_->Name(), options.march, FixedBytes(*field, views)) {
  const PlainSet plain = MakeSet(views, static_cast<float>(field->box.Size()));
  batches_.Try([&] { engine_->StartTraining(options, plain.set, occupancy.open()); }, [] {});
}

ImageState DeviceWorker::MakeState() const {
  ImageState state;
  state.gain_bias = image_parameters_.gain_bias();
  state.vignetting_k = field_.vignetting.k;
  const auto size = static_cast<std::size_t>(field_.options.latent_size);
  for (std::size_t v = 0; v < views_; ++v) {
    state.poses.push_back(PlainPoseOf(image_parameters_.T_N_C(v)));
    if (const float* latent = image_parameters_.latent(v)) {
      state.latents.insert(state.latents.end(), latent, latent + size);
    }
  }
  return state;
}

StepSums DeviceWorker::RunRays(const StepPlan& plan, std::vector<ImageGradient>* images) {
  StepSums sums;
  is_field_old_ = true;
  batches_.Try(
      [&] {
        engine_->SetImages(MakeState());
        sums = AddRays(plan, images);
      },
      [&] { engine_->DropGradients(); });
  return sums;
}

StepSums DeviceWorker::AddRays(const StepPlan& plan, std::vector<ImageGradient>* images) {
  const std::size_t rays = plan.chunks * kRaysPerChunk;
  StepSums sums;
  images->clear();
  for (std::size_t first = 0; first < rays; first += batches_.size()) {
    RayGradients gradients;
    sums.Add(engine_->AddRays(plan, first, std::min(batches_.size(), rays - first), &gradients));
    ImageGradient image;
    image.targets = std::move(gradients.targets);
    image.d_exposure = std::move(gradients.d_exposure);
    image.d_latent = std::move(gradients.d_latent);
    images->push_back(std::move(image));
  }
  return sums;
}

void DeviceWorker::UpdateField(float rate) {
  engine_->UpdateField(rate);
}

void DeviceWorker::UpdateOccupancy(std::uint64_t round, bool full) {
  is_field_old_ = true;
  batches_.Try([&] { engine_->UpdateOccupancy(round, full); }, [] {});
}

void DeviceWorker::Download() {
  if (!is_field_old_) {
    return;
  }
  std::vector<std::uint64_t> words;
  engine_->SaveField(ArraysOf(&field_, &words));
  field_.occupancy.SetWords(std::move(words));
  for (Network* network : {&field_.density, &field_.color, &field_.background_color}) {
    network->UpdateTranspose();
  }
  is_field_old_ = false;
}

}  // namespace deja_view::nerf::internal
