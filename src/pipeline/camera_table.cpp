#include "camera_table.hpp"

namespace deja_view {
namespace {

bool AreEqual(const CameraParameters& a, const CameraParameters& b) {
  return a.model == b.model && a.width == b.width && a.height == b.height &&
         a.distortion == b.distortion && a.projection == b.projection;
}

}  // namespace

std::shared_ptr<const Camera> CameraTable::Share(const std::shared_ptr<const Camera>& camera) {
  CameraParameters parameters = DescribeCamera(*camera);
  for (const Entry& entry : entries_) {
    if (AreEqual(entry.parameters, parameters)) {
      return entry.camera;
    }
  }
  entries_.push_back({std::move(parameters), camera});
  return camera;
}

}  // namespace deja_view
