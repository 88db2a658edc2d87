#pragma once

// Plain data and functions only: this header is compiled for several instruction sets, and an inline function
// of a library that came out of the widest one would crash older processors.

namespace extperfc::arm {

inline constexpr int kLanes = 8;  ///< states per batch

struct KernelBody {
  int parent;  ///< -1 for body 0
  int joint;
  float multiplier, offset;
  bool prismatic;
  float rotation[9];     ///< of parent_T_joint, row by row
  float translation[3];  ///< [m]
  float ball[3];         ///< centre of a ball about all parts, in the body's frame
  float ball_radius;
};

struct KernelSphere {
  float centre[3];  ///< in the body's frame [m]
  float radius;
};

struct KernelPart {
  int body;
  KernelSphere ball;  ///< holds the part
  int first_sphere, sphere_end;
};

enum class KernelShape { kBox, kSphere, kCylinder, kCone, kPlanes };

struct KernelObstacle {
  KernelShape shape;
  bool upright;       ///< rotation is the identity
  float centre[3];    ///< in the root frame
  float rotation[9];  ///< root_R_shape, row by row
  float half[3];      ///< as ConvexPart::half
  int first_plane, plane_end;
  float low[3], high[3];  ///< bounding box in the root frame
};

/// A half space of the root frame: normal . x <= offset inside.
struct KernelPlane {
  float normal[3];
  float offset;
};

/// Parts that must keep `padding` from each other, the rounding of this kernel included.
struct KernelPair {
  int part;
  int other;  ///< obstacle, or second part
  float padding;
};

/// The pairs between a body and an obstacle, or between two bodies.
struct KernelGroup {
  int body;
  int other;
  float padding;  ///< largest of the pairs
  int first_pair, pair_end;
};

struct KernelScene {
  const KernelBody* bodies;
  int body_count;
  const KernelPart* parts;
  int part_count;
  const KernelSphere* spheres;
  int sphere_count;
  const KernelObstacle* obstacles;
  const KernelPlane* planes;
  const KernelPair* pairs;
  const KernelGroup* world_groups;
  int world_group_count;
  const KernelGroup* self_groups;
  int self_group_count;
};

/// How far objects can drift from where they are at the middle of an interval of a motion.
struct KernelDrift {
  float shift;  ///< bound of the displacement of any point [m]
  float bend;   ///< bound of its part that is not linear in time [m]
};

struct KernelMotion {
  const float* rates;              ///< per body: rate of its joint
  float half;                      ///< half length of the interval, in the parameter that the rates are per
  const KernelDrift* world_drift;  ///< per body
  const KernelDrift* self_drift;   ///< per self group: of both bodies together
};

/// A pair that the spheres do not clear, and the lanes in which they do not (bit i: lane i).
struct KernelFlag {
  int pair;
  unsigned lanes;
};

/// Memory of one caller. Floats must be aligned to 4 * kLanes bytes.
struct KernelScratch {
  float* floats;         ///< kernel_floats(scene)
  unsigned char* bytes;  ///< part_count * 2
  KernelFlag* flags;     ///< as many as there are pairs
};

constexpr int kernel_floats(const KernelScene& scene) {
  return kLanes * (22 * scene.body_count + 3 * scene.part_count + 3 * scene.sphere_count);
}

/// Tests a batch. `positions[joint * kLanes + lane]`, finite, at most some hundred rad. With `motion`, a pair
/// is cleared only if it stays apart over the whole interval. Returns the number of flags.
using KernelFunction = int (*)(const KernelScene& scene, const float* positions, const KernelMotion* motion,
                               const KernelScratch& scratch);

/// The best one for this processor.
[[nodiscard]] KernelFunction sphere_kernel();
[[nodiscard]] const char* sphere_kernel_name();

int sphere_kernel_generic(const KernelScene& scene, const float* positions, const KernelMotion* motion,
                          const KernelScratch& scratch);
#ifdef EXTPERFC_AVX2_KERNEL
int sphere_kernel_avx2(const KernelScene& scene, const float* positions, const KernelMotion* motion,
                       const KernelScratch& scratch);
#endif

}  // namespace extperfc::arm
