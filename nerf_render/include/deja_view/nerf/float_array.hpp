#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>

namespace deja_view::nerf {

/// A fixed number of floats, zero at first, on a cache line's boundary; large ones on huge pages
/// where the system has them, since grids are read at random.
class FloatArray {
 public:
  FloatArray() = default;
  explicit FloatArray(std::size_t size);

  std::size_t size() const { return size_; }
  float* data() { return data_.get(); }
  const float* data() const { return data_.get(); }
  float& operator[](std::size_t i) { return data_.get()[i]; }
  float operator[](std::size_t i) const { return data_.get()[i]; }

 private:
  struct Free {
    void operator()(float* memory) const { std::free(memory); }  // NOLINT: from aligned_alloc
  };
  std::size_t size_ = 0;
  std::unique_ptr<float, Free> data_;
};

}  // namespace deja_view::nerf
