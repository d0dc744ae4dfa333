// Leaks of libraries that the address sanitizer shall not report. Nothing without it.
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
#endif
