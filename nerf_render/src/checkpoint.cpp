#include "deja_view/nerf/checkpoint.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <type_traits>

namespace deja_view::nerf {
namespace {

constexpr std::array<char, 8> kMagic = {'D', 'V', 'N', 'E', 'R', 'F', '\r', '\n'};
constexpr std::uint32_t kVersion = 1;

struct Header {
  std::array<char, 8> magic;
  std::uint32_t version;
  std::uint32_t reserved;
  std::uint64_t body_size;
};

std::uint64_t Checksum(const std::vector<char>& body) {
  std::uint64_t hash = 0xCBF29CE484222325ULL;
  for (std::size_t i = 0; i < body.size(); i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, body.data() + i, std::min<std::size_t>(8, body.size() - i));
    hash = (hash ^ word) * 0x100000001B3ULL;
    hash ^= hash >> 32U;
  }
  return hash;
}

class Writer {
 public:
  template <typename T>
  void Value(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    Bytes(&value, sizeof(T));
  }
  void Bytes(const void* from, std::size_t size) {
    if (size > 0) {
      const std::size_t at = body.size();
      body.resize(at + size);
      std::memcpy(body.data() + at, from, size);
    }
  }
  template <typename T>
  void operator()(const char* /*key*/, T& field) {
    if constexpr (std::is_arithmetic_v<T>) {
      Value(field);
    } else {
      field.Visit(*this);
    }
  }
  std::vector<char> body;
};

class Reader {
 public:
  Reader(std::string path, const std::vector<char>& body) : path_(std::move(path)), body_(body) {}

  template <typename T>
  T Value() {
    static_assert(std::is_arithmetic_v<T>);
    T value{};
    Bytes(&value, sizeof(T));
    return value;
  }
  void Bytes(void* to, std::size_t size) {
    if (size > body_.size() - at_) {
      ThrowInputError("{}: ends early: {} more bytes expected at {}", path_, size, at_);
    }
    if (size > 0) {
      std::memcpy(to, body_.data() + at_, size);
      at_ += size;
    }
  }
  template <typename T>
  void operator()(const char* /*key*/, T& field) {
    if constexpr (std::is_arithmetic_v<T>) {
      field = Value<T>();
    } else {
      field.Visit(*this);
    }
  }
  std::size_t left() const { return body_.size() - at_; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  const std::vector<char>& body_;
  std::size_t at_ = 0;
};

std::vector<char> ReadBody(const std::string& path) {
  std::ifstream stream(path, std::ios::binary | std::ios::ate);
  if (!stream) {
    ThrowInputError("{}: can't be opened as a NeRF model", path);
  }
  const auto size = static_cast<std::uint64_t>(stream.tellg());
  stream.seekg(0);
  Header header{};
  char raw[sizeof(Header)];
  if (size < sizeof(Header) + 8 || !stream.read(raw, sizeof(Header))) {
    ThrowInputError("{}: {} bytes are too few for a NeRF model", path, size);
  }
  std::memcpy(&header, raw, sizeof(Header));
  if (header.magic != kMagic) {
    ThrowInputError("{}: is no NeRF model (its first bytes are others)", path);
  }
  if (header.version != kVersion || header.reserved != 0) {
    ThrowInputError("{}: version {}, expected {}", path, header.version, kVersion);
  }
  if (header.body_size != size - sizeof(Header) - 8) {
    ThrowInputError(
        "{}: says {} bytes of content, has {}", path, header.body_size, size - sizeof(Header) - 8);
  }
  std::vector<char> body(header.body_size);
  std::uint64_t checksum = 0;
  char tail[8];
  if (!stream.read(body.data(), static_cast<std::streamsize>(body.size())) ||
      !stream.read(tail, sizeof(tail))) {
    ThrowInputError("{}: can't be read to its end", path);
  }
  std::memcpy(&checksum, tail, sizeof(tail));
  if (checksum != Checksum(body)) {
    ThrowInputError("{}: is damaged (its checksum differs)", path);
  }
  return body;
}

template <typename Floats>
void WriteFloats(const Floats& values, Writer* writer) {
  writer->Value(static_cast<std::uint64_t>(values.size()));
  writer->Bytes(values.data(), values.size() * sizeof(float));
}

template <typename Floats>
void ReadFloats(const char* what, Reader* reader, Floats* values) {
  const auto size = reader->Value<std::uint64_t>();
  if (size != values->size()) {
    ThrowInputError(
        "{}: {} {} parameters, expected {}", reader->path(), size, what, values->size());
  }
  reader->Bytes(values->data(), values->size() * sizeof(float));
  if (!std::all_of(values->data(), values->data() + values->size(), [](float v) {
        return std::isfinite(v);
      })) {
    ThrowInputError("{}: {} parameters are not finite", reader->path(), what);
  }
}

// Bytes that the largest part of a model with these options must take: checked before it is made,
// so that a file can't ask for more memory than its own length.
std::uint64_t LeastBytes(const FieldOptions& options, const Eigen::Vector3d& extent) {
  std::uint64_t values = 0;
  for (const GridOptions& grid : {options.geometry, options.appearance}) {
    double growth = 1;
    if (grid.levels > 1) {
      growth = std::pow(static_cast<double>(grid.finest_resolution) / grid.base_resolution,
                        1.0 / (grid.levels - 1));
    }
    for (int l = 0; l < grid.levels; ++l) {
      const double cells = grid.base_resolution * std::pow(growth, l);
      const double dense = (extent * cells).array().max(1.0).prod();
      values += static_cast<std::uint64_t>(std::min(dense, std::pow(2.0, grid.log2_table_size)) *
                                           grid.features);
    }
  }
  const double voxels = (extent * options.occupancy_resolution).array().max(1.0).prod();
  return values * sizeof(float) + static_cast<std::uint64_t>(voxels / 8);
}

void ReadExposures(Reader* reader, RadianceField* field) {
  const auto count = reader->Value<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    Exposure exposure;
    const auto length = reader->Value<std::uint32_t>();
    if (length > reader->left()) {
      ThrowInputError("{}: name of image {} is longer than the file", reader->path(), i);
    }
    exposure.image.resize(length);
    reader->Bytes(exposure.image.data(), length);
    exposure.stamp_ns = reader->Value<std::int64_t>();
    exposure.gain = reader->Value<float>();
    exposure.bias = reader->Value<float>();
    field->exposures.push_back(std::move(exposure));
  }
}

}  // namespace

void WriteField(const std::filesystem::path& path, const RadianceField& field) {
  Writer writer;
  FieldOptions options = field.options;
  MarchOptions march = field.march;
  options.Visit(writer);
  march.Visit(writer);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    writer.Value(field.box.min[axis]);
    writer.Value(field.box.max[axis]);
  }
  writer.Value(static_cast<std::int32_t>(field.channels));
  WriteFloats(field.geometry.parameters(), &writer);
  WriteFloats(field.appearance.parameters(), &writer);
  WriteFloats(field.density.parameters(), &writer);
  WriteFloats(field.color.parameters(), &writer);
  writer.Value(static_cast<std::uint64_t>(field.occupancy.words().size()));
  writer.Bytes(field.occupancy.words().data(), field.occupancy.words().size() * 8);
  writer.Value(static_cast<std::uint64_t>(field.exposures.size()));
  for (const Exposure& exposure : field.exposures) {
    writer.Value(static_cast<std::uint32_t>(exposure.image.size()));
    writer.Bytes(exposure.image.data(), exposure.image.size());
    writer.Value(exposure.stamp_ns);
    writer.Value(exposure.gain);
    writer.Value(exposure.bias);
  }
  const Header header{kMagic, kVersion, 0, writer.body.size()};
  const std::uint64_t checksum = Checksum(writer.body);
  WriteFileAtomically(path, [&](std::ostream& out) {
    char raw[sizeof(Header)];
    std::memcpy(raw, &header, sizeof(Header));
    out.write(raw, sizeof(Header));
    out.write(writer.body.data(), static_cast<std::streamsize>(writer.body.size()));
    char tail[sizeof(checksum)];
    std::memcpy(tail, &checksum, sizeof(checksum));
    out.write(tail, sizeof(tail));
  });
}

RadianceField ReadField(const std::filesystem::path& path) {
  const std::vector<char> body = ReadBody(path.string());
  Reader reader(path.string(), body);
  FieldOptions options;
  MarchOptions march;
  SceneBox box;
  options.Visit(reader);
  march.Visit(reader);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    box.min[axis] = reader.Value<double>();
    box.max[axis] = reader.Value<double>();
  }
  const auto channels = reader.Value<std::int32_t>();
  const std::vector<std::string> violations = options.Validate();
  if (!violations.empty()) {
    ThrowInputError("{}: {}", path.string(), violations.front());
  }
  if (!box.min.allFinite() || !box.max.allFinite() || !(box.max.array() > box.min.array()).all() ||
      (channels != 1 && channels != 3)) {
    ThrowInputError("{}: its box or its {} channels make no sense", path.string(), channels);
  }
  if (LeastBytes(options, (box.max - box.min) / box.Size()) > body.size()) {
    ThrowInputError("{}: is too short for the model it describes", path.string());
  }
  RadianceField field(options, march, box, channels, 0);
  ReadFloats("geometry", &reader, &field.geometry.parameters());
  ReadFloats("appearance", &reader, &field.appearance.parameters());
  ReadFloats("density network", &reader, &field.density.parameters());
  ReadFloats("colour network", &reader, &field.color.parameters());
  field.density.UpdateTranspose();
  field.color.UpdateTranspose();
  const auto words = reader.Value<std::uint64_t>();
  if (words != field.occupancy.words().size()) {
    ThrowInputError("{}: {} occupancy words, expected {}",
                    path.string(),
                    words,
                    field.occupancy.words().size());
  }
  reader.Bytes(field.occupancy.words().data(), words * 8);
  ReadExposures(&reader, &field);
  if (reader.left() != 0) {
    ThrowInputError("{}: {} bytes too many", path.string(), reader.left());
  }
  return field;
}

}  // namespace deja_view::nerf
