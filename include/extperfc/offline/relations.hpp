#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/trajectory.hpp"

namespace extperfc::offline {

/// Pose of scan `to` in the frame of scan `from`, known independently of the mapper under test.
struct Relation {
  std::size_t from{0};  ///< scans are numbered from 0 in the order of their recording
  std::size_t to{0};
  Pose2 from_T_to;
};

/// Reads lines `i j x y z roll pitch yaw` [m, rad], `#` comments; z, roll and pitch are passed over. Errors
/// name the file and the line.
[[nodiscard]] Result<std::vector<Relation>> read_relations(const std::filesystem::path& file);

/// Of a set of errors. Standard deviations are of the set itself (divided by its size).
struct ErrorStatistics {
  double mean{0};
  double deviation{0};
  double squared_mean{0};  ///< of the squared errors
  double squared_deviation{0};
  double worst{0};
};

/// One group of relations. Absolute values: lengths in metres, angles in degrees.
struct GroupScore {
  std::size_t relations{0};
  ErrorStatistics translation_m;
  ErrorStatistics rotation_deg;
};

struct RelationError {
  std::size_t relation{0};  ///< into the relations
  double translation_m{0};
  double rotation_deg{0};  ///< [0, 180]
};

/// The metric of Kuemmerle et al., "On Measuring the Accuracy of SLAM Algorithms", Autonomous Robots 27
/// (2009), section 3: each relation against the same relation of the trajectory, the difference delta (-)
/// delta* split into its length and its angle.
struct RelationsScore {
  GroupScore all;
  GroupScore neighbours;
  GroupScore loops;                   ///< relations that span more scans than a limit
  std::size_t unmatched{0};           ///< relations to scans without a pose
  std::vector<RelationError> errors;  ///< of every scored relation, in the file's order
};

/// Relations that span more than this many scans close a loop.
constexpr std::size_t kLoopSpan = 100;

struct ScoreOptions {
  Pose2 base_T_scanner;  ///< relations are between scanners, poses those of the robot
  std::size_t loop_span{kLoopSpan};
};

/// `poses` of the robot by the scan's number; no value where the trajectory has none.
[[nodiscard]] RelationsScore score_relations(const std::vector<Relation>& relations,
                                             const std::vector<std::optional<Pose2>>& poses,
                                             const ScoreOptions& options = {});

/// The `count` relations with the largest translational errors, worst first.
[[nodiscard]] std::vector<RelationError> worst_relations(const RelationsScore& score, std::size_t count);

/// One scan of the recording that a trajectory belongs to.
struct ScanMoment {
  std::size_t index{0};  ///< the scan's number
  double stamp_s{0};
  std::optional<Pose2> odom_T_base;
};

/// A pose for each scan number. With as many poses as scans they belong together one by one. Else they are
/// matched by stamps, both in their order (stamps may run backwards), and scans between two poses get
/// odometry's path from the pose before, deformed so that it ends at the pose behind. Errors: a pose whose
/// stamp no scan has.
[[nodiscard]] Result<std::vector<std::optional<Pose2>>> poses_of_scans(const Trajectory& trajectory,
                                                                       const std::vector<ScanMoment>& scans);

}  // namespace extperfc::offline
