#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace deja_view {

/// What the stages' figures (RunMap) say is bad, and what to do about it; empty when all is well.
std::vector<std::string> MapAdvice(const nlohmann::ordered_json& map);

/// One page without other files: what was made of the flight, how well the field knows the place,
/// rendered pictures (`directory`/pictures) beside photographs, and the advice. Written to
/// `directory`/map.html.
void WriteMapPage(const std::filesystem::path& directory, const nlohmann::ordered_json& map);

}  // namespace deja_view
