// Trajectories: TUM's and comma-separated poses, told apart by their content.
#include "deja_view/io/trajectory_file.hpp"
#include "deja_view/io/tum.hpp"

#include "fuzz.hpp"

namespace deja_view::fuzz {

std::vector<std::string> Seeds() {
  Trajectory trajectory;
  for (int i = 0; i < 5; ++i) {
    trajectory.stamps_ns.push_back(1403636627638560000 + i * 50000000);
    trajectory.poses.push_back({FromYaw(0.1 * i), {1.0 * i, 0.25, -2}});
  }
  WriteTum(Scratch() / "seed.txt", trajectory);
  return {ReadAll(Scratch() / "seed.txt"),
          "#timestamp [ns], p, q\n1403636580838555648, 4.68, -1.78, 0.78, 0.6, 0, 0.8, 0\n"
          "1403636580843555648, 4.68, -1.78, 0.78, 0.6, 0, 0.8, 0, 1, 2, 3\n"};
}

void RunOne(const std::string& input) {
  ReadTrajectoryFile(Write("poses", input));
}

}  // namespace deja_view::fuzz
