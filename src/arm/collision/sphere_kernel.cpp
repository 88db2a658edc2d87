#include "arm/collision/sphere_kernel.hpp"

namespace extperfc::arm {
namespace {

bool has_avx2() {
#ifdef EXTPERFC_AVX2_KERNEL
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

}  // namespace

KernelFunction sphere_kernel() {
#ifdef EXTPERFC_AVX2_KERNEL
  if (has_avx2()) return sphere_kernel_avx2;
#endif
  return sphere_kernel_generic;
}

const char* sphere_kernel_name() {
  return has_avx2() ? "avx2" : "generic";
}

}  // namespace extperfc::arm
