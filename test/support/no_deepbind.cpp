// AddressSanitizer refuses dlopen() with RTLD_DEEPBIND, which TBB (in OpenCV and OpenVINO) uses for a
// plug-in. Linked into the tests of sanitizer builds only, this takes the flag away.
#include <dlfcn.h>

extern "C" __attribute__((visibility("default"))) void* dlopen(const char* file, int mode) {
  using Open = void* (*)(const char*, int);
  static const auto next = reinterpret_cast<Open>(dlsym(RTLD_NEXT, "dlopen"));
  return next(file, mode & ~RTLD_DEEPBIND);
}
