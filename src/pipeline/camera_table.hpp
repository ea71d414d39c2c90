#pragma once

#include "deja_view/camera/camera_parameters.hpp"

#include <memory>
#include <vector>

namespace deja_view {

/// The cameras of virtual views, each kept once: every message brings its own.
class CameraTable {
 public:
  /// The table's camera with the same parameters as `camera`; adds it when there is none.
  std::shared_ptr<const Camera> Share(const std::shared_ptr<const Camera>& camera);

 private:
  struct Entry {
    CameraParameters parameters;
    std::shared_ptr<const Camera> camera;
  };
  std::vector<Entry> entries_;
};

}  // namespace deja_view
