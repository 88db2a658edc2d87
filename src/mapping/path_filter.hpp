#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "extperfc/base/rng.hpp"
#include "extperfc/world/pose.hpp"

#include "mapping/key_frame.hpp"
#include "mapping/matcher.hpp"
#include "mapping/pose_graph.hpp"
#include "mapping/relative_uncertainty.hpp"
#include "mapping/submap_cache.hpp"
#include "mapping/visibility.hpp"

namespace extperfc::mapping {

struct PathFilterParams {
  int particles{30};
  double resample_threshold{0.5};
  std::uint64_t seed{1};
};

/// The step from one key frame to the next as the tracker saw it.
struct TrackedStep {
  Pose2 step;                   ///< in the frame of the earlier key frame
  Eigen::Matrix3d information;  ///< of x, y, yaw there
  double distance_m{0};         ///< distance travelled
  /// What scans and wheels disagreed by, as a covariance of x, y, yaw there.
  Eigen::Matrix3d doubt{Eigen::Matrix3d::Zero()};
};

/// An approximate pose of the robot that the user gives.
struct StartPose {
  Pose2 pose;                  ///< in the map
  Eigen::Matrix3d covariance;  ///< of x, y, yaw there
};

/// A key frame that matched an old submap.
struct LoopClosureCandidate {
  Constraint constraint;
  double fit{0};
};

/// The back end: a Rao-Blackwellised particle filter over key frames (Grisetti, Stachniss and Burgard 2005).
///
/// Each particle is a hypothesis of the path since the last accepted loop closure: the pose of the last key
/// frame. It moves by the tracked step and a sample of its noise. Near an old submap its scan is matched to
/// that submap (the improved proposal), and the fit weights the particle. Particles share the submaps,
/// because hypotheses differ by their pose in the same submaps only. When the particles agree and have enough
/// loop-closure candidates, these become constraints of a pose graph, whose optimization distributes the
/// correction over the path. Hypotheses that would deform the path too much are rejected.
class PathFilter {
 public:
  struct Particle {
    Pose2 pose;
    double log_weight{0};
    std::vector<LoopClosureCandidate> candidates;  ///< since the last accepted loop closure; bounded
    bool injected{false};                          ///< came from a wide search: needs more candidates
  };

  struct Step {
    bool accepted{false};     ///< a loop closure was accepted
    bool map_changed{false};  ///< poses of old key frames changed by more than centimetres
  };

  explicit PathFilter(const PathFilterParams& params);

  /// The first key frame, at `pose`.
  void begin(const Pose2& pose, KeyFrame frame);
  Step add(const TrackedStep& step, KeyFrame frame);
  /// A key frame of a robot that was carried: at `start`, or anywhere. Then it begins a new part of the map,
  /// which a search joins to the others when it recognizes a place.
  /// `driven`: the step since the last key frame as odometry has it, in case that the robot was not carried.
  void add_carried(const std::optional<StartPose>& start, const std::optional<Pose2>& driven, KeyFrame frame);
  /// Drops the points of these key frames; their poses and constraints stay.
  void thin(const std::vector<std::size_t>& frames);
  /// A search of the whole path for loop closures: a copy, so that it can run in another thread while key
  /// frames are added here. Seconds for a long path.
  struct Search {
    std::vector<KeyFrame> frames;
    PoseGraph graph;
    std::vector<Constraint> driven;

    void run();
  };
  [[nodiscard]] Search search() const;
  /// Takes over what a search found; key frames that came meanwhile stay. False, and nothing happens, when it
  /// is not of this path.
  bool adopt(Search search);
  /// The same search at the end of a recording, where fewer candidates suffice; without the copy.
  void finish();

  [[nodiscard]] const std::vector<KeyFrame>& frames() const { return frames_; }
  [[nodiscard]] const std::vector<Pose2>& poses() const { return graph_.poses(); }
  [[nodiscard]] const PoseGraph& graph() const { return graph_; }
  [[nodiscard]] const std::vector<Particle>& particles() const { return particles_; }
  [[nodiscard]] double effective_particles() const { return effective_; }
  [[nodiscard]] double entropy() const;
  [[nodiscard]] std::vector<double> weights() const;  ///< sum to one
  /// Of the newest key frame, relative to the first.
  [[nodiscard]] const RelativeUncertainty& uncertainty() const { return known_.back(); }
  /// Spread of the particles' poses: x, y, yaw.
  [[nodiscard]] Eigen::Matrix3d covariance() const;
  [[nodiscard]] std::size_t loops() const { return loops_; }
  /// Number of parts whose poses relative to each other are unknown.
  [[nodiscard]] std::size_t parts() const;
  [[nodiscard]] std::size_t resamplings() const { return resamplings_; }

  /// Restores the state from graph() and frames() of an earlier filter.
  void restore(std::vector<KeyFrame> frames, PoseGraph graph);

 private:
  struct SubmapMatch;

  void move_particles(const TrackedStep& step);
  void find_loop_closures();
  [[nodiscard]] std::vector<std::size_t> old_key_frames_near(const Pose2& pose, double radius_m,
                                                             std::size_t max_count) const;
  [[nodiscard]] std::size_t old_end() const;
  [[nodiscard]] std::optional<SubmapMatch> match_submap(std::size_t submap, const Pose2& pose, double sigma_m,
                                                        double sigma_rad);
  bool match_to_submaps(Particle& particle);
  void search_far();
  void inject(const SubmapMatch& found);
  void normalize_weights();
  void resample();
  [[nodiscard]] bool determined(const Particle& particle) const;
  [[nodiscard]] bool is_consistent(std::size_t best) const;
  [[nodiscard]] bool was_refused(const Pose2& correction) const;
  Step accept(std::size_t best);
  void accept_rest();
  bool optimize_accepted(double moved_m);
  void collapse();
  [[nodiscard]] double expected_drift_m() const;
  [[nodiscard]] double farthest_offset_m(std::size_t submap) const;
  bool rematch(Constraint& constraint);
  [[nodiscard]] double estimated_fit(const std::vector<std::size_t>& closures, double present_fit);
  void know_newest();
  void know_again();
  void know_closed();
  bool review(std::size_t constraints_before);

  /// A correction that contradicted earlier loop closures, which fitted better.
  struct Refusal {
    Pose2 correction;  ///< of the newest key frame
    double at_m{0};    ///< distance travelled then
  };

  PathFilterParams params_;
  Rng rng_;
  std::vector<KeyFrame> frames_;
  PoseGraph graph_;
  SubmapCache submaps_;
  std::vector<RelativeUncertainty> known_;  ///< of each key frame, relative to the first
  std::vector<Constraint> driven_;          ///< unknown steps as odometry has them
  std::vector<std::size_t> parts_;          ///< of each key frame: the number of its part of the map
  std::optional<RangeProfile> profile_;     ///< of the newest key frame
  std::vector<Particle> particles_;
  double effective_{0};
  std::optional<Refusal> refused_;      ///< the last one
  double accepted_at_m_{0};             ///< distance travelled at the last accepted loop closure
  std::size_t trusted_constraints_{0};  ///< the last correction began after these
  std::size_t since_optimized_{0};      ///< accepted loop closures since the whole graph was optimized
  std::size_t next_far_{0};             ///< index of the submap that the next wide search uses
  std::size_t loops_{0};
  std::size_t resamplings_{0};
};

}  // namespace extperfc::mapping
