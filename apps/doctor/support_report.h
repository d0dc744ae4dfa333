#pragma once
// Thread: [control]

#include <string>
#include <utility>
#include <vector>

#include "apps/doctor/findings.h"

namespace tactus::app {

/// What must not stand in a report that is sent to others.
struct PersonalNames {
  std::string home, user, host;  ///< empty: nothing to leave out

  /// Of this process.
  static PersonalNames of_process();
  /// The home folder as ~, user and host as USER and HOST where they are whole words, serial numbers of
  /// devices left out.
  std::string removed_from(std::string text) const;
};

/// A text for people who help from afar: version, system, kernel, processor, sound servers, cards with their
/// formats and rates, findings; then `sections`, each a heading and its text.
std::string support_report(const SystemState& system, const std::vector<SystemFinding>& findings,
                           const std::vector<std::pair<std::string, std::string>>& sections,
                           const PersonalNames& names);

/// "/usr/bin/jackd -dalsa -p64" of each sound server that runs.
std::vector<std::string> sound_servers(const SystemFiles& system);

}  // namespace tactus::app
