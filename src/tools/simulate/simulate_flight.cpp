#include "simulate/simulate_flight.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/camera/depth_image.hpp"
#include "deja_view/io/options_yaml.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/lab/sim/camera_yaml.hpp"
#include "deja_view/lab/sim/simulator.hpp"

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "common/interrupt.hpp"
#include "simulate/exact_views.hpp"
#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#ifdef DEJA_VIEW_WITH_ROS
#include "simulate/flight_bag.hpp"
#endif

namespace deja_view {
namespace {

namespace fs = std::filesystem;

/// A directory that gets its name when it is complete, in place of an older one. Its parent is
/// locked (OutputLock), so that what is there already was left by a killed process.
class PendingDirectory {
 public:
  explicit PendingDirectory(fs::path path)
      : path_(std::move(path)), temporary_(path_.string() + ".deja_view_tmp") {
    fs::remove_all(temporary_);
    fs::create_directories(temporary_);
  }
  ~PendingDirectory() {
    std::error_code error;
    fs::remove_all(temporary_, error);
  }
  PendingDirectory(const PendingDirectory&) = delete;
  PendingDirectory& operator=(const PendingDirectory&) = delete;

  void WriteImage(const std::string& name, const cv::Mat& image) const {
    const fs::path file = temporary_ / name;
    if (!cv::imwrite(file.string(), image)) {
      ThrowInputError("{}: can't be written", file.string());
    }
  }
  void Commit() const {
    fs::remove_all(path_);
    fs::rename(temporary_, path_);
  }

 private:
  fs::path path_, temporary_;
};

/// Writes images and ranges, counts, and passes everything on to the bag.
class RecordedFiles : public sim::FlightSink {
 public:
  RecordedFiles(const sim::Simulator& simulator, const SimulateRequest& request)
      : simulator_(simulator), extension_(request.images) {
    if (extension_ != "none") {
      images_.emplace(request.out / "images");
    }
    if (request.ranges) {
      ranges_.emplace(request.out / "ranges");
    }
#ifdef DEJA_VIEW_WITH_ROS
    if (request.bag) {
      bag_ = std::make_unique<FlightBag>(
          request.out / "flight.bag", simulator.camera(), sim::SimulatedExtrinsic());
      if (!request.virtual_views.empty()) {
        views_.emplace(simulator, request);
      }
    }
#endif
  }

  void OnImu(const sim::ImuSample& sample) override {
    ++imu_samples;
    PassOn([&](FlightSink& sink) { sink.OnImu(sample); });
  }
  void OnImage(std::int64_t stamp_ns, const cv::Mat& image) override {
    if (images_) {
      images_->WriteImage(fmt::format("{}.{}", stamp_ns, extension_), image);
    }
    if (ranges_) {
      const double t = 1e-9 * static_cast<double>(stamp_ns - simulator_.options().start_stamp_ns);
      const Rigid3 T_W_C = simulator_.path().Pose(t) * sim::SimulatedExtrinsic();
      ranges_->WriteImage(fmt::format("{}.png", stamp_ns),
                          ToMillimetres(simulator_.renderer().RenderRange(T_W_C)));
    }
    PassOn([&](FlightSink& sink) { sink.OnImage(stamp_ns, image); });
  }
  void OnOdometry(std::int64_t arrival_ns, const sim::VioOdometry& odometry) override {
    PassOn([&](FlightSink& sink) { sink.OnOdometry(arrival_ns, odometry); });
  }
  void OnKeyframe(std::int64_t arrival_ns, const KeyframeInput& keyframe) override {
    vio.stamps_ns.push_back(keyframe.stamp_ns);
    vio.poses.push_back(keyframe.T_W_B);
    points += keyframe.points.size();
    PassOn([&](FlightSink& sink) { sink.OnKeyframe(arrival_ns, keyframe); });
#ifdef DEJA_VIEW_WITH_ROS
    if (views_) {
      for (const VirtualView& view : views_->Render(keyframe.stamp_ns)) {
        bag_->AddVirtualView(arrival_ns, view);
        ++virtual_views;
      }
    }
#endif
  }

  /// Gives all files their names.
  void Commit() {
    if (images_) {
      images_->Commit();
    }
    if (ranges_) {
      ranges_->Commit();
    }
#ifdef DEJA_VIEW_WITH_ROS
    if (bag_) {
      bag_->Close();
    }
#endif
  }

  Trajectory vio;
  std::size_t points = 0;
  std::size_t imu_samples = 0;
  std::size_t virtual_views = 0;

 private:
  template <typename Call>
  void PassOn(const Call& call) {
#ifdef DEJA_VIEW_WITH_ROS
    if (bag_) {
      call(*bag_);
    }
#else
    static_cast<void>(call);
#endif
  }

  const sim::Simulator& simulator_;
  std::string extension_;
  std::optional<PendingDirectory> images_;
  std::optional<PendingDirectory> ranges_;
#ifdef DEJA_VIEW_WITH_ROS
  std::unique_ptr<FlightBag> bag_;
#endif
  std::optional<ExactViews> views_;
};

SimulateRequest Completed(SimulateRequest request) {
  if (request.images.empty()) {
    request.images = request.bag ? "none" : "png";
  }
#ifndef DEJA_VIEW_WITH_ROS
  if (request.bag) {
    ThrowInputError("--bag: this deja_view was built without ROS; images and poses work");
  }
#endif
  if (!request.virtual_views.empty() && !request.bag && request.views_for.empty() &&
      request.views_like.empty()) {
    ThrowInputError("--virtual-views {}: they go into the bag; expected --bag as well",
                    request.virtual_views);
  }
  return request;
}

}  // namespace

nlohmann::ordered_json RunSimulate(const SimulateRequest& unfinished_request) {
  const SimulateRequest request = Completed(unfinished_request);
  const Interrupt interrupt;
  const auto begin = std::chrono::steady_clock::now();
  const sim::SimOptions options = ReadSimOptions(request);
  const sim::Simulator simulator(options);
  RecordedFiles files(simulator, request);
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("simulate", "images", simulator.image_count());
  }
  simulator.Run(&files, [&](std::size_t done, std::size_t /*total*/) {
    interrupt.Check();
    if (progress) {
      progress->Update(done, fmt::format("{} keyframes", files.vio.size()));
    }
  });
  files.Commit();
  WriteTum(request.out / "groundtruth.txt", simulator.path().GroundTruth(options.start_stamp_ns));
  WriteTum(request.out / "vio.txt", files.vio);
  WriteFileAtomically(request.out / "camera.yaml", [&](std::ostream& out) {
    out << sim::CameraYaml(simulator.camera()->parameters(), sim::SimulatedExtrinsic());
  });
  WriteFileAtomically(request.out / "simulation.yaml",
                      [&](std::ostream& out) { out << OptionsToYaml(options); });
  if (progress) {
    progress->Finish(simulator.image_count(), fmt::format("{} keyframes", files.vio.size()));
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  const auto keyframes = static_cast<double>(std::max<std::size_t>(1, files.vio.size()));
  return {{"preset", request.preset},
          {"seed", options.seed},
          {"flight_seed", options.flight_seed},
          {"duration_s", options.flight.duration_s},
          {"path_m", simulator.path().Length()},
          {"drift", simulator.drift().drift()},
          {"images", simulator.image_count()},
          {"imu_samples", files.imu_samples},
          {"keyframes", files.vio.size()},
          {"virtual_views", files.virtual_views},
          {"points_per_keyframe", static_cast<double>(files.points) / keyframes},
          {"wall_s", wall.count()}};
}

}  // namespace deja_view
