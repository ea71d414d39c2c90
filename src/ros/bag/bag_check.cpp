#include "bag_check.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

namespace deja_view::internal {
namespace {

// http://wiki.ros.org/Bags/Format/2.0
constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
enum Op : int {
  kMessage = 2,
  kBagHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};

// No header is nearly as long; a connection's data, which holds a message definition, may be.
constexpr std::uint32_t kMaxHeader = 1U << 16U;
constexpr std::uint32_t kMaxConnection = 1U << 26U;
constexpr std::uint32_t kMaxIndex = 1U << 30U;

// rosbag makes room for an unpacked chunk before it unpacks; its writers make chunks of 768 kB, or
// of one message. LZ4 packs 255 bytes into one at best, BZ2 more where all are the same.
constexpr std::uint32_t kMaxChunk = 1U << 30U;
constexpr std::uint64_t kMaxRatio = 1100;
constexpr std::uint64_t kAnyRatio = 1U << 24U;

using Fields = std::map<std::string, std::string>;

struct Record {
  std::uint64_t start = 0;
  int op = 0;
  Fields fields;
  std::uint64_t data = 0;  // where it is
  std::uint32_t size = 0;  // of the data
  std::uint64_t end() const { return data + size; }
};

struct Chunk {
  bool is_compressed = false;
  std::uint32_t size = 0;                           // uncompressed
  std::map<std::uint32_t, std::uint32_t> messages;  // offset to connection
  int indices = 0;
  bool is_listed = false;  // in the bag's index
};

class Checker {
 public:
  explicit Checker(const std::filesystem::path& path)
      : path_(path), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (file_ < 0) {
      Fail(0, "it can't be opened", "a readable file");
    }
    const off_t size = ::lseek(file_, 0, SEEK_END);
    size_ = size < 0 ? 0 : static_cast<std::uint64_t>(size);
  }
  ~Checker() {
    if (file_ >= 0) {
      ::close(file_);
    }
  }
  Checker(const Checker&) = delete;
  Checker& operator=(const Checker&) = delete;

  void Run() {
    if (size_ < kMagic.size() || Bytes(0, static_cast<std::uint32_t>(kMagic.size())) != kMagic) {
      Fail(0, "the first line is another", "a ROS bag of version 2.0");
    }
    const Record header = ReadRecord(kMagic.size(), size_);
    Expect(header.op == kBagHeader, header.start, "the bag's header");
    index_position_ = Number<std::uint64_t>(header, "index_pos");
    Number<std::uint32_t>(header, "conn_count");
    Number<std::uint32_t>(header, "chunk_count");
    if (index_position_ == 0) {
      ThrowInputError(
          "{}: the bag was not closed (its recording was cut off): expected an indexed bag; "
          "'rosbag reindex' repairs it",
          path_.string());
    }
    if (header.fields.count("encryptor") > 0 && !header.fields.at("encryptor").empty()) {
      Fail(header.start, "the bag is encrypted", "a plain one");
    }
    std::uint64_t position = header.end();
    bool index_is_found = index_position_ == size_;
    while (position < size_) {
      index_is_found = index_is_found || position == index_position_;
      const Record record = ReadRecord(position, size_);
      CheckRecord(record);
      position = record.end();
    }
    Expect(index_is_found, index_position_, "the index");
    CheckReferences();
  }

 private:
  [[noreturn]] void Fail(std::uint64_t position,
                         const std::string& what,
                         const std::string& expected) const {
    ThrowInputError(
        "{}: the bag is damaged or truncated, or is no bag: at byte {}: {}: expected {}",
        path_.string(),
        position,
        what,
        expected);
  }

  void Expect(bool holds, std::uint64_t position, const std::string& expected) const {
    if (!holds) {
      Fail(position, "something else", expected);
    }
  }

  std::string Bytes(std::uint64_t position, std::uint32_t count) const {
    std::string bytes(count, '\0');
    std::size_t done = 0;
    while (done < count) {
      const ssize_t read =
          ::pread(file_, &bytes[done], count - done, static_cast<off_t>(position + done));
      if (read <= 0) {
        Fail(position, "the file ends", fmt::format("{} bytes", count));
      }
      done += static_cast<std::size_t>(read);
    }
    return bytes;
  }

  template <typename T>
  static T FromBytes(const char* bytes) {
    T value{};
    std::memcpy(&value, bytes, sizeof(T));
    return value;
  }

  std::uint32_t Length(std::uint64_t position, std::uint64_t end, std::uint32_t most) const {
    Expect(position + 4 <= end, position, "four bytes of length");
    const auto length = FromBytes<std::uint32_t>(Bytes(position, 4).data());
    Expect(
        length <= most && position + 4 + length <= end,
        position,
        fmt::format("a length of at most {} bytes", std::min<std::uint64_t>(most, end - position)));
    return length;
  }

  // Fields of a header: length, name, '=', value.
  Fields ParseFields(const std::string& bytes, std::uint64_t position) const {
    Fields fields;
    std::size_t at = 0;
    while (at < bytes.size()) {
      Expect(bytes.size() - at >= 4, position + at, "a header field");
      const auto length = FromBytes<std::uint32_t>(&bytes[at]);
      at += 4;
      Expect(length <= bytes.size() - at, position + at, "a header field within its header");
      const std::string field = bytes.substr(at, length);
      const std::size_t equals = field.find('=');
      Expect(equals != std::string::npos, position + at, "name=value");
      fields[field.substr(0, equals)] = field.substr(equals + 1);
      at += length;
    }
    return fields;
  }

  Record ReadRecord(std::uint64_t position, std::uint64_t end) const {
    Record record;
    record.start = position;
    const std::uint32_t header = Length(position, end, kMaxHeader);
    record.fields = ParseFields(Bytes(position + 4, header), position + 4);
    record.op = Number<std::uint8_t>(record, "op");
    record.size = Length(position + 4 + header, end, 0xFFFFFFFFU);
    record.data = position + 8 + header;
    return record;
  }

  template <typename T>
  T Number(const Record& record, const std::string& name) const {
    const auto field = record.fields.find(name);
    Expect(field != record.fields.end() && field->second.size() == sizeof(T),
           record.start,
           fmt::format("a field '{}' of {} bytes", name, sizeof(T)));
    return FromBytes<T>(field->second.data());
  }

  void CheckRecord(const Record& record) {
    switch (record.op) {
      case kChunk:
        CheckChunk(record);
        break;
      case kIndex:
        CheckIndex(record);
        break;
      case kConnection:
        CheckConnection(record);
        if (record.start >= index_position_) {
          connections_.insert(Number<std::uint32_t>(record, "conn"));
        }
        break;
      case kChunkInfo:
        CheckChunkInfo(record);
        break;
      default:
        Fail(record.start, fmt::format("a record of kind {}", record.op), "4, 5, 6 or 7");
    }
  }

  void CheckChunk(const Record& record) {
    const auto compression = record.fields.find("compression");
    Expect(compression != record.fields.end(), record.start, "a chunk's compression");
    Chunk chunk;
    chunk.is_compressed = compression->second != "none";
    chunk.size = Number<std::uint32_t>(record, "size");
    Expect(chunk.is_compressed || chunk.size == record.size, record.start, "the chunk's true size");
    const std::uint64_t most =
        std::min<std::uint64_t>(kMaxChunk, std::max(kAnyRatio, kMaxRatio * record.size));
    if (chunk.is_compressed && chunk.size > most) {
      Fail(record.start,
           fmt::format("a chunk of {} bytes unpacked", chunk.size),
           fmt::format("at most {}", most));
    }
    for (std::uint64_t at = record.data; !chunk.is_compressed && at < record.end();) {
      const Record inner = ReadRecord(at, record.end());
      if (inner.op == kMessage) {
        Number<std::uint64_t>(inner, "time");
        chunk.messages[static_cast<std::uint32_t>(at - record.data)] =
            Number<std::uint32_t>(inner, "conn");
      } else {
        Expect(inner.op == kConnection, at, "a message or a connection");
        CheckConnection(inner);
      }
      at = inner.end();
    }
    last_chunk_ = record.start;
    chunks_[record.start] = std::move(chunk);
  }

  void CheckConnection(const Record& record) const {
    Number<std::uint32_t>(record, "conn");
    Expect(record.fields.count("topic") > 0, record.start, "a connection's topic");
    Expect(record.size <= kMaxConnection, record.start, "a message definition of sane size");
    const Fields fields = ParseFields(Bytes(record.data, record.size), record.data);
    for (const char* name : {"type", "md5sum", "message_definition"}) {
      Expect(fields.count(name) > 0, record.data, fmt::format("a connection's {}", name));
    }
  }

  void CheckIndex(const Record& record) {
    Number<std::uint32_t>(record, "ver");
    const auto connection = Number<std::uint32_t>(record, "conn");
    const std::uint64_t count = Number<std::uint32_t>(record, "count");
    Expect(!chunks_.empty(), record.start, "a chunk before its index");
    Expect(12 * count == record.size && record.size <= kMaxIndex,
           record.start,
           "12 bytes for each message of an index");
    Chunk& chunk = chunks_[last_chunk_];
    ++chunk.indices;
    indexed_connections_.insert(connection);
    const std::string entries = Bytes(record.data, record.size);
    for (std::size_t at = 8; at < entries.size(); at += 12) {
      const auto offset = FromBytes<std::uint32_t>(&entries[at]);
      const auto message = chunk.messages.find(offset);
      const bool is_right = chunk.is_compressed
                                ? offset < chunk.size
                                : message != chunk.messages.end() && message->second == connection;
      Expect(is_right, record.data + at, "the offset of one of the connection's messages");
    }
  }

  void CheckChunkInfo(const Record& record) {
    Number<std::uint32_t>(record, "ver");
    Number<std::uint64_t>(record, "start_time");
    Number<std::uint64_t>(record, "end_time");
    const std::uint64_t count = Number<std::uint32_t>(record, "count");
    Expect(8 * count == record.size, record.start, "8 bytes for each connection of a chunk");
    const auto chunk = chunks_.find(Number<std::uint64_t>(record, "chunk_pos"));
    Expect(chunk != chunks_.end() && static_cast<std::uint64_t>(chunk->second.indices) == count,
           record.start,
           "a chunk and its indices");
    // rosbag reads a chunk's indices for each time that it is listed.
    Expect(!chunk->second.is_listed, record.start, "a chunk that is not listed yet");
    chunk->second.is_listed = true;
  }

  void CheckReferences() const {
    for (const std::uint32_t connection : indexed_connections_) {
      Expect(connections_.count(connection) > 0,
             index_position_,
             fmt::format("connection {}, which has messages", connection));
    }
  }

  std::filesystem::path path_;
  int file_;
  std::uint64_t size_ = 0;
  std::uint64_t index_position_ = 0;
  std::uint64_t last_chunk_ = 0;
  std::map<std::uint64_t, Chunk> chunks_;  // by position
  std::set<std::uint32_t> connections_;
  std::set<std::uint32_t> indexed_connections_;
};

}  // namespace

void CheckBag(const std::filesystem::path& path) {
  Checker(path).Run();
}

}  // namespace deja_view::internal
