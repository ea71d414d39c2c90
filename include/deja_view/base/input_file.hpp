#pragma once

#include <filesystem>
#include <fstream>

namespace deja_view {

/// Throws InputError, naming the path and why, unless it is a regular file that can be read: a
/// directory reads as nothing, and a pipe may wait for ever.
void CheckInputFile(const std::filesystem::path& path);

/// Opens a file to read after CheckInputFile.
std::ifstream OpenInputFile(const std::filesystem::path& path, std::ios::openmode mode = {});

}  // namespace deja_view
