#include "deja_view/ros/bag/view_store.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"

#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>

#include "message_layout.hpp"

#include <ros/message_traits.h>
#include <ros/serialization.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

constexpr char kMagic[8] = {'D', 'V', 'V', 'I', 'E', 'W', '2', '\n'};
constexpr const char* kExtension = ".views";

// All but the frames, as it lies in the file; results move between runs on one machine only.
struct Header {
  char magic[8];
  std::uint64_t settings_hash;
  std::uint64_t body_hash;
  std::int64_t stamp_ns;
  std::int64_t recorded_ns;
  double gain;
  double bias;
  double correlation;
  double psnr_db;
  double elapsed_s;
  std::int32_t is_recognised;
  std::int32_t not_free;
  std::int32_t uncertain;
  std::int32_t frames;
};
static_assert(sizeof(Header) == 96, "no padding");

std::string Serialize(const std::vector<VirtualFrame>& frames) {
  std::string bytes;
  for (const VirtualFrame& frame : frames) {
    const std::uint32_t size = ros::serialization::serializationLength(frame);
    std::string part(size, '\0');
    // ROS streams write bytes.
    ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(part.data()), size);
    ros::serialization::serialize(stream, frame);
    bytes.append(reinterpret_cast<const char*>(&size), sizeof(size));
    bytes += part;
  }
  return bytes;
}

// Nothing when the bytes are not `count` messages.
std::optional<std::vector<VirtualFrame>> Deserialize(std::string bytes, std::int32_t count) {
  static const internal::MessageLayout layout(ros::message_traits::datatype<VirtualFrame>(),
                                              ros::message_traits::definition<VirtualFrame>());
  std::vector<VirtualFrame> frames;
  std::size_t at = 0;
  for (std::int32_t i = 0; i < count; ++i) {
    std::uint32_t size = 0;
    if (bytes.size() - at < sizeof(size)) {
      return std::nullopt;
    }
    std::memcpy(&size, bytes.data() + at, sizeof(size));
    at += sizeof(size);
    auto* data = reinterpret_cast<std::uint8_t*>(bytes.data() + at);
    if (bytes.size() - at < size || !layout.FindOverrun(data, size).empty()) {
      return std::nullopt;
    }
    ros::serialization::IStream stream(data, size);
    ros::serialization::deserialize(stream, frames.emplace_back());
    at += size;
  }
  return at == bytes.size() ? std::make_optional(std::move(frames)) : std::nullopt;
}

}  // namespace

ViewStore::ViewStore(fs::path directory, std::uint64_t settings_hash)
    : directory_(std::move(directory)), settings_hash_(settings_hash) {}

void ViewStore::Write(const SourceResult& result) const {
  const std::string body = Serialize(result.frames);
  Header header{};
  std::memcpy(header.magic, kMagic, sizeof(kMagic));
  header.settings_hash = settings_hash_;
  header.body_hash = Hash64(body);
  header.stamp_ns = result.stamp_ns;
  header.recorded_ns = result.recorded_ns;
  header.gain = result.fit.gain;
  header.bias = result.fit.bias;
  header.correlation = result.fit.correlation;
  header.psnr_db = result.fit.psnr_db;
  header.elapsed_s = result.elapsed_s;
  header.is_recognised = result.is_recognised ? 1 : 0;
  header.not_free = result.not_free;
  header.uncertain = result.uncertain;
  header.frames = static_cast<std::int32_t>(result.frames.size());
  WriteFileAtomically(PathOf(result.stamp_ns), [&](std::ostream& out) {
    out.write(reinterpret_cast<const char*>(&header), sizeof(header));
    out.write(body.data(), static_cast<std::streamsize>(body.size()));
  });
}

std::optional<SourceResult> ViewStore::Read(std::int64_t stamp_ns) const {
  std::ifstream in(PathOf(stamp_ns), std::ios::binary);
  Header header{};
  if (!in.read(reinterpret_cast<char*>(&header), sizeof(header))) {
    return std::nullopt;
  }
  std::string body((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0 ||
      header.settings_hash != settings_hash_ || header.stamp_ns != stamp_ns ||
      header.body_hash != Hash64(body)) {
    return std::nullopt;
  }
  SourceResult result;
  result.stamp_ns = stamp_ns;
  result.recorded_ns = header.recorded_ns;
  result.fit = {header.gain, header.bias, header.correlation, header.psnr_db};
  result.elapsed_s = header.elapsed_s;
  result.is_recognised = header.is_recognised != 0;
  result.not_free = header.not_free;
  result.uncertain = header.uncertain;
  std::optional<std::vector<VirtualFrame>> frames = Deserialize(std::move(body), header.frames);
  if (!frames) {
    return std::nullopt;
  }
  result.frames = std::move(*frames);
  return result;
}

void ViewStore::Remove() const {
  std::error_code error;
  for (fs::directory_iterator entry(directory_, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().extension() == kExtension) {
      std::error_code ignored;
      fs::remove(entry->path(), ignored);
    }
  }
  fs::remove(directory_, error);  // fails, rightly, where there is something else
}

fs::path ViewStore::PathOf(std::int64_t stamp_ns) const {
  return directory_ / (std::to_string(stamp_ns) + kExtension);
}

}  // namespace deja_view
