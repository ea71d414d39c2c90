#include "deja_view/vocabulary/vocabulary_files.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"

#include <cctype>
#include <cstring>

#include "flat_format.hpp"
#include "mapped_file.hpp"

namespace deja_view {

VocabularyFormat DetectVocabularyFormat(const std::filesystem::path& path) {
  const internal::MappedFile file(path);
  const internal::FlatHeader flat;
  if (file.size() >= sizeof(flat.magic) &&
      std::memcmp(file.data(), flat.magic, sizeof(flat.magic)) == 0) {
    return VocabularyFormat::kFlat;
  }
  const auto first = *static_cast<const unsigned char*>(file.data());
  const auto second = file.size() > 1 ? static_cast<const unsigned char*>(file.data())[1] : ' ';
  const bool is_text = std::isdigit(first) != 0 && (std::isdigit(second) != 0 || second == ' ');
  return is_text ? VocabularyFormat::kOrbSlam : VocabularyFormat::kVins;
}

void WriteFlatVocabulary(const std::filesystem::path& path, const VocabularyTree& tree) {
  const std::vector<Descriptor> bytes = internal::BuildFlat(tree, path.string());
  WriteFileAtomically(path, [&](std::ostream& stream) {
    stream.write(reinterpret_cast<const char*>(bytes.data()),
                 static_cast<std::streamsize>(bytes.size() * sizeof(Descriptor)));
  });
}

void VerifyFlatVocabulary(const std::filesystem::path& path) {
  const internal::MappedFile file(path);
  internal::ViewFlat(file.data(), file.size(), path.string(), internal::FlatCheck::kAll);
}

void CheckVocabularyExtension(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension != ".dvv" && extension != ".bin" && extension != ".txt") {
    ThrowInputError(
        "{}: extension: is '{}', expected .dvv, .bin or .txt", path.string(), extension);
  }
}

void WriteVocabulary(const std::filesystem::path& path, const VocabularyTree& tree) {
  CheckVocabularyExtension(path);
  const std::string extension = path.extension().string();
  if (extension == ".dvv") {
    WriteFlatVocabulary(path, tree);
  } else if (extension == ".bin") {
    WriteVinsVocabulary(path, tree);
  } else {
    WriteOrbSlamVocabulary(path, tree);
  }
}

}  // namespace deja_view
