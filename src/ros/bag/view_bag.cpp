#include "deja_view/ros/bag/view_bag.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"
#include "deja_view/base/parallel.hpp"
#include "deja_view/camera/camera_parameters.hpp"
#include "deja_view/io/config_node.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/bag/bag_writer.hpp"
#include "deja_view/ros/messages/virtual_frame_conversion.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "view_messages.hpp"

#include <nav_msgs/Odometry.h>
#include <ros/serialization.h>
#include <std_msgs/String.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

std::vector<SourceImage> OwnImages(const std::vector<SourceImage>& images,
                                   const ViewSubMap& sub_map) {
  std::vector<SourceImage> own;
  std::copy_if(images.begin(), images.end(), std::back_inserter(own), [&](const SourceImage& i) {
    return sub_map.shard.count == 1 || sub_map.is_own(i.T_N_C.t);
  });
  return own;
}

// Every shard.count-th.
std::vector<SourceImage> ShareOf(const std::vector<SourceImage>& images, const Shard& shard) {
  std::vector<SourceImage> share;
  for (std::size_t i = static_cast<std::size_t>(shard.index); i < images.size();
       i += static_cast<std::size_t>(shard.count)) {
    share.push_back(images[i]);
  }
  return share;
}

// All that decides what this job's views look like.
std::string OwnSettings(const ViewJob& job) {
  return job.sub_map.settings + job.settings;
}

// Of all that decides about the views but the images' content.
std::uint64_t HashJob(const ViewJob& job, const std::vector<SourceImage>& images) {
  std::string text = job.settings + job.flight->Describe();
  const CameraParameters camera = DescribeCamera(*job.camera);
  text += fmt::format("{} {} {} {} {}\n",
                      camera.model,
                      camera.width,
                      camera.height,
                      fmt::join(camera.distortion, " "),
                      fmt::join(camera.projection, " "));
  text += fmt::format("{} {} {} {}\n",
                      job.topics.image,
                      job.content.image,
                      job.content.features,
                      job.content.depth);
  for (const SourceImage& image : images) {
    const Rigid3& T = image.T_N_C;
    text += fmt::format("{} {} {}\n",
                        image.stamp_ns,
                        fmt::join(Numbers(T.t), " "),
                        fmt::join(ScalarFirst(T.q), " "));
  }
  return Hash64(text);
}

// Makes and stores the views of one image.
void MakeOne(const ViewJob& job,
             const ViewMaker& maker,
             const ViewRendererFactory& make_renderer,
             const LoadedSource& loaded,
             int threads,
             const ViewStore& store) {
  const auto start = Clock::now();
  const auto renderer = make_renderer(loaded.source, loaded.points);
  const MadeViews made = maker.Make(loaded.source, *renderer, threads);
  SourceResult result;
  result.stamp_ns = loaded.source.stamp_ns;
  result.recorded_ns = loaded.recorded_ns;
  for (const VirtualView& view : made.views) {
    result.frames.push_back(ToVirtualFrame(
        view, loaded.frame_id, {job.options.image_format, job.options.jpeg_quality}));
  }
  result.is_recognised = made.is_recognised;
  result.not_free = made.not_free;
  result.uncertain = made.uncertain;
  result.fit = made.fit;
  result.elapsed_s = std::chrono::duration<double>(Clock::now() - start).count();
  store.Write(result);
}

// What a ViewChooser chose, by the images' stamps.
using Choice = std::map<std::int64_t, ChosenViews>;

// For `images`, those of this sub-map; nothing where each image's views are its own affair.
Choice ChooseViews(const ViewJob& job,
                   const ViewRendererFactory& make_renderer,
                   const std::vector<SourceImage>& images,
                   const std::vector<Eigen::Vector3d>& flown_N,
                   const ViewProgress& on_progress) {
  Choice choice;
  if (job.options.choice.by == ChoiceKind::kSampling || images.empty()) {
    return choice;
  }
  std::vector<PlacedImage> placed;
  for (const SourceImage& image : images) {
    placed.push_back({image.stamp_ns, image.T_N_C});
  }
  const ViewChooser chooser(
      job.options.choice, job.options.sampling, job.options.gate, job.camera, flown_N);
  ViewSource anywhere;
  anywhere.T_N_C = images.front().T_N_C;
  const std::vector<ChosenViews> chosen = chooser.Choose(
      placed, *make_renderer(anywhere, {}), job.threads, [&](std::size_t done, std::size_t total) {
        on_progress(ViewStep::kChoosing, done, total);
      });
  for (std::size_t i = 0; i < images.size(); ++i) {
    choice[images[i].stamp_ns] = chosen[i];
  }
  return choice;
}

// Makes and stores the views of `missing`. Each thread takes whole images: what a view needs beside
// its render (gates, fits, networks, compression) runs on one thread and would leave others idle.
void MakeMissing(const ViewJob& job,
                 const ViewMaker& maker,
                 const ViewRendererFactory& make_renderer,
                 const std::vector<SourceImage>& missing,
                 const Choice& choice,
                 const ViewStore& store,
                 const std::function<void()>& on_made) {
  constexpr std::size_t kImagesPerThread = 8;  // held in memory at once
  const std::size_t threads = job.threads > 0
                                  ? static_cast<std::size_t>(job.threads)
                                  : std::max<std::size_t>(1, std::thread::hardware_concurrency());
  const int threads_per_image = missing.size() < threads ? job.threads : 1;
  std::mutex mutex;
  std::vector<LoadedSource> batch;
  const auto make_batch = [&] {
    ParallelFor(threads_per_image == 1 ? job.threads : 1,
                batch.size(),
                [&](std::size_t begin, std::size_t end) {
                  for (std::size_t i = begin; i < end; ++i) {
                    MakeOne(job, maker, make_renderer, batch[i], threads_per_image, store);
                    const std::lock_guard<std::mutex> lock(mutex);
                    on_made();
                  }
                });
    batch.clear();
  };
  ReadSourceImages(
      *job.flight, job.topics, *job.camera, job.T_B_C, missing, [&](const LoadedSource& loaded) {
        batch.push_back(loaded);
        if (const auto chosen = choice.find(loaded.source.stamp_ns); chosen != choice.end()) {
          batch.back().source.chosen = chosen->second;
        }
        if (batch.size() >= kImagesPerThread * threads) {
          make_batch();
        }
      });
  make_batch();
}

void Count(const SourceResult& result, ViewReport* report) {
  report->not_recognised += result.is_recognised ? 0 : 1;
  report->views += static_cast<std::int64_t>(result.frames.size());
  report->not_free += result.not_free;
  report->uncertain += result.uncertain;
  for (const VirtualFrame& frame : result.frames) {
    report->bytes += ros::serialization::serializationLength(frame);
  }
  report->source_s.push_back(result.elapsed_s);
  report->source_psnr_db.push_back(result.fit.psnr_db);
}

void CheckRecognised(const ViewReport& report, const fs::path& flight) {
  if (report.sources > 0 && report.not_recognised == report.sources) {
    ThrowInputError(
        "{}: the model shows something else at the poses of all {} images: expected poses in the "
        "frame that it was trained in, or min_correlation below what they have",
        flight.string(),
        report.sources);
  }
}

// The body's poses at the images, where they are wanted.
void WritePoses(const ViewJob& job, const std::vector<SourceImage>& images, BagWriter* bag) {
  if (job.pose_topic.empty()) {
    return;
  }
  const Rigid3 T_C_B = job.T_B_C.Inverse();
  nav_msgs::Odometry message;
  message.header.frame_id = "world";
  message.child_frame_id = "body";
  for (const SourceImage& image : images) {
    message.header.stamp = ToRosTime(image.stamp_ns);
    message.pose.pose = ToPose(image.T_N_C * T_C_B);
    bag->Write(job.pose_topic, image.recorded_ns, message);
  }
}

// A bag of the share's views alone; the first one has the poses, too.
void WritePart(const fs::path& path,
               const ViewJob& job,
               std::uint64_t job_hash,
               const std::vector<SourceImage>& all,
               const std::vector<SourceImage>& share,
               const ViewStore& store,
               ViewReport* report) {
  const ViewTopics topics;
  BagWriter bag(path);
  std_msgs::String label;
  label.data = internal::FormatLabel(
      {job.shard, job.sub_map.shard, job.sub_map.settings, job_hash, job.settings});
  bag.Write(topics.settings, 1, label);
  if (job.shard.index == 0 && job.sub_map.shard.index == 0) {
    WritePoses(job, all, &bag);
  }
  for (const SourceImage& image : share) {
    const std::optional<SourceResult> result = store.Read(image.stamp_ns);
    if (!result) {
      ThrowInputError("{}: the finished views of stamp {} ns are gone or damaged: run again",
                      path.string(),
                      image.stamp_ns);
    }
    internal::WriteViews(*result, topics, job.plain_topics, &bag);
    Count(*result, report);
  }
  CheckRecognised(*report, job.flight->path());
  bag.Close();
}

}  // namespace

ViewReport RenderViews(const ViewJob& job,
                       const ViewRendererFactory& make_renderer,
                       const ViewProgress& on_progress) {
  DEJA_VIEW_CHECK(job.shard.count >= 1 && job.shard.index >= 0 &&
                  job.shard.index < job.shard.count);
  job.flight->CheckContent(job.threads);
  const SourceImages all = FindSourceImages(*job.flight, job.topics, job.sources, job.T_N_C);
  const std::vector<SourceImage> selected =
      job.source_stamps_ns.empty() ? SelectSourceImages(all.images, job.options.sources)
                                   : SourceImagesAt(all.images, job.source_stamps_ns);
  const std::vector<SourceImage> own = OwnImages(selected, job.sub_map);
  const std::vector<SourceImage> share = ShareOf(own, job.shard);
  const std::uint64_t job_hash = HashJob(job, selected);

  ViewReport report;
  report.images = static_cast<std::int64_t>(all.images.size());
  report.without_pose = all.without_pose;
  report.sources = static_cast<std::int64_t>(share.size());
  const fs::path work = job.out.string() + ".work";
  const ViewStore store(work, job_hash ^ Hash64(job.sub_map.settings));
  std::vector<SourceImage> missing;
  for (const SourceImage& image : share) {
    if (!job.resume || !store.Read(image.stamp_ns)) {
      missing.push_back(image);
    }
  }
  report.resumed = static_cast<std::int64_t>(share.size() - missing.size());

  std::vector<Eigen::Vector3d> flown_N;
  for (const SourceImage& image : all.images) {
    flown_N.push_back(image.T_N_C.t);
  }
  Choice choice;
  if (!missing.empty()) {
    choice = ChooseViews(job, make_renderer, own, flown_N, on_progress);
  }
  std::size_t done = share.size() - missing.size();
  on_progress(ViewStep::kRendering, done, share.size());
  const ViewMaker maker(
      job.options, job.content, job.camera, std::move(flown_N), Hash64(OwnSettings(job)));
  MakeMissing(job, maker, make_renderer, missing, choice, store, [&] {
    on_progress(ViewStep::kRendering, ++done, share.size());
  });

  const bool is_whole = job.shard.count == 1 && job.sub_map.shard.count == 1;
  const fs::path part = is_whole ? work / "views.bag" : job.out;
  WritePart(part, job, job_hash, all.images, share, store, &report);
  if (is_whole) {
    MergeViews(*job.flight, {part}, job.out, job.views_only);
    std::error_code error;
    fs::remove(part, error);
  }
  store.Remove();
  return report;
}

}  // namespace deja_view
