#pragma once

#include <memory>
#include <vector>

#include "arm/collision/scene.hpp"
#include "arm/collision/sphere_kernel.hpp"

namespace extperfc::arm {

/// A Scene in the kernel's layout, rounded to the safe side: what the kernel clears in single precision is
/// apart in exact arithmetic. Pair k of the kernel is pair k of the scene.
class KernelTables {
 public:
  KernelTables(const Bodies& bodies, const Scene& scene);

  [[nodiscard]] KernelScene view() const;

 private:
  void add_bodies(const Bodies& bodies, const Scene& scene);
  void add_parts(const Scene& scene);
  void add_obstacles(const Scene& scene);
  void add_pairs(const Scene& scene);

  std::vector<KernelBody> bodies_;
  std::vector<KernelPart> parts_;
  std::vector<KernelSphere> spheres_;
  std::vector<KernelObstacle> obstacles_;
  std::vector<KernelPlane> planes_;
  std::vector<KernelPair> pairs_;
  std::vector<KernelGroup> world_groups_, self_groups_;
};

/// Aligned memory for one caller of the kernel.
class KernelMemory {
 public:
  explicit KernelMemory(const KernelScene& scene);
  [[nodiscard]] const KernelScratch& scratch() const { return scratch_; }
  /// kMaxJoints * kLanes floats, the kernel's input.
  [[nodiscard]] float* positions() { return positions_; }

 private:
  struct Release {
    void operator()(float* memory) const;
  };
  std::unique_ptr<float, Release> floats_;
  std::vector<unsigned char> bytes_;
  std::vector<KernelFlag> flags_;
  float* positions_{nullptr};
  KernelScratch scratch_{};
};

}  // namespace extperfc::arm
