#pragma once

#include "deja_view/base/error_policy.hpp"
#include "deja_view/fusion/front_end_thread.hpp"
#include "deja_view/fusion/loop_fusion_options.hpp"
#include "deja_view/host/keyframe_assembler.hpp"
#include "deja_view/host/odometry_input.hpp"
#include "deja_view/pipeline/loop_closer.hpp"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <variant>

namespace deja_view {

/// Called on the worker thread.
struct LoopFusionCallbacks {
  /// After each keyframe, with the loop closer locked.
  std::function<void(const KeyframeInput&, const KeyframeReport&, const LoopCloser&)> on_keyframe;
  /// A message or keyframe that can't be used, or that was dropped. Also from the thread that adds
  /// messages.
  std::function<void(const std::string& what)> on_problem;
};

/// What happened so far.
struct LoopFusionStatistics {
  AssemblerCounts assembler;
  FrontEndCounts front_end;          ///< where keyframes are made here
  std::int64_t keyframes = 0;        ///< processed
  std::int64_t refused = 0;          ///< keyframes that could not be used
  std::int64_t queue_overflows = 0;  ///< keyframes dropped because the queue was full
  int queue_length = 0;              ///< keyframes that wait now
  int queue_peak = 0;                ///< the longest it ever was
  std::int64_t relative_poses = 0;   ///< of the VIO's relocalisation, taken over
  std::int64_t relative_poses_ignored = 0;
  std::map<std::string, std::int64_t> candidates;  ///< verified, by reason ("accepted")
  std::int64_t joins_taken_back = 0;  ///< the flight had been joined wrongly to another world
  double mean_ms = 0;                 ///< per keyframe
  double max_ms = 0;
  ViewCounts views;
  std::int64_t view_overflows = 0;    ///< views dropped because the queue was full
  std::size_t view_memory_bytes = 0;  ///< of the views kept, with their part of the index
};

/// Decodes a virtual view when its turn comes. May throw InputError.
using VirtualViewSource = std::function<VirtualView()>;

/// Runs the loop closer on a thread of its own behind a bounded queue: adding messages takes
/// microseconds. Keyframes are processed in order, so that the result is that of a replay of the
/// same messages, unless the queue overflows.
///
/// Add... may be called by one thread or several; all other methods by any.
class LoopFusion {
 public:
  /// Does not start the thread. Throws InputError for options that are not valid.
  LoopFusion(const LoopFusionOptions& options, LoopCloser closer, LoopFusionCallbacks callbacks);
  /// For a host that gives poses alone (AddOdometry): keyframes are made of them and the images, on
  /// one thread more. `camera` and `T_B_C` are the loop closer's.
  LoopFusion(const LoopFusionOptions& options,
             LoopCloser closer,
             LoopFusionCallbacks callbacks,
             std::shared_ptr<const Camera> camera,
             const Rigid3& T_B_C,
             GravityPolicy gravity = GravityPolicy::kGiven);
  /// Stops without draining.
  ~LoopFusion();

  void Start();

  /// No more messages: finishes the keyframes that wait, for at most `drain`. Returns how many were
  /// left.
  int Stop(std::chrono::duration<double> drain);

  /// `bytes` is what the source holds in memory.
  void AddImage(std::int64_t stamp_ns, ImageSource image, std::size_t bytes);
  void AddPose(std::int64_t stamp_ns, const Rigid3& T_W_B);
  void AddPoints(std::int64_t stamp_ns, std::vector<TrackedPoint> points);
  void AddExtrinsic(std::int64_t stamp_ns, const Rigid3& T_B_C);
  /// Body pose at any stamp; passed over where the host has keyframes of its own.
  void AddOdometry(std::int64_t stamp_ns, const Rigid3& T_W_B);
  void AddRelativePose(const RelativePoseUpdate& update);
  void AddVirtualView(VirtualViewSource view, std::size_t bytes);

  /// T_M_W after the newest keyframe, of the odometry's own world, level or not; never waits for
  /// one.
  Rigid3 drift() const;

  LoopFusionStatistics statistics() const;

  /// Of the worker: after a failure it processes nothing any more.
  const ErrorPolicy& errors() const { return errors_; }

  /// Calls `use(LoopCloser&)` between two keyframes and returns what it returns.
  template <typename Use>
  auto WithLoopCloser(Use&& use) {
    const std::lock_guard<std::mutex> lock(closer_mutex_);
    auto result = use(closer_);
    SetDrift(closer_.drift());
    return result;
  }

  /// Runs graph solves on a thread beside the keyframes'.
  static std::future<void> RunBeside(std::function<void()> solve);

 private:
  using Content = std::variant<AssembledKeyframe, RelativePoseUpdate, VirtualViewSource>;
  struct Task {
    Content content;
    std::size_t bytes = 0;  ///< that its images hold
    bool is_view() const { return std::holds_alternative<VirtualViewSource>(content); }
  };

  void Enqueue(Task task);
  /// Drops the oldest tasks of the kind of which there are too many; how many.
  int MakeRoom(const Task& task);
  std::optional<Task> NextTask();
  void Work();
  void Process(const AssembledKeyframe& keyframe);
  void Process(const RelativePoseUpdate& update);
  void Process(const VirtualViewSource& source);
  void CountViews();
  void CountKeyframe(const KeyframeReport& report);
  void SetDrift(const Rigid3& T_M_W);
  void Tell(const std::string& what) const;

  NodeOptions options_;
  LoopFusionCallbacks callbacks_;
  ErrorPolicy errors_{[this](const std::string& what) { Tell(what); }};

  mutable std::mutex assembler_mutex_;
  KeyframeAssembler assembler_;
  std::unique_ptr<FrontEndThread> front_end_;

  mutable std::mutex queue_mutex_;
  std::condition_variable queue_changed_;
  std::deque<Task> queue_;
  bool is_stopping_ = false;
  std::chrono::steady_clock::time_point deadline_{};

  std::mutex closer_mutex_;
  LoopCloser closer_;
  std::optional<Rigid3> T_B_C_;

  mutable std::mutex statistics_mutex_;
  LoopFusionStatistics statistics_;
  Rigid3 T_M_W_;

  std::thread worker_;
};

}  // namespace deja_view
