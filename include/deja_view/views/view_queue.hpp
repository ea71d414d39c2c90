#pragma once

#include "deja_view/geometry/trajectory.hpp"
#include "deja_view/host/image_source.hpp"
#include "deja_view/views/view_maker.hpp"

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

namespace deja_view {

/// An image whose pose is known.
struct PosedSource {
  std::int64_t stamp_ns = 0;
  std::string frame_id;
  ImageSource image;
  Rigid3 T_N_C;
};

/// Bounds of ViewQueue.
struct ViewQueueOptions {
  std::size_t max_images = 100;           ///< that wait for their pose
  std::size_t max_sources = 20;           ///< that wait to be rendered; then the oldest is dropped
  std::int64_t max_gap_ns = 100'000'000;  ///< between the poses that an image's lies between
};

/// What became of the images so far.
struct ViewQueueCounts {
  std::int64_t images = 0;
  std::int64_t poses = 0;
  std::int64_t sources = 0;       ///< images that were chosen
  std::int64_t without_pose = 0;  ///< images
  std::int64_t dropped = 0;       ///< sources, since the queue was full
};

/// Gives images their poses as both come in, in any order, and hands those that are to get views to
/// a worker. Not thread-safe but for Pop.
class ViewQueue {
 public:
  ViewQueue(const ViewQueueOptions& options, const SourceOptions& sources, const Rigid3& T_B_C);

  /// Stamps increase; others are passed over.
  void AddPose(std::int64_t stamp_ns, const Rigid3& T_N_B);
  void AddImage(std::int64_t stamp_ns, const std::string& frame_id, ImageSource image);

  /// Waits for a source; nothing after Close, once all are handed out.
  std::optional<PosedSource> Pop();
  void Close();

  ViewQueueCounts counts() const;

 private:
  void Match();
  void Push(PosedSource source);

  ViewQueueOptions options_;
  SourceSelector selector_;
  Rigid3 T_B_C_;
  Trajectory T_N_B_;
  std::deque<PosedSource> waiting_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<PosedSource> sources_;
  ViewQueueCounts counts_;
  bool is_closed_ = false;
};

}  // namespace deja_view
