#pragma once

#ifdef __cplusplus
extern "C" {
#endif

/* Runs the kernel of a node with its default settings over `frames` frames; in[k] is input k. 0: not here. */
int tactus_run_kernel(const char* node, const double* const* in, int frames, double rate, double* out);

#ifdef __cplusplus
}
#endif
