#include "deja_view/nerf/float_array.hpp"

#include <algorithm>
#include <new>

#include <sys/mman.h>

namespace deja_view::nerf {

FloatArray::FloatArray(std::size_t size) : size_(size) {
  constexpr std::size_t kHugePage = std::size_t{1} << 21U;
  const std::size_t bytes = std::max<std::size_t>(1, size) * sizeof(float);
  const std::size_t alignment = bytes >= kHugePage ? kHugePage : 64;
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  data_.reset(static_cast<float*>(std::aligned_alloc(alignment, rounded)));
  if (data_ == nullptr) {
    throw std::bad_alloc();
  }
#ifdef MADV_HUGEPAGE
  if (alignment == kHugePage) {
    ::madvise(data_.get(), rounded, MADV_HUGEPAGE);  // only a hint: it may fail
  }
#endif
  std::fill_n(data_.get(), rounded / sizeof(float), 0.0F);
}

}  // namespace deja_view::nerf
