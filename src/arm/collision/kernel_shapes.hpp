#pragma once

// Spheres against obstacles and each other; see kernel_lanes.hpp.

#include "arm/collision/kernel_lanes.hpp"

namespace extperfc::arm {
namespace {

/// Where a ball's centre is, how it moves, and what it must keep.
///
/// A convex set's distance from a point p(t) = p + v t + e, |e| <= bend for |t| <= half, is at least
/// d + n.v t - bend, with d and its gradient n taken at t = 0. So lanes are cleared when
/// d - |n.v| half - bend >= limit; whoever moves less than `shift` is cleared by d >= limit + shift at once.
struct Probe {
  Lanes3 centre;
  float limit;        ///< radius and padding
  KernelDrift drift;  ///< of the motion
  float half;
  const Lanes3* twist;  ///< angular velocity of the body, then the velocity of its point at the root's origin
};

inline Lanes3 velocity(const Probe& probe) {
  const Lanes3& w = probe.twist[0];
  const Lanes3& v = probe.twist[1];
  const Lanes3& p = probe.centre;
  return {v.x + w.y * p.z - w.z * p.y, v.y + w.z * p.x - w.x * p.z, v.z + w.x * p.y - w.y * p.x};
}

/// Not cleared, by the squared distance `square` alone.
inline Mask too_near(Lanes square, float limit) {
  return ~(square >= limit * limit);
}

/// Not cleared, when `along` is half the rate of `square`, the squared distance.
inline Mask too_near_moving(Lanes square, Lanes along, float limit, const Probe& probe) {
  return ~(square - magnitude(along) * probe.half >= root(square) * (limit + probe.drift.bend));
}

inline Lanes3 local_velocity(const KernelObstacle& obstacle, const Probe& probe) {
  const Lanes3 v = velocity(probe);
  return obstacle.upright ? v : rotated_back(obstacle.rotation, v);
}

template <bool kMoving>
inline Mask near_box(const KernelObstacle& obstacle, const Lanes3& p, const Probe& probe) {
  const Lanes zero{};
  const Lanes3 out{larger(magnitude(p.x) - obstacle.half[0], zero),
                   larger(magnitude(p.y) - obstacle.half[1], zero),
                   larger(magnitude(p.z) - obstacle.half[2], zero)};
  const Lanes square = dot(out, out);
  if (!kMoving) return too_near(square, probe.limit);
  const Mask doubtful = too_near(square, probe.limit + probe.drift.shift);
  if (bits(doubtful) == 0) return doubtful;
  const Lanes3 v = local_velocity(obstacle, probe);
  const Lanes along =
      out.x * (p.x < 0 ? -v.x : v.x) + out.y * (p.y < 0 ? -v.y : v.y) + out.z * (p.z < 0 ? -v.z : v.z);
  return doubtful & too_near_moving(square, along, probe.limit, probe);
}

template <bool kMoving>
inline Mask near_sphere(const KernelObstacle& obstacle, const Lanes3& p, const Probe& probe) {
  const float limit = probe.limit + obstacle.half[0];
  const Lanes square = dot(p, p);
  if (!kMoving) return too_near(square, limit);
  const Mask doubtful = too_near(square, limit + probe.drift.shift);
  if (bits(doubtful) == 0) return doubtful;
  return doubtful & too_near_moving(square, dot(p, local_velocity(obstacle, probe)), limit, probe);
}

template <bool kMoving>
inline Mask near_cylinder(const KernelObstacle& obstacle, const Lanes3& p, const Probe& probe) {
  const Lanes zero{};
  const Lanes across = root(p.x * p.x + p.y * p.y);
  const Lanes side = larger(across - obstacle.half[0], zero);
  const Lanes end = larger(magnitude(p.z) - obstacle.half[2], zero);
  const Lanes square = side * side + end * end;
  if (!kMoving) return too_near(square, probe.limit);
  const Mask doubtful = too_near(square, probe.limit + probe.drift.shift);
  if (bits(doubtful) == 0) return doubtful;
  const Lanes3 v = local_velocity(obstacle, probe);
  const Lanes outward = (p.x * v.x + p.y * v.y) / larger(across, all(1e-12F));
  const Lanes along = side * outward + end * (p.z < 0 ? -v.z : v.z);
  return doubtful & too_near_moving(square, along, probe.limit, probe);
}

/// Not cleared, by the distance bound `bound` of a plane that moves against the probe at `rate`.
template <bool kMoving>
inline Mask below(Lanes bound, Lanes rate, const Probe& probe) {
  if (!kMoving) return ~(bound >= probe.limit);
  return ~(bound >= probe.limit + probe.drift.shift) &
         ~(bound - magnitude(rate) * probe.half >= probe.limit + probe.drift.bend);
}

/// The cone's distance is at least that from its side, prolonged, and from the plane of its base.
template <bool kMoving>
inline Mask near_cone(const KernelObstacle& obstacle, const Lanes3& p, const Probe& probe) {
  const float radius = obstacle.half[0], half = obstacle.half[2];
  const float slope = __builtin_sqrtf(4 * half * half + radius * radius);
  const float out = 2 * half / slope, up = radius / slope;
  const Lanes across = root(p.x * p.x + p.y * p.y);
  const Lanes side = out * across + up * (p.z - half);
  const Lanes base = -half - p.z;
  const Mask use_side = side > base;
  Lanes rate{};
  if (kMoving) {
    const Lanes3 v = local_velocity(obstacle, probe);
    const Lanes outward = (p.x * v.x + p.y * v.y) / larger(across, all(1e-12F));
    rate = use_side ? out * outward + up * v.z : -v.z;
  }
  return below<kMoving>(use_side ? side : base, rate, probe);
}

template <bool kMoving>
inline Mask near_planes(const KernelObstacle& obstacle, const KernelPlane* planes, const Probe& probe) {
  Lanes bound = all(-1e30F);
  Lanes3 normal{};
  for (int i = obstacle.first_plane; i < obstacle.plane_end; ++i) {
    const float* n = planes[i].normal;
    const Lanes height =
        n[0] * probe.centre.x + n[1] * probe.centre.y + n[2] * probe.centre.z - planes[i].offset;
    const Mask higher = height > bound;
    bound = higher ? height : bound;
    if (kMoving) {
      normal.x = higher ? all(n[0]) : normal.x;
      normal.y = higher ? all(n[1]) : normal.y;
      normal.z = higher ? all(n[2]) : normal.z;
    }
  }
  return below<kMoving>(bound, kMoving ? dot(normal, velocity(probe)) : Lanes{}, probe);
}

/// Lanes in which the probe is not cleared of the obstacle.
template <bool kMoving>
inline Mask near_obstacle(const KernelScene& scene, const KernelObstacle& obstacle, const Probe& probe) {
  if (obstacle.shape == KernelShape::kPlanes) return near_planes<kMoving>(obstacle, scene.planes, probe);
  Lanes3 p = minus(probe.centre, obstacle.centre);
  if (!obstacle.upright) p = rotated_back(obstacle.rotation, p);
  switch (obstacle.shape) {
    case KernelShape::kBox:
      return near_box<kMoving>(obstacle, p, probe);
    case KernelShape::kSphere:
      return near_sphere<kMoving>(obstacle, p, probe);
    case KernelShape::kCylinder:
      return near_cylinder<kMoving>(obstacle, p, probe);
    case KernelShape::kCone:
    case KernelShape::kPlanes:
      break;
  }
  return near_cone<kMoving>(obstacle, p, probe);
}

/// Lanes in which two balls are not cleared of each other; `limit` holds both radii and the padding. The rate
/// of a distance is the same in every frame, so both velocities may be those in the root's frame.
template <bool kMoving>
inline Mask near_probe(const Probe& a, const Probe& b, float limit) {
  const Lanes3 apart = minus(a.centre, b.centre);
  const Lanes square = dot(apart, apart);
  if (!kMoving) return too_near(square, limit);
  const Mask doubtful = too_near(square, limit + a.drift.shift);
  if (bits(doubtful) == 0) return doubtful;
  const Lanes along = dot(apart, minus(velocity(a), velocity(b)));
  return doubtful & too_near_moving(square, along, limit, a);
}

}  // namespace
}  // namespace extperfc::arm
