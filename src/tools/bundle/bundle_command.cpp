#include "bundle/bundle_command.hpp"

#include "deja_view/base/output_lock.hpp"

#include <iostream>
#include <memory>

#include "common/commands.hpp"
#include "common/interrupt.hpp"
#include "common/reporting.hpp"
#include "nerf/nerf_command.hpp"
#include <fmt/format.h>

namespace deja_view {
void AddBundleCommand(CLI::App& app, Command* command) {
  auto request = std::make_shared<BundleRequest>();
  CLI::App* sub = app.add_subcommand(
      "bundle", "Adjust poses, points and calibration of a flight or of posed images");
  AddNerfInputOptions(sub, &request->input);
  AddHostOptions(sub, &request->host);
  sub->add_flag_callback(
      "--no-loops", [request] { request->use_loops = false; }, "Take a flight's poses as they are");
  sub->add_option("--vocabulary", request->vocabulary, "For loops; default: the shipped one")
      ->check(CLI::ExistingFile);
  sub->add_option(
         "--refine",
         request->refine,
         "What of the cameras is adjusted: intrinsics, distortion, extrinsics, time_offset")
      ->check(CLI::IsMember({"intrinsics", "distortion", "extrinsics", "time_offset"}));
  sub->add_option("--config", request->config, "YAML with options")->check(CLI::ExistingFile);
  sub->add_option("--set", request->overrides, "Override of an option: group.key=value")
      ->take_all();
  sub->add_option("--out", request->out, "Directory for poses.txt, colmap/ and bundle.json")
      ->required();
  sub->add_flag("--write-images",
                request->write_images,
                "Write a flight's keyframes to colmap/images, for nerf train --colmap");
  AddQuietOption(sub, &request->show_progress);
  sub->footer(
      "Without --poses, --bag is a flight with VINS-Mono's topics.\n"
      "Example:\n  deja_view bundle --bag hall.bag --camera euroc.yaml --out hall_bundle");
  sub->callback([=] {
    *command = [=] {
      try {
        const OutputLock lock = OutputLock::OfDirectory(request->out);
        const nlohmann::ordered_json json = RunBundle(*request);
        std::cout << json.dump(2) << "\n";
        if (!json.value("interrupted", false)) {
          return 0;
        }
        std::cerr << "deja_view: interrupted; " << request->out.string() << " has what "
                  << json["rounds"].size() << " finished rounds gave\n";
      } catch (const Interrupted& e) {
        std::cerr << "deja_view: " << e.what() << "\n";
      }
      return 130;
    };
  });
}

}  // namespace deja_view
