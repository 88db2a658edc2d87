#pragma once

#include <optional>

#include <gtest/gtest.h>

#include "extperfc/localize/localizer.hpp"

#include "test/unit/localize/plan.hpp"

namespace extperfc::localize {

/// A robot that drives through a plan; its odometry starts somewhere else and has noise.
class Drive {
 public:
  Drive(const Plan& plan, const Pose2& start, std::uint64_t seed) : plan_(plan), truth_(start), rng_(seed) {}

  /// Moves by `step` in the robot's frame. Odometry errs by 3 % and 0.3 degrees per step.
  void move(const Pose2& step) {
    truth_ = compose(truth_, step);
    const double distance = std::hypot(step.x, step.y);
    odom_ = compose(odom_, {step.x + rng_.normal(0, 0.03) * distance,
                            step.y + rng_.normal(0, 0.03) * distance, step.yaw + rng_.normal(0, 0.005)});
  }
  /// The robot stands against something: only its wheels move.
  void slip(const Pose2& step) { odom_ = compose(odom_, step); }
  /// The robot is carried: odometry does not notice.
  void carry_to(const Pose2& pose) { truth_ = pose; }

  [[nodiscard]] LaserScan scan() { return plan_.scan(truth_, rng_); }
  [[nodiscard]] const Pose2& truth() const { return truth_; }  ///< in the plan
  [[nodiscard]] const Pose2& odom() const { return odom_; }

 private:
  Plan plan_;
  Pose2 truth_;
  Pose2 odom_{17, -4, 2};
  Rng rng_;
};

inline LocalizerParams test_params() {
  LocalizerParams params;
  params.min_particles = 300;
  params.max_particles = 2000;
  params.odom_alpha1 = params.odom_alpha2 = params.odom_alpha3 = params.odom_alpha4 = params.odom_alpha5 =
      0.05;
  return params;
}

inline bool at_truth(const PoseEstimate& estimate, const Pose2& truth) {
  return apart_m(estimate.pose, truth) < 0.2 && apart_rad(estimate.pose, truth) < 0.1;
}

/// Forced updates of a robot that stands until the estimate has been right for five of them; nothing after
/// `max_updates`.
inline std::optional<int> updates_until_found(Localizer& localizer, Drive& drive, int max_updates) {
  int right = 0;
  for (int i = 1; i <= max_updates; ++i) {
    EXPECT_TRUE(localizer.update(drive.scan(), drive.odom(), true));
    right = at_truth(localizer.estimate(), drive.truth()) ? right + 1 : 0;
    if (right == 5) return i;
  }
  return std::nullopt;
}

}  // namespace extperfc::localize
