#pragma once

#include "deja_view/base/error_policy.hpp"
#include "deja_view/front_end/odometry_front_end.hpp"

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <variant>

namespace deja_view {

/// Runs OdometryFrontEnd on a thread of its own behind a queue: adding takes microseconds.
///
/// Add... may be called by any thread; the callbacks are called on the front end's.
class FrontEndThread {
 public:
  /// Does not start the thread. `errors` is that of the program, which must outlive this: what
  /// breaks here ends it. Throws InputError for bad options.
  FrontEndThread(const FrontEndSetup& setup,
                 ErrorPolicy* errors,
                 OdometryFrontEnd::KeyframeCallback on_keyframe,
                 OdometryFrontEnd::ProblemCallback on_problem);
  /// Stops at once.
  ~FrontEndThread();

  void Start();
  /// Works off what waits, hands over the last keyframes, and ends the thread.
  void Drain();

  /// `bytes` is what the source holds in memory. When the front end is behind by more than
  /// `image_memory_mb`, the oldest image that waits is given up and told of.
  void AddImage(std::int64_t stamp_ns, ImageSource image, std::size_t bytes);
  void AddPose(std::int64_t stamp_ns, const Rigid3& T_W_B);

  FrontEndCounts counts() const;
  /// OdometryFrontEnd::T_L_W.
  Rigid3 T_L_W() const;

 private:
  using Task = std::variant<WaitingImage, StampedPose>;
  enum class State { kRunning, kDraining, kStopped };

  void Join(State state);
  void Enqueue(Task task);
  bool NextTask(Task* task);
  void Work();
  void Process(WaitingImage& image);
  void Process(const StampedPose& pose);
  void DropOldImages();

  double image_memory_mb_;
  OdometryFrontEnd::ProblemCallback on_problem_;
  OdometryFrontEnd front_end_;  ///< the thread's
  ErrorPolicy* errors_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task> queue_;
  std::size_t queued_bytes_ = 0;
  State state_ = State::kStopped;
  FrontEndCounts counts_;
  Rigid3 T_L_W_;
  std::int64_t overflows_ = 0;
  std::thread thread_;
};

}  // namespace deja_view
