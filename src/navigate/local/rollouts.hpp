#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "extperfc/navigate/local_planner.hpp"

#include "navigate/local/clearance_field.hpp"
#include "navigate/local/guide.hpp"
#include "navigate/local/path_window.hpp"
#include "navigate/local/people_cost.hpp"
#include "navigate/local/speed_profile.hpp"

namespace extperfc::navigate {

/// What trajectories are rated by in one cycle. Positions are about the robot's.
struct Scene {
  const std::vector<Station>& stations;
  const ClearanceField& field;
  const Outline& outline;
  const Footprint& footprint;
  const PeopleCost& people;
  SpeedRules rules;
  Pose2 robot;     ///< in the grid's frame
  Twist2 current;  ///< velocity
};

/// Sampled trajectories of a cycle: structure of arrays, one column per step, one row per sample. Memory is
/// taken once.
class Rollouts {
 public:
  explicit Rollouts(const MppiParams& params);

  /// Samples about the last solution and about the guide, rolls them out within the limits and rates them.
  void run(const Scene& scene);
  /// The weighted mean becomes the solution (Williams et al. 2017, eq. 34: exp(-cost / temperature)).
  void update_mean();
  /// The solution begins `dt_s` later in the next cycle.
  void shift_mean(double dt_s);
  void reset();

  [[nodiscard]] int samples() const { return static_cast<int>(costs_.size()); }
  [[nodiscard]] int steps() const { return steps_; }
  /// Samples with the smallest costs, best first.
  [[nodiscard]] const std::vector<int>& best() const { return best_; }
  [[nodiscard]] float cost(int sample) const { return costs_[sample]; }
  [[nodiscard]] Twist2 velocity(int sample, int step) const;
  [[nodiscard]] Twist2 mean(int step) const;
  /// In the grid's frame, the robot's pose first.
  void poses(int sample, const Pose2& robot, std::vector<Pose2>& out) const;

  /// The poses of the solution.
  void mean_poses(const Pose2& robot, std::vector<Pose2>& out) const;
  /// The sample becomes the solution.
  void adopt(int sample);

  static constexpr float kCollision = 1000;

 private:
  using Column = Eigen::ArrayXf;
  using Table = Eigen::ArrayXXf;

  void draw_noise(std::uint64_t seed);
  void sample_controls(const Scene& scene);
  void roll_guide(const Scene& scene, int sample, double rate_factor);
  void roll_step(int step);
  void limit_change(int step);
  void rate_step(const Scene& scene, int step);
  [[nodiscard]] float rate_pose(const Scene& scene, int step, int sample);
  [[nodiscard]] float exactness(const Scene& scene, const Station& at) const;
  [[nodiscard]] float people_cost(const Scene& scene, int step, int sample) const;
  [[nodiscard]] float obstacle_cost(const Scene& scene, int step, int sample, const Station& at);
  void rate_ends(const Scene& scene);
  [[nodiscard]] float reference_length(const Scene& scene) const;

  MppiParams params_;
  Guide guide_;
  int steps_;
  int cycle_{0};
  float factor_{1};
  Table noise_[3];          ///< samples x (steps + kOffsets), of unit variance, correlated in time
  Table control_[3];        ///< vx, vy, wz that are wanted, then those that the limits admit
  Table x_, y_, yaw_;       ///< after each step
  Column cos_, sin_;        ///< of the yaw
  Column now_[3];           ///< velocity
  Column a_, b_, c_, d_;    ///< scratch
  Column costs_, lengths_;  ///< lengths: along the path
  std::vector<std::size_t> station_;
  std::vector<char> touched_;
  std::vector<int> best_;
  Eigen::Array<float, Eigen::Dynamic, 3> mean_;  ///< steps x (vx, vy, wz)
};

}  // namespace extperfc::navigate
