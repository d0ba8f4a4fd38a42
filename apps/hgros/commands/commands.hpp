#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arguments/command.hpp"

namespace hgros::cli {

/// All commands, in the order of `hgros help`.
[[nodiscard]] std::span<const CommandEntry> Commands() noexcept;
/// Null if there is none.
[[nodiscard]] const CommandEntry* FindCommand(std::string_view name) noexcept;
/// Takes the name of a command or a family, one word or two, from the beginning of the words of a command line. Throws
/// UsageError with the nearest name.
[[nodiscard]] const CommandEntry& TakeCommand(std::vector<std::string>& words);

// Those of robots that hgros run starts are in robots.
std::unique_ptr<Command> MakeBagCheck();
std::unique_ptr<Command> MakeBagInfo();
std::unique_ptr<Command> MakeBagRecover();
std::unique_ptr<Command> MakeBw();
std::unique_ptr<Command> MakeCall();
std::unique_ptr<Command> MakeCheck();
std::unique_ptr<Command> MakeComplete();
std::unique_ptr<Command> MakeComponents();
std::unique_ptr<Command> MakeCompletion();
std::unique_ptr<Command> MakeControlAllow();
std::unique_ptr<Command> MakeControlClose();
std::unique_ptr<Command> MakeControlForbid();
std::unique_ptr<Command> MakeControlLog();
std::unique_ptr<Command> MakeControlOpen();
std::unique_ptr<Command> MakeControlStop();
std::unique_ptr<Command> MakeDelay();
std::unique_ptr<Command> MakeDoctor();
std::unique_ptr<Command> MakeEcho();
std::unique_ptr<Command> MakeExportCompose();
std::unique_ptr<Command> MakeExportKubernetes();
std::unique_ptr<Command> MakeExportSystemd();
std::unique_ptr<Command> MakeGraph();
std::unique_ptr<Command> MakeHelp();
std::unique_ptr<Command> MakeHosted();
std::unique_ptr<Command> MakeHz();
std::unique_ptr<Command> MakeInfo();
std::unique_ptr<Command> MakeList();
std::unique_ptr<Command> MakeLogs();
std::unique_ptr<Command> MakeManual();
std::unique_ptr<Command> MakeNew();
std::unique_ptr<Command> MakeParamDescribe();
std::unique_ptr<Command> MakeParamGet();
std::unique_ptr<Command> MakeParamList();
std::unique_ptr<Command> MakeParamLoad();
std::unique_ptr<Command> MakeParamSave();
std::unique_ptr<Command> MakeParamSet();
std::unique_ptr<Command> MakeParamWatch();
std::unique_ptr<Command> MakePath();
std::unique_ptr<Command> MakePs();
std::unique_ptr<Command> MakePub();
std::unique_ptr<Command> MakeRestart();
std::unique_ptr<Command> MakeMove();
std::unique_ptr<Command> MakeRun();
std::unique_ptr<Command> MakeSchema();
std::unique_ptr<Command> MakeStop();
std::unique_ptr<Command> MakeTfEcho();
std::unique_ptr<Command> MakeTfStatic();
std::unique_ptr<Command> MakeTfSvg();
std::unique_ptr<Command> MakeTfTree();
std::unique_ptr<Command> MakeTfWatch();
std::unique_ptr<Command> MakeTop();
std::unique_ptr<Command> MakeTrace();
std::unique_ptr<Command> MakeWait();

}  // namespace hgros::cli
