#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

namespace deja_view {

/// Which images of a sequence show the same place: row i lists the images j < i, rising, that image
/// i shows again. What is said of j >= i is left out.
using PlaceTruth = std::vector<std::vector<int>>;

/// Reads the truth of `images` images, told apart by a colon:
///   N x N numbers 0 or 1, a line per image, with blanks, commas or tabs between them;
///   lines "i: j j j", in any order; images without a line show nothing again.
/// Lines that begin with # are comments. MATLAB's .mat files are refused with how to convert them.
/// Throws InputError that names file, line, what was found and what was expected.
PlaceTruth ReadPlaceTruth(const std::filesystem::path& path, std::size_t images);

/// Whether image `query` shows again what `match` showed.
bool IsTrueMatch(const PlaceTruth& truth, int query, int match);

/// How many images show a place again.
int CountRevisits(const PlaceTruth& truth);

}  // namespace deja_view
