#include "deja_view/base/check.hpp"
#include "deja_view/base/output_lock.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/nerf/cell_images.hpp"
#include "deja_view/nerf/checkpoint.hpp"
#include "deja_view/nerf/posed_images.hpp"
#include "deja_view/nerf/sparse_points.hpp"
#include "deja_view/nerf/trainer.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/device_option.hpp"
#include "common/interrupt.hpp"
#include "common/tool_figures.hpp"
#include "nerf/nerf_command.hpp"
#include "nerf/nerf_options.hpp"
#include "nerf/sub_maps.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

std::size_t CountPoints(const std::vector<nerf::TrainingView>& views) {
  std::size_t count = 0;
  for (const nerf::TrainingView& view : views) {
    count += view.points.size();
  }
  return count;
}

nerf::SceneBox MakeBox(const NerfTrainRequest& request,
                       const std::vector<nerf::TrainingView>& views) {
  if (request.box.empty()) {
    return nerf::BoxAround(views, request.margin.value_or(DefaultMargin(views)));
  }
  nerf::SceneBox box;
  box.min = {request.box[0], request.box[1], request.box[2]};
  box.max = {request.box[3], request.box[4], request.box[5]};
  if (!(box.max.array() > box.min.array()).all()) {
    ThrowInputError("--box: expected each maximum to be greater than its minimum");
  }
  return box;
}

// What a training starts from.
struct Beginning {
  std::optional<nerf::RadianceField> field;  // to go on with
  SceneCells cells;
  std::vector<nerf::PosedImage> images;
  std::size_t outside = 0;  // images left out that the field's box does not hold
};

nerf::Split ReadInputs(const NerfTrainRequest& request) {
  nerf::Split split = ReadNerfInput(request.input);
  for (const NerfInput& input : request.more) {
    std::vector<nerf::PosedImage> images = ReadNerfInput(input).training;
    std::move(images.begin(), images.end(), std::back_inserter(split.training));
  }
  return split;
}

// A trained field as one whose training is half done: rates as high as they then were, which is
// enough to learn what it has not seen and not to forget what it has.
nerf::RadianceField ReadStart(const std::filesystem::path& path) {
  constexpr float kProgress = 0.75F;
  nerf::RadianceField field = nerf::ReadField(path);
  field.progress = kProgress;
  return field;
}

std::size_t DropOutside(const nerf::SceneBox& box, std::vector<nerf::PosedImage>* images) {
  const auto inside = std::remove_if(images->begin(), images->end(), [&](const auto& image) {
    const Eigen::Vector3d& p_N = image.T_N_C.t;
    return (p_N.array() < box.min.array()).any() || (p_N.array() > box.max.array()).any();
  });
  const auto outside = static_cast<std::size_t>(images->end() - inside);
  images->erase(inside, images->end());
  return outside;
}

Beginning Begin(const NerfTrainRequest& request) {
  Beginning beginning;
  nerf::Split split = ReadInputs(request);
  if (!request.start_from.empty() && request.resume.empty()) {
    beginning.field = ReadStart(request.start_from);
    beginning.cells = beginning.field->cells;
    CheckShard(request.shard, beginning.cells, request.start_from.string());
  } else if (request.resume.empty()) {
    beginning.cells = CutScene(split, request.shard);
  } else {
    beginning.field = nerf::ReadField(request.resume);
    if (beginning.field->progress >= 1) {
      ThrowInputError("{}: its training is complete; nothing is left to resume",
                      request.resume.string());
    }
    beginning.cells = beginning.field->cells;
    CheckShard(request.shard, beginning.cells, request.resume.string());
  }
  const SceneCells& cells = beginning.cells;
  beginning.images = cells.IsCut() ? nerf::SelectCellImages(split.training, cells.own())
                                   : std::move(split.training);
  if (!request.start_from.empty()) {
    beginning.outside = DropOutside(beginning.field->box, &beginning.images);
  }
  if (beginning.images.empty() && beginning.outside > 0) {
    ThrowInputError("{}: all {} images are outside of the box that it is the field of",
                    request.start_from.string(),
                    beginning.outside);
  }
  if (beginning.images.empty()) {
    ThrowInputError("none of the images to train on is of sub-map {}/{}",
                    cells.shard().index,
                    cells.shard().count);
  }
  return beginning;
}

nerf::Trainer MakeTrainer(const NerfTrainRequest& request,
                          const nerf::TrainOptions& options,
                          std::vector<nerf::TrainingView> views,
                          std::optional<nerf::RadianceField> field) {
  const nerf::DeviceChoice device = ChooseToolDevice(request.device);
  if (field) {
    return nerf::Trainer(options, std::move(views), std::move(*field), device);
  }
  const nerf::SceneBox box = MakeBox(request, views);
  return nerf::Trainer(options, std::move(views), box, device);
}

/// What the steps of a training add up to.
struct TrainingSums {
  std::size_t rays = 0;
  std::size_t samples = 0;
  std::size_t weighted = 0;
  int steps = 0;
  double psnr_db = 0;  ///< over the last steps

  void Add(const nerf::StepReport& report) {
    rays += report.rays;
    samples += report.samples;
    weighted += report.weighted;
    psnr_db += (steps == 0 ? 1.0 : 0.02) * (report.psnr_db - psnr_db);
    ++steps;
  }
  std::string Line(double share) const {
    const auto per_ray = [&](std::size_t count) {
      return static_cast<double>(count) / static_cast<double>(rays);
    };
    return fmt::format("{:.0f} %  PSNR {:.2f} dB  {:.1f} samples/ray, {:.1f} coloured",
                       100 * share,
                       psnr_db,
                       per_ray(samples),
                       per_ray(weighted));
  }
};

/// How far a training is, by the clock or, for repeatable ones, by steps.
class Schedule {
 public:
  Schedule(const NerfTrainRequest& request, Clock::time_point start, double done)
      : request_(request), start_(start), setup_s_(SecondsSince(start)), done_(done) {}

  /// In [0, 1); 1 or more when the training is over.
  double Share(int steps) const { return done_ + (1 - done_) * ShareOfRun(steps); }

  /// Of this run, which may go on with an older one.
  double ShareOfRun(int steps) const {
    // Time that writing the model takes; part of the budget.
    constexpr double kWriting_s = 1.5;
    if (request_.steps > 0) {
      return static_cast<double>(steps) / request_.steps;
    }
    // Where reading the images took most of the budget, or more, some training remains.
    const double left_s =
        std::max({request_.budget_s - setup_s_, 0.25 * request_.budget_s, 2 * kWriting_s});
    return (SecondsSince(start_) + kWriting_s - setup_s_) / left_s;
  }
  double setup_s() const { return setup_s_; }

 private:
  const NerfTrainRequest& request_;
  Clock::time_point start_;
  double setup_s_;
  double done_;
};

/// The model's file while it is trained.
class ModelFile {
 public:
  explicit ModelFile(const NerfTrainRequest& request) : request_(request) {}

  void Write(const nerf::RadianceField& field) {
    nerf::WriteField(request_.out, field);
    written_ = Clock::now();
    share_ = static_cast<double>(field.progress);
  }
  bool IsDue() const {
    return request_.checkpoint_s > 0 && SecondsSince(written_) > request_.checkpoint_s;
  }
  /// What there is to go on with.
  std::string Describe() const {
    if (share_ < 0) {
      return request_.resume.empty() ? "no model was written yet"
                                     : fmt::format("{} is as it was", request_.resume.string());
    }
    return fmt::format("{0} holds {1:.0f} % of the training: go on with --resume {0}",
                       request_.out.string(),
                       100 * share_);
  }

 private:
  const NerfTrainRequest& request_;
  Clock::time_point written_ = Clock::now();
  double share_ = -1;  // of the training, that the file holds; below 0: not written yet
};

/// Steps until the schedule's end or Ctrl-C, and writes the model now and then. Returns whether it
/// was interrupted.
bool Train(const NerfTrainRequest& request,
           const Interrupt& interrupt,
           const Schedule& schedule,
           nerf::Trainer* trainer,
           ModelFile* file,
           TrainingSums* sums) {
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("training", "krays", 0);
  }
  bool interrupted = false;
  for (double share = schedule.Share(0); share < 1 && !interrupted;
       share = schedule.Share(sums->steps)) {
    sums->Add(trainer->Step(share));
    if (progress) {
      const double krays = static_cast<double>(sums->rays) / 1000;
      progress->SetTotal(static_cast<std::size_t>(krays / schedule.ShareOfRun(sums->steps)));
      progress->Update(sums->rays / 1000, sums->Line(share));
    }
    if (file->IsDue()) {
      file->Write(trainer->field());
    }
    try {
      interrupt.Check();
    } catch (const Interrupted&) {
      interrupted = true;
    }
  }
  if (!interrupted) {
    sums->Add(trainer->Step(1));  // marks the training as complete
  }
  if (progress) {
    progress->Finish(sums->rays / 1000, fmt::format("PSNR {:.2f} dB", sums->psnr_db));
  }
  file->Write(trainer->field());
  return interrupted;
}

// Train; a lost card leaves the file as it was last written.
bool TrainOrTell(const NerfTrainRequest& request,
                 const Interrupt& interrupt,
                 const Schedule& schedule,
                 nerf::Trainer* trainer,
                 TrainingSums* sums) {
  ModelFile file(request);
  try {
    return Train(request, interrupt, schedule, trainer, &file, sums);
  } catch (const nerf::DeviceLostError& e) {
    throw nerf::DeviceLostError(fmt::format("{}; {}", e.what(), file.Describe()));
  }
}

}  // namespace

Json RunNerfTrain(const NerfTrainRequest& request) {
  const auto start = Clock::now();
  const Interrupt interrupt;
  const OutputLock lock = OutputLock::OfFile(request.out);
  const nerf::TrainOptions options =
      ReadTrainOptions(request.config, request.overrides, request.threads);
  Beginning beginning = Begin(request);
  std::vector<nerf::TrainingView> views =
      LoadTrainingViews(request.input, beginning.images, request.threads);
  if (request.sparse_points) {
    nerf::AddSparsePoints({}, request.threads, &views);
  }
  const std::size_t points = CountPoints(views);
  nerf::Trainer trainer =
      MakeTrainer(request, options, std::move(views), std::move(beginning.field));
  trainer.SetCells(beginning.cells);
  if (request.resume.empty() && request.start_from.empty()) {
    trainer.SetFrame(FrameOf(request.input));
  }
  const Schedule schedule(request, start, static_cast<double>(trainer.field().progress));
  const auto train_start = Clock::now();
  TrainingSums sums;
  const bool interrupted = TrainOrTell(request, interrupt, schedule, &trainer, &sums);
  const double train_s = SecondsSince(train_start);
  Json json;
  json["model"] = request.out.string();
  if (beginning.cells.IsCut()) {
    json["shard"] = fmt::format("{}/{}", beginning.cells.index, beginning.cells.cells.size());
  }
  json["images"] = beginning.images.size();
  if (!request.start_from.empty()) {
    json["images_outside"] = beginning.outside;
  }
  json["steps"] = sums.steps;
  json["psnr_db"] = sums.psnr_db;
  json["train_wall_s"] = SecondsSince(start);
  json["setup_s"] = schedule.setup_s();
  json["depth_points"] = points;
  json["rays"] = sums.rays;
  json["samples"] = sums.samples;
  json["weighted_samples"] = sums.weighted;
  json["rays_per_s"] = static_cast<double>(sums.rays) / train_s;
  json["samples_per_s"] = static_cast<double>(sums.samples) / train_s;
  json["interrupted"] = interrupted;
  json["peak_device_mb"] = static_cast<double>(trainer.device_bytes()) / (1 << 20U);
  json["peak_rss_mb"] = PeakRssMb();
  return json;
}

}  // namespace deja_view
