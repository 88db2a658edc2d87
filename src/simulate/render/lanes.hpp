#pragma once

// Loops over lanes and rows of pixels are compiled for several instruction sets; the fastest that the
// processor has is chosen when the program starts. Sanitizers instrument the choice itself and break it.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__OPTIMIZE__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define EXTPERFC_LANES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define EXTPERFC_LANES
#endif
