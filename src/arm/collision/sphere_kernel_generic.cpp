#include "arm/collision/sphere_kernel_body.hpp"

namespace extperfc::arm {

int sphere_kernel_generic(const KernelScene& scene, const float* positions, const KernelMotion* motion,
                          const KernelScratch& scratch) {
  return run_batch(scene, positions, motion, scratch);
}

}  // namespace extperfc::arm
