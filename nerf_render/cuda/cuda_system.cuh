#pragma once

#include "deja_view/nerf/device.hpp"

#include <cstddef>
#include <string>

#include <cuda_runtime.h>
#include <thrust/execution_policy.h>
#include <thrust/version.h>

namespace deja_view::nerf::internal {

/// Throws the DeviceError that a result of CUDA stands for, unless it is success.
inline void CheckCuda(cudaError_t result, const char* what) {
  if (result == cudaSuccess) {
    return;
  }
  const std::string text = std::string(what) + ": " + cudaGetErrorString(result);
  if (result == cudaErrorMemoryAllocation) {
    cudaGetLastError();  // or the next call would report it again
    throw DeviceMemoryError(text);
  }
  throw DeviceLostError(text);
}

/// A graphics card by CUDA; see device_memory.cuh.
struct CudaSystem {
  static void Select(int card) { CheckCuda(cudaSetDevice(card), "choosing the card"); }
  static std::size_t UsedBytes() {
    std::size_t free = 0;
    std::size_t total = 0;
    CheckCuda(cudaMemGetInfo(&free, &total), "asking for the card's memory");
    return total - free;
  }
  static void* Allocate(std::size_t bytes) {
    void* memory = nullptr;
    CheckCuda(cudaMalloc(&memory, bytes), "reserving memory of the card");
    return memory;
  }
  static void Free(void* memory) { cudaFree(memory); }
  static void Upload(const void* from, std::size_t bytes, void* to) {
    CheckCuda(cudaMemcpy(to, from, bytes, cudaMemcpyHostToDevice), "copying to the card");
  }
  static void Download(const void* from, std::size_t bytes, void* to) {
    CheckCuda(cudaMemcpy(to, from, bytes, cudaMemcpyDeviceToHost), "copying from the card");
  }
  static void Clear(void* memory, std::size_t bytes) {
    CheckCuda(cudaMemset(memory, 0, bytes), "clearing memory of the card");
  }
  static void Finish() {
    CheckCuda(cudaGetLastError(), "starting work on the card");
    CheckCuda(cudaDeviceSynchronize(), "working on the card");
  }
#if THRUST_VERSION >= 101600
  static auto policy() {
    return thrust::cuda::par_nosync;
  }
#else
  static auto policy() {
    return thrust::cuda::par;
  }
#endif
};

}  // namespace deja_view::nerf::internal
