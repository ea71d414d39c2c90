#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include <nlohmann/json.hpp>

namespace deja_view {

/// Finished stages of a map in the making with what they were made from, in `stages.json`.
class MapStages {
 public:
  /// `input`: a hash of all that the first stage is made from.
  MapStages(const std::filesystem::path& directory, std::uint64_t input, bool is_shown);

  /// Runs `make`, or takes what it gave before if the settings and all stages before are the same
  /// and `product` is there. Throws what `make` throws, InputError with the stage's name.
  nlohmann::ordered_json Run(const std::string& name,
                             const std::string& settings,
                             const std::filesystem::path& product,
                             const std::function<nlohmann::ordered_json()>& make);

  /// Whether the running stage was begun before, with the same settings.
  bool is_begun() const { return is_begun_; }

 private:
  void Forget(const std::string& name);
  void Tell(const std::string& name, const std::string& what) const;
  void Write() const;

  std::filesystem::path path_;
  bool is_shown_;
  std::uint64_t key_;
  nlohmann::ordered_json finished_ = nlohmann::ordered_json::object();
  bool is_begun_ = false;
};

}  // namespace deja_view
