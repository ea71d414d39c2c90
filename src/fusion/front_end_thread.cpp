#include "deja_view/fusion/front_end_thread.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <utility>

namespace deja_view {

FrontEndThread::FrontEndThread(const FrontEndSetup& setup,
                               ErrorPolicy* errors,
                               OdometryFrontEnd::KeyframeCallback on_keyframe,
                               OdometryFrontEnd::ProblemCallback on_problem)
    : image_memory_mb_(setup.options.image_memory_mb),
      on_problem_(std::move(on_problem)),
      front_end_(setup, std::move(on_keyframe), on_problem_),
      errors_(errors) {
  DEJA_VIEW_CHECK(errors_ != nullptr && on_problem_);
}

FrontEndThread::~FrontEndThread() {
  Join(State::kStopped);
}

void FrontEndThread::Start() {
  DEJA_VIEW_CHECK(!thread_.joinable());
  state_ = State::kRunning;
  thread_ = std::thread([this] { Work(); });
}

void FrontEndThread::Drain() {
  Join(State::kDraining);
}

void FrontEndThread::Join(State state) {
  if (!thread_.joinable()) {
    return;
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    state_ = state;
  }
  changed_.notify_one();
  thread_.join();
}

void FrontEndThread::AddImage(std::int64_t stamp_ns, ImageSource image, std::size_t bytes) {
  Enqueue(WaitingImage{stamp_ns, std::move(image), bytes});
}

void FrontEndThread::AddPose(std::int64_t stamp_ns, const Rigid3& T_W_B) {
  Enqueue(StampedPose{stamp_ns, T_W_B});
}

void FrontEndThread::Enqueue(Task task) {
  std::int64_t dropped = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto* image = std::get_if<WaitingImage>(&task);
    queued_bytes_ += image != nullptr ? image->bytes : 0;
    queue_.push_back(std::move(task));
    dropped = -overflows_;
    DropOldImages();
    dropped += overflows_;
  }
  changed_.notify_one();
  if (dropped > 0) {
    on_problem_(fmt::format("the front end can't keep up: {} images were given up", dropped));
  }
}

void FrontEndThread::DropOldImages() {
  auto task = queue_.begin();
  while (task != queue_.end() && static_cast<double>(queued_bytes_) > 1e6 * image_memory_mb_) {
    if (const auto* image = std::get_if<WaitingImage>(&*task)) {
      queued_bytes_ -= image->bytes;
      ++overflows_;
      task = queue_.erase(task);
    } else {
      ++task;
    }
  }
}

FrontEndCounts FrontEndThread::counts() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  FrontEndCounts counts = counts_;
  counts.overflows += overflows_;
  return counts;
}

Rigid3 FrontEndThread::T_L_W() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return T_L_W_;
}

bool FrontEndThread::NextTask(Task* task) {
  std::unique_lock<std::mutex> lock(mutex_);
  counts_ = front_end_.counts();
  T_L_W_ = front_end_.T_L_W();
  changed_.wait(lock, [this] { return state_ != State::kRunning || !queue_.empty(); });
  if (state_ == State::kStopped || queue_.empty()) {
    return false;
  }
  *task = std::move(queue_.front());
  queue_.pop_front();
  const auto* image = std::get_if<WaitingImage>(task);
  queued_bytes_ -= image != nullptr ? image->bytes : 0;
  return true;
}

void FrontEndThread::Work() {
  Task task;
  while (NextTask(&task)) {
    errors_->Guard([&] { std::visit([this](auto& content) { Process(content); }, task); });
    if (errors_->has_failed()) {
      return;
    }
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (state_ == State::kDraining) {
    errors_->Guard([this] { front_end_.Flush(); });
    counts_ = front_end_.counts();
  }
}

void FrontEndThread::Process(WaitingImage& image) {
  front_end_.AddImage(image.stamp_ns, std::move(image.source), image.bytes);
}

void FrontEndThread::Process(const StampedPose& pose) {
  front_end_.AddPose(pose.stamp_ns, pose.pose);
}

}  // namespace deja_view
