#include "deja_view/io/options_yaml.hpp"
#include "deja_view/nerf/checkpoint.hpp"
#include "deja_view/nerf/device.hpp"

#include <cmath>

#include "nerf/nerf_command.hpp"
#include <fmt/format.h>

namespace deja_view {

using Json = nlohmann::ordered_json;

namespace {

// Null where there is no bound.
Json ToJson(const Eigen::Vector3d& corner) {
  Json json;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    json.push_back(std::isfinite(corner[axis]) ? Json(corner[axis]) : Json(nullptr));
  }
  return json;
}

// What --device can name, or why there is no card.
Json Devices() {
  const nerf::DeviceReport report = nerf::CudaPlatform().Find();
  Json json;
  json["cards"] = Json::array();
  for (const nerf::DeviceCard& card : report.cards) {
    json["cards"].push_back(fmt::format("cuda:{} {}, compute capability {}.{}, {} MB",
                                        card.number,
                                        card.name,
                                        card.compute_major,
                                        card.compute_minor,
                                        card.memory_bytes >> 20U));
  }
  json["problem"] = report.problem;
  json["driver"] = report.driver;
  json["runtime"] = report.runtime;
  return json;
}

Json Model(const std::filesystem::path& path) {
  const nerf::RadianceField field = nerf::ReadField(path);
  nerf::FieldOptions options = field.options;
  internal::OptionsWriter writer;
  options.Visit(writer);
  Json json;
  json["path"] = path.string();
  json["bytes"] = std::filesystem::file_size(path);
  json["channels"] = field.channels;
  json["images"] = field.exposures.size();
  json["trained_share"] = field.progress;
  json["box_min"] = ToJson(field.box.min);
  json["box_max"] = ToJson(field.box.max);
  if (field.cells.IsCut()) {
    json["shard"] = fmt::format("{}/{}", field.cells.index, field.cells.cells.size());
    json["cell_min"] = ToJson(field.cells.own().min);
    json["cell_max"] = ToJson(field.cells.own().max);
  }
  const Similarity3& W_N = field.frame.W_N;
  json["scale_m"] = field.frame.is_known ? Json(W_N.scale) : Json(nullptr);
  json["parameters"] = field.geometry.parameters().size() + field.appearance.parameters().size() +
                       field.density.parameters().size() + field.color.parameters().size();
  json["occupied_share"] = static_cast<double>(field.occupancy.CountOccupied()) /
                           static_cast<double>(field.occupancy.cell_count());
  json["options"] = writer.text();
  return json;
}

}  // namespace

Json RunNerfInfo(const std::filesystem::path& path) {
  Json json;
  json["devices"] = Devices();
  if (!path.empty()) {
    json.update(Model(path));
  }
  return json;
}

}  // namespace deja_view
