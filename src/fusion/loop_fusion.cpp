#include "deja_view/fusion/loop_fusion.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>

namespace deja_view {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

LoopFusion::LoopFusion(const LoopFusionOptions& options,
                       LoopCloser closer,
                       LoopFusionCallbacks callbacks)
    : options_(options.node),
      callbacks_(std::move(callbacks)),
      assembler_(
          options.assembler,
          [this](AssembledKeyframe keyframe) {
            if (keyframe.is_restart) {
              Tell(RestartText(keyframe.stamp_ns));
            }
            const std::size_t bytes = keyframe.image_bytes;
            Enqueue({std::move(keyframe), bytes});
          },
          [this](DropReason reason, std::int64_t stamp_ns) {
            Tell(fmt::format("message of stamp {} ns: {}", stamp_ns, EnumToString(reason)));
          }),
      closer_(std::move(closer)),
      T_M_W_(closer_.drift()) {
  if (const auto violations = options_.Validate(); !violations.empty()) {
    ThrowInputError("{}", fmt::join(violations, "; "));
  }
}

LoopFusion::LoopFusion(const LoopFusionOptions& options,
                       LoopCloser closer,
                       LoopFusionCallbacks callbacks,
                       std::shared_ptr<const Camera> camera,
                       const Rigid3& T_B_C,
                       GravityPolicy gravity)
    : LoopFusion(options, std::move(closer), std::move(callbacks)) {
  front_end_ = std::make_unique<FrontEndThread>(
      FrontEndSetup{options.front_end, std::move(camera), T_B_C, gravity},
      &errors_,
      [this](OdometryFrontEnd::Keyframe keyframe) {
        const std::lock_guard<std::mutex> lock(assembler_mutex_);
        assembler_.AddPose(keyframe.stamp_ns, keyframe.T_W_B);
        assembler_.AddPoints(keyframe.stamp_ns, std::move(keyframe.points));
      },
      [this](const std::string& what) { Tell(what); });
}

LoopFusion::~LoopFusion() {
  front_end_.reset();
  Stop(std::chrono::seconds(0));
}

void LoopFusion::Start() {
  DEJA_VIEW_CHECK(!worker_.joinable());
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    is_stopping_ = false;
  }
  worker_ = std::thread([this] { Work(); });
  if (front_end_) {
    front_end_->Start();
  }
}

int LoopFusion::Stop(std::chrono::duration<double> drain) {
  if (!worker_.joinable()) {
    return 0;
  }
  if (front_end_) {
    front_end_->Drain();
  }
  {
    const std::lock_guard<std::mutex> lock(assembler_mutex_);
    assembler_.Flush();
  }
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    is_stopping_ = true;
    deadline_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(drain);
  }
  queue_changed_.notify_all();
  worker_.join();
  const std::lock_guard<std::mutex> lock(queue_mutex_);
  const auto left = std::count_if(queue_.begin(), queue_.end(), [](const Task& task) {
    return std::holds_alternative<AssembledKeyframe>(task.content);
  });
  queue_.clear();
  return static_cast<int>(left);
}

void LoopFusion::AddImage(std::int64_t stamp_ns, ImageSource image, std::size_t bytes) {
  {
    const std::lock_guard<std::mutex> lock(assembler_mutex_);
    assembler_.AddImage(stamp_ns, image, bytes);
  }
  if (front_end_) {
    front_end_->AddImage(stamp_ns, std::move(image), bytes);
  }
}

void LoopFusion::AddOdometry(std::int64_t stamp_ns, const Rigid3& T_W_B) {
  if (front_end_) {
    front_end_->AddPose(stamp_ns, T_W_B);
  }
}

void LoopFusion::AddPose(std::int64_t stamp_ns, const Rigid3& T_W_B) {
  const std::lock_guard<std::mutex> lock(assembler_mutex_);
  assembler_.AddPose(stamp_ns, T_W_B);
}

void LoopFusion::AddPoints(std::int64_t stamp_ns, std::vector<TrackedPoint> points) {
  const std::lock_guard<std::mutex> lock(assembler_mutex_);
  assembler_.AddPoints(stamp_ns, std::move(points));
}

void LoopFusion::AddExtrinsic(std::int64_t stamp_ns, const Rigid3& T_B_C) {
  const std::lock_guard<std::mutex> lock(assembler_mutex_);
  assembler_.AddExtrinsic(stamp_ns, T_B_C);
}

void LoopFusion::AddVirtualView(VirtualViewSource view, std::size_t bytes) {
  Enqueue({std::move(view), bytes});
}

void LoopFusion::AddRelativePose(const RelativePoseUpdate& update) {
  Enqueue({update, 0});
}

Rigid3 LoopFusion::drift() const {
  const Rigid3 T_L_W = front_end_ ? front_end_->T_L_W() : Rigid3::Identity();
  const std::lock_guard<std::mutex> lock(statistics_mutex_);
  return T_M_W_ * T_L_W;
}

LoopFusionStatistics LoopFusion::statistics() const {
  LoopFusionStatistics statistics;
  {
    const std::lock_guard<std::mutex> lock(statistics_mutex_);
    statistics = statistics_;
  }
  statistics.refused = errors_.bad_inputs();
  {
    const std::lock_guard<std::mutex> lock(assembler_mutex_);
    statistics.assembler = assembler_.counts();
  }
  if (front_end_) {
    statistics.front_end = front_end_->counts();
  }
  const std::lock_guard<std::mutex> lock(queue_mutex_);
  statistics.queue_length = static_cast<int>(queue_.size());
  return statistics;
}

std::future<void> LoopFusion::RunBeside(std::function<void()> solve) {
  return std::async(std::launch::async, std::move(solve));
}

void LoopFusion::Enqueue(Task task) {
  int dropped = 0;
  std::size_t length = 0;
  const bool is_view = task.is_view();
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    dropped = MakeRoom(task);
    queue_.push_back(std::move(task));
    length = queue_.size();
  }
  queue_changed_.notify_one();
  {
    const std::lock_guard<std::mutex> lock(statistics_mutex_);
    (is_view ? statistics_.view_overflows : statistics_.queue_overflows) += dropped;
    statistics_.queue_peak = std::max(statistics_.queue_peak, static_cast<int>(length));
  }
  if (dropped > 0) {
    Tell(fmt::format("the queue of {} {} or {} MB is full: {} of the oldest dropped",
                     is_view ? options_.virtual_queue_size : options_.queue_size,
                     is_view ? "virtual views" : "keyframes",
                     options_.queue_memory_mb,
                     dropped));
  }
}

// Views never push keyframes out, nor the other way round.
int LoopFusion::MakeRoom(const Task& task) {
  const auto is_alike = [&task](const Task& other) { return other.is_view() == task.is_view(); };
  const int limit = task.is_view() ? options_.virtual_queue_size : options_.queue_size;
  const double byte_limit = 1e6 * options_.queue_memory_mb;
  int count = 1;
  std::size_t bytes = task.bytes;
  for (const Task& other : queue_) {
    count += is_alike(other) ? 1 : 0;
    bytes += is_alike(other) ? other.bytes : 0;
  }
  int dropped = 0;
  for (; count > 1 && (count > limit || static_cast<double>(bytes) > byte_limit); --count) {
    const auto oldest = std::find_if(queue_.begin(), queue_.end(), is_alike);
    bytes -= oldest->bytes;
    queue_.erase(oldest);
    ++dropped;
  }
  return dropped;
}

std::optional<LoopFusion::Task> LoopFusion::NextTask() {
  std::unique_lock<std::mutex> lock(queue_mutex_);
  queue_changed_.wait(lock, [this] { return is_stopping_ || !queue_.empty(); });
  if (queue_.empty() || (is_stopping_ && Clock::now() >= deadline_)) {
    return std::nullopt;
  }
  Task task = std::move(queue_.front());
  queue_.pop_front();
  return task;
}

void LoopFusion::Work() {
  while (const std::optional<Task> task = NextTask()) {
    errors_.Guard(
        [&] { std::visit([this](const auto& content) { Process(content); }, task->content); });
    if (errors_.has_failed()) {
      return;
    }
  }
}

void LoopFusion::Process(const AssembledKeyframe& keyframe) {
  const KeyframeInput input = keyframe.ToInput();
  const std::lock_guard<std::mutex> lock(closer_mutex_);
  const auto& T_B_C = keyframe.T_B_C;
  if (T_B_C && (!T_B_C_ || T_B_C_->t != T_B_C->t || T_B_C_->q.coeffs() != T_B_C->q.coeffs())) {
    closer_.SetExtrinsic(*T_B_C);
    T_B_C_ = T_B_C;
  }
  const KeyframeReport report = closer_.AddKeyframe(input);
  SetDrift(closer_.drift());
  CountKeyframe(report);
  if (callbacks_.on_keyframe) {
    callbacks_.on_keyframe(input, report, closer_);
  }
}

void LoopFusion::Process(const RelativePoseUpdate& update) {
  const std::lock_guard<std::mutex> closer_lock(closer_mutex_);
  const bool is_used = closer_.UpdateLoop(update.current, update.T_Bold_Bcurrent);
  SetDrift(closer_.drift());
  const std::lock_guard<std::mutex> lock(statistics_mutex_);
  ++(is_used ? statistics_.relative_poses : statistics_.relative_poses_ignored);
}

void LoopFusion::Process(const VirtualViewSource& source) {
  const VirtualView view = source();
  const std::lock_guard<std::mutex> closer_lock(closer_mutex_);
  closer_.AddVirtualView(view);
  CountViews();
}

void LoopFusion::CountViews() {
  const ViewCounts views = closer_.view_counts();
  const std::size_t bytes = views.kept > 0 ? closer_.view_memory_bytes() : 0;
  const std::lock_guard<std::mutex> lock(statistics_mutex_);
  statistics_.views = views;
  statistics_.view_memory_bytes = bytes;
}

void LoopFusion::CountKeyframe(const KeyframeReport& report) {
  CountViews();
  if (report.separates) {
    const auto withdrawn =
        std::count_if(report.loops.begin(), report.loops.end(), [](const LoopReport& loop) {
          return loop.reason == RejectReason::kWithdrawn;
        });
    Tell(
        fmt::format("keyframe {}: the flight was joined wrongly to another world, as later loops "
                    "show: {} loops are withdrawn",
                    report.index,
                    withdrawn));
  }
  const std::lock_guard<std::mutex> lock(statistics_mutex_);
  ++statistics_.keyframes;
  statistics_.joins_taken_back += report.separates ? 1 : 0;
  for (const LoopReport& loop : report.loops) {
    ++statistics_.candidates[EnumToString(loop.reason)];
  }
  const double ms = report.times.total();
  statistics_.max_ms = std::max(statistics_.max_ms, ms);
  statistics_.mean_ms += (ms - statistics_.mean_ms) / static_cast<double>(statistics_.keyframes);
}

void LoopFusion::SetDrift(const Rigid3& T_M_W) {
  const std::lock_guard<std::mutex> lock(statistics_mutex_);
  T_M_W_ = T_M_W;
}

void LoopFusion::Tell(const std::string& what) const {
  if (callbacks_.on_problem) {
    callbacks_.on_problem(what);
  }
}

}  // namespace deja_view
