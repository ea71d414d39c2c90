#pragma once

#include "deja_view/vocabulary/vocabulary_training.hpp"

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace deja_view {

/// What `deja_view vocabulary train` is told.
struct VocabularyTrainRequest {
  std::vector<std::filesystem::path>
      images;                 ///< directories, searched without their subdirectories
  std::filesystem::path out;  ///< .dvv, .bin or .txt
  TrainOptions options;
  bool show_progress = true;
};

/// Trains a vocabulary from the images' features and writes it. Returns `images, descriptors,
/// words, nodes, k, levels, descriptor, bytes, features_s, train_s, identity`. Throws InputError
/// that names the directory or file at fault.
nlohmann::ordered_json RunVocabularyTrain(const VocabularyTrainRequest& request);

/// Writes `in` in the format that the extension of `out` asks for; returns what VocabularyInfo does
/// of `out`.
nlohmann::ordered_json RunVocabularyConvert(const std::filesystem::path& in,
                                            const std::filesystem::path& out);

/// Checks a vocabulary to the last byte and returns `path, format, descriptor, k, levels, words,
/// nodes, bytes, idf_min, idf_mean, idf_max, identity`.
nlohmann::ordered_json RunVocabularyInfo(const std::filesystem::path& path);

}  // namespace deja_view
