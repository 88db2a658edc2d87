#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "extperfc/base/error.hpp"
#include "extperfc/world/laser_scan.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"
#include "extperfc/world/trajectory.hpp"

namespace extperfc::mapping {

/// Parameters of the mapper. Standard deviations of odometry follow GMapping: srr and str of the translation
/// per metre and per radian, srt and stt of the rotation per metre and per radian.
struct MapperParams {
  int particles{30};          ///< hypotheses of the path, [1, 1000]
  double resolution_m{0.05};  ///< side of a cell of the map [m], [0.01, 1]
  double max_range_m{0};      ///< maxRange: rays without return are free up to here [m]; 0: they are not used
  double max_usable_range_m{0};     ///< maxUrange: returns beyond do not count [m]; 0: the scan's range_max
  double linear_update_m{0.3};      ///< a key frame after this translation [m], [0.05, 5] ...
  double angular_update_rad{0.25};  ///< ... or this rotation [rad], [0.02, 3.2] ...
  double temporal_update_s{-1};     ///< ... or this time [s]; negative: never by time
  double resample_threshold{0.5};   ///< resample below this fraction of effective particles, [0, 1]
  double minimum_score{0.4};        ///< fraction of a scan that must fit the map for a match to count, [0, 1]
  double srr{0.1};                  ///< [m/m]
  double srt{0.1};                  ///< [rad/m]
  double str{0.1};                  ///< [m/rad]
  double stt{0.1};                  ///< [rad/rad]
  double occupied_threshold{0.25};  ///< occ_thresh: fraction of hits from which a cell is occupied, (0, 1)
  /// Of a place that is seen again and again the scans of this many passes stay, and of as many of the
  /// newest: scans, which take most of the memory, grow with the building; poses and constraints, some
  /// hundred bytes per key frame, with the path. [0, 100]; 0: all scans stay.
  int kept_passes{2};
  std::uint64_t seed{1};  ///< of every random draw
};

/// An error that names the first parameter out of its range.
[[nodiscard]] Result<void> validate(const MapperParams& params);

/// Result of processing one scan.
enum class ScanStatus {
  kKeyFrame,  ///< the scan was added to the map
  kTracked,   ///< the scan gave a pose; the robot is too near the last key frame for another one
  kUnusable,  ///< too few returns for scan matching: the pose follows odometry alone
};

enum class MapperMode {
  kMapping,       ///< scans make the map
  kLocalization,  ///< the map stays as it is; scans give the robot's pose in it
};

struct MapperUpdate {
  ScanStatus status{ScanStatus::kTracked};
  Pose2 pose;  ///< of the base in the map, at the scan's stamp
  /// Of x, y, yaw [m, m, rad], relative to the first key frame: drift since known surroundings included.
  Eigen::Matrix3d covariance;
  double fit{0};                      ///< fraction of the returns that the map explains, [0, 1]
  bool matched{false};                ///< false: odometry (or standing still) alone gave the pose
  bool odometry_contradicted{false};  ///< match and odometry differ widely: slip, a jump, or a wrong match
  /// The scan shows other surroundings than those about the robot; it is not used.
  bool lost{false};
  bool carried{false};      ///< so did the latest scans: the map goes on as a new part
  bool map_changed{false};  ///< a loop was closed: poses of old scans, and the map, changed
};

struct MapperStatistics {
  std::size_t scans{0};
  std::size_t key_frames{0};
  std::size_t thinned_key_frames{0};  ///< of these, whose scans were dropped: others show the same
  std::size_t unusable_scans{0};
  std::size_t odometry_contradictions{0};
  /// Closed so far: known ground that was reached again after 5 m elsewhere, or a correction of more than 0.1
  /// m.
  std::size_t loops{0};
  std::size_t carried{0};  ///< times that the robot was found to stand elsewhere
  /// Parts of the map whose poses relative to each other are unknown: one, and one for each time the robot
  /// was carried to a place that was not recognized yet. They lie side by side.
  std::size_t parts{1};
  std::size_t resamplings{0};
  double effective_particles{0};  ///< of the last key frame, [1, particles]
  double entropy{0};              ///< of the particles' weights [nat]
  double path_m{0};               ///< length of the tracked path [m]
  /// Standard deviation of the newest key frame's position relative to the first, along the direction in
  /// which it is known least [m]. It grows with the distance from known surroundings, until a loop is closed.
  double position_sigma_m{0};
};

struct WeightedPose {
  Pose2 pose;
  double weight{0};  ///< all sum to one
};

/// A search of a whole map for loop closures: Mapper::search() makes it, run() may take its time in any
/// thread while the mapper goes on, Mapper::adopt() takes over what was found.
class LoopSearch {
 public:
  LoopSearch(LoopSearch&&) noexcept;
  LoopSearch& operator=(LoopSearch&&) noexcept;
  ~LoopSearch();

  /// Some 10 s for a path of hundreds of metres.
  void run();

 private:
  friend class Mapper;
  struct Impl;
  explicit LoopSearch(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Simultaneous localization and mapping from planar scans by a Rao-Blackwellised particle filter. One thread
/// at a time. The same input, parameters and seed give the same map.
class Mapper {
 public:
  [[nodiscard]] static Result<Mapper> make(const MapperParams& params);
  Mapper(Mapper&&) noexcept;
  Mapper& operator=(Mapper&&) noexcept;
  ~Mapper();

  /// Adds one scan with the odometry's pose of the base at its stamp, if there is one. Scans may vary in size
  /// from one to the next, and stamps may run backwards. Errors: validate(scan), non-finite odometry.
  [[nodiscard]] Result<MapperUpdate> add(const LaserScan& scan, const std::optional<Pose2>& odom_T_base);

  /// The robot stands about here: in a session that is resumed, or when it was carried. The next scan is
  /// looked for within 1.2 m and 0.6 rad. `covariance` of x, y, yaw in the map [m, m, rad]. Errors: no map
  /// yet, a pose or a covariance that is not finite, a covariance that is not positive definite.
  [[nodiscard]] Result<void> put_at(const Pose2& pose, const Eigen::Matrix3d& covariance);

  /// The robot may have been carried since the last scan: where the next ones do not fit, the map goes on as
  /// a new part.
  void expect_elsewhere();

  /// Switches between mapping and localization in the same map, in both directions, while the robot drives.
  /// During localization memory does not grow, trajectory() stays as it is, and put_at() works as it does
  /// otherwise. A robot that was carried reports `lost` until it is near a place that fits, or is put there.
  /// Mapping then goes on at the pose that localization found. Errors: localization without a map.
  [[nodiscard]] Result<void> set_mode(MapperMode mode);
  [[nodiscard]] MapperMode mode() const;

  /// Of the last scan, in the map.
  [[nodiscard]] Pose2 pose() const;
  /// Hypotheses of the pose of the last key frame.
  [[nodiscard]] std::vector<WeightedPose> particles() const;
  /// The most likely map. The work per call is bounded: after a loop closure several calls redraw the moved
  /// scans, until settled() is true.
  [[nodiscard]] std::shared_ptr<const OccupancyGrid> map();
  [[nodiscard]] bool settled() const;
  /// Changes whenever map() would give another map.
  [[nodiscard]] std::uint64_t map_version() const;
  /// The latest estimate of the pose of every scan so far.
  [[nodiscard]] Trajectory trajectory() const;
  [[nodiscard]] MapperStatistics statistics() const;

  /// Searches the whole map for loop closures now and optimizes the graph, from which mapping continues.
  /// Takes some 10 s for a path of hundreds of metres. map() then redraws the moved scans.
  void optimize();
  /// The same in three steps, so that scans need not wait: search(), its run() in another thread, adopt().
  /// Copies the key frames.
  [[nodiscard]] LoopSearch search() const;
  /// Scans that were added since the search began stay. False, and nothing changes, when the search is not of
  /// this map.
  bool adopt(LoopSearch search);
  /// True when a search may join parts of the map: a robot that was carried has seen enough since.
  [[nodiscard]] bool wants_search() const;
  /// Call after the last scan: final graph optimization and full redraw of the map.
  void finish();

  /// Writes a session, from which `load` continues at the last pose; its odometry may begin anywhere. Errors
  /// name the file and what is wrong with it (missing, damaged, other version).
  [[nodiscard]] Result<void> save(const std::filesystem::path& file) const;
  [[nodiscard]] static Result<Mapper> load(const std::filesystem::path& file, const MapperParams& params);
  /// Adds the map of another session, recognizes the places that both show, and joins them: a minute for long
  /// paths. Mapping goes on at that session's end. Errors: those of load(), and kNotFound when no place was
  /// recognized; nothing changes then.
  [[nodiscard]] Result<void> merge(const std::filesystem::path& file);

 private:
  class Impl;
  explicit Mapper(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace extperfc::mapping
