#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace deja_view {

/// What `deja_view simulate` is told.
struct SimulateRequest {
  std::string preset = "hall";
  std::filesystem::path config;        ///< SimOptions; empty: the preset alone
  std::vector<std::string> overrides;  ///< "group.key=value" on top
  std::filesystem::path out;
  bool bag = false;     ///< write flight.bag
  std::string images;   ///< "png", "jpg" or "none"; empty: png when there is no bag
  bool ranges = false;  ///< write exact ranges
  bool show_progress = true;
};

/// Simulates a flight and writes its files; returns the documented JSON keys. Throws InputError for
/// bad options or files that can't be written, Interrupted after Ctrl-C.
nlohmann::ordered_json RunSimulate(const SimulateRequest& request);

}  // namespace deja_view
