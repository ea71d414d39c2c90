#pragma once

#include "deja_view/vocabulary/vocabulary_tree.hpp"

#include <filesystem>

namespace deja_view {

enum class VocabularyFormat {
  kFlat,     ///< ours
  kVins,     ///< VINS-Mono's brief_k10L6.bin
  kOrbSlam,  ///< ORB-SLAM's ORBvoc.txt
};

/// Tells formats apart by content: our magic, then text that starts with a digit, else VINS-Mono's.
/// Throws InputError when the file can't be read.
VocabularyFormat DetectVocabularyFormat(const std::filesystem::path& path);

/// VINS-Mono's vocabulary (little endian): int32 k, L, scoringType, weightingType, nNodes, nWords;
/// nNodes records {int32 nodeId, int32 parentId, double weight, uint64[4] descriptor}; nWords
/// records {int32 nodeId, int32 wordId}. Node 0 is the root and has no record. Records may stand in
/// any order. Throws InputError that names path and field.
VocabularyTree ReadVinsVocabulary(const std::filesystem::path& path);

/// Writes what ReadVinsVocabulary reads; nodes keep their order and ids, words are sorted by id.
void WriteVinsVocabulary(const std::filesystem::path& path, const VocabularyTree& tree);

/// ORB-SLAM's vocabulary: a first line "k L scoring weighting", then one line per node, node ids
/// counting from 1: parentId isLeaf 32 descriptor bytes weight. Words count the leaves' lines.
/// Throws InputError that names path, line and field.
VocabularyTree ReadOrbSlamVocabulary(const std::filesystem::path& path);

/// Writes what ReadOrbSlamVocabulary, and ORB-SLAM, reads: parents before children, weights with as
/// many digits as they need. Words are numbered anew, in the order of the lines.
void WriteOrbSlamVocabulary(const std::filesystem::path& path, const VocabularyTree& tree);

/// Writes our own flat format, which Vocabulary::Open maps into memory.
void WriteFlatVocabulary(const std::filesystem::path& path, const VocabularyTree& tree);

/// Checks a flat file to the last byte. Vocabulary::Open does so itself for files up to 16 MB; in
/// bigger ones it checks what keeps memory accesses within bounds, to open in milliseconds. Throws
/// InputError that names path and field.
void VerifyFlatVocabulary(const std::filesystem::path& path);

/// Writes the format that the extension asks for: .dvv (flat), .bin (VINS-Mono) or .txt (ORB-SLAM).
/// Throws InputError for another extension.
void WriteVocabulary(const std::filesystem::path& path, const VocabularyTree& tree);

/// Throws InputError when WriteVocabulary would not know the extension; to fail before long work.
void CheckVocabularyExtension(const std::filesystem::path& path);

}  // namespace deja_view
