#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace deja_view {

/// What `deja_view check` is told.
struct CheckRequest {
  std::filesystem::path bag;
  std::filesystem::path camera;  ///< of ReadVinsConfig; empty: none
};

/// Reads the bag once and judges it. Keys of the result: `topics` (name, type, messages, rate_hz,
/// longest_gap_s, stamps_back), `hosts` (name, how to start with it, problems), `problems`.
/// Throws InputError for a bag or a camera that can't be read.
nlohmann::ordered_json CheckBag(const CheckRequest& request);

}  // namespace deja_view
