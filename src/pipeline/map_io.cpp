#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <utility>

#include "binary_io.hpp"
#include "loop_closer_impl.hpp"

namespace deja_view {
namespace {

namespace fs = std::filesystem;

// File: magic, version, checksum of the rest; then the body that WriteBody writes.
constexpr std::uint64_t kMagic = 0x50414d5645414a44U;  // "DJAEVMAP"
// Version 1 is a map without virtual views, 2 one with them after the loops.
constexpr std::uint32_t kVersionPlain = 1;
constexpr std::uint32_t kVersionViews = 2;
constexpr const char* kFileName = "map.dvm";

/// 64-bit FNV-1a over 8-byte words: enough to notice a damaged file.
std::uint64_t Checksum(const char* data, std::size_t size) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  std::size_t i = 0;
  for (; i + 8 <= size; i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, data + i, 8);
    hash = (hash ^ word) * 0x100000001b3U;
    hash ^= hash >> 29U;
  }
  for (; i < size; ++i) {
    hash = (hash ^ static_cast<std::uint8_t>(data[i])) * 0x100000001b3U;
  }
  return hash;
}

void WritePose(const Rigid3& T, BinaryWriter* out) {
  for (const double value : {T.q.w(), T.q.x(), T.q.y(), T.q.z(), T.t.x(), T.t.y(), T.t.z()}) {
    out->Write(value);
  }
}

Rigid3 ReadPose(BinaryReader* in, const char* field) {
  std::array<double, 7> v{};
  for (double& value : v) {
    value = in->Read<double>(field);
  }
  const Rigid3 T{{v[0], v[1], v[2], v[3]}, {v[4], v[5], v[6]}};
  if (!T.IsFinite() || std::abs(T.q.norm() - 1.0) > 1e-6) {
    in->Fail(field, "not a finite rigid transform");
  }
  return T;
}

// Eigen's vectors are not trivially copyable: written as flat floats.
template <int N>
std::vector<float> Flatten(const std::vector<Eigen::Matrix<float, N, 1>>& vectors) {
  std::vector<float> flat;
  flat.reserve(vectors.size() * N);
  for (const auto& v : vectors) {
    flat.insert(flat.end(), v.data(), v.data() + N);
  }
  return flat;
}

template <int N>
std::vector<Eigen::Matrix<float, N, 1>> ReadVectors(BinaryReader* in, const char* field) {
  const auto flat = in->ReadAll<float>(field);
  std::vector<Eigen::Matrix<float, N, 1>> vectors(flat.size() / N);
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    for (int k = 0; k < N; ++k) {
      vectors[i][k] = flat[i * N + static_cast<std::size_t>(k)];
      if (!std::isfinite(vectors[i][k])) {
        in->Fail(field, "not finite");
      }
    }
  }
  return vectors;
}

void WriteKeyframe(const StoredKeyframe& k, const PoseGraphNode& node, BinaryWriter* out) {
  out->Write(k.stamp_ns);
  out->Write(static_cast<std::int32_t>(k.sequence));
  out->Write(static_cast<std::uint8_t>(k.is_place ? 1 : 0));
  WritePose(node.T_W_B, out);
  out->Write(node.psi);
  WritePose(node.T_M_B(), out);
  WritePose(k.features.T_B_C, out);
  out->WriteAll(Flatten<2>(k.features.keypoints));
  out->WriteAll(k.features.descriptors);
  out->WriteAll(Flatten<3>(k.features.points_B));
  out->WriteAll(Flatten<2>(k.features.point_pixels));
  out->WriteAll(k.features.point_depth_sigmas);
  out->WriteAll(k.features.point_ids);
  out->WriteAll(k.features.point_descriptors);
}

void ReadKeyframe(BinaryReader* in, StoredKeyframe* k, PoseGraphNode* node) {
  k->stamp_ns = in->Read<std::int64_t>("keyframe stamp");
  k->sequence = in->Read<std::int32_t>("keyframe sequence");
  k->is_place = in->Read<std::uint8_t>("keyframe flags") != 0;
  node->sequence = k->sequence;
  node->is_fixed = true;
  node->T_W_B = ReadPose(in, "keyframe VIO pose");
  node->psi = in->Read<double>("keyframe correction");
  node->t_M_B = ReadPose(in, "keyframe map pose").t;
  k->features.T_B_C = ReadPose(in, "keyframe extrinsics");
  k->features.keypoints = ReadVectors<2>(in, "keypoints");
  k->features.descriptors = in->ReadAll<Descriptor>("descriptors");
  k->features.points_B = ReadVectors<3>(in, "points");
  k->features.point_pixels = ReadVectors<2>(in, "point pixels");
  k->features.point_depth_sigmas = in->ReadAll<float>("point depth sigmas");
  k->features.point_ids = in->ReadAll<std::int64_t>("point ids");
  k->features.point_descriptors = in->ReadAll<Descriptor>("point descriptors");
  const KeyframeFeatures& f = k->features;
  if (f.keypoints.size() != f.descriptors.size() || f.points_B.size() != f.point_pixels.size() ||
      f.points_B.size() != f.point_depth_sigmas.size() || f.points_B.size() != f.point_ids.size() ||
      f.points_B.size() != f.point_descriptors.size()) {
    in->Fail("keyframe features", "lists of different lengths");
  }
  if (!std::isfinite(node->psi)) {
    in->Fail("keyframe correction", "not finite");
  }
}

void WriteLoop(const PoseGraphLoop& loop, const LoopReport& report, BinaryWriter* out) {
  out->Write(static_cast<std::int32_t>(loop.from));
  out->Write(static_cast<std::int32_t>(loop.to));
  WritePose(loop.T_from_to, out);
  for (Eigen::Index i = 0; i < loop.covariance.size(); ++i) {
    out->Write(loop.covariance.data()[i]);
  }
  out->Write(loop.weight);
  out->Write(report.score);
  out->Write(static_cast<std::int32_t>(report.matches));
  out->Write(static_cast<std::int32_t>(report.inliers));
  out->Write(static_cast<std::uint8_t>(report.is_virtual ? 1 : 0));
}

PoseGraphLoop ReadLoop(BinaryReader* in, int keyframe_count, LoopReport* report) {
  PoseGraphLoop loop;
  loop.from = in->Read<std::int32_t>("loop from");
  loop.to = in->Read<std::int32_t>("loop to");
  if (loop.from < 0 || loop.from >= keyframe_count || loop.to < 0 || loop.to >= keyframe_count) {
    in->Fail("loop", "names a keyframe that is not there");
  }
  loop.T_from_to = ReadPose(in, "loop pose");
  for (Eigen::Index i = 0; i < loop.covariance.size(); ++i) {
    loop.covariance.data()[i] = in->Read<double>("loop covariance");
  }
  loop.weight = in->Read<double>("loop weight");
  if (!loop.covariance.allFinite() || !std::isfinite(loop.weight)) {
    in->Fail("loop covariance", "not finite");
  }
  report->old = loop.from;
  report->current = loop.to;
  report->T_Bold_Bcurrent = loop.T_from_to;
  report->covariance = loop.covariance;
  report->score = in->Read<double>("loop score");
  report->matches = in->Read<std::int32_t>("loop matches");
  report->inliers = in->Read<std::int32_t>("loop inliers");
  report->is_virtual = in->Read<std::uint8_t>("loop flags") != 0;
  return loop;
}

void WriteView(std::size_t keyframe, const StoredView& view, BinaryWriter* out) {
  const CameraParameters camera = DescribeCamera(*view.camera);
  out->Write(static_cast<std::int32_t>(keyframe));
  out->Write(view.index);
  WritePose(view.T_C_V, out);
  out->WriteAll(std::vector<char>(camera.model.begin(), camera.model.end()));
  out->Write(static_cast<std::int32_t>(camera.width));
  out->Write(static_cast<std::int32_t>(camera.height));
  out->WriteAll(camera.distortion);
  out->WriteAll(camera.projection);
  out->WriteAll(view.keypoints);
  out->WriteAll(view.descriptors);
}

StoredView ReadView(BinaryReader* in, std::size_t keyframe_count, std::size_t* keyframe) {
  const auto index = in->Read<std::int32_t>("view's keyframe");
  if (index < 0 || static_cast<std::size_t>(index) >= keyframe_count) {
    in->Fail("view's keyframe", "names a keyframe that is not there");
  }
  *keyframe = static_cast<std::size_t>(index);
  StoredView view;
  view.index = in->Read<std::int32_t>("view index");
  view.T_C_V = ReadPose(in, "view pose");
  CameraParameters camera;
  const auto model = in->ReadAll<char>("view camera model");
  camera.model.assign(model.begin(), model.end());
  camera.width = in->Read<std::int32_t>("view camera width");
  camera.height = in->Read<std::int32_t>("view camera height");
  camera.distortion = in->ReadAll<double>("view camera distortion");
  camera.projection = in->ReadAll<double>("view camera projection");
  try {
    view.camera = MakeCamera(camera, "camera");
  } catch (const InputError& e) {
    in->Fail("view camera", e.what());
  }
  view.keypoints = in->ReadAll<PackedKeypoint>("view keypoints");
  view.descriptors = in->ReadAll<Descriptor>("view descriptors");
  if (view.index < 0 || view.keypoints.size() != view.descriptors.size()) {
    in->Fail("view", "lists of different lengths, or no index");
  }
  for (const PackedKeypoint& k : view.keypoints) {
    const Eigen::Vector2d pixel(static_cast<double>(k.u) / double{PackedKeypoint::kPerPixel},
                                static_cast<double>(k.v) / double{PackedKeypoint::kPerPixel});
    if (!view.camera->IsInImage(pixel)) {
      in->Fail("view keypoints", "pixels outside the image");
    }
  }
  return view;
}

/// Pixels index grids over the image later on.
bool AreInImage(const std::vector<Eigen::Vector2f>& pixels, const Camera& camera) {
  return std::all_of(pixels.begin(), pixels.end(), [&](const Eigen::Vector2f& pixel) {
    return camera.IsInImage(pixel.cast<double>(), -1.0);
  });
}

std::string ReadFile(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    ThrowInputError("{}: can't be read; expected a saved map", path.string());
  }
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

void LoopCloser::Impl::Save(const fs::path& directory) const {
  BinaryWriter body;
  const std::string descriptor = vocabulary->descriptor_name();
  body.WriteAll(std::vector<char>(descriptor.begin(), descriptor.end()));
  body.Write(static_cast<std::int32_t>(camera->width()));
  body.Write(static_cast<std::int32_t>(camera->height()));
  body.Write(static_cast<std::uint64_t>(keyframes.size()));
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    WriteKeyframe(keyframes[i], graph.nodes()[i], &body);
  }
  body.Write(static_cast<std::uint64_t>(accepted.size()));
  for (std::size_t i = 0; i < accepted.size(); ++i) {
    WriteLoop(graph.loops()[i], accepted[i], &body);
  }
  if (view_counts.kept > 0) {
    body.Write(static_cast<std::uint64_t>(view_counts.kept));
    for (std::size_t i = 0; i < keyframes.size(); ++i) {
      for (const StoredView& view : keyframes[i].views) {
        WriteView(i, view, &body);
      }
    }
  }
  BinaryWriter head;
  head.Write(kMagic);
  head.Write(view_counts.kept > 0 ? kVersionViews : kVersionPlain);
  head.Write(Checksum(body.bytes().data(), body.bytes().size()));
  WriteFileAtomically(directory / kFileName, [&](std::ostream& out) {
    out.write(head.bytes().data(), static_cast<std::streamsize>(head.bytes().size()));
    out.write(body.bytes().data(), static_cast<std::streamsize>(body.bytes().size()));
  });
}

LoopCloser::Impl::LoadedMap LoopCloser::Impl::ReadMap(const fs::path& directory) const {
  const fs::path path = directory / kFileName;
  const std::string bytes = ReadFile(path);
  BinaryReader in(bytes, path.string());
  if (in.Read<std::uint64_t>("magic") != kMagic) {
    in.Fail("magic", "not a saved map");
  }
  const auto version = in.Read<std::uint32_t>("version");
  if (version != kVersionPlain && version != kVersionViews) {
    in.Fail("version", "a map of another version than this program's");
  }
  const auto checksum = in.Read<std::uint64_t>("checksum");
  constexpr std::size_t kHead = 20;
  if (checksum != Checksum(bytes.data() + kHead, bytes.size() - kHead)) {
    in.Fail("checksum", "the file is damaged");
  }
  const auto name = in.ReadAll<char>("descriptor name");
  if (std::string(name.begin(), name.end()) != vocabulary->descriptor_name()) {
    in.Fail("descriptor name", "the map was made with another descriptor than the vocabulary's");
  }
  if (in.Read<std::int32_t>("image width") != camera->width() ||
      in.Read<std::int32_t>("image height") != camera->height()) {
    in.Fail("image size", "the map was made with another camera");
  }
  LoadedMap map;
  const auto count = in.Read<std::uint64_t>("number of keyframes");
  std::vector<PoseGraphNode> nodes;
  for (std::uint64_t i = 0; i < count; ++i) {
    StoredKeyframe keyframe;
    PoseGraphNode node;
    ReadKeyframe(&in, &keyframe, &node);
    if (!AreInImage(keyframe.features.keypoints, *camera) ||
        !AreInImage(keyframe.features.point_pixels, *camera)) {
      in.Fail("keyframe features", "pixels outside the image");
    }
    const int expected = map.keyframes.empty() ? 0 : map.keyframes.back().sequence;
    if (keyframe.sequence != expected && keyframe.sequence != expected + 1) {
      in.Fail("keyframe sequence", "not numbered in order");
    }
    map.keyframes.push_back(std::move(keyframe));
    nodes.push_back(node);
  }
  const auto loop_count = in.Read<std::uint64_t>("number of loops");
  std::vector<PoseGraphLoop> loops;
  for (std::uint64_t i = 0; i < loop_count; ++i) {
    LoopReport report;
    loops.push_back(ReadLoop(&in, static_cast<int>(count), &report));
    report.stamp_old_ns = map.keyframes[static_cast<std::size_t>(report.old)].stamp_ns;
    report.stamp_current_ns = map.keyframes[static_cast<std::size_t>(report.current)].stamp_ns;
    map.accepted.push_back(report);
  }
  const auto view_count =
      version == kVersionViews ? in.Read<std::uint64_t>("number of views") : std::uint64_t{0};
  for (std::uint64_t i = 0; i < view_count; ++i) {
    std::size_t keyframe = 0;
    StoredView view = ReadView(&in, map.keyframes.size(), &keyframe);
    for (const StoredView& other : map.keyframes[keyframe].views) {
      if (other.index == view.index) {
        in.Fail("view index", "two views of one keyframe have it");
      }
    }
    map.keyframes[keyframe].views.push_back(std::move(view));
  }
  if (!in.AtEnd()) {
    in.Fail("end", "bytes follow that should not be there");
  }
  map.graph = PoseGraph::FromParts(options.pose_graph, std::move(nodes), std::move(loops));
  return map;
}

// Looks all words up again and fills what is known about the keyframes by other keys.
void LoopCloser::Impl::IndexMap() {
  places = PlaceDatabase(options.place, vocabulary);
  if (scored_places_) {
    scored_places_->Clear();
    predecessors_.clear();
  }
  cameras_ = CameraTable();
  stamps_.clear();
  view_bytes_ = view_words_ = place_words_ = 0;
  view_counts = ViewCounts{};
  view_counts.waiting = static_cast<std::int64_t>(waiting_views_.size());
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    StoredKeyframe& k = keyframes[i];
    stamps_[k.stamp_ns] = i;
    std::vector<StoredView> views = std::exchange(k.views, {});
    if (!k.is_place) {
      continue;
    }
    AddPlace(static_cast<int>(i), vocabulary->Bag(k.features.descriptors), 0);
    if (views.size() > static_cast<std::size_t>(options.views.keep)) {
      views.resize(static_cast<std::size_t>(options.views.keep));
    }
    for (StoredView& view : views) {
      view.camera = cameras_.Share(view.camera);
      IndexView(i, std::move(view));
      ++view_counts.kept;
    }
  }
}

void LoopCloser::Impl::Load(const fs::path& directory) {
  LoadedMap map = ReadMap(directory);
  TakeDueSolution(true, nullptr);
  keyframes = std::move(map.keyframes);
  graph = std::move(map.graph);
  accepted = std::move(map.accepted);
  IndexMap();
  consistency = LoopConsistency(options.consistency);
  reports.clear();
  loops_since_solve_ = 0;
  is_surprised_ = false;
  last_localised_ = -1;
  // The first keyframe after a load starts a sequence of its own.
  sequence = keyframes.empty() ? -1 : keyframes.back().sequence;
  starts_sequence_ = true;
}

}  // namespace deja_view
