#pragma once

#include <cstdint>
#include <vector>

#include "extperfc/arm/srdf.hpp"
#include "extperfc/base/error.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc::arm {

struct CollisionMatrixParams {
  int samples{20000};  ///< random positions of all joints; 1 to 10 million
  std::uint64_t seed{1};
  double clearance_m{
      0.02};  ///< pairs that came nearer than this are checked, though they never touched; 0 to 1
  /// Pairs on one chain with at most this many moving joints between them count as neighbours: 0 to 10.
  int neighbour_joints{3};
  double neighbour_ratio{
      0.1};  ///< neighbours that touch in more than this fraction of the samples are not checked; [0, 1]
  double always{0.95};  ///< pairs that touch in at least this fraction of the samples are not checked; (0, 1]
};

/// Pairs of links that need no check, found by trying random positions of all joints within their limits
/// (continuous joints: one revolution). The reasons are
/// - Rigid: no moving joint between them;
/// - Adjacent: one carries the other, by moving joints and links without shapes only;
/// - Always: in contact in a fraction `always` of the samples, the shapes overlap by design;
/// - Neighbours: at most `neighbour_joints` between them on one chain (the robot's root body left out), and
///   in contact in a fraction `neighbour_ratio`: rough shapes that overlap where the chain bends, as a wrist
///   and its forearm do. The limits of the joints between guard such pairs;
/// - Never: nearer than `clearance_m` in no sample; in contact in no sample, if a single joint moves one
///   against the other. What holds in n samples fails, with a confidence of 95 %, in less than a fraction
///   3 / n of all positions.
///
/// Sorted by names. Errors: a parameter out of its range, an unreadable mesh. O(samples * shapes^2).
[[nodiscard]] Result<std::vector<DisabledPair>> find_disabled_pairs(const RobotModel& robot,
                                                                    const CollisionMatrixParams& params = {});

}  // namespace extperfc::arm
