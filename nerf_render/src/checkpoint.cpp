#include "deja_view/nerf/checkpoint.hpp"

#include "deja_view/base/binary_stream.hpp"
#include "deja_view/base/requirements.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deja_view::nerf {
namespace {

constexpr BinaryFormat kFormat{{'D', 'V', 'N', 'E', 'R', 'F', '\r', '\n'}, 5, "a NeRF model"};

template <typename Floats>
void ReadFloats(const char* what, BinaryReader* reader, Floats* values) {
  const auto size = reader->Read<std::uint64_t>(what);
  if (size != values->size()) {
    reader->Fail(what, fmt::format("{} parameters, expected {}", size, values->size()));
  }
  reader->ReadBytes(values->data(), values->size() * sizeof(float), what);
  if (!std::all_of(values->data(), values->data() + values->size(), [](float v) {
        return std::isfinite(v);
      })) {
    reader->Fail(what, "parameters that are not finite");
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

void WriteExposures(const std::vector<Exposure>& exposures, BinaryWriter* writer) {
  writer->Write(static_cast<std::uint64_t>(exposures.size()));
  for (const Exposure& exposure : exposures) {
    writer->Write(static_cast<std::uint32_t>(exposure.image.size()));
    writer->WriteBytes(exposure.image.data(), exposure.image.size());
    writer->Write(exposure.stamp_ns);
    writer->Write(exposure.gain);
    writer->Write(exposure.bias);
    writer->WriteBytes(exposure.latent.data(), exposure.latent.size() * sizeof(float));
  }
}

void ReadExposures(BinaryReader* reader, RadianceField* field) {
  const auto count = reader->Read<std::uint64_t>("number of images");
  for (std::uint64_t i = 0; i < count; ++i) {
    Exposure exposure;
    const auto length = reader->Read<std::uint32_t>("image name");
    if (length > reader->left()) {
      reader->Fail("image name", "longer than the file");
    }
    exposure.image.resize(length);
    reader->ReadBytes(exposure.image.data(), length, "image name");
    exposure.stamp_ns = reader->Read<std::int64_t>("image stamp");
    exposure.gain = reader->Read<float>("image gain");
    exposure.bias = reader->Read<float>("image bias");
    exposure.latent.resize(static_cast<std::size_t>(field->options.latent_size));
    reader->ReadBytes(
        exposure.latent.data(), exposure.latent.size() * sizeof(float), "image latent code");
    field->exposures.push_back(std::move(exposure));
  }
}

void WriteCells(const SceneCells& cells, BinaryWriter* writer) {
  writer->Write(static_cast<std::int32_t>(cells.index));
  writer->Write(static_cast<std::uint32_t>(cells.cells.size()));
  for (SceneCell cell : cells.cells) {
    cell.Visit(*writer);
  }
}

void ReadCells(BinaryReader* reader, SceneCells* cells) {
  cells->index = reader->Read<std::int32_t>("sub-map");
  const auto count = reader->Read<std::uint32_t>("number of sub-maps");
  if (count == 0 && cells->index == 0) {
    return;  // a scene in one piece
  }
  if (count > reader->left() / (6 * sizeof(double)) || cells->index < 0 ||
      static_cast<std::uint32_t>(cells->index) >= count) {
    reader->Fail("sub-map", fmt::format("{} of {} makes no sense", cells->index, count));
  }
  cells->cells.resize(count);
  for (SceneCell& cell : cells->cells) {
    cell.Visit(*reader);
    if (!(cell.max.array() > cell.min.array()).all()) {
      reader->Fail("sub-map", "a cell that is empty");
    }
  }
}

void WriteFrame(const FieldFrame& frame, BinaryWriter* writer) {
  writer->Write(frame.is_known);
  writer->Write(frame.W_N.scale);
  for (const double v : frame.W_N.T_A_B.t) {
    writer->Write(v);
  }
  for (const double v : frame.W_N.T_A_B.q.coeffs()) {
    writer->Write(v);
  }
}

void ReadFrame(BinaryReader* reader, FieldFrame* frame) {
  frame->is_known = reader->Read<bool>("frame is known");
  Similarity3& W_N = frame->W_N;
  W_N.scale = reader->Read<double>("frame");
  for (Eigen::Index i = 0; i < 3; ++i) {
    W_N.T_A_B.t[i] = reader->Read<double>("frame");
  }
  for (Eigen::Index i = 0; i < 4; ++i) {
    W_N.T_A_B.q.coeffs()[i] = reader->Read<double>("frame");
  }
  constexpr double kTolerance = 1e-6;
  if (!(W_N.scale > 0) || !std::isfinite(W_N.scale) || !W_N.T_A_B.IsFinite() ||
      !(std::abs(W_N.T_A_B.q.norm() - 1) < kTolerance)) {
    reader->Fail("frame", fmt::format("(scale {}) makes no sense", W_N.scale));
  }
}

void WriteBody(const RadianceField& field, BinaryWriter* writer) {
  FieldOptions options = field.options;
  MarchOptions march = field.march;
  options.Visit(*writer);
  march.Visit(*writer);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    writer->Write(field.box.min[axis]);
    writer->Write(field.box.max[axis]);
  }
  writer->Write(static_cast<std::int32_t>(field.channels));
  writer->WriteAll(field.geometry.parameters());
  writer->WriteAll(field.appearance.parameters());
  writer->WriteAll(field.density.parameters());
  writer->WriteAll(field.color.parameters());
  writer->WriteAll(field.background.parameters());
  writer->WriteAll(field.background_color.parameters());
  writer->WriteAll(field.occupancy.words());
  WriteExposures(field.exposures, writer);
  for (const float k : field.vignetting.k) {
    writer->Write(k);
  }
  writer->Write(field.progress);
  WriteCells(field.cells, writer);
  WriteFrame(field.frame, writer);
}

// Options and box, which say how large the rest is.
RadianceField ReadHead(BinaryReader* reader) {
  const std::uint64_t size = reader->left();
  FieldOptions options;
  MarchOptions march;
  SceneBox box;
  options.Visit(*reader);
  march.Visit(*reader);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    box.min[axis] = reader->Read<double>("box");
    box.max[axis] = reader->Read<double>("box");
  }
  const auto channels = reader->Read<std::int32_t>("channels");
  RejectAny(options.Validate(), reader->path().c_str());
  RejectAny(march.Validate(), reader->path().c_str());
  if (!box.min.allFinite() || !box.max.allFinite() || !(box.max.array() > box.min.array()).all()) {
    reader->Fail("box", "makes no sense");
  }
  if (channels != 1 && channels != 3) {
    reader->Fail("channels", "neither 1 nor 3");
  }
  if (LeastBytes(options, (box.max - box.min) / box.Size()) > size) {
    reader->Fail("parameters", "the file is too short for the model it describes");
  }
  return {options, march, box, channels, 0};
}

void ReadParameters(BinaryReader* reader, RadianceField* field) {
  ReadFloats("geometry", reader, &field->geometry.parameters());
  ReadFloats("appearance", reader, &field->appearance.parameters());
  ReadFloats("density network", reader, &field->density.parameters());
  ReadFloats("colour network", reader, &field->color.parameters());
  ReadFloats("background", reader, &field->background.parameters());
  ReadFloats("background network", reader, &field->background_color.parameters());
  field->background_color.UpdateTranspose();
  field->density.UpdateTranspose();
  field->color.UpdateTranspose();
  auto words = reader->ReadAll<std::uint64_t>("occupancy");
  if (words.size() != field->occupancy.words().size()) {
    reader->Fail(
        "occupancy",
        fmt::format("{} words, expected {}", words.size(), field->occupancy.words().size()));
  }
  field->occupancy.SetWords(std::move(words));
}

}  // namespace

void WriteField(const std::filesystem::path& path, const RadianceField& field) {
  WriteBinaryFile(path, kFormat, [&](BinaryWriter* writer) { WriteBody(field, writer); });
}

RadianceField ReadField(const std::filesystem::path& path) {
  BinaryReader reader(path, kFormat);
  RadianceField field = ReadHead(&reader);
  ReadParameters(&reader, &field);
  ReadExposures(&reader, &field);
  for (float& k : field.vignetting.k) {
    k = reader.Read<float>("vignetting");
  }
  field.progress = reader.Read<float>("progress");
  if (!(field.progress >= 0 && field.progress <= 1)) {
    reader.Fail("progress", "not in [0, 1]");
  }
  ReadCells(&reader, &field.cells);
  ReadFrame(&reader, &field.frame);
  reader.Finish();
  return field;
}

}  // namespace deja_view::nerf
