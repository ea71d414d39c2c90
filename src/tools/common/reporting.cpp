#include "common/reporting.hpp"

#include "deja_view/base/atomic_file.hpp"

#include <iostream>

#include "common/device_option.hpp"
#include "common/interrupt.hpp"
#include <fmt/format.h>

namespace deja_view {

void AddQuietOption(CLI::App* sub, bool* show_progress) {
  sub->add_flag_callback(
      "--quiet", [show_progress] { *show_progress = false; }, "No progress");
}

void AddPosesOfOption(CLI::App* sub, std::string* poses_of, const std::string& description) {
  sub->add_option("--poses-of", *poses_of, description)
      ->check(CLI::IsMember({"body", "camera"}))
      ->capture_default_str();
}

void WriteJson(const std::filesystem::path& file, const nlohmann::ordered_json& json) {
  if (!file.empty()) {
    WriteFileAtomically(file, [&](std::ostream& out) { out << json.dump(2) << "\n"; });
  }
}

void PrintJson(const nlohmann::ordered_json& json) {
  for (const auto& [key, value] : json.items()) {
    std::cout << fmt::format(
        "{:<18} {}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
  }
}

int Report(const std::function<nlohmann::ordered_json()>& run,
           const std::string& json_file,
           const PrintFigures& print,
           const char* left) {
  constexpr int kInterrupted = 130;
  nlohmann::ordered_json json;
  try {
    json = run();
  } catch (const Interrupted& e) {
    std::cerr << "deja_view: " << e.what() << left << "\n";
    return kInterrupted;
  } catch (const nerf::DeviceLostError& e) {
    std::cerr << "deja_view: " << e.what() << left << "\n";
    return kDeviceLostCode;
  }
  WriteJson(json_file, json);
  print(json);
  return json.value("interrupted", false) ? kInterrupted : 0;
}

}  // namespace deja_view
