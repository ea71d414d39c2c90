#pragma once

#include "deja_view/base/enum_names.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/host/extrinsic_history.hpp"
#include "deja_view/host/image_source.hpp"
#include "deja_view/host/keyframe_input.hpp"
#include "deja_view/host/restart_detector.hpp"

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace deja_view {

/// Bounds of KeyframeAssembler.
struct KeyframeAssemblerOptions {
  /// Memory for images that are held while their keyframe messages are on the way [MB]. VINS-Mono
  /// sends a keyframe 0.1 to 0.5 s after its image; a slow computer needs more.
  double image_memory_mb = 300;
  /// Keyframe poses held while their image or points are on the way, and points while their pose
  /// is.
  int max_pending = 50;
  /// A topic that is silent for this long, against the newest poses, no longer holds up a keyframe
  /// [s].
  double timeout_s = 3.0;
  /// So many later messages of one topic prove that a missing one of that topic will not come; one
  /// stray stamp proves nothing.
  int later_messages = 2;
  /// A longer pause of the image stream means that the VIO may have moved unseen: a new sequence
  /// [s]. So does one of the VIO after which it has no track left.
  double sequence_gap_s = 1.0;

  /// All violations, each with its key; empty when all is well.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("image_memory_mb", image_memory_mb);
    v("max_pending", max_pending);
    v("timeout_s", timeout_s);
    v("later_messages", later_messages);
    v("sequence_gap_s", sequence_gap_s);
  }
};

/// Messages of one stamp, put together.
struct AssembledKeyframe {
  std::int64_t stamp_ns = 0;         ///< as in the pose message
  Rigid3 T_W_B;                      ///< body pose in the VIO's world
  bool starts_sequence = false;      ///< after a pause of the image stream or a restart of the VIO
  bool is_restart = false;           ///< the latter
  ImageSource image;                 ///< never empty
  std::size_t image_bytes = 0;       ///< that the source holds in memory
  std::vector<TrackedPoint> points;  ///< empty when the point message is missing
  std::optional<Rigid3> T_B_C;       ///< newest calibration before this keyframe's stamp, if any

  /// Decodes the image. Throws what the image source throws.
  KeyframeInput ToInput() const;
};

/// Why the assembler let a message, or a keyframe, go.
enum class DropReason {
  kMissingImage,   ///< a keyframe without an image can't be used
  kMissingPoints,  ///< the keyframe is used all the same, without points
  kDuplicate,      ///< a second message with that stamp
  kStrayStamp,     ///< a pose whose stamp does not fit between its neighbours'
  kOverflow,       ///< a bound of the options was reached before the missing message came
  kUnmatched,      ///< points to which no keyframe pose came
  kExtrinsicJump,  ///< a calibration too far from the one before; told once, then only counted
};

template <>
inline constexpr auto kEnumNames<DropReason> = EnumNames("missing_image",
                                                         "missing_points",
                                                         "duplicate",
                                                         "stray_stamp",
                                                         "overflow",
                                                         "unmatched",
                                                         "extrinsic_jump");

/// How many messages came and what became of them.
struct AssemblerCounts {
  std::int64_t images = 0;     ///< received
  std::int64_t poses = 0;      ///< received
  std::int64_t points = 0;     ///< received
  std::int64_t keyframes = 0;  ///< handed on, with or without points
  std::int64_t restarts = 0;   ///< of the VIO
  std::int64_t missing_image = 0;
  std::int64_t missing_points = 0;
  std::int64_t duplicates = 0;
  std::int64_t stray_stamps = 0;
  std::int64_t overflows = 0;
  std::int64_t unmatched = 0;
  std::int64_t extrinsic_jumps = 0;
};

/// Puts images, keyframe poses and keyframe points of the same stamp together, in any order of
/// arrival.
///
/// Keyframes come out in the order of their pose messages. What comes out depends only on the
/// messages of each topic, in that topic's own order, and not on how the topics interleave (within
/// the bounds of the options): a bag read at full speed and the same bag played through topics give
/// the same keyframes. Pose stamps that go back are taken for a restart of the VIO when two come in
/// a row; a single one is dropped. RestartDetector finds the restarts that the stamps do not tell.
/// Images that are no keyframe's are dropped without being decoded. Where each keyframe has a
/// calibration of its stamp, as OpenVINS', it waits for that, too.
///
/// Stamps match when they are equal as double seconds: VIOs compute with those, so that the stamps
/// they send may be rounded by up to 120 ns.
///
/// Not thread-safe.
class KeyframeAssembler {
 public:
  using KeyframeCallback = std::function<void(AssembledKeyframe)>;
  using DropCallback = std::function<void(DropReason reason, std::int64_t stamp_ns)>;

  /// Throws InputError, with all violations, for bad options. `on_drop` may be empty.
  KeyframeAssembler(const KeyframeAssemblerOptions& options,
                    KeyframeCallback on_keyframe,
                    DropCallback on_drop);

  /// `bytes` is what the source holds in memory.
  void AddImage(std::int64_t stamp_ns, ImageSource image, std::size_t bytes);
  void AddPose(std::int64_t stamp_ns, const Rigid3& T_W_B);
  void AddPoints(std::int64_t stamp_ns, std::vector<TrackedPoint> points);
  /// One that jumps is dropped (ExtrinsicHistory).
  void AddExtrinsic(std::int64_t stamp_ns, const Rigid3& T_B_C);

  /// End of the stream: hands on what is complete enough and drops the rest.
  void Flush();

  const AssemblerCounts& counts() const { return counts_; }

  /// The stamp as it looks after a trip through double seconds.
  static std::int64_t Key(std::int64_t stamp_ns);

 private:
  template <typename T>
  struct Stamped {
    std::int64_t key = 0;
    T value;
  };
  struct HeldImage {
    std::int64_t key = 0;
    ImageSource value;
    std::size_t bytes = 0;
  };
  struct Pending {
    std::int64_t key = 0;
    std::int64_t stamp_ns = 0;
    Rigid3 T_W_B;
    bool is_restart = false;
    ImageSource image;
    std::size_t image_bytes = 0;
    std::optional<std::vector<TrackedPoint>> points;
    int later_images = 0;  ///< messages after this pose with later stamps
    int later_points = 0;
    int later_poses = 0;  ///< with stamps later by the timeout
  };

  void Drop(DropReason reason, std::int64_t stamp_ns);
  bool IsKnown(std::int64_t key) const;
  bool IsHopeless(std::int64_t key) const;
  bool IsNewestPoseStray() const;
  void DropNewestPose();
  Pending* FindPending(std::int64_t key);
  void NoteImageStamp(std::int64_t key);
  void Push(Pending pending);
  void Settle();
  void Resolve(Pending pending);
  void ResolveAll();
  void NoteRestart(const Pending& pending);
  void HoldImage(HeldImage image);
  bool CalibrationIsSettled() const;
  void PruneImages();
  void PrunePoints();
  std::size_t PendingBytes() const;

  KeyframeAssemblerOptions options_;
  KeyframeCallback on_keyframe_;
  DropCallback on_drop_;
  AssemblerCounts counts_;

  std::deque<HeldImage> images_;  ///< in order of arrival
  std::size_t image_bytes_ = 0;   ///< of these
  std::deque<Stamped<std::vector<TrackedPoint>>> points_;
  ExtrinsicHistory extrinsics_;
  bool awaits_extrinsic_ = false;  ///< keyframes have had one of their own stamp
  std::deque<Pending> pending_;
  std::optional<Pending> suspect_;       ///< pose whose stamp went back
  std::deque<std::int64_t> pose_keys_;   ///< newest accepted poses
  std::deque<std::int64_t> image_keys_;  ///< last two images that came
  std::deque<std::int64_t> pauses_;      ///< first images after a pause
  RestartDetector restart_detector_;
  bool starts_sequence_ = false;  ///< a keyframe that starts a sequence was lost: the next one does
  bool is_restart_ = false;       ///< as well
};

}  // namespace deja_view
