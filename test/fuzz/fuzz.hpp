#pragma once

#include <filesystem>
#include <string>
#include <vector>

/// What a fuzz target consists of; fuzz_main.cpp runs it.
namespace deja_view::fuzz {

/// Defined by each target: sound inputs to start from, made by the package's own writers.
std::vector<std::string> Seeds();

/// Defined by each target: reads the input. InputError is what bad input is meant to end in; all
/// else that is thrown is a fault.
void RunOne(const std::string& input);

/// A folder of this process in memory, which goes with it.
const std::filesystem::path& Scratch();

/// Writes a file in Scratch(), and the folders it needs; returns its path.
std::filesystem::path Write(const std::string& name, const std::string& bytes);
std::string ReadAll(const std::filesystem::path& path);

/// Gives a file of ours (BinaryFormat) the length and hash of what is in it, as a faulty writer
/// would, so that damage gets past them.
void Seal(std::string* file);

/// The first byte of an input, and what follows.
struct Prefixed {
  unsigned char prefix = 0;
  std::string rest;
};
Prefixed SplitPrefix(const std::string& input);

}  // namespace deja_view::fuzz
