// Radiance fields; after a first byte of 1 with the hash of what they hold.
#include "deja_view/nerf/checkpoint.hpp"
#include "deja_view/nerf/scene_cells.hpp"

#include "fuzz.hpp"

namespace deja_view::fuzz {
namespace {

nerf::RadianceField SmallField() {
  nerf::FieldOptions options;
  options.geometry = {2, 2, 9, 4, 8};
  options.appearance = {2, 2, 9, 4, 8};
  options.color_hidden = 8;
  options.occupancy_resolution = 8;
  nerf::SceneBox box;
  box.min = {0, 0, 0};
  box.max = {1, 1, 1};
  return {options, nerf::MarchOptions(), box, 1, 1};
}

}  // namespace

std::vector<std::string> Seeds() {
  nerf::RadianceField field = SmallField();
  std::vector<std::string> seeds;
  for (const bool is_cut : {false, true}) {
    if (is_cut) {
      field.exposures = {{"one", 17, 1.5F, 0.1F, {}}, {"two", 18, 0.5F, -0.1F, {}}};
      field.cells = {1, nerf::CutByCameras({{0, 0, 0}, {2, 0, 0}, {2, 5, 0}}, 3)};
    }
    nerf::WriteField(Scratch() / "seed", field);
    seeds.push_back('\1' + ReadAll(Scratch() / "seed"));
  }
  return seeds;
}

void RunOne(const std::string& input) {
  auto [prefix, file] = SplitPrefix(input);
  if (prefix == 1) {
    Seal(&file);
  }
  nerf::ReadField(Write("field.dvn", file));
}

}  // namespace deja_view::fuzz
