#include <exception>
#include <iostream>

#include "common/commands.hpp"

namespace {

int Run(int argc, char** argv) {
  CLI::App app{
      "Loop closure for visual-inertial drones that also recognises a place from new viewpoints",
      "deja_view"};
  app.set_version_flag("--version", DEJA_VIEW_VERSION);
  app.require_subcommand(1);
  deja_view::Command command;
#ifdef DEJA_VIEW_WITH_LAB
  deja_view::AddApeCommand(app, &command);
#ifdef DEJA_VIEW_WITH_ROS
  deja_view::AddEvaluateCommand(app, &command);
  deja_view::AddExplainCommand(app, &command);
#endif
  deja_view::AddPlacesCommand(app, &command);
  deja_view::AddReportCommand(app, &command);
  deja_view::AddSimulateCommand(app, &command);
#endif
  deja_view::AddNerfCommand(app, &command);
#ifdef DEJA_VIEW_WITH_ROS
  deja_view::AddBundleCommand(app, &command);
  deja_view::AddCheckCommand(app, &command);
  deja_view::AddKeyframesCommand(app, &command);
  deja_view::AddMapCommand(app, &command);
  deja_view::AddReplayCommand(app, &command);
  deja_view::AddViewsCommand(app, &command);
#endif
  deja_view::AddVocabularyCommand(app, &command);
  CLI11_PARSE(app, argc, argv);
  return command();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return Run(argc, argv);
  } catch (const std::exception& e) {
    std::cerr << "deja_view: " << e.what() << "\n";
    return 1;
  }
}
