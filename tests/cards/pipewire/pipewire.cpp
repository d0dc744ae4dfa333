#include "tests/cards/pipewire/pipewire.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>

#include "tests/support/skip.h"
#include "tests/support/wait_until.h"

namespace tactus::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVariables[] = {"XDG_RUNTIME_DIR", "XDG_CONFIG_HOME", "XDG_STATE_HOME",
                                      "ALSA_CONFIG_PATH"};
constexpr const char* kMissing =
    "PipeWire is not installed (Debian: apt-get install pipewire pipewire-jack wireplumber dbus-daemon)";

constexpr const char* kCable =
    "context.objects = [ { factory = adapter args = { factory.name = support.null-audio-sink "
    "node.name = cable media.class = Audio/Sink object.linger = true audio.position = [ FL FR ] } } ]\n";

/// Both end when stdin does.
constexpr const char* kServer = R"(pipewire & server=$!
until [ -S "$XDG_RUNTIME_DIR/pipewire-0" ]; do sleep 0.05; done
wireplumber & manager=$!
read -r end
kill $manager $server
wait
)";

#ifdef TACTUS_NO_MIXER
constexpr const char* kPlugin = TACTUS_ALSA_PLUGINS "/libasound_module_pcm_pipewire.so";

std::string alsa_config() {
  return fmt::format(
      "ctl_type.none {{ lib \"{}\" }}\nctl.default {{ type none }}\n"
      "pcm_type.pipewire {{ lib \"{}/libasound_module_pcm_pipewire.so\" }}\n"
      "pcm.default {{ type pipewire }}\n",
      TACTUS_NO_MIXER, TACTUS_ALSA_PLUGINS);
}
#else
constexpr const char* kPlugin = "";
std::string alsa_config() { return {}; }
#endif

std::string output_of(const std::string& command) {
  std::string text;
  if (auto* pipe = ::popen((command + " 2>/dev/null").c_str(), "r"); pipe != nullptr) {
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
    ::pclose(pipe);
  }
  return text;
}

bool is_installed() {
  return !output_of(
              "command -v pipewire && command -v wireplumber && command -v pw-jack && "
              "command -v dbus-run-session")
              .empty();
}

}  // namespace

PipeWire::PipeWire() {
  if (!is_installed()) skip(kMissing);
  const auto folder = folder_.path().string();
  fs::permissions(folder_.path(), fs::perms::owner_all);
  folder_.write("pipewire/pipewire.conf.d/cable.conf", kCable);
  folder_.write("server", kServer);
  for (const auto* variable : {"XDG_RUNTIME_DIR", "XDG_CONFIG_HOME", "XDG_STATE_HOME"})
    ::setenv(variable, folder.c_str(), 1);
  ::setenv("ALSA_CONFIG_PATH", folder_.write("alsa.conf", alsa_config()).c_str(), 1);
  server_ = std::make_unique<ChildProcess>(
      std::vector<std::string>{"dbus-run-session", "--", "sh", folder + "/server"},
      ChildProcess::Stdout::Logged);
  if (!wait_until([&] { return has_cable(); })) FAIL("PipeWire does not start:\n" << server_->log());
}

bool PipeWire::has_alsa() { return fs::exists(kPlugin); }

PipeWire::~PipeWire() {
  server_->hang_up();
  static_cast<void>(server_->wait(std::chrono::seconds{10}));
  for (const auto* variable : kVariables) ::unsetenv(variable);
}

bool PipeWire::has_cable() const {
  return output_of("pw-link -o").find("cable:monitor_FL") != std::string::npos;
}

void PipeWire::force_rate(int rate) const { set("clock.force-rate", rate); }
void PipeWire::force_block(int frames) const { set("clock.force-quantum", frames); }

void PipeWire::set(const std::string& key, int value) const {
  const auto command = fmt::format("pw-metadata -n settings 0 {} {} >/dev/null", key, value);
  CAPTURE(command);
  REQUIRE(std::system(command.c_str()) == 0);
}

std::vector<std::string> PipeWire::over_jack(std::vector<std::string> command) {
  command.insert(command.begin(), "pw-jack");
  return command;
}

}  // namespace tactus::test
