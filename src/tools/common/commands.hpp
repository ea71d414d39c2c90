#pragma once

#include <functional>

#include <CLI/CLI.hpp>

namespace deja_view {

/// What a subcommand does once its arguments are parsed; returns the exit code.
using Command = std::function<int()>;

/// Each adds its subcommand to `app` and sets `*command` when it is the one that was called.
void AddApeCommand(CLI::App& app, Command* command);
void AddBundleCommand(CLI::App& app, Command* command);
void AddCheckCommand(CLI::App& app, Command* command);
void AddEvaluateCommand(CLI::App& app, Command* command);
void AddExplainCommand(CLI::App& app, Command* command);
void AddKeyframesCommand(CLI::App& app, Command* command);
void AddMapCommand(CLI::App& app, Command* command);
void AddNerfCommand(CLI::App& app, Command* command);
void AddPlacesCommand(CLI::App& app, Command* command);
void AddReplayCommand(CLI::App& app, Command* command);
void AddReportCommand(CLI::App& app, Command* command);
void AddSimulateCommand(CLI::App& app, Command* command);
void AddViewsCommand(CLI::App& app, Command* command);
void AddVocabularyCommand(CLI::App& app, Command* command);

}  // namespace deja_view
