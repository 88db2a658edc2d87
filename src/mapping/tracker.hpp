#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "extperfc/world/pose.hpp"

#include "mapping/key_frame.hpp"
#include "mapping/matcher.hpp"
#include "mapping/scan_points.hpp"
#include "mapping/surface_map.hpp"
#include "mapping/visibility.hpp"
#include "mapping/wheel_spin.hpp"

namespace extperfc::mapping {

/// How much odometry may be trusted; see MapperParams.
struct OdometryNoise {
  double srr{0.1};
  double srt{0.1};
  double str{0.1};
  double stt{0.1};
};

struct Tracked {
  Pose2 pose;                                            ///< of the base in the tracker's own, drifting frame
  Eigen::Matrix3d information{Eigen::Matrix3d::Zero()};  ///< of x, y, yaw in that frame, prior included
  double fit{0};                                         ///< see ScanMatch
  bool matched{false};                                   ///< false: odometry alone gave the pose
  bool odometry_contradicted{false};
  /// The scan shows other surroundings than those about the robot: nothing is added to the local map.
  bool lost{false};
  /// So did all of the latest scans: the robot was carried, and tracking begins anew with this scan.
  bool carried{false};
  /// What the scan and the wheels disagree by, or what no scan measures, as a covariance of x, y, yaw in that
  /// frame; zero when they agree.
  Eigen::Matrix3d doubt{Eigen::Matrix3d::Zero()};
};

/// Scan-to-map tracking: matches every scan to the surfaces seen over the last metres, with odometry (without
/// odometry the last motion) as prior. Precise over a room, drifts over a building. Where the scan hardly
/// constrains the position along a corridor and the match deviates from odometry more than srr and str allow,
/// odometry decides along that direction, until what faces it shows that the wheels spin; compare degenerate
/// directions in Zhang, Kaess and Singh, "On Degeneracy of Optimization-based State Estimation Problems",
/// ICRA 2016.
class Tracker {
 public:
  static constexpr std::size_t kMinPoints = 12;  ///< fewer do not determine a pose

  Tracker(const OdometryNoise& noise, double minimum_fit) : noise_(noise), minimum_fit_(minimum_fit) {}

  /// gap_s: since the scan before; 0: not known.
  [[nodiscard]] Tracked add(const ScanPoints& points, const std::optional<Pose2>& odom_T_base,
                            double gap_s = 0);
  [[nodiscard]] const Pose2& pose() const { return pose_; }
  /// Resumes at `pose`, using the key frames about it as local map, in the frame of their `poses`. The robot
  /// may stand a step away from there, and its odometry may begin anywhere.
  void resume_from(const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses, const Pose2& pose);
  /// The same without a local map yet.
  void begin_at(const Pose2& pose);
  /// The robot may have been carried since the last scan.
  void expect_elsewhere() { resuming_ = true; }
  /// Takes the `chosen` key frames as local map, the last of which are nearest; from now on scans are not
  /// added to it.
  void use_as_map(const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses,
                  const std::vector<std::size_t>& chosen);

 private:
  struct Remembered {
    Pose2 pose;
    ScanPoints points;
    RangeProfile profile;
    bool held{false};  ///< placed while odometry decided along a corridor
  };
  /// Recent deviation of the matches from odometry along directions that scans hardly constrain.
  struct Slide {
    Eigen::Vector2d off_m{0, 0};  ///< in the tracker's frame
    double wheels_m{0};           ///< expected error of wheel odometry over the same distance
  };

  struct Window {
    double m{0};
    double rad{0};
  };
  [[nodiscard]] Window window_about(const Pose2& expected) const;
  [[nodiscard]] bool jumps(const std::optional<Pose2>& odom_T_base) const;
  [[nodiscard]] bool drove_unseen(const Pose2& there) const;
  [[nodiscard]] Pose2 expected_step(const std::optional<Pose2>& odom_T_base) const;
  [[nodiscard]] PosePrior prior(const Pose2& step, bool has_odometry) const;
  void match_scan(const ScanPoints& points, const PosePrior& prior, Tracked& tracked) const;
  void watch_place(const ScanPoints& points, const PosePrior& prior, Tracked& tracked);
  void watch_slide(const ScanPoints& points, const PosePrior& prior, const Pose2& step, Tracked& tracked);
  void hold(const ScanPoints& points, PosePrior prior, Tracked& tracked);
  void begin_hold(const Eigen::Vector2d& along);
  void judge_hold(const ScanPoints& points, Tracked& tracked);
  void end_hold();
  [[nodiscard]] bool is_unusual(const ScanMatch& match) const;
  [[nodiscard]] bool shows_elsewhere(const ScanPoints& points, const PosePrior& prior,
                                     const Tracked& tracked) const;
  [[nodiscard]] double common_with_last(const ScanPoints& points, const Pose2& step,
                                        const Window& window) const;
  [[nodiscard]] double support(const ScanPoints& points, const Pose2& pose) const;
  struct StepError {
    double m{0};
    double rad{0};
  };
  [[nodiscard]] StepError usual_error(const Pose2& step) const;
  [[nodiscard]] bool disagrees(const Pose2& matched, const Pose2& step, const Pose2& by_wheels) const;
  [[nodiscard]] Eigen::Matrix3d doubt(const Tracked& tracked, const Pose2& step,
                                      const PosePrior& prior) const;
  [[nodiscard]] Eigen::Matrix3d reckoned(const Pose2& step, bool has_odometry) const;
  [[nodiscard]] Eigen::Matrix3d unmeasured(const Tracked& tracked) const;
  [[nodiscard]] ScanMatch look_wider(const ScanPoints& points, const PosePrior& prior,
                                     const ScanMatch& first) const;
  void restart();
  void take(const std::vector<KeyFrame>& frames, const std::vector<Pose2>& poses,
            const std::vector<std::size_t>& chosen);
  void redraw();
  void remember(const ScanPoints& points, const Pose2& pose);

  OdometryNoise noise_;
  double minimum_fit_;
  Pose2 pose_;
  Pose2 last_step_;
  std::optional<Pose2> last_odometry_;
  std::deque<Remembered> recent_;
  SurfaceMap map_;
  ScanPoints last_scan_;
  Slide slide_;
  std::optional<WheelSpin> wheel_spin_;  ///< while odometry decides along a corridor
  double longest_step_m_{0};             ///< of the latest scans
  double usual_fit_{0};                  ///< of the latest scans
  double gap_s_{0};       ///< between the last two scans; 0: not known, or too long for odometry
  bool resuming_{false};  ///< until a scan matches, it is looked for in a wider window
  int lost_scans_{0};     ///< the latest ones, one after another
  bool fixed_{false};     ///< scans are not added to the local map
};

}  // namespace extperfc::mapping
