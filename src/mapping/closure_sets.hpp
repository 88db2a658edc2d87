#pragma once

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "mapping/key_frame.hpp"
#include "mapping/pose_graph.hpp"
#include "mapping/relative_uncertainty.hpp"

namespace extperfc::mapping {

/// The submap of a key frame, recognized in an older submap.
struct SubmapClosure {
  Constraint constraint;  ///< from the older submap's key frame
  double support{0};      ///< fraction of the surfaces explained, less contradictions
  double distinctness{
      0};  ///< 0: the surroundings look alike elsewhere, too; 1: well supported and like no other
  bool is_joining{false};  ///< nothing is known of the newer submap's pose in the older one
  double reach_m{0};       ///< where the graph allowed the newer submap to stand: this far from its pose [m]
};

/// Whether a residual in x, y, yaw can be explained by a covariance and a bias of the position [m], at one in
/// a hundred.
[[nodiscard]] bool is_explained(const Pose2& residual, Eigen::Matrix3d covariance, double systematic_m);

/// Sets of loop closures of which every two agree, by the path between their ends: pairwise consistency
/// (Mangelson et al., "Pairwise Consistent Measurement Set Maximization for Robust Multi-robot Map Merging",
/// ICRA 2018). A set weighs what its closures are distinct; closures of one query, and those of queries
/// beside each other where parts are joined, show the same and count once. The arguments of the constructor
/// must live as long as the object.
class ClosureSets {
 public:
  using Members = std::vector<std::size_t>;    ///< indices of closures
  static constexpr double kUsualReachM = 3.0;  ///< within which min_weight is enough

  ClosureSets(const std::vector<SubmapClosure>& closures, const std::vector<KeyFrame>& frames,
              const std::vector<Pose2>& poses, const RelativeUncertainties& known);

  /// The heaviest set with one of the closures from `first_new` on. Empty where none weighs `min_weight`, or
  /// more where its queries may stand far away, or where another set that contradicts it is nearly as heavy.
  [[nodiscard]] Members best(std::size_t first_new, double min_weight);

  /// Whether two closures and the path between their ends agree.
  [[nodiscard]] bool agree(std::size_t a, std::size_t b);
  [[nodiscard]] double weight(const Members& members) const { return weight_without(members, {}); }

 private:
  [[nodiscard]] const RelativeUncertainty& uncertainty(std::size_t from, std::size_t to);
  [[nodiscard]] bool is_consistent(const SubmapClosure& a, const SubmapClosure& b);
  [[nodiscard]] bool agrees_with_all(std::size_t closure, const Members& members);
  [[nodiscard]] Members grow(std::size_t seed);
  [[nodiscard]] double place_of(const SubmapClosure& closure) const;
  /// Of those that are not in `others`: what two sets have in common speaks for neither.
  [[nodiscard]] double weight_without(const Members& members, const Members& others) const;
  [[nodiscard]] double wanted(const Members& members, double min_weight) const;

  const std::vector<SubmapClosure>& closures_;
  const std::vector<KeyFrame>& frames_;
  const std::vector<Pose2>& poses_;
  const RelativeUncertainties& known_;
  Members by_weight_;
  std::vector<std::size_t> ends_;  ///< key frames that closures begin or end at, ascending
  std::map<std::size_t, std::vector<RelativeUncertainty>>
      known_ends_;  ///< from a key frame, of each of ends_
  std::map<std::pair<std::size_t, std::size_t>, bool> agreed_;
};

}  // namespace extperfc::mapping
