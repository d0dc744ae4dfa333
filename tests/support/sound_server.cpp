#include "tests/support/sound_server.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>
#include <thread>

#include "tests/support/skip.h"

namespace tactus::test {
namespace {

namespace fs = std::filesystem;
using std::to_string;

constexpr const char* kDefaultServer = "JACK_DEFAULT_SERVER";
constexpr std::chrono::seconds kStart{10};  // a server that takes longer never becomes ready
constexpr int kNames = 4;  // JACK has room for eight servers of all users, and keeps the place of a dead one

std::string own_name(const std::string& client) { return client + "-" + to_string(::getpid()); }

fs::path lock_file(const std::string& name) { return fs::temp_directory_path() / (name + ".lock"); }

/// The open and locked file, or -1. It is removed by whoever holds it, so one that is gone by now is no lock.
int try_lock(const fs::path& path) {
  const int file = ::open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600);
  struct stat opened {
  }, there{};
  if (file >= 0 && ::flock(file, LOCK_EX | LOCK_NB) == 0 && ::fstat(file, &opened) == 0 &&
      ::stat(path.c_str(), &there) == 0 && opened.st_ino == there.st_ino)
    return file;
  if (file >= 0) ::close(file);
  return -1;
}

std::string name_of(int n) { return "tactus-test-" + to_string(::getuid()) + "-" + to_string(n); }

/// The first name that no running test has, or none. It is used again and again, so that whatever a test that
/// crashed left under it goes away with the next.
std::string free_name(int& lock) {
  for (int n = 0; n < kNames; ++n) {
    if ((lock = try_lock(lock_file(name_of(n)))) >= 0) return name_of(n);
  }
  return "";
}

/// Whether another test has a sound server at this moment.
bool others_run(const std::string& name) {
  for (int n = 0; n < kNames; ++n) {
    const auto path = lock_file(name_of(n));
    if (name_of(n) == name || !fs::exists(path)) continue;
    const int lock = try_lock(path);
    if (lock < 0) return true;
    ::close(lock);
  }
  return false;
}

/// What a server that was killed leaves, and the next one of its name does not take over.
void remove_leftovers(const std::string& name) {
  const auto mark = "_" + name + "_";
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/dev/shm", ignored))
    if (entry.path().filename().string().find(mark) != std::string::npos) fs::remove(entry, ignored);
}

/// Where all JACK servers and clients of a user keep what they say of themselves. One that is killed leaves
/// its part for ever; one that is killed while it makes the files leaves them too short, and from then on
/// every JACK program of the user dies of SIGBUS; one that is killed while it holds a lock in them leaves it
/// locked, and the next server, or its first client, waits for it without end.
fs::path metadata() { return "/dev/shm/jack_db-" + to_string(::getuid()); }

/// Our helper program leaves the server before that ends: JACK dies of clients that vanish with it.
void leave(ChildProcess& client) {
  client.hang_up();
  client.wait(std::chrono::seconds{3});
}

}  // namespace

std::unique_ptr<SoundServer> start_sound_server(const SoundServer::Settings& settings) {
  std::unique_ptr<SoundServer> server{new SoundServer};
  server->settings_ = settings;
  server->name_ = free_name(server->lock_);
  if (server->name_.empty()) {
    server.reset();
    skip(to_string(kNames) + " other tests have a sound server at this moment");
  }
  server->first_of_user_ = !fs::exists(metadata());
  ::setenv(kDefaultServer, server->name_.c_str(), 1);
  if (server->begin()) return server;
  const auto reason = server->why_not();
  server.reset();
  skip(reason);
}

SoundServer::~SoundServer() {
  if (name_.empty()) return;
  end();
  ::unsetenv(kDefaultServer);
  fs::remove(lock_file(name_));
  ::close(lock_);
}

std::string SoundServer::why_not() {
  if (server_->wait(std::chrono::milliseconds{0}) == ChildProcess::kCannotRun)
    return "jackd is not installed (Debian: apt-get install jackd2)";
  const auto said = server_->log();
  const bool full = said.find("Too many servers") != std::string::npos;
  return "jackd does not start here; it says:\n" + said +
         (full ? "It keeps the places of servers that were killed. When none runs: rm "
                 "/dev/shm/jack-shm-registry"
               : "");
}

bool SoundServer::begin() {
  if (try_to_begin()) return true;
  const auto died = [](ChildProcess& program) {
    return program.wait(std::chrono::milliseconds{200}) == -SIGBUS;
  };
  const bool hangs = server_->running();
  if (!hangs && !died(*server_) && !died(*hand_)) return false;
  server_->kill();
  hand_->kill();
  fs::remove_all(metadata());
  return try_to_begin();
}

bool SoundServer::try_to_begin() {
  const auto channels = to_string(settings_.channels);
  // -p 64: room for 64 ports takes 40 MB of shared memory, the usual 2048 take 107.
  std::vector<std::string> command{"jackd", "-n", name_, "-p", "64", "-R", "-P", "80", "-L", "2"};
  if (settings_.synchronous) command.push_back("-S");
  for (const auto& word : {"-d", "dummy", "-r"}) command.emplace_back(word);
  for (const auto& word : {to_string(settings_.rate), std::string{"-p"}, to_string(settings_.period),
                           std::string{"-C"}, channels, std::string{"-P"}, channels})
    command.push_back(word);
  server_ = std::make_unique<ChildProcess>(command, ChildProcess::Stdout::Logged);
  hand_ = std::make_unique<ChildProcess>(
      std::vector<std::string>{TACTUS_DELAY_CLIENT, "--hand", own_name("hand")});
  const auto deadline = std::chrono::steady_clock::now() + kStart;
  while (server_->running() && hand_->running() && std::chrono::steady_clock::now() < deadline)
    if (hand_->hear(std::chrono::milliseconds{50}) == "ready") return true;
  return false;
}

/// A server that dies instead of ending leaves its shared memory; the next one of its name frees it.
void SoundServer::end() {
  for (int turn = 0; turn < 2; ++turn) {
    go_on();
    leave(*hand_);
    if (const bool died = server_->terminate() < 0; !died || turn > 0) break;
    begin();
  }
  remove_leftovers(name_);
}

void SoundServer::kill() {
  server_->kill();
  hand_->kill();
  if (first_of_user_ && !others_run(name_)) fs::remove_all(metadata());
}
void SoundServer::stop_answering() { server_->pause(); }
void SoundServer::go_on() { server_->send(SIGCONT); }
void SoundServer::restart() {
  if (!begin()) throw std::runtime_error{why_not()};
}

std::string SoundServer::ask(const std::string& question) {
  hand_->say(question);
  std::string answer;
  for (std::string line; (line = hand_->hear()) != "done";) {
    if (line.empty() || line == "failed") throw std::runtime_error{"jackd: no to '" + question + "'"};
    answer += line + "\n";
  }
  return answer;
}

void SoundServer::set_period(int frames) { ask("period " + to_string(frames)); }
void SoundServer::freewheel(bool on) { ask("freewheel " + to_string(int{on})); }
void SoundServer::disconnect(const std::string& client) { ask("disconnect " + client); }
void SoundServer::connect(const std::string& from_port, const std::string& to_port) {
  ask("connect " + from_port + " " + to_port);
}
std::string SoundServer::connections(const std::string& port) { return ask("connections " + port); }

DelayClient::DelayClient(const Settings& settings) : name_(own_name(settings.name)) {
  process_ = std::make_unique<ChildProcess>(std::vector<std::string>{
      TACTUS_DELAY_CLIENT, "--card", name_, to_string(settings.channels), to_string(settings.delay_frames),
      to_string(settings.gain), to_string(settings.noise), to_string(settings.input_latency),
      to_string(settings.output_latency), to_string(int{settings.reversed}), settings.hardware});
  if (process_->hear() != "ready")
    throw std::runtime_error{"the delay client '" + name_ + "' does not start"};
}

DelayClient::~DelayClient() { leave(*process_); }

void DelayClient::sleep_once(std::chrono::milliseconds time) {
  process_->say("sleep " + to_string(time.count()));
  if (process_->hear() != "done") throw std::runtime_error{"the delay client did not sleep"};
}

std::int64_t DelayClient::xruns() {
  process_->say("xruns");
  return std::stoll(process_->hear());
}

}  // namespace tactus::test
