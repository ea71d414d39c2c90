#include "map/map_flights.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/io/tum.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>
#include <utility>

#include "common/pose_input.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

MappedFlight FromJson(const Json& json, const fs::path& directory) {
  MappedFlight flight;
  flight.bag = json.at("bag").get<std::string>();
  flight.camera = json.at("camera").get<std::string>();
  flight.poses = directory / json.at("poses").get<std::string>();
  flight.every = json.at("every").get<int>();
  for (const fs::path& file : {flight.bag, flight.camera, flight.poses}) {
    if (!fs::is_regular_file(file)) {
      ThrowInputError("{}: {}: no such file; a field goes on learning from its images, too",
                      (directory / "map.json").string(),
                      file.string());
    }
  }
  return flight;
}

/// Where a keyframe of the map is in the field's frame. Flights may share stamps: the pose nearest
/// to that of the pose graph is meant.
std::optional<Rigid3> FindPose(const std::vector<Trajectory>& T_F_B, const KeyframeInfo& keyframe) {
  std::optional<Rigid3> nearest;
  for (const Trajectory& flight : T_F_B) {
    const auto at =
        std::lower_bound(flight.stamps_ns.begin(), flight.stamps_ns.end(), keyframe.stamp_ns);
    if (at == flight.stamps_ns.end() || *at != keyframe.stamp_ns) {
      continue;
    }
    const Rigid3& pose = flight.poses[static_cast<std::size_t>(at - flight.stamps_ns.begin())];
    const Eigen::Vector3d& p = keyframe.T_M_B.t;
    if (!nearest || (pose.t - p).norm() < (nearest->t - p).norm()) {
      nearest = pose;
    }
  }
  return nearest;
}

/// Where the loops with the map's places say that the flight was; of several of one keyframe the
/// one that most agree with.
Trajectory SeenFromTheMap(const ReplayResult& replay, const std::vector<Trajectory>& T_F_B) {
  std::map<std::int64_t, std::pair<int, Rigid3>> seen;  // by stamp: inliers, T_F_B
  for (const LoopReport& loop : replay.loops) {
    if (!loop.accepted() || loop.old >= replay.map_keyframes) {
      continue;
    }
    const auto old = FindPose(T_F_B, replay.keyframes[static_cast<std::size_t>(loop.old)]);
    const auto known = seen.find(loop.stamp_current_ns);
    if (old && (known == seen.end() || loop.inliers > known->second.first)) {
      seen[loop.stamp_current_ns] = {loop.inliers, *old * loop.T_Bold_Bcurrent};
    }
  }
  Trajectory trajectory;
  for (const auto& [stamp_ns, pose] : seen) {
    trajectory.stamps_ns.push_back(stamp_ns);
    trajectory.poses.push_back(pose.second);
  }
  return trajectory;
}

}  // namespace

NerfInput MappedFlight::Images() const {
  NerfInput input;
  input.bag = bag;
  input.camera = camera;
  input.poses = poses;
  input.skip_missing = true;
  input.every = every;
  return input;
}

Json ToJson(const MappedFlight& flight, const fs::path& directory) {
  return {{"bag", fs::absolute(flight.bag).string()},
          {"camera", fs::absolute(flight.camera).string()},
          {"poses", flight.poses.lexically_relative(directory).string()},
          {"every", flight.every}};
}

std::vector<MappedFlight> ReadMappedFlights(const fs::path& directory) {
  for (const char* name : {"map.json", "map.dvm", "field.dvn"}) {
    if (!fs::is_regular_file(directory / name)) {
      ThrowInputError("{}: no {}: expected what `deja_view map` made", directory.string(), name);
    }
  }
  std::ifstream file(directory / "map.json");
  std::vector<MappedFlight> flights;
  try {
    const Json map = Json::parse(file);
    for (const Json& flight : map.at("flights")) {
      flights.push_back(FromJson(flight, directory));
    }
  } catch (const Json::exception&) {
    ThrowInputError(
        "{}: expected `flights`, which it was made of; the `deja_view map` that made it adds them",
        (directory / "map.json").string());
  }
  return flights;
}

JoinedFlight JoinFlight(const ReplayResult& replay,
                        const std::vector<MappedFlight>& mapped,
                        const Trajectory& T_N_B,
                        const std::string& what) {
  std::vector<Trajectory> T_F_B;
  for (const MappedFlight& flight : mapped) {
    T_F_B.push_back(ReadTum(flight.poses));
  }
  const Trajectory seen = SeenFromTheMap(replay, T_F_B);
  constexpr std::size_t kFewest = 10;
  if (seen.size() < kFewest) {
    ThrowInputError(
        "{}: {} keyframes found one of its places, expected at least {}: fly through "
        "places that it knows, and look where that flight looked",
        what,
        seen.size(),
        kFewest);
  }
  AlignmentOptions options;
  options.freedom = AlignmentFreedom::kYaw;
  options.max_rmse_m = 0.15;
  JoinedFlight joined;
  joined.fit = AlignTrajectories(seen, T_N_B, options, what);
  joined.T_F_B = Transform(joined.fit.A_B, T_N_B);
  return joined;
}

}  // namespace deja_view
