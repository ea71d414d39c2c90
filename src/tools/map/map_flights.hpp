#pragma once

#include "deja_view/geometry/trajectory_alignment.hpp"

#include <filesystem>
#include <string>
#include <vector>

#include "nerf/nerf_input.hpp"
#include "replay/replay.hpp"
#include <nlohmann/json.hpp>

namespace deja_view {

/// A flight that a map was made of.
struct MappedFlight {
  std::filesystem::path bag;
  std::filesystem::path camera;
  std::filesystem::path poses;  ///< TUM, of the body in the field's frame
  int every = 1;                ///< every N-th image is the field's

  /// The images that the field is trained on.
  NerfInput Images() const;
};

/// For map.json, with the paths of bag and camera from the root and that of the poses within the
/// map's `directory`.
nlohmann::ordered_json ToJson(const MappedFlight& flight, const std::filesystem::path& directory);

/// The flights of a map that `deja_view map` made in `directory`. Throws InputError that says what
/// is missing.
std::vector<MappedFlight> ReadMappedFlights(const std::filesystem::path& directory);

/// Where a flight lies among those of a map.
struct JoinedFlight {
  Trajectory T_F_B;     ///< its poses in the field's frame
  RobustAlignment fit;  ///< to where its loops with the map's places say that it was
};

/// Brings the adjusted poses of a flight, T_N_B, to the frame of the map that it was replayed on,
/// by yaw and position, from its loops with that map's places. `what` begins the message of the
/// InputError for too few loops, and for a bad fit.
JoinedFlight JoinFlight(const ReplayResult& replay,
                        const std::vector<MappedFlight>& mapped,
                        const Trajectory& T_N_B,
                        const std::string& what);

}  // namespace deja_view
