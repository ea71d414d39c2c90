#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "common/commands.hpp"
#include <nlohmann/json.hpp>

namespace deja_view {

/// --quiet and --poses-of, as many commands have them. They keep a reference to what they set.
void AddQuietOption(CLI::App* sub, bool* show_progress);
void AddPosesOfOption(CLI::App* sub, std::string* poses_of, const std::string& description);

/// Whole or not at all; nothing without a file.
void WriteJson(const std::filesystem::path& file, const nlohmann::ordered_json& json);

/// A line per key.
void PrintJson(const nlohmann::ordered_json& json);

using PrintFigures = std::function<void(const nlohmann::ordered_json&)>;

/// Writes what `run` finds to `json_file`, if it has a name, and prints it. Returns the exit code:
/// 130, as shells report a program that Ctrl-C ended, when Interrupted is thrown, or the figures
/// have "interrupted"; kDeviceLostCode when nerf::DeviceLostError is; `left` says what there is
/// then.
int Report(const std::function<nlohmann::ordered_json()>& run,
           const std::string& json_file,
           const PrintFigures& print = PrintJson,
           const char* left = "");

/// Makes `sub` the command that reports what `run` finds for the request; gives it --json.
template <typename Request>
void ReportOf(CLI::App* sub,
              Command* command,
              nlohmann::ordered_json (*run)(const Request&),
              const std::shared_ptr<Request>& request,
              const PrintFigures& print = PrintJson,
              const char* left = "") {
  const auto json_file = std::make_shared<std::string>();
  sub->add_option("--json", *json_file, "File for the figures");
  sub->callback([=] {
    *command = [=] { return Report([&] { return run(*request); }, *json_file, print, left); };
  });
}

}  // namespace deja_view
