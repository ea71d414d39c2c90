#pragma once

#include "deja_view/geometry/trajectory.hpp"

#include <filesystem>

namespace deja_view {

/// Reads a trajectory in the TUM format: one pose per line, `stamp tx ty tz qx qy qz qw`, stamp in
/// seconds, blanks or tabs between; lines that begin with # are comments.
/// Stamps are exact to the nanosecond. Quaternions are normalised; their norm may be off by 1e-3.
/// Throws InputError that names file, line and what was expected for a line of another form, a
/// value that is not finite, or a stamp that is not later than the one before.
Trajectory ReadTum(const std::filesystem::path& path);

/// Writes a trajectory in the TUM format, stamps with 9 decimals, whole or not at all
/// (WriteFileAtomically).
void WriteTum(const std::filesystem::path& path, const Trajectory& trajectory);

}  // namespace deja_view
