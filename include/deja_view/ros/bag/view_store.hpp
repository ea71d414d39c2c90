#pragma once

#include "deja_view/VirtualFrame.h"
#include "deja_view/views/exposure_fit.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace deja_view {

/// What was made of one source image.
struct SourceResult {
  std::int64_t stamp_ns = 0;
  std::int64_t recorded_ns = 0;  ///< of the source image
  std::vector<VirtualFrame> frames;
  bool is_recognised = true;
  std::int32_t not_free = 0;
  std::int32_t uncertain = 0;
  ExposureFit fit;
  double elapsed_s = 0;  ///< that it took
};

/// Finished results on disk, one file each, so that work goes on after a kill where it stopped.
class ViewStore {
 public:
  /// The directory is made with the first result. `settings_hash` tells results of other settings
  /// apart.
  ViewStore(std::filesystem::path directory, std::uint64_t settings_hash);

  /// Written whole or not at all.
  void Write(const SourceResult& result) const;

  /// Nothing when there is no result of these settings for that stamp, or its file is damaged: it
  /// is then to be made again.
  std::optional<SourceResult> Read(std::int64_t stamp_ns) const;

  /// Removes the results that are there, and the directory when it is empty then.
  void Remove() const;

 private:
  std::filesystem::path PathOf(std::int64_t stamp_ns) const;

  std::filesystem::path directory_;
  std::uint64_t settings_hash_;
};

}  // namespace deja_view
