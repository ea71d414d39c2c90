#pragma once

#include "deja_view/io/colmap_model.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace deja_view::internal {

/// Tells what is wrong with the record that is being read; throws InputError with the place.
using ColmapFail = std::function<void(const std::string& what)>;

/// A camera model by its name in text files and its number in binary ones.
struct ColmapCameraModel {
  const char* name;
  int id;
  std::size_t parameters;
};

/// Null for a model that COLMAP does not have.
const ColmapCameraModel* FindColmapCameraModel(const std::string& name);
const ColmapCameraModel* FindColmapCameraModel(int id);

std::shared_ptr<const Camera> MakeColmapCamera(const ColmapCameraModel& model,
                                               std::uint64_t width,
                                               std::uint64_t height,
                                               const std::vector<double>& parameters,
                                               const ColmapFail& fail);

/// From the quaternion (w, x, y, z) and translation of T_C_W.
Rigid3 MakeColmapPose(const std::vector<double>& q_wxyz_t, const ColmapFail& fail);

/// All observations are read; those of no point have the id kNoColmapPoint.
constexpr std::uint64_t kNoColmapPoint = ~std::uint64_t{0};

void ReadColmapText(ColmapModel* model);
void ReadColmapBinary(ColmapModel* model);

}  // namespace deja_view::internal
