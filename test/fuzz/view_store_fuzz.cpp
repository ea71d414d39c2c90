// Finished views of an interrupted run, with the hash of what they hold.
#include "deja_view/base/hash.hpp"
#include "deja_view/ros/bag/view_store.hpp"

#include <cstring>

#include "fuzz.hpp"

namespace deja_view::fuzz {
namespace {

constexpr std::int64_t kStamp = 1403636627638560000;
constexpr std::uint64_t kSettings = 7;
constexpr std::size_t kHead = 96;
constexpr std::size_t kHashAt = 16;
const char* const kName = "1403636627638560000.views";

}  // namespace

std::vector<std::string> Seeds() {
  SourceResult result;
  result.stamp_ns = kStamp;
  result.frames.resize(2);
  result.frames[0].image.assign(50, 7);
  const ViewStore store(Scratch() / "seeds", kSettings);
  store.Write(result);
  return {ReadAll(Scratch() / "seeds" / kName)};
}

void RunOne(const std::string& input) {
  std::string file = input;
  if (file.size() >= kHead) {
    const std::uint64_t hash = Hash64(file.data() + kHead, file.size() - kHead);
    std::memcpy(file.data() + kHashAt, &hash, sizeof(hash));
  }
  Write(std::string("store/") + kName, file);
  ViewStore(Scratch() / "store", kSettings).Read(kStamp);
}

}  // namespace deja_view::fuzz
