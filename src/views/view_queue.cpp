#include "deja_view/views/view_queue.hpp"

#include <utility>

namespace deja_view {
namespace {

// As many as a high-rate odometry sends in some seconds.
constexpr std::size_t kMaxPoses = 4000;

}  // namespace

ViewQueue::ViewQueue(const ViewQueueOptions& options,
                     const SourceOptions& sources,
                     const Rigid3& T_B_C)
    : options_(options), selector_(sources), T_B_C_(T_B_C) {}

void ViewQueue::AddPose(std::int64_t stamp_ns, const Rigid3& T_N_B) {
  if (!T_N_B_.empty() && stamp_ns <= T_N_B_.stamps_ns.back()) {
    return;
  }
  if (T_N_B_.size() >= kMaxPoses) {
    const auto half = static_cast<std::ptrdiff_t>(kMaxPoses / 2);
    T_N_B_.stamps_ns.erase(T_N_B_.stamps_ns.begin(), T_N_B_.stamps_ns.begin() + half);
    T_N_B_.poses.erase(T_N_B_.poses.begin(), T_N_B_.poses.begin() + half);
  }
  T_N_B_.stamps_ns.push_back(stamp_ns);
  T_N_B_.poses.push_back(T_N_B);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++counts_.poses;
  }
  Match();
}

void ViewQueue::AddImage(std::int64_t stamp_ns, const std::string& frame_id, ImageSource image) {
  waiting_.push_back({stamp_ns, frame_id, std::move(image), {}});
  const bool is_full = waiting_.size() > options_.max_images;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++counts_.images;
    counts_.without_pose += is_full ? 1 : 0;
  }
  if (is_full) {
    waiting_.pop_front();
  }
  Match();
}

void ViewQueue::Match() {
  while (!waiting_.empty() && !T_N_B_.empty() &&
         waiting_.front().stamp_ns <= T_N_B_.stamps_ns.back()) {
    PosedSource source = std::move(waiting_.front());
    waiting_.pop_front();
    if (const std::optional<Rigid3> T_N_B = T_N_B_.At(source.stamp_ns, options_.max_gap_ns)) {
      source.T_N_C = *T_N_B * T_B_C_;
      if (selector_.Take(source.T_N_C)) {
        Push(std::move(source));
      }
    } else {
      const std::lock_guard<std::mutex> lock(mutex_);
      ++counts_.without_pose;
    }
  }
}

void ViewQueue::Push(PosedSource source) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++counts_.sources;
    sources_.push_back(std::move(source));
    if (sources_.size() > options_.max_sources) {
      sources_.pop_front();
      ++counts_.dropped;
    }
  }
  changed_.notify_one();
}

std::optional<PosedSource> ViewQueue::Pop() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return is_closed_ || !sources_.empty(); });
  if (sources_.empty()) {
    return std::nullopt;
  }
  PosedSource source = std::move(sources_.front());
  sources_.pop_front();
  return source;
}

void ViewQueue::Close() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_closed_ = true;
  }
  changed_.notify_all();
}

ViewQueueCounts ViewQueue::counts() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return counts_;
}

}  // namespace deja_view
