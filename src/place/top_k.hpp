#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace deja_view::internal {

/// The best k of the values offered; `IsBetter` orders all of them strictly.
template <typename T, typename IsBetter>
class TopK {
 public:
  explicit TopK(std::size_t k) : k_(k) {}

  bool is_full() const { return heap_.size() == k_; }
  /// Of those kept, of which there is one.
  const T& worst() const { return heap_.front(); }

  void Offer(const T& value) {
    if (k_ == 0) {
      return;
    }
    if (is_full()) {
      if (!IsBetter()(value, worst())) {
        return;
      }
      std::pop_heap(heap_.begin(), heap_.end(), IsBetter());
      heap_.pop_back();
    }
    heap_.push_back(value);
    std::push_heap(heap_.begin(), heap_.end(), IsBetter());
  }

  /// True when one that is kept `is_same`: from now on the better of it and `value`.
  template <typename F>
  bool Improve(const T& value, F is_same) {
    const auto same = std::find_if(heap_.begin(), heap_.end(), is_same);
    if (same == heap_.end()) {
      return false;
    }
    if (IsBetter()(value, *same)) {
      *same = value;
      std::make_heap(heap_.begin(), heap_.end(), IsBetter());
    }
    return true;
  }

  /// Best first.
  std::vector<T> Take() {
    std::sort_heap(heap_.begin(), heap_.end(), IsBetter());
    return std::move(heap_);
  }

 private:
  std::size_t k_;
  std::vector<T> heap_;  // the worst in front
};

}  // namespace deja_view::internal
