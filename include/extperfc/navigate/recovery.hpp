#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/navigate/cost_grid.hpp"
#include "extperfc/navigate/footprint.hpp"
#include "extperfc/navigate/nav_error.hpp"
#include "extperfc/navigate/velocity.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::navigate {

enum class RecoveryStep {
  kWait,     ///< until a person in front walks on
  kClear,    ///< forget obstacles that sensors saw, beyond the robot
  kBackOff,  ///< drive back to where it came from, as far as the footprint stays free
  kRotate,   ///< in place, as far as the footprint stays free
  kAvoid,    ///< replan with high costs at the blocked place
  kYield,    ///< drive to a place where a person in front can pass
};

/// "wait", "clear", "back off", "rotate", "avoid", "yield".
[[nodiscard]] const char* to_string(RecoveryStep step);

struct RecoveryParams {
  double wait_s{3.0};          ///< [0, 600]
  double back_off_m{0.6};      ///< [0, 5]; 0: never, and never yields
  double back_off_m_s{0.15};   ///< (0, 1]
  double rotate_rad{1.6};      ///< [0, 6.3]
  double rotate_rad_s{0.5};    ///< (0, 3]
  double clear_beyond_m{1.0};  ///< nearer obstacles are kept, [0, 100]
  double avoid_ahead_m{0.9};   ///< from the robot to the middle of what is avoided, [0, 10]
  double avoid_radius_m{0.6};  ///< (0, 10]
  double avoid_person_m{1.5};  ///< in its place about a person: the whole width of a corridor, (0, 10]
  double same_place_m{0.5};    ///< attempts at places nearer than this are at one place, (0, 100]
  int max_attempts{15};        ///< without coming nearer to the goal, [1, 1000]
};

/// What a step needs to know, every cycle. Pointers are valid during the call.
struct RecoveryView {
  double now_s{0};  ///< of a clock that never runs back
  Pose2 map_T_base;
  Pose2 odom_T_base;
  const CostGrid* costs{nullptr};  ///< local, in the frame odom
  const Footprint* footprint{nullptr};
  const std::deque<Pose2>* trail{nullptr};  ///< where the robot came from, in odom, oldest first
  const VelocityLimits* limits{nullptr};
  std::optional<Eigen::Vector2d> person_m{};  ///< who may be the cause, in the frame map
};

/// A disc of the map that plans shall avoid.
struct AvoidedPlace {
  Eigen::Vector2d middle_m{Eigen::Vector2d::Zero()};  ///< in the frame map
  double radius_m{0.6};
};

struct RecoveryOutput {
  Twist2 velocity;
  std::optional<double> clear_beyond_m{};       ///< clear the cost maps now
  std::optional<AvoidedPlace> avoid{};          ///< from now on, for this goal
  bool done{false};                             ///< plan again
  std::optional<Eigen::Vector2d> yield_to_m{};  ///< plan to a place where this person can pass, map
};

/// The ladder of a robot that is stuck: wait, clear, back off, avoid, rotate; with a person near, yielding
/// and avoid come after wait, and where there is no path or the goal is occupied, yielding comes first. A
/// step that did not help at a place is never tried there again for this goal. One thread at a time.
class Recovery {
 public:
  /// Throws std::invalid_argument for parameters out of their range.
  explicit Recovery(const RecoveryParams& params);
  /// Throws as the constructor.
  void set_params(const RecoveryParams& params);

  /// Forgets everything: a new goal.
  void reset();
  /// The next step for this cause at this place, with its reason in one line. Empty: none is left.
  [[nodiscard]] std::optional<std::string> begin(const NavError& cause, const RecoveryView& view);
  /// Precondition: begin() gave a step, and no update() since said done.
  [[nodiscard]] RecoveryOutput update(const RecoveryView& view);
  /// Whether a person is near to whom the robot has not yielded at this place.
  [[nodiscard]] bool may_yield(const RecoveryView& view) const {
    return possible(RecoveryStep::kYield, view) && !tried(RecoveryStep::kYield, view.map_T_base);
  }
  /// The robot drives on after the last step: that step may be tried again here.
  void helped();
  /// The robot is nearer to the goal than ever: attempts are counted anew.
  void advanced() { attempts_ = 0; }
  [[nodiscard]] RecoveryStep step() const { return step_; }
  /// Steps begun for this goal.
  [[nodiscard]] int count() const { return count_; }

 private:
  struct Attempt {
    RecoveryStep step;
    Pose2 map_T_base;
  };

  [[nodiscard]] bool tried(RecoveryStep step, const Pose2& map_T_base) const;
  [[nodiscard]] bool possible(RecoveryStep step, const RecoveryView& view) const;
  [[nodiscard]] std::string reason(const NavError& cause, const Pose2& map_T_base) const;
  [[nodiscard]] RecoveryOutput back_off(const RecoveryView& view);
  [[nodiscard]] RecoveryOutput rotate(const RecoveryView& view);
  [[nodiscard]] AvoidedPlace avoided(const RecoveryView& view) const;

  RecoveryParams params_;
  std::vector<Attempt> attempts_here_;
  RecoveryStep step_{RecoveryStep::kWait};
  double began_s_{0};
  bool fresh_{false};  ///< no update yet
  Pose2 began_at_;     ///< in odom
  double rotation_sign_{1};
  int attempts_{0};
  int count_{0};
};

/// Whether a motion of the base is safe by these costs: free all along or, where the footprint touches
/// already, no deeper into what it touches.
[[nodiscard]] bool is_safe_motion(const CostGrid& costs, const Footprint& footprint, const Pose2& from,
                                  const Pose2& to);

}  // namespace extperfc::navigate
