#pragma once

// Thread: [control]

#include <string>
#include <vector>

#include "apps/cli/platform.h"
#include "engine/core/error.h"

namespace tactus::app {

/// What `tactus doctor` says of one thing.
struct Finding {
  enum class State {
    Ok,
    Warn,
    Unknown,
  };
  std::string name;
  State state = State::Unknown;
  std::string what;     ///< one sentence
  std::string command;  ///< that mends it, or that shows more; empty where there is nothing to do
};

/// "ok", "warn", "unknown"
const char* name_of(Finding::State state);

// Each judges from what the system says and nothing else, so that every answer can be tried.

/// `tried`: a thread asked for real-time priority.
Finding judge_priority(const SystemFacts& facts, const Status& tried);
/// `tried`: the program asked to stay in memory.
Finding judge_memory(const SystemFacts& facts, const Status& tried);
Finding judge_governor(const SystemFacts& facts);
Finding judge_idle(const SystemFacts& facts);
Finding judge_kernel(const SystemFacts& facts);
Finding judge_interrupts(const SystemFacts& facts);
Finding judge_swap(const SystemFacts& facts, bool memory_locked);
Finding judge_machine(const SystemFacts& facts);
Finding judge_cards(const SystemFacts& facts);
/// One for each sound card on USB, or one that says that there is none.
std::vector<Finding> judge_usb(const SystemFacts& facts);
/// One for each sound server that runs, or one that says that there is none.
std::vector<Finding> judge_servers(const SystemFacts& facts);

/// All of them, in the order in which they matter.
std::vector<Finding> judge_system(const SystemFacts& facts, const Status& priority, const Status& memory);

}  // namespace tactus::app
