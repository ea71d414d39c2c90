#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace deja_view {

/// Image files of a directory, without its subdirectories, sorted by name. Depth maps
/// ("*.depth.*") are none. Throws InputError that names the directory when it can't be read or
/// holds no image.
std::vector<std::filesystem::path> ListImages(const std::filesystem::path& directory);

/// An image file that is named by its stamp.
struct StampedImage {
  std::int64_t stamp_ns = 0;
  std::filesystem::path path;
};

/// The images of `directory`, or of its mav0/cam0/data (FindAslImages), in order of their stamps.
/// Throws InputError as ListImages does, for a name that is no stamp (ParseImageStamp), and for two
/// names of the same stamp.
std::vector<StampedImage> ListStampedImages(const std::filesystem::path& directory);

}  // namespace deja_view
