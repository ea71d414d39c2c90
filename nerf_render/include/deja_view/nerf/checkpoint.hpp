#pragma once

#include "deja_view/nerf/radiance_field.hpp"

#include <filesystem>

namespace deja_view::nerf {

/// Writes a field as a binary file (BinaryFormat), whole or not at all.
void WriteField(const std::filesystem::path& path, const RadianceField& field);

/// Reads what WriteField wrote. Throws InputError that names the path for a file that is missing,
/// of another kind or version, cut off, longer than it says, damaged, or with sizes that make no
/// sense; nothing is allocated beyond what the file's own length covers.
RadianceField ReadField(const std::filesystem::path& path);

}  // namespace deja_view::nerf
