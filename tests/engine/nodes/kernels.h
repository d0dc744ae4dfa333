#pragma once

#ifdef __cplusplus
extern "C" {
#endif

/* Runs the kernel of a node with the settings of kernels_test.cpp over `frames` frames; in[k] is input k,
   those that are fixed left out. 0: it has none. */
int tactus_run_kernel(const char* node, const double* const* in, int frames, double rate, double* out);

#ifdef __cplusplus
}
#endif
