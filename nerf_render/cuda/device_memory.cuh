#pragma once

#include <cstddef>
#include <vector>

namespace deja_view::nerf::internal {

/// System is the way to reach a device: CUDA, or the host as its stand-in, with static functions
///   void Select(int card)         for this thread
///   std::size_t UsedBytes()       of its memory
///   void* Allocate(std::size_t)   throws DeviceMemoryError
///   void Free(void*)
///   void Upload/Download(const void* from, std::size_t bytes, void* to)
///   void Clear(void*, std::size_t bytes)
///   void Finish()                 waits; throws DeviceError for what went wrong on the way
///   policy()                      Thrust's

/// An array on a device. Grows, never shrinks; what it held is lost when it grows.
template <typename System, typename T>
class DeviceArray {
 public:
  DeviceArray() = default;
  DeviceArray(const DeviceArray&) = delete;
  DeviceArray& operator=(const DeviceArray&) = delete;
  ~DeviceArray() { Free(); }

  T* data() { return data_; }
  const T* data() const { return data_; }
  std::size_t size() const { return size_; }

  /// Its values are then not known.
  void Resize(std::size_t size) {
    if (size > capacity_) {
      Free();
      data_ = static_cast<T*>(System::Allocate(size * sizeof(T)));
      capacity_ = size;
    }
    size_ = size;
  }
  void Release() { Free(); }
  void ResizeToZeros(std::size_t size) {
    Resize(size);
    Clear();
  }
  void Clear() {
    if (size_ > 0) {
      System::Clear(data_, size_ * sizeof(T));
    }
  }
  void Upload(const T* from, std::size_t size) {
    Resize(size);
    if (size > 0) {
      System::Upload(from, size * sizeof(T), data_);
    }
  }
  void Upload(const std::vector<T>& from) { Upload(from.data(), from.size()); }
  void Download(T* to) const {
    if (size_ > 0) {
      System::Download(data_, size_ * sizeof(T), to);
    }
  }
  std::vector<T> Download() const {
    std::vector<T> values(size_);
    Download(values.data());
    return values;
  }

 private:
  void Free() {
    if (data_ != nullptr) {
      System::Free(data_);
    }
    data_ = nullptr;
    capacity_ = 0;
    size_ = 0;
  }

  T* data_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

}  // namespace deja_view::nerf::internal
