#include "deja_view/io/options_yaml.hpp"
#include "deja_view/nerf/checkpoint.hpp"

#include "nerf_command.hpp"

namespace deja_view {

using Json = nlohmann::ordered_json;

Json RunNerfInfo(const std::filesystem::path& path) {
  const nerf::RadianceField field = nerf::ReadField(path);
  nerf::FieldOptions options = field.options;
  internal::OptionsWriter writer;
  options.Visit(writer);
  Json json;
  json["path"] = path.string();
  json["bytes"] = std::filesystem::file_size(path);
  json["channels"] = field.channels;
  json["images"] = field.exposures.size();
  json["box_min"] = {field.box.min.x(), field.box.min.y(), field.box.min.z()};
  json["box_max"] = {field.box.max.x(), field.box.max.y(), field.box.max.z()};
  json["parameters"] = field.geometry.parameters().size() + field.appearance.parameters().size() +
                       field.density.parameters().size() + field.color.parameters().size();
  json["occupied_share"] = static_cast<double>(field.occupancy.CountOccupied()) /
                           static_cast<double>(field.occupancy.cell_count());
  json["options"] = writer.text();
  return json;
}

}  // namespace deja_view
