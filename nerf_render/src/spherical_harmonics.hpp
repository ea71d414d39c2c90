#pragma once

#include "deja_view/base/host_device.hpp"

namespace deja_view::nerf::internal {

/// See EncodeDirection.
DEJA_VIEW_HOST_DEVICE inline void WriteHarmonics(int degree, const float* direction, float* out) {
  const float x = direction[0];
  const float y = direction[1];
  const float z = direction[2];
  if (degree >= 1) {
    *out++ = x;
    *out++ = y;
    *out++ = z;
  }
  if (degree >= 2) {
    *out++ = x * y;
    *out++ = y * z;
    *out++ = x * z;
    *out++ = x * x - y * y;
    *out++ = 1.5F * z * z - 0.5F;
  }
  if (degree >= 3) {
    *out++ = y * (3 * x * x - y * y);
    *out++ = x * y * z;
    *out++ = y * (5 * z * z - 1);
    *out++ = 0.5F * z * (5 * z * z - 3);
    *out++ = x * (5 * z * z - 1);
    *out++ = z * (x * x - y * y);
    *out++ = x * (x * x - 3 * y * y);
  }
  if (degree >= 4) {
    *out++ = x * y * (x * x - y * y);
    *out++ = y * z * (3 * x * x - y * y);
    *out++ = x * y * (7 * z * z - 1);
    *out++ = y * z * (7 * z * z - 3);
    *out++ = 0.125F * (35 * z * z * z * z - 30 * z * z + 3);
    *out++ = x * z * (7 * z * z - 3);
    *out++ = (x * x - y * y) * (7 * z * z - 1);
    *out++ = x * z * (x * x - 3 * y * y);
    *out++ = x * x * (x * x - 3 * y * y) - y * y * (3 * x * x - y * y);
  }
}

}  // namespace deja_view::nerf::internal
