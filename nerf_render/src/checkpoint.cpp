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
constexpr std::uint32_t kVersion = 2;
constexpr std::uint32_t kCellsVersion = 3;  // the same, and cells behind it

struct Header {
  std::array<char, 8> magic;
  std::uint32_t version;
  std::uint32_t reserved;
  std::uint64_t body_size;
};

/// FNV-1a over words of eight bytes, of data that comes in pieces.
class Checksum {
 public:
  void Add(const void* data, std::size_t size) {
    const char* from = static_cast<const char*>(data);
    for (; size > 0 && held_ > 0; --size) {
      Hold(*from++);
    }
    for (; size >= 8; size -= 8, from += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, from, 8);
      Mix(word);
    }
    for (; size > 0; --size) {
      Hold(*from++);
    }
  }
  std::uint64_t Value() const {
    Checksum last = *this;
    while (last.held_ > 0) {
      last.Hold(0);
    }
    return last.hash_;
  }

 private:
  void Hold(char byte) {
    word_[held_++] = byte;
    if (held_ == 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, word_.data(), 8);
      Mix(word);
      held_ = 0;
    }
  }
  void Mix(std::uint64_t word) {
    hash_ = (hash_ ^ word) * 0x100000001B3ULL;
    hash_ ^= hash_ >> 32U;
  }
  std::uint64_t hash_ = 0xCBF29CE484222325ULL;
  std::array<char, 8> word_{};
  std::size_t held_ = 0;
};

/// Counts bytes or, given a stream, writes and sums them up.
class Writer {
 public:
  explicit Writer(std::ostream* out) : out_(out) {}

  template <typename T>
  void Value(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    Bytes(&value, sizeof(T));
  }
  void Bytes(const void* from, std::size_t size) {
    size_ += size;
    if (out_ != nullptr && size > 0) {
      checksum_.Add(from, size);
      out_->write(static_cast<const char*>(from), static_cast<std::streamsize>(size));
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
  std::uint64_t size() const { return size_; }
  std::uint64_t checksum() const { return checksum_.Value(); }

 private:
  std::ostream* out_;
  std::uint64_t size_ = 0;
  Checksum checksum_;
};

/// Reads the body of a model file; what it says is to be believed only after Finish().
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path)
      : path_(path.string()), stream_(path, std::ios::binary | std::ios::ate) {
    if (!stream_) {
      ThrowInputError("{}: can't be opened as a NeRF model", path_);
    }
    const auto size = static_cast<std::uint64_t>(stream_.tellg());
    stream_.seekg(0);
    Header header{};
    char raw[sizeof(Header)];
    if (size < sizeof(Header) + 8 || !stream_.read(raw, sizeof(Header))) {
      ThrowInputError("{}: {} bytes are too few for a NeRF model", path_, size);
    }
    std::memcpy(&header, raw, sizeof(Header));
    if (header.magic != kMagic) {
      ThrowInputError("{}: is no NeRF model (its first bytes are others)", path_);
    }
    if ((header.version != kVersion && header.version != kCellsVersion) || header.reserved != 0) {
      ThrowInputError(
          "{}: version {}, expected {} or {}", path_, header.version, kVersion, kCellsVersion);
    }
    has_cells_ = header.version == kCellsVersion;
    left_ = size - sizeof(Header) - 8;
    if (header.body_size != left_) {
      ThrowInputError("{}: says {} bytes of content, has {}", path_, header.body_size, left_);
    }
  }

  template <typename T>
  T Value() {
    static_assert(std::is_arithmetic_v<T>);
    if constexpr (std::is_same_v<T, bool>) {
      const auto value = Value<std::uint8_t>();
      if (value > 1) {
        ThrowInputError("{}: a switch is {}, expected 0 or 1", path_, value);
      }
      return value == 1;
    } else {
      T value{};
      Bytes(&value, sizeof(T));
      return value;
    }
  }
  void Bytes(void* to, std::size_t size) {
    if (size > left_) {
      ThrowInputError("{}: ends early: {} more bytes expected, {} left", path_, size, left_);
    }
    if (size > 0) {
      if (!stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(size))) {
        ThrowInputError("{}: can't be read to its end", path_);
      }
      checksum_.Add(to, size);
      left_ -= size;
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
  /// Throws InputError unless all has been read and was as it was written.
  void Finish() {
    if (left_ != 0) {
      ThrowInputError("{}: {} bytes too many", path_, left_);
    }
    std::uint64_t checksum = 0;
    char tail[sizeof(checksum)];
    if (!stream_.read(tail, sizeof(tail))) {
      ThrowInputError("{}: can't be read to its end", path_);
    }
    std::memcpy(&checksum, tail, sizeof(tail));
    if (checksum != checksum_.Value()) {
      ThrowInputError("{}: is damaged (its checksum differs)", path_);
    }
  }
  std::uint64_t left() const { return left_; }
  bool has_cells() const { return has_cells_; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  std::ifstream stream_;
  std::uint64_t left_ = 0;
  bool has_cells_ = false;
  Checksum checksum_;
};

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
    exposure.latent.resize(static_cast<std::size_t>(field->options.latent_size));
    reader->Bytes(exposure.latent.data(), exposure.latent.size() * sizeof(float));
    field->exposures.push_back(std::move(exposure));
  }
}

void ReadCells(Reader* reader, SceneCells* cells) {
  cells->index = reader->Value<std::int32_t>();
  const auto count = reader->Value<std::uint32_t>();
  if (count == 0 || count > reader->left() / (6 * sizeof(double)) || cells->index < 0 ||
      static_cast<std::uint32_t>(cells->index) >= count) {
    ThrowInputError("{}: sub-map {} of {} makes no sense", reader->path(), cells->index, count);
  }
  cells->cells.resize(count);
  for (SceneCell& cell : cells->cells) {
    cell.Visit(*reader);
    if (!(cell.max.array() > cell.min.array()).all()) {
      ThrowInputError("{}: a sub-map's cell is empty", reader->path());
    }
  }
}

void WriteCells(const SceneCells& cells, Writer* writer) {
  writer->Value(static_cast<std::int32_t>(cells.index));
  writer->Value(static_cast<std::uint32_t>(cells.cells.size()));
  for (SceneCell cell : cells.cells) {
    cell.Visit(*writer);
  }
}

void WriteBody(const RadianceField& field, Writer* writer) {
  FieldOptions options = field.options;
  MarchOptions march = field.march;
  options.Visit(*writer);
  march.Visit(*writer);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    writer->Value(field.box.min[axis]);
    writer->Value(field.box.max[axis]);
  }
  writer->Value(static_cast<std::int32_t>(field.channels));
  WriteFloats(field.geometry.parameters(), writer);
  WriteFloats(field.appearance.parameters(), writer);
  WriteFloats(field.density.parameters(), writer);
  WriteFloats(field.color.parameters(), writer);
  WriteFloats(field.background.parameters(), writer);
  WriteFloats(field.background_color.parameters(), writer);
  writer->Value(static_cast<std::uint64_t>(field.occupancy.words().size()));
  writer->Bytes(field.occupancy.words().data(), field.occupancy.words().size() * 8);
  writer->Value(static_cast<std::uint64_t>(field.exposures.size()));
  for (const Exposure& exposure : field.exposures) {
    writer->Value(static_cast<std::uint32_t>(exposure.image.size()));
    writer->Bytes(exposure.image.data(), exposure.image.size());
    writer->Value(exposure.stamp_ns);
    writer->Value(exposure.gain);
    writer->Value(exposure.bias);
    writer->Bytes(exposure.latent.data(), exposure.latent.size() * sizeof(float));
  }
  for (const float k : field.vignetting.k) {
    writer->Value(k);
  }
  writer->Value(field.progress);
  if (field.cells.IsCut()) {
    WriteCells(field.cells, writer);
  }
}

}  // namespace

void WriteField(const std::filesystem::path& path, const RadianceField& field) {
  Writer counter(nullptr);
  WriteBody(field, &counter);
  const std::uint32_t version = field.cells.IsCut() ? kCellsVersion : kVersion;
  const Header header{kMagic, version, 0, counter.size()};
  WriteFileAtomically(path, [&](std::ostream& out) {
    char raw[sizeof(Header)];
    std::memcpy(raw, &header, sizeof(Header));
    out.write(raw, sizeof(Header));
    Writer writer(&out);
    WriteBody(field, &writer);
    const std::uint64_t checksum = writer.checksum();
    char tail[sizeof(checksum)];
    std::memcpy(tail, &checksum, sizeof(checksum));
    out.write(tail, sizeof(tail));
  });
}

RadianceField ReadField(const std::filesystem::path& path) {
  Reader reader(path);
  const std::uint64_t size = reader.left();
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
  if (LeastBytes(options, (box.max - box.min) / box.Size()) > size) {
    ThrowInputError("{}: is too short for the model it describes", path.string());
  }
  RadianceField field(options, march, box, channels, 0);
  ReadFloats("geometry", &reader, &field.geometry.parameters());
  ReadFloats("appearance", &reader, &field.appearance.parameters());
  ReadFloats("density network", &reader, &field.density.parameters());
  ReadFloats("colour network", &reader, &field.color.parameters());
  ReadFloats("background", &reader, &field.background.parameters());
  ReadFloats("background network", &reader, &field.background_color.parameters());
  field.background_color.UpdateTranspose();
  field.density.UpdateTranspose();
  field.color.UpdateTranspose();
  const auto word_count = reader.Value<std::uint64_t>();
  if (word_count != field.occupancy.words().size()) {
    ThrowInputError("{}: {} occupancy words, expected {}",
                    path.string(),
                    word_count,
                    field.occupancy.words().size());
  }
  std::vector<std::uint64_t> words(word_count);
  reader.Bytes(words.data(), word_count * 8);
  field.occupancy.SetWords(std::move(words));
  ReadExposures(&reader, &field);
  for (float& k : field.vignetting.k) {
    k = reader.Value<float>();
  }
  field.progress = reader.Value<float>();
  if (reader.has_cells()) {
    ReadCells(&reader, &field.cells);
  }
  reader.Finish();
  if (!(field.progress >= 0 && field.progress <= 1)) {
    ThrowInputError("{}: its progress {} is not in [0, 1]", path.string(), field.progress);
  }
  return field;
}

}  // namespace deja_view::nerf
