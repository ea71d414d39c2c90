#pragma once

#include "deja_view/host/image_source.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>

namespace deja_view {

/// Images that wait for their turn, in order of their stamps whatever the order in which they came.
class ImageQueue {
 public:
  bool empty() const { return images_.empty(); }
  std::size_t size() const { return images_.size(); }
  std::size_t bytes() const { return bytes_; }  ///< that the images hold in memory
  const WaitingImage& front() const { return images_.front(); }
  const WaitingImage& back() const { return images_.back(); }

  void Add(WaitingImage image) {
    const auto later = std::upper_bound(
        images_.begin(),
        images_.end(),
        image.stamp_ns,
        [](std::int64_t stamp_ns, const WaitingImage& w) { return stamp_ns < w.stamp_ns; });
    bytes_ += image.bytes;
    images_.insert(later, std::move(image));
  }

  WaitingImage Pop() {
    WaitingImage image = std::move(images_.front());
    images_.pop_front();
    bytes_ -= image.bytes;
    return image;
  }

  void DropBefore(std::int64_t stamp_ns) {
    while (!images_.empty() && images_.front().stamp_ns < stamp_ns) {
      Pop();
    }
  }

  /// This stamp's image, too.
  void DropFrom(std::int64_t stamp_ns) {
    while (!images_.empty() && images_.back().stamp_ns >= stamp_ns) {
      bytes_ -= images_.back().bytes;
      images_.pop_back();
    }
  }

 private:
  std::deque<WaitingImage> images_;
  std::size_t bytes_ = 0;
};

}  // namespace deja_view
