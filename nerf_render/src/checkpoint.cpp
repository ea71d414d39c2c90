#include "deja_view/nerf/checkpoint.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "model_stream.hpp"

namespace deja_view::nerf {
namespace {

using internal::Header;
using internal::kCellsVersion;
using internal::kFrameVersion;
using internal::kMagic;
using internal::kVersion;
using internal::Reader;
using internal::Writer;

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
  const bool is_none = count == 0 && cells->index == 0 && reader->version() > kCellsVersion;
  if (is_none) {
    return;
  }
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

void ReadFrame(Reader* reader, FieldFrame* frame) {
  frame->is_known = reader->Value<bool>();
  Similarity3& W_N = frame->W_N;
  W_N.scale = reader->Value<double>();
  for (Eigen::Index i = 0; i < 3; ++i) {
    W_N.T_A_B.t[i] = reader->Value<double>();
  }
  for (Eigen::Index i = 0; i < 4; ++i) {
    W_N.T_A_B.q.coeffs()[i] = reader->Value<double>();
  }
  constexpr double kTolerance = 1e-6;
  if (!(W_N.scale > 0) || !std::isfinite(W_N.scale) || !W_N.T_A_B.IsFinite() ||
      !(std::abs(W_N.T_A_B.q.norm() - 1) < kTolerance)) {
    ThrowInputError("{}: its frame (scale {}) makes no sense", reader->path(), W_N.scale);
  }
}

void WriteFrame(const FieldFrame& frame, Writer* writer) {
  writer->Value(static_cast<std::uint8_t>(frame.is_known));
  writer->Value(frame.W_N.scale);
  for (const double v : frame.W_N.T_A_B.t) {
    writer->Value(v);
  }
  for (const double v : frame.W_N.T_A_B.q.coeffs()) {
    writer->Value(v);
  }
}

std::uint32_t VersionOf(const RadianceField& field) {
  if (!field.frame.IsWorld()) {
    return kFrameVersion;
  }
  return field.cells.IsCut() ? kCellsVersion : kVersion;
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
  const std::uint32_t version = VersionOf(field);
  if (version >= kCellsVersion) {
    WriteCells(field.cells, writer);
  }
  if (version >= kFrameVersion) {
    WriteFrame(field.frame, writer);
  }
}

}  // namespace

void WriteField(const std::filesystem::path& path, const RadianceField& field) {
  Writer counter(nullptr);
  WriteBody(field, &counter);
  const Header header{kMagic, VersionOf(field), 0, counter.size()};
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
  if (reader.version() >= kCellsVersion) {
    ReadCells(&reader, &field.cells);
  }
  if (reader.version() >= kFrameVersion) {
    ReadFrame(&reader, &field.frame);
  }
  reader.Finish();
  if (!(field.progress >= 0 && field.progress <= 1)) {
    ThrowInputError("{}: its progress {} is not in [0, 1]", path.string(), field.progress);
  }
  return field;
}

}  // namespace deja_view::nerf
