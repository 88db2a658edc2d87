#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "extperfc/base/rng.hpp"
#include "extperfc/world/pose.hpp"

#include "mapping/key_frame.hpp"
#include "mapping/matcher.hpp"
#include "mapping/place_cache.hpp"
#include "mapping/pose_graph.hpp"
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
  double way_m{0};              ///< travelled, along whatever curve
};

/// A key frame seen to stand somewhere in an old place.
struct Sighting {
  Relation relation;
  double fit{0};
};

/// The back end: a Rao-Blackwellised particle filter over key frames (Grisetti, Stachniss and Burgard 2005).
///
/// Each particle is a hypothesis of the path since the committed one ended: where the last key frame is. It
/// is moved by the tracked step and a draw of its noise; where it would see an old place, its scan is matched
/// to that place's map (the improved proposal) and the fit weighs it. Maps given a path need no copies per
/// particle: hypotheses differ by where they are in the same old places, so those are drawn once and shared.
/// When the particles agree, and saw enough, what they saw becomes part of a pose graph, which spreads the
/// correction over the path; hypotheses that would bend the path beyond belief are refused.
class PathFilter {
 public:
  struct Particle {
    Pose2 pose;
    double log_weight{0};
    std::vector<Sighting> sightings;  ///< since the last commit; bounded
    bool injected{false};             ///< came from a wide search, so it has more to prove
  };

  struct Step {
    bool committed{false};
    bool bent{false};  ///< poses of old key frames changed by more than centimetres
  };

  explicit PathFilter(const PathFilterParams& params);

  /// The first key frame, at `pose`.
  void begin(const Pose2& pose, KeyFrame frame);
  Step add(const TrackedStep& step, KeyFrame frame);
  /// Measures what relaxing contradicts anew and relaxes everything.
  void finish();

  [[nodiscard]] const std::vector<KeyFrame>& frames() const { return frames_; }
  [[nodiscard]] const std::vector<Pose2>& poses() const { return graph_.poses(); }
  [[nodiscard]] const PoseGraph& graph() const { return graph_; }
  [[nodiscard]] const std::vector<Particle>& particles() const { return particles_; }
  [[nodiscard]] double effective_particles() const { return effective_; }
  [[nodiscard]] double entropy() const;
  [[nodiscard]] std::vector<double> weights() const;  ///< sum to one
  /// Spread of the particles' poses: x, y, yaw.
  [[nodiscard]] Eigen::Matrix3d covariance() const;
  [[nodiscard]] std::size_t loops() const { return loops_; }
  [[nodiscard]] std::size_t resamplings() const { return resamplings_; }

  /// Puts back what graph() and frames() gave before.
  void restore(std::vector<KeyFrame> frames, PoseGraph graph);

 private:
  struct Candidate;

  void move_particles(const TrackedStep& step);
  void sight();
  [[nodiscard]] std::vector<std::size_t> old_places_near(const Pose2& pose, double radius_m,
                                                         std::size_t most) const;
  [[nodiscard]] std::size_t old_end() const;
  [[nodiscard]] std::optional<Candidate> look_at(std::size_t place, const Pose2& pose, double sigma_m,
                                                 double sigma_rad);
  void sight_one(Particle& particle);
  void search_far();
  void inject(const Candidate& candidate);
  void weigh();
  void resample();
  [[nodiscard]] bool determined(const Particle& particle) const;
  [[nodiscard]] bool convincing(std::size_t best) const;
  Step commit(std::size_t best);
  void commit_rest();
  bool relax_commit(double moved_m);
  void collapse();
  [[nodiscard]] double expected_drift_m() const;
  [[nodiscard]] double farthest_offset_m(std::size_t place) const;
  bool look_again(Relation& relation);
  bool review(std::size_t relations_before);

  PathFilterParams params_;
  Rng rng_;
  std::vector<KeyFrame> frames_;
  PoseGraph graph_;
  PlaceCache places_;
  std::optional<RangeProfile> profile_;  ///< of the newest key frame
  std::vector<Particle> particles_;
  double effective_{0};
  double committed_at_m_{0};          ///< way at the last commit
  std::size_t trusted_relations_{0};  ///< the last correction began after these
  std::size_t since_relaxed_{0};      ///< commits since everything was relaxed
  std::size_t next_far_{0};           ///< which old place a wide search looks at next
  std::size_t loops_{0};
  std::size_t resamplings_{0};
};

}  // namespace extperfc::mapping
