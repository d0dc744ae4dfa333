// What the sanitizers shall not report of libraries, with the reason. Nothing without them.
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
// Libraries stay loaded: the report of a leak names only those that are, and a suppression needs the name.
extern "C" int dlclose(void*) { return 0; }

// JACK and PipeWire keep parts of every client that was closed, ALSA its configuration.
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libjack\nleak:libpipewire\nleak:libasound\n";
}
#endif
#if __has_feature(thread_sanitizer)
// Libraries were compiled without the sanitizer, which does not see how their threads wait for each other:
// neither in their own code, nor where the callback reads and writes their buffers. RtAudio does not join all
// its threads.
extern "C" const char* __tsan_default_options() {
  return "ignore_noninstrumented_modules=1:print_suppressions=0:handle_segv=0";
}
extern "C" const char* __tsan_default_suppressions() {
  return "race:tactus::read_library_buffer\nrace:tactus::write_library_buffer\n"
         "race:tactus::silence_library_buffer\nthread:librtaudio\nthread:libjack\nthread:"
         "libportaudio\nthread:libasound\n";
}
#endif
#endif
