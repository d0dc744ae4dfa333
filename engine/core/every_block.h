#pragma once
// Thread: [any]

/// Marks a function that runs in every block. The compiler puts them all in one place of the program, so that
/// a thread that wakes up finds what it runs in few pages of memory.
#if defined(__GNUC__)
#define TACTUS_EVERY_BLOCK [[gnu::hot]]
#else
#define TACTUS_EVERY_BLOCK
#endif
