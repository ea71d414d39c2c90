// What a replay leaves: the first byte says which of its files is read.
#include "deja_view/fusion/result_files.hpp"
#include "deja_view/lab/report/matches.hpp"
#include "deja_view/lab/report/run.hpp"

#include "fuzz.hpp"

namespace deja_view::fuzz {
namespace {

constexpr const char* kNames[] = {"loops.csv", "matches.csv", "trajectory.txt", "vio.txt"};

std::filesystem::path SoundRun() {
  static const std::filesystem::path directory = [] {
    std::vector<KeyframeInfo> keyframes(4);
    for (int i = 0; i < 4; ++i) {
      keyframes[static_cast<std::size_t>(i)].index = i;
      keyframes[static_cast<std::size_t>(i)].stamp_ns = 1403636627638560000 + i * 500000000LL;
    }
    LoopReport loop;
    loop.current = 3;
    loop.stamp_current_ns = keyframes[3].stamp_ns;
    loop.stamp_old_ns = keyframes[0].stamp_ns;
    LoopMatches matches;
    matches.stamp_current_ns = loop.stamp_current_ns;
    matches.stamp_old_ns = loop.stamp_old_ns;
    matches.pairs.resize(3);
    LoopRows rows;
    rows.Add(loop);
    rows.Add(loop);
    WriteResultFiles(Scratch() / "run", keyframes, 0, rows, {matches});
    return Scratch() / "run";
  }();
  return directory;
}

}  // namespace

std::vector<std::string> Seeds() {
  std::vector<std::string> seeds;
  for (std::size_t i = 0; i < std::size(kNames); ++i) {
    seeds.push_back(static_cast<char>(i) + ReadAll(SoundRun() / kNames[i]));
  }
  return seeds;
}

void RunOne(const std::string& input) {
  const auto [prefix, content] = SplitPrefix(input);
  const std::size_t which = prefix % std::size(kNames);
  const std::string sound = ReadAll(SoundRun() / kNames[which]);
  Write(std::string("run/") + kNames[which], content);
  try {
    report::ReadRun(SoundRun());
    report::ReadMatches(SoundRun() / "matches.csv");
  } catch (...) {
    Write(std::string("run/") + kNames[which], sound);
    throw;
  }
  Write(std::string("run/") + kNames[which], sound);
}

}  // namespace deja_view::fuzz
