// What the sanitizers shall not report of libraries, with the reason. Nothing without them.
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
// Libraries stay loaded: the report of a leak names only those that are, and a suppression needs the name.
extern "C" int dlclose(void*) { return 0; }

// JACK and PipeWire keep parts of every client that was closed, ALSA its configuration, SDL the record of
// each thread that it has met.
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libjack\nleak:libpipewire\nleak:libasound\nleak:libSDL2\n";
}
#endif
#if __has_feature(thread_sanitizer)
// Libraries were compiled without the sanitizer, which does not see how their threads wait for each other:
// neither in their own code, nor where their thread calls ours. What the callback shares with other threads
// is tested without them: tests/backends/card_callback_test.cpp and the simulated cards.
extern "C" const char* __tsan_default_options() { return "print_suppressions=0:handle_segv=0"; }
extern "C" const char* __tsan_default_suppressions() {
  return "race:libjack\nrace:librtaudio\nrace:libportaudio\nrace:libasound\nrace:libpipewire\nrace:"
         "libspa\nrace:libpulse\n"
         "thread:libjack\nthread:librtaudio\nthread:libportaudio\nthread:libasound\nthread:"
         "libpipewire\ndeadlock:libasound\ndeadlock:libpipewire\n";
}
#endif
#endif
