#pragma once

#include "deja_view/nerf/radiance_field.hpp"

#include <filesystem>

namespace deja_view::nerf {

/// Writes a field, whole or not at all (WriteFileAtomically). Little endian:
///   8 bytes "DVNERF\r\n", uint32 version, uint32 0, uint64 length of the body, body, uint64 FNV-1a
///   of the body, taken over 8-byte words
/// Fields of a scene in one piece, in the world of their poses, are of version 2; those of a
/// sub-map of version 3, which has its cells at the body's end; those in a frame of their own of
/// version 4, with cells, of which there may be none, and frame.
void WriteField(const std::filesystem::path& path, const RadianceField& field);

/// Reads what WriteField wrote. Throws InputError that names the path for a file that is missing,
/// of another kind or version, cut off, longer than it says, damaged, or with sizes that make no
/// sense; nothing is allocated beyond what the file's own length covers.
RadianceField ReadField(const std::filesystem::path& path);

}  // namespace deja_view::nerf
