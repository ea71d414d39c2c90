#include "map_records.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/camera/camera_parameters.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace deja_view {
namespace {

void WritePose(const Rigid3& T, BinaryWriter* out) {
  out->Write(ScalarFirst(T.q));
  out->Write(Numbers(T.t));
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
    vectors[i] = Eigen::Map<const Eigen::Matrix<float, N, 1>>(&flat[i * N]);
    if (!vectors[i].allFinite()) {
      in->Fail(field, "not finite");
    }
  }
  return vectors;
}

/// Pixels index grids over the image later on.
bool AreInImage(const std::vector<Eigen::Vector2f>& pixels, const Camera& camera) {
  return std::all_of(pixels.begin(), pixels.end(), [&](const Eigen::Vector2f& pixel) {
    return camera.IsInImage(pixel.cast<double>(), -1.0);
  });
}

}  // namespace

void WriteKeyframe(const KeyframeMap& keyframes, int keyframe, BinaryWriter* out) {
  const KeyframeMap::Keyframe& k = keyframes[keyframe];
  const PoseGraphNode node = keyframes.node(keyframe);
  const KeyframeFeatures nothing;
  const KeyframeFeatures& f = k.is_place ? keyframes.features(keyframe) : nothing;
  out->Write(k.stamp_ns);
  out->Write(static_cast<std::int32_t>(node.sequence));
  out->Write(k.is_place);
  WritePose(node.T_W_B, out);
  out->Write(node.psi);
  WritePose(node.T_M_B(), out);
  WritePose(keyframes.T_B_C(keyframe), out);
  out->WriteAll(Flatten<2>(f.keypoints));
  out->WriteAll(f.descriptors);
  out->WriteAll(Flatten<3>(f.points_B));
  out->WriteAll(Flatten<2>(f.point_pixels));
  out->WriteAll(f.point_depth_sigmas);
  out->WriteAll(f.point_ids);
  out->WriteAll(f.point_descriptors);
}

void ReadKeyframe(BinaryReader* in, const Camera& camera, StoredKeyframe* k, PoseGraphNode* node) {
  k->stamp_ns = in->Read<std::int64_t>("keyframe stamp");
  node->sequence = in->Read<std::int32_t>("keyframe sequence");
  k->is_place = in->Read<bool>("keyframe place");
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
  if (!AreInImage(f.keypoints, camera) || !AreInImage(f.point_pixels, camera)) {
    in->Fail("keyframe features", "pixels outside the image");
  }
}

void WriteLoop(const LoopReport& loop, BinaryWriter* out) {
  out->Write(static_cast<std::int32_t>(loop.old));
  out->Write(static_cast<std::int32_t>(loop.current));
  WritePose(loop.T_Bold_Bcurrent, out);
  for (Eigen::Index i = 0; i < loop.covariance.size(); ++i) {
    out->Write(loop.covariance.data()[i]);
  }
  out->Write(PoseGraphLoop{}.weight);
  out->Write(loop.score);
  out->Write(static_cast<std::int32_t>(loop.matches));
  out->Write(static_cast<std::int32_t>(loop.inliers));
  out->Write(loop.is_virtual);
}

PoseGraphLoop ReadLoop(BinaryReader* in,
                       const std::vector<StoredKeyframe>& keyframes,
                       LoopReport* report) {
  const auto count = static_cast<int>(keyframes.size());
  PoseGraphLoop loop;
  loop.from = in->Read<std::int32_t>("loop from");
  loop.to = in->Read<std::int32_t>("loop to");
  if (loop.from < 0 || loop.from >= count || loop.to < 0 || loop.to >= count) {
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
  report->stamp_old_ns = keyframes[static_cast<std::size_t>(loop.from)].stamp_ns;
  report->stamp_current_ns = keyframes[static_cast<std::size_t>(loop.to)].stamp_ns;
  report->T_Bold_Bcurrent = loop.T_from_to;
  report->covariance = loop.covariance;
  report->score = in->Read<double>("loop score");
  report->matches = in->Read<std::int32_t>("loop matches");
  report->inliers = in->Read<std::int32_t>("loop inliers");
  report->is_virtual = in->Read<bool>("loop views");
  return loop;
}

void WriteView(int keyframe, const StoredView& view, BinaryWriter* out) {
  const CameraParameters camera = DescribeCamera(*view.camera);
  out->Write(static_cast<std::int32_t>(keyframe));
  out->Write(view.index);
  WritePose(view.T_C_V, out);
  out->WriteAll(camera.model);
  out->Write(static_cast<std::int32_t>(camera.width));
  out->Write(static_cast<std::int32_t>(camera.height));
  out->WriteAll(camera.distortion);
  out->WriteAll(camera.projection);
  out->WriteAll(view.keypoints);
  out->WriteAll(view.descriptors);
}

StoredView ReadView(BinaryReader* in, std::size_t keyframe_count, int* keyframe) {
  const auto index = in->Read<std::int32_t>("view's keyframe");
  if (index < 0 || static_cast<std::size_t>(index) >= keyframe_count) {
    in->Fail("view's keyframe", "names a keyframe that is not there");
  }
  *keyframe = index;
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

void WriteWords(const PackedBow& words, BinaryWriter* out) {
  out->WriteAll(words.words);
  out->WriteAll(words.counts);
  out->WriteAll(words.weights);
}

PackedBow ReadWords(BinaryReader* in, std::size_t descriptor_count, const PlaceFinder& finder) {
  PackedBow words;
  words.words = in->ReadAll<WordId>("words");
  words.counts = in->ReadAll<std::uint16_t>("word counts");
  words.weights = in->ReadAll<float>("word weights");
  if (words.counts.size() != words.words.size() ||
      words.weights.size() != (finder.weighs_words() ? words.words.size() : 0)) {
    in->Fail("words", "lists of different lengths");
  }
  const std::size_t vocabulary_size = finder.vocabulary_size();
  std::size_t counted = 0;
  for (std::size_t i = 0; i < words.words.size(); ++i) {
    const bool is_sorted = i == 0 || words.words[i - 1] < words.words[i];
    if (!is_sorted || words.words[i] >= vocabulary_size || words.counts[i] == 0) {
      in->Fail("words", "not of the vocabulary, each once and in their order");
    }
    counted += words.counts[i];
  }
  if (counted != descriptor_count) {
    in->Fail("word counts", "not those of the descriptors");
  }
  const auto is_weight = [](float weight) { return weight >= 0 && weight <= 1.0001F; };
  if (!std::all_of(words.weights.begin(), words.weights.end(), is_weight)) {
    in->Fail("word weights", "not those of a vector of length 1");
  }
  words.descriptor_count = static_cast<std::uint32_t>(descriptor_count);
  return words;
}

}  // namespace deja_view
