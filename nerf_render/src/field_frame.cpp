#include "deja_view/nerf/field_frame.hpp"

#include "deja_view/base/check.hpp"

namespace deja_view::nerf {

const Similarity3& RequireFrame(const FieldFrame& frame, const std::filesystem::path& model) {
  if (!frame.is_known) {
    ThrowInputError(
        "{}: was trained on poses without a scale, so that other poses don't tell where they are "
        "in it: expected a field that `deja_view nerf align` has given its place among poses in "
        "metres",
        model.string());
  }
  return frame.W_N;
}

}  // namespace deja_view::nerf
