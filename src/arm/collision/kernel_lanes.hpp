#pragma once

// Lanes of floats with the compilers' vector extensions. Everything here has internal linkage: each
// instruction set gets its own.

#include "arm/collision/sphere_kernel.hpp"

#pragma GCC diagnostic ignored \
    "-Wpsabi"  // vectors wider than the processor's are passed inside one file only

namespace extperfc::arm {
namespace {

using Lanes = float __attribute__((vector_size(4 * kLanes)));
using Mask = int __attribute__((vector_size(4 * kLanes)));  // 0 or -1

struct Lanes3 {
  Lanes x, y, z;
};

inline Lanes all(float value) {
  return value - Lanes{};
}

inline Lanes load(const float* values) {
  return *reinterpret_cast<const Lanes*>(values);  // aligned by the caller
}

inline unsigned bits(Mask mask) {
#ifdef __AVX__
  return static_cast<unsigned>(__builtin_ia32_movmskps256(reinterpret_cast<Lanes>(mask)));
#else
  unsigned result = 0;
  for (int i = 0; i < kLanes; ++i) result |= static_cast<unsigned>(mask[i] & 1) << i;
  return result;
#endif
}

inline Lanes larger(Lanes a, Lanes b) {
  return a > b ? a : b;
}

inline Lanes magnitude(Lanes a) {
  return a < 0 ? -a : a;
}

/// Smallest and largest lane.
inline void range(Lanes a, float& low, float& high) {
  low = high = a[0];
  for (int i = 1; i < kLanes; ++i) {
    low = a[i] < low ? a[i] : low;
    high = a[i] > high ? a[i] : high;
  }
}

inline Lanes root(Lanes a) {
  Lanes result;
  for (int i = 0; i < kLanes; ++i) result[i] = __builtin_sqrtf(a[i]);
  return result;
}

inline Lanes dot(const Lanes3& a, const Lanes3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

inline Lanes3 minus(const Lanes3& a, const Lanes3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

inline Lanes3 minus(const Lanes3& a, const float* b) {
  return {a.x - b[0], a.y - b[1], a.z - b[2]};
}

/// transpose(matrix) * v
inline Lanes3 rotated_back(const float* matrix, const Lanes3& v) {
  return {matrix[0] * v.x + matrix[3] * v.y + matrix[6] * v.z,
          matrix[1] * v.x + matrix[4] * v.y + matrix[7] * v.z,
          matrix[2] * v.x + matrix[5] * v.y + matrix[8] * v.z};
}

/// Sine and cosine, |angle| up to some hundred rad, error below 2e-7: reduced to [-pi/4, pi/4] in two steps,
/// then the Taylor-like polynomials of minimum error there.
inline void sine_cosine(Lanes angle, Lanes& sine, Lanes& cosine) {
  constexpr float kTwoOverPi = 0.636619772F;
  constexpr float kHalfPiHigh = 1.5707855225F, kHalfPiLow = 1.0804327e-5F;
  const Lanes half = angle < 0 ? all(-0.5F) : all(0.5F);
  const Mask quarter = __builtin_convertvector(angle * kTwoOverPi + half, Mask);
  const Lanes quarters = __builtin_convertvector(quarter, Lanes);
  const Lanes y = (angle - quarters * kHalfPiHigh) - quarters * kHalfPiLow;
  const Lanes y2 = y * y;
  const Lanes s = y + y * y2 * (-1.66666547e-1F + y2 * (8.33216087e-3F + y2 * -1.95152959e-4F));
  const Lanes c =
      1.0F - 0.5F * y2 + y2 * y2 * (4.16666456e-2F + y2 * (-1.38873163e-3F + y2 * 2.44331571e-5F));
  const Mask swap = -(quarter & 1);
  const Lanes a = swap ? c : s, b = swap ? s : c;
  sine = (quarter & 2) != 0 ? -a : a;
  cosine = ((quarter + 1) & 2) != 0 ? -b : b;
}

}  // namespace
}  // namespace extperfc::arm
