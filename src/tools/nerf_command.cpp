#include "nerf_command.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/io/options_yaml.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/nerf/checkpoint.hpp"
#include "deja_view/nerf/field_renderer.hpp"
#include "deja_view/nerf/image_metrics.hpp"
#include "deja_view/nerf/posed_images.hpp"
#include "deja_view/nerf/trainer.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "interrupt.hpp"
#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sys/resource.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double PeakRss_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

double Median(std::vector<double> values) {
  if (values.empty()) {
    return 0;
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) {
    sum += value;
  }
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

nerf::Split ReadInput(const NerfInput& input) {
  const VinsConfig config = ReadVinsConfig(input.camera);
  const Rigid3 T_B_C = input.poses_of == "body" ? config.T_B_C : Rigid3::Identity();
  return nerf::HoldOut(
      nerf::ReadTrajectoryImages(input.images, config.camera, T_B_C, ReadTum(input.poses)),
      input.holdout);
}

nerf::TrainOptions ReadTrainOptions(const NerfTrainRequest& request) {
  nerf::TrainOptions options;
  if (!request.config.empty()) {
    ReadOptions(request.config, &options);
  }
  for (const std::string& assignment : request.overrides) {
    OverrideOption(assignment, &options);
  }
  options.threads = request.threads;
  return options;
}

nerf::SceneBox MakeBox(const NerfTrainRequest& request,
                       const std::vector<nerf::TrainingView>& views) {
  if (request.box.empty()) {
    return nerf::BoxAround(views, request.margin);
  }
  nerf::SceneBox box;
  box.min = {request.box[0], request.box[1], request.box[2]};
  box.max = {request.box[3], request.box[4], request.box[5]};
  if (!(box.max.array() > box.min.array()).all()) {
    ThrowInputError("--box: expected each maximum to be greater than its minimum");
  }
  return box;
}

void PrintJson(const Json& json) {
  for (const auto& [key, value] : json.items()) {
    std::cout << fmt::format(
        "{:<18} {}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
  }
}

void WriteImage(const fs::path& path, const cv::Mat& image) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", image, bytes);
  WriteFileAtomically(path, [&](std::ostream& out) {
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
  });
}

cv::Mat SideBySide(const cv::Mat& real, const cv::Mat& rendered) {
  cv::Mat difference;
  cv::absdiff(real, rendered, difference);
  cv::Mat picture;
  cv::hconcat(std::vector<cv::Mat>{real, rendered, 2 * difference}, picture);
  return picture;
}

cv::Mat ToGrey(const cv::Mat& image) {
  if (image.channels() == 1) {
    return image;
  }
  cv::Mat grey;
  cv::extractChannel(image, grey, 1);
  return grey;
}

}  // namespace

Json RunNerfTrain(const NerfTrainRequest& request) {
  const auto start = Clock::now();
  Interrupt interrupt;
  const nerf::TrainOptions options = ReadTrainOptions(request);
  std::vector<nerf::TrainingView> views = nerf::LoadViews(
      ReadInput(request.input).training, request.color ? 3 : 1, request.scale, request.threads);
  const nerf::SceneBox box = MakeBox(request, views);
  nerf::Trainer trainer(options, std::move(views), box);

  const auto train_start = Clock::now();
  const double setup_s = SecondsSince(start);
  // Time that writing the model takes; part of the budget.
  constexpr double kWriting_s = 1.5;
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("training", "krays", 0);
  }
  std::size_t rays = 0;
  std::size_t samples = 0;
  std::size_t weighted = 0;
  double psnr_db = 0;
  int steps = 0;
  bool interrupted = false;
  for (; !interrupted; ++steps) {
    const double share = request.steps > 0 ? static_cast<double>(steps) / request.steps
                                           : (SecondsSince(start) + kWriting_s - setup_s) /
                                                 (request.budget_s - setup_s);
    if (share >= 1) {
      break;
    }
    const nerf::StepReport report = trainer.Step(share);
    rays += report.rays;
    samples += report.samples;
    weighted += report.weighted;
    psnr_db += (steps == 0 ? 1.0 : 0.02) * (report.psnr_db - psnr_db);
    if (progress) {
      progress->Update(
          rays / 1000,
          fmt::format("{:.0f} %  PSNR {:.2f} dB  {:.1f} samples/ray, {:.1f} coloured",
                      100 * share,
                      psnr_db,
                      static_cast<double>(report.samples) / static_cast<double>(report.rays),
                      static_cast<double>(report.weighted) / static_cast<double>(report.rays)));
    }
    try {
      interrupt.Check();
    } catch (const Interrupted&) {
      interrupted = true;
    }
  }
  const double train_s = SecondsSince(train_start);
  if (progress) {
    progress->Finish(rays / 1000, fmt::format("PSNR {:.2f} dB", psnr_db));
  }
  nerf::WriteField(request.out, trainer.field());
  Json json;
  json["model"] = request.out.string();
  json["steps"] = steps;
  json["psnr_db"] = psnr_db;
  json["train_wall_s"] = SecondsSince(start);
  json["setup_s"] = setup_s;
  json["rays"] = rays;
  json["samples"] = samples;
  json["weighted_samples"] = weighted;
  json["rays_per_s"] = static_cast<double>(rays) / train_s;
  json["samples_per_s"] = static_cast<double>(samples) / train_s;
  json["interrupted"] = interrupted;
  json["peak_rss_mb"] = PeakRss_mb();
  return json;
}

Json RunNerfEval(const NerfEvalRequest& request) {
  Interrupt interrupt;
  const auto field = std::make_shared<nerf::RadianceField>(nerf::ReadField(request.model));
  const nerf::FieldRenderer renderer(field, nerf::FindKernels(request.kernels));
  std::vector<nerf::PosedImage> images = ReadInput(request.input).held_out;
  if (request.views > 0 && images.size() > static_cast<std::size_t>(request.views)) {
    images.resize(static_cast<std::size_t>(request.views));
  }
  const std::vector<nerf::TrainingView> views =
      nerf::LoadViews(images, field->channels, request.scale, request.threads);
  std::vector<double> psnr, ssim, corners, times;
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("rendering", "views", views.size());
  }
  for (const nerf::TrainingView& view : views) {
    interrupt.Check();
    const nerf::Exposure exposure = renderer.ExposureAt(view.stamp_ns);
    const auto start = Clock::now();
    const RenderedView rendered =
        renderer.Render(*view.camera, view.T_N_C, {exposure.gain, exposure.bias, request.threads});
    times.push_back(1e3 * SecondsSince(start));
    psnr.push_back(nerf::Psnr(view.image, rendered.image));
    ssim.push_back(nerf::Ssim(view.image, rendered.image));
    corners.push_back(nerf::CornerMatchRate(ToGrey(view.image), ToGrey(rendered.image)));
    if (!request.pictures.empty()) {
      WriteImage(request.pictures / (view.name + ".png"), SideBySide(view.image, rendered.image));
    }
    if (progress) {
      progress->Update(psnr.size());
    }
  }
  if (progress) {
    progress->Finish(psnr.size());
  }
  Json json;
  json["psnr_db"] = Mean(psnr);
  json["ssim"] = Mean(ssim);
  json["corner_match_rate"] = Mean(corners);
  json["views"] = psnr.size();
  json["render_ms_median"] = Median(times);
  json["peak_rss_mb"] = PeakRss_mb();
  return json;
}

Json RunNerfRender(const NerfRenderRequest& request) {
  Interrupt interrupt;
  const auto field = std::make_shared<nerf::RadianceField>(nerf::ReadField(request.model));
  const nerf::FieldRenderer renderer(field);
  const VinsConfig config = ReadVinsConfig(request.camera);
  const std::shared_ptr<const Camera> camera = config.camera->Scaled(request.scale);
  const Rigid3 T_B_C = request.poses_of == "body" ? config.T_B_C : Rigid3::Identity();
  const Trajectory trajectory = ReadTum(request.trajectory);
  if (trajectory.empty()) {
    ThrowInputError("{}: holds no pose", request.trajectory.string());
  }
  const auto period_ns = static_cast<std::int64_t>(1e9 / request.fps);
  std::vector<double> times;
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("rendering", "views", 0);
  }
  std::size_t count = 0;
  for (std::int64_t stamp_ns = trajectory.stamps_ns.front();
       stamp_ns <= trajectory.stamps_ns.back();
       stamp_ns += period_ns) {
    interrupt.Check();
    const std::optional<Rigid3> T_N_B = trajectory.At(stamp_ns);
    const auto start = Clock::now();
    const nerf::Exposure exposure = renderer.ExposureAt(stamp_ns);
    const RenderedView view =
        renderer.Render(*camera, *T_N_B * T_B_C, {exposure.gain, exposure.bias, request.threads});
    times.push_back(1e3 * SecondsSince(start));
    WriteImage(request.out / fmt::format("{:06}.png", count), view.image);
    if (request.depth) {
      cv::Mat millimetres;
      view.depth.convertTo(millimetres, CV_16U, 1000);
      WriteImage(request.out / fmt::format("{:06}.depth.png", count), millimetres);
    }
    ++count;
    if (progress) {
      progress->Update(count);
    }
  }
  if (progress) {
    progress->Finish(count);
  }
  Json json;
  json["views"] = count;
  json["render_ms_median"] = Median(times);
  json["peak_rss_mb"] = PeakRss_mb();
  return json;
}

Json RunNerfInfo(const fs::path& path) {
  const nerf::RadianceField field = nerf::ReadField(path);
  nerf::FieldOptions options = field.options;
  internal::OptionsWriter writer;
  options.Visit(writer);
  Json json;
  json["path"] = path.string();
  json["bytes"] = fs::file_size(path);
  json["channels"] = field.channels;
  json["images"] = field.exposures.size();
  json["box_min"] = {field.box.min.x(), field.box.min.y(), field.box.min.z()};
  json["box_max"] = {field.box.max.x(), field.box.max.y(), field.box.max.z()};
  json["parameters"] = field.geometry.parameters().size() + field.appearance.parameters().size() +
                       field.density.parameters().size() + field.color.parameters().size();
  json["occupied_share"] = static_cast<double>(field.occupancy.CountOccupied()) /
                           static_cast<double>(field.occupancy.cell_count());
  json["options"] = writer.text();
  return json;
}

namespace {

void AddInputOptions(CLI::App* sub, NerfInput* input) {
  sub->add_option("--images", input->images, "Directory of images named <stamp in ns>.png or .jpg")
      ->required()
      ->check(CLI::ExistingDirectory);
  sub->add_option("--camera", input->camera, "Camera and extrinsics: VINS-Mono's YAML")
      ->required()
      ->check(CLI::ExistingFile);
  sub->add_option("--poses", input->poses, "Trajectory in the TUM format")
      ->required()
      ->check(CLI::ExistingFile);
  sub->add_option("--poses-of", input->poses_of, "What the trajectory is of")
      ->check(CLI::IsMember({"body", "camera"}))
      ->capture_default_str();
  sub->add_option("--holdout", input->holdout, "Hold out every N-th image; 0: none")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
}

template <typename Run>
Command Reporting(std::shared_ptr<std::string> json_file, Run run) {
  return [json_file, run] {
    Json json;
    try {
      json = run();
    } catch (const Interrupted& e) {
      std::cerr << "deja_view: " << e.what() << "\n";
      return 130;
    }
    if (!json_file->empty()) {
      WriteFileAtomically(*json_file, [&](std::ostream& out) { out << json.dump(2) << "\n"; });
    }
    PrintJson(json);
    return 0;
  };
}

template <typename Request>
void AddCommonOptions(CLI::App* sub, Request* request, std::string* json_file) {
  sub->add_option("--scale", request->scale, "Size of the images against the files'")
      ->check(CLI::Range(0.01, 1.0))
      ->capture_default_str();
  sub->add_option("--threads", request->threads, "Threads; 0: all cores")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  sub->add_option("--json", *json_file, "File for the figures");
  sub->add_flag_callback(
      "--quiet", [request] { request->show_progress = false; }, "No progress");
}

void AddTrain(CLI::App* nerf, Command* command) {
  CLI::App* sub = nerf->add_subcommand("train", "Train a radiance field on posed images");
  auto request = std::make_shared<NerfTrainRequest>();
  auto json_file = std::make_shared<std::string>();
  AddInputOptions(sub, &request->input);
  AddCommonOptions(sub, request.get(), json_file.get());
  sub->add_option("--config", request->config, "YAML with training options")
      ->check(CLI::ExistingFile);
  sub->add_option("--set", request->overrides, "Override of an option: group.key=value")
      ->take_all();
  sub->add_option("--box", request->box, "The scene: min x y z, max x y z [m]")->expected(6);
  sub->add_option("--margin",
                  request->margin,
                  "Without --box: room about the cameras' box, times its diagonal")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  sub->add_flag("--color", request->color, "Train three channels");
  sub->add_option("--budget-s", request->budget_s, "Wall time [s]")
      ->check(CLI::Range(5.0, 1e7))
      ->capture_default_str();
  sub->add_option("--steps", request->steps, "Train this many steps, whatever the time; repeatable")
      ->check(CLI::NonNegativeNumber);
  sub->add_option("--out", request->out, "Model file")->required();
  sub->callback(
      [=] { *command = Reporting(json_file, [request] { return RunNerfTrain(*request); }); });
}

void AddEval(CLI::App* nerf, Command* command) {
  CLI::App* sub = nerf->add_subcommand("eval", "Compare renders with held-out images");
  auto request = std::make_shared<NerfEvalRequest>();
  auto json_file = std::make_shared<std::string>();
  AddInputOptions(sub, &request->input);
  AddCommonOptions(sub, request.get(), json_file.get());
  sub->add_option("--model", request->model, "Model file")->required()->check(CLI::ExistingFile);
  sub->add_option("--pictures", request->pictures, "Directory for real | rendered | difference");
  sub->add_option("--views", request->views, "At most this many views; 0: all")
      ->check(CLI::NonNegativeNumber);
  sub->add_option("--kernels", request->kernels, "Instructions: auto, portable, avx2, avx512")
      ->capture_default_str();
  sub->callback(
      [=] { *command = Reporting(json_file, [request] { return RunNerfEval(*request); }); });
}

void AddRender(CLI::App* nerf, Command* command) {
  CLI::App* sub = nerf->add_subcommand("render", "Render pictures along a trajectory");
  auto request = std::make_shared<NerfRenderRequest>();
  auto json_file = std::make_shared<std::string>();
  AddCommonOptions(sub, request.get(), json_file.get());
  sub->add_option("--model", request->model, "Model file")->required()->check(CLI::ExistingFile);
  sub->add_option("--camera", request->camera, "Camera and extrinsics: VINS-Mono's YAML")
      ->required()
      ->check(CLI::ExistingFile);
  sub->add_option("--trajectory", request->trajectory, "Poses in the TUM format")
      ->required()
      ->check(CLI::ExistingFile);
  sub->add_option("--poses-of", request->poses_of, "What the trajectory is of")
      ->check(CLI::IsMember({"body", "camera"}))
      ->capture_default_str();
  sub->add_option("--fps", request->fps, "Pictures per second of the trajectory")
      ->check(CLI::Range(1e-3, 1e3))
      ->capture_default_str();
  sub->add_flag("--depth", request->depth, "Also write depth, 16 bit, millimetres along the ray");
  sub->add_option("--out", request->out, "Directory for the pictures")->required();
  sub->callback(
      [=] { *command = Reporting(json_file, [request] { return RunNerfRender(*request); }); });
}

void AddInfo(CLI::App* nerf, Command* command) {
  CLI::App* sub = nerf->add_subcommand("info", "Check a model file and show what it holds");
  auto path = std::make_shared<fs::path>();
  auto json_file = std::make_shared<std::string>();
  sub->add_option("model", *path, "Model file")->required()->check(CLI::ExistingFile);
  sub->add_option("--json", *json_file, "File for the figures");
  sub->callback([=] { *command = Reporting(json_file, [path] { return RunNerfInfo(*path); }); });
}

}  // namespace

void AddNerfCommand(CLI::App& app, Command* command) {
  CLI::App* nerf = app.add_subcommand("nerf", "Radiance fields: train, render, eval, info");
  nerf->require_subcommand(1);
  AddTrain(nerf, command);
  AddEval(nerf, command);
  AddRender(nerf, command);
  AddInfo(nerf, command);
}

}  // namespace deja_view
