#include <cstdio>
#include <exception>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/play/live/controls/keyboard.h"

int main(int argc, char** argv) {
  using namespace tactus::app;
  open_standard_streams();
  CLI::App app{"Tactus: haptic instruments on ordinary sound cards", "tactus"};
  app.require_subcommand(1);
  app.set_version_flag("--version", version());
  app.footer(
      "Start with:  tactus play instruments/haptic_drum\nEach command explains itself:  tactus render "
      "--help");
  int exit_code = kDone;
  for (auto* add : {TACTUS_COMMANDS}) add(app, exit_code);  // as apps/CMakeLists.txt says
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  } catch (const CommandError& error) {
    return report(error);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tactus: %s\n", error.what());
    return kNo;
  }
  return exit_code;
}
