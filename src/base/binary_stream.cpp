#include "deja_view/base/binary_stream.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/input_file.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>

namespace deja_view {
namespace {

struct Header {
  std::array<char, 8> magic;
  std::uint32_t version;
  std::uint32_t reserved;
  std::uint64_t body_size;
};
static_assert(sizeof(Header) == 24, "no padding");

// Raw bytes: the one place where values become what lies in a file.
template <typename T>
void Put(const T& value, std::ostream* out) {
  out->write(reinterpret_cast<const char*>(&value), sizeof(T));
}

template <typename T>
bool Get(std::istream* in, T* value) {
  return static_cast<bool>(in->read(reinterpret_cast<char*>(value), sizeof(T)));
}

}  // namespace

void BinaryWriter::WriteBytes(const void* from, std::size_t size) {
  hasher_.Add(from, size);
  size_ += size;
  out_->write(static_cast<const char*>(from), static_cast<std::streamsize>(size));
}

void WriteBinaryFile(const std::filesystem::path& path,
                     const BinaryFormat& format,
                     const std::function<void(BinaryWriter*)>& write_body) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    Put(Header{format.magic, format.version, 0, 0}, &out);
    BinaryWriter writer(&out);
    write_body(&writer);
    Put(writer.hash(), &out);
    out.seekp(offsetof(Header, body_size));
    Put(writer.size(), &out);
  });
}

BinaryReader::BinaryReader(const std::filesystem::path& path, const BinaryFormat& format)
    : path_(path.string()), stream_(OpenInputFile(path, std::ios::binary | std::ios::ate)) {
  const auto file_size = static_cast<std::uint64_t>(stream_.tellg());
  stream_.seekg(0);
  Header header{};
  constexpr std::uint64_t kAround = sizeof(Header) + sizeof(std::uint64_t);
  if (file_size < kAround || !Get(&stream_, &header)) {
    ThrowInputError("{}: {} bytes are too few for {}", path_, file_size, format.what);
  }
  if (header.magic != format.magic) {
    ThrowInputError("{}: is not {} (its first bytes are others)", path_, format.what);
  }
  if (header.version < format.oldest || header.version > format.version || header.reserved != 0) {
    ThrowInputError("{}: version {}, expected {}{}",
                    path_,
                    header.version,
                    format.oldest == format.version ? "" : fmt::format("{} to ", format.oldest),
                    format.version);
  }
  version_ = header.version;
  size_ = left_ = file_size - kAround;
  if (header.body_size != size_) {
    ThrowInputError("{}: says {} bytes of content, has {}", path_, header.body_size, size_);
  }
  CheckHash();
}

// Before anything is made of the content.
void BinaryReader::CheckHash() {
  Hasher64 hasher;
  std::vector<char> block(std::size_t{1} << 16U);
  for (std::uint64_t left = size_; left > 0;) {
    const std::size_t count = std::min<std::uint64_t>(left, block.size());
    if (!stream_.read(block.data(), static_cast<std::streamsize>(count))) {
      ThrowInputError("{}: can't be read to its end", path_);
    }
    hasher.Add(block.data(), count);
    left -= count;
  }
  std::uint64_t hash = 0;
  if (!Get(&stream_, &hash) || hash != hasher.value()) {
    ThrowInputError("{}: is damaged (its checksum differs)", path_);
  }
  stream_.seekg(sizeof(Header));
}

void BinaryReader::ReadBytes(void* to, std::size_t size, const char* field) {
  if (size > left_) {
    Fail(field, "the file ends too early");
  }
  if (size > 0 && !stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(size))) {
    Fail(field, "can't be read");
  }
  left_ -= size;
}

void BinaryReader::Skip(std::uint64_t size, const char* field) {
  if (size > left_) {
    Fail(field, "the file ends too early");
  }
  stream_.seekg(static_cast<std::streamoff>(size), std::ios::cur);
  left_ -= size;
}

void BinaryReader::Finish() const {
  if (left_ != 0) {
    ThrowInputError("{}: {} bytes too many", path_, left_);
  }
}

void BinaryReader::Fail(const char* field, std::string_view what) const {
  ThrowInputError("{}: {}: {} (at byte {})", path_, field, what, sizeof(Header) + size_ - left_);
}

}  // namespace deja_view
