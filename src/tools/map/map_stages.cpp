#include "map/map_stages.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"

#include <fstream>
#include <iostream>
#include <utility>

#include <fmt/format.h>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

Json Make(const std::string& name, const std::function<Json()>& make) {
  try {
    return make();
  } catch (const InputError& e) {
    ThrowInputError("{}: {}", name, e.what());
  }
}

}  // namespace

MapStages::MapStages(const std::filesystem::path& directory, std::uint64_t input, bool is_shown)
    : path_(directory / "stages.json"), is_shown_(is_shown), key_(input) {
  std::ifstream file(path_);
  if (file) {
    finished_ = Json::parse(file, nullptr, false);
  }
  if (!finished_.is_object()) {
    finished_ = Json::object();
  }
}

Json MapStages::Run(const std::string& name,
                    const std::string& settings,
                    const std::filesystem::path& product,
                    const std::function<Json()>& make) {
  key_ = Hash64(fmt::format("{:016x}\n{}\n{}", key_, name, settings));
  const std::string key = fmt::format("{:016x}", key_);
  const auto before = finished_.find(name);
  if (before != finished_.end() && before->value("made_from", "") == key &&
      before->contains("figures") && std::filesystem::exists(product)) {
    Tell(name, "as it was");
    return (*before)["figures"];
  }
  Tell(name, "begins");
  is_begun_ = before != finished_.end() && before->value("made_from", "") == key;
  Forget(name);
  finished_[name] = {{"made_from", key}};
  Write();
  Json figures = Make(name, make);
  finished_[name]["figures"] = figures;
  Write();
  return figures;
}

// The stage and those after it, which were made of what it gave.
void MapStages::Forget(const std::string& name) {
  Json before = Json::object();
  for (const auto& stage : finished_.items()) {
    if (stage.key() == name) {
      break;
    }
    before[stage.key()] = stage.value();
  }
  finished_ = std::move(before);
}

void MapStages::Tell(const std::string& name, const std::string& what) const {
  if (is_shown_) {
    std::cerr << fmt::format("{}: {}\n", name, what);
  }
}

void MapStages::Write() const {
  WriteFileAtomically(path_, [&](std::ostream& out) { out << finished_.dump(2) << "\n"; });
}

}  // namespace deja_view
