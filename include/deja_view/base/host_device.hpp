#pragma once

/// Marks what runs on the CPU and, where it is compiled for a graphics card, on the card as well.
#if defined(__CUDACC__)
#define DEJA_VIEW_HOST_DEVICE __host__ __device__
#else
#define DEJA_VIEW_HOST_DEVICE
#endif
