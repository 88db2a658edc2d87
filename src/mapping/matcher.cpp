#include "mapping/matcher.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "mapping/near_mask.hpp"

namespace extperfc::mapping {

namespace {

constexpr double kSigmaM = 0.03;     // of a point about its line
constexpr double kCorrelated = 8.0;  // points that count as one: their errors are correlated by the map
constexpr double kOnSurfaceM = 0.1;  // a point this near to its line counts as explained
constexpr int kIterations = 14;
constexpr int kCoarseIterations = 3;    // with the full reach
constexpr double kLongestStepM = 0.15;  // of one iteration
constexpr double kMatchedM = 1e-4;
constexpr double kMatchedRad = 5e-5;
constexpr double kPointWeight = 0.3;  // of a point without normal against one with a line

/// Normal equations of one iteration, in x, y, yaw.
struct MatchEquations {
  Eigen::Matrix3d h{Eigen::Matrix3d::Zero()};
  Eigen::Vector3d g{Eigen::Vector3d::Zero()};
  int used{0};
  int explained{0};
};

double robust_weight(double error_m, double scale_m) {
  const double ratio = error_m / scale_m;
  const double weight = 1.0 / (1.0 + ratio * ratio);
  return weight * weight;
}

void add_row(MatchEquations& equations, const Eigen::Vector3d& jacobian, double error, double weight) {
  equations.h.noalias() += weight * jacobian * jacobian.transpose();
  equations.g.noalias() += weight * error * jacobian;
}

MatchEquations linearize(const SurfaceMap& map, const ScanPoints& points, const Pose2& pose, int reach_cells,
                         double scale_m) {
  MatchEquations equations;
  Eigen::Matrix2f rotation;
  const auto c = static_cast<float>(std::cos(pose.yaw));
  const auto s = static_cast<float>(std::sin(pose.yaw));
  rotation << c, -s, s, c;
  const Eigen::Vector2f shift(static_cast<float>(pose.x), static_cast<float>(pose.y));
  constexpr double kUnit = 1.0 / (kSigmaM * kSigmaM * kCorrelated);
  for (const SurfacePoint& point : points.surface) {
    const Eigen::Vector2f arm = rotation * point.position;
    const Eigen::Vector2f position = arm + shift;
    const Eigen::Vector2f own_normal = rotation * point.normal;
    const auto* surface = map.nearest(position, own_normal, reach_cells);
    if (!surface) continue;
    ++equations.used;
    const Eigen::Vector2d d = (position - surface->mean).cast<double>();
    const Eigen::Vector2d lever(-arm.y(), arm.x());
    const Eigen::Vector2f& line = surface->normal.squaredNorm() > 0 ? surface->normal : own_normal;
    if (line.squaredNorm() > 0) {
      const Eigen::Vector2d n = line.cast<double>();
      const double error = n.dot(d);
      if (std::abs(error) < kOnSurfaceM) ++equations.explained;
      add_row(equations, {n.x(), n.y(), n.dot(lever)}, error, kUnit * robust_weight(error, scale_m));
    } else {
      const double weight = kPointWeight * kUnit * robust_weight(d.norm(), scale_m);
      if (d.norm() < kOnSurfaceM) ++equations.explained;
      add_row(equations, {1, 0, lever.x()}, d.x(), weight);
      add_row(equations, {0, 1, lever.y()}, d.y(), weight);
    }
  }
  return equations;
}

/// Makes `sigma_m` the minimum standard deviation along a direction, for any yaw.
void weaken(Eigen::Matrix3d& information, const Eigen::Vector2d& along, double sigma_m) {
  const Eigen::Vector3d u(along.x(), along.y(), 0);
  Eigen::Matrix3d covariance = (information + 1e-2 * Eigen::Matrix3d::Identity()).inverse();
  covariance += sigma_m * sigma_m * u * u.transpose();
  information = covariance.inverse();
}

/// Log likelihoods at equal steps along a direction, from -reach to reach.
class Profile {
 public:
  explicit Profile(int reach) : reach_(reach) {
    const int count = 2 * reach + 1;
    logs_.reserve(static_cast<std::size_t>(count));
  }

  void add(double log_likelihood) { logs_.push_back(log_likelihood); }
  [[nodiscard]] bool finite() const {
    return std::all_of(logs_.begin(), logs_.end(), [](double value) { return std::isfinite(value); });
  }
  [[nodiscard]] int peak() const {
    return static_cast<int>(std::max_element(logs_.begin(), logs_.end()) - logs_.begin()) - reach_;
  }
  /// Standard deviation of the normalized likelihood, in steps (Olson 2009, equation 5).
  [[nodiscard]] double sigma_steps() const {
    const double highest = *std::max_element(logs_.begin(), logs_.end());
    double sum = 0;
    double first = 0;
    double second = 0;
    for (std::size_t i = 0; i < logs_.size(); ++i) {
      const double weight = std::exp(logs_[i] - highest);
      const auto at = static_cast<double>(i);
      sum += weight;
      first += weight * at;
      second += weight * at * at;
    }
    return std::sqrt(std::max(0.0, second / sum - first * first / (sum * sum)));
  }
  /// The step nearest to the middle that is within `below` of the highest.
  [[nodiscard]] int nearest(double below) const {
    const double enough = *std::max_element(logs_.begin(), logs_.end()) - below;
    const auto is_likely = [&](int step) {
      const int index = step + reach_;
      return logs_[static_cast<std::size_t>(index)] >= enough;
    };
    int step = 0;
    while (!is_likely(step)) step = step > 0 ? -step : 1 - step;  // 0, 1, -1, 2, -2, ...
    return step;
  }

 private:
  int reach_;
  std::vector<double> logs_;
};

int cells(double reach_m) {
  return std::max(1, static_cast<int>(std::lround(reach_m / SurfaceMap::kCellM)));
}

ScanMatch summarize(const MatchEquations& equations, const ScanPoints& points, const Pose2& pose) {
  ScanMatch result;
  result.pose = pose;
  result.information = equations.h;
  result.used = equations.used;
  if (!points.surface.empty())
    result.fit = static_cast<double>(equations.explained) / static_cast<double>(points.surface.size());
  return result;
}

/// One damped Newton step; false when the equations cannot be solved.
bool step(const MatchEquations& equations, const PosePrior& prior, Pose2& pose, bool& settled) {
  const double per_m = 1.0 / (prior.sigma_m * prior.sigma_m);
  const double per_rad = 1.0 / (prior.sigma_rad * prior.sigma_rad);
  const Eigen::Vector2d along = prior.along / prior.sigma_along_m;
  Eigen::Matrix3d weights = Eigen::Vector3d(per_m, per_m, per_rad).asDiagonal();
  weights.topLeftCorner<2, 2>() += along * along.transpose();
  const Eigen::Vector3d away(pose.x - prior.mean.x, pose.y - prior.mean.y,
                             wrap_angle(pose.yaw - prior.mean.yaw));
  const Eigen::Matrix3d h = equations.h + weights;
  const Eigen::LDLT<Eigen::Matrix3d> solver(h);
  if (solver.info() != Eigen::Success) return false;
  Eigen::Vector3d move = -solver.solve(equations.g + weights * away);
  if (!move.allFinite()) return false;
  settled = move.head<2>().norm() < kMatchedM && std::abs(move.z()) < kMatchedRad;
  move *= std::min(1.0, kLongestStepM / std::max(1e-9, move.head<2>().norm()));
  pose = {pose.x + move.x(), pose.y + move.y(), wrap_angle(pose.yaw + move.z())};
  return true;
}

}  // namespace

ScanMatch match(const SurfaceMap& map, const ScanPoints& points, const Pose2& start, const PosePrior& prior,
                double reach_m) {
  constexpr double kFineReachM = 0.16;
  Pose2 pose = start;
  for (int i = 0; i < kIterations; ++i) {
    const bool coarse = i < kCoarseIterations && reach_m > kFineReachM;
    const double reach = coarse ? reach_m : std::min(reach_m, kFineReachM);
    const double scale = coarse ? std::max(2 * kSigmaM, reach_m / 3) : 2 * kSigmaM;
    const auto equations = linearize(map, points, pose, cells(reach), scale);
    bool settled = false;
    if (!step(equations, prior, pose, settled)) break;
    if (settled && !coarse) break;
  }
  return evaluate(map, points, pose);
}

ScanMatch evaluate(const SurfaceMap& map, const ScanPoints& points, const Pose2& pose) {
  constexpr int kReachCells = 2;
  return summarize(linearize(map, points, pose, kReachCells, 2 * kSigmaM), points, pose);
}

Agreement agreement(const SurfaceMap& map, const ScanPoints& points, const Pose2& pose) {
  constexpr int kNearCells = 4;
  Eigen::Matrix2f rotation;
  const auto c = static_cast<float>(std::cos(pose.yaw));
  const auto s = static_cast<float>(std::sin(pose.yaw));
  rotation << c, -s, s, c;
  const Eigen::Vector2f shift(static_cast<float>(pose.x), static_cast<float>(pose.y));
  Agreement sum;
  sum.all = static_cast<double>(points.surface.size());
  for (const SurfacePoint& point : points.surface) {
    const Eigen::Vector2f position = rotation * point.position + shift;
    const Eigen::Vector2f own_normal = rotation * point.normal;
    const auto* surface = map.nearest(position, own_normal, kNearCells);
    if (!surface) continue;
    sum.near_surface += 1;
    const Eigen::Vector2f d = position - surface->mean;
    constexpr float kBesideM = 2 * SurfaceMap::kCellM;  // along its line, a surface ends here
    if (d.squaredNorm() > kBesideM * kBesideM) continue;
    const double error =
        static_cast<double>(surface->normal.squaredNorm() > 0 ? std::abs(surface->normal.dot(d)) : d.norm());
    const double ratio = error / kOnSurfaceM;
    sum.on_surface += std::max(0.0, 1.0 - ratio * ratio);
  }
  return sum;
}

double graded_fit(const SurfaceMap& map, const ScanPoints& points, const Pose2& pose) {
  constexpr int kReachCells = 2;
  Eigen::Matrix2f rotation;
  const auto c = static_cast<float>(std::cos(pose.yaw));
  const auto s = static_cast<float>(std::sin(pose.yaw));
  rotation << c, -s, s, c;
  const Eigen::Vector2f shift(static_cast<float>(pose.x), static_cast<float>(pose.y));
  double sum = 0;
  for (const SurfacePoint& point : points.surface) {
    const Eigen::Vector2f position = rotation * point.position + shift;
    const Eigen::Vector2f own_normal = rotation * point.normal;
    const auto* surface = map.nearest(position, own_normal, kReachCells);
    if (!surface) continue;
    const Eigen::Vector2f d = position - surface->mean;
    const double error =
        static_cast<double>(surface->normal.squaredNorm() > 0 ? std::abs(surface->normal.dot(d)) : d.norm());
    const double ratio = error / kOnSurfaceM;
    sum += std::max(0.0, 1.0 - ratio * ratio);
  }
  return points.surface.empty() ? 0.0 : sum / static_cast<double>(points.surface.size());
}

ScanMatch match_along(const SurfaceMap& map, const ScanPoints& points, const ScanMatch& first,
                      const PosePrior& prior, double window_m, double reach_m,
                      const std::function<double(const Pose2&)>& score) {
  constexpr double kWeakRatio = 0.15;  // of the strongest direction's information
  constexpr double kStepM = 0.1;
  constexpr double kMinWindowM = 1.0;     // narrower, a wrong peak would be the only one
  constexpr double kLogPerPoint = 0.3;    // log likelihood per unit of score; below 1: errors are correlated
  constexpr double kDeterminedM = 0.12;   // a wider likelihood tells nothing along the direction ...
  constexpr double kUndeterminedM = 3.0;  // ... and its constraint does not, either
  constexpr double kAsLikely = 2.0;       // in log likelihood
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(first.information.topLeftCorner<2, 2>());
  if (axes.eigenvalues()[0] > kWeakRatio * axes.eigenvalues()[1]) return first;
  const Eigen::Vector2d along = axes.eigenvectors().col(0);
  const double to_prior =
      along.dot(Eigen::Vector2d(prior.mean.x - first.pose.x, prior.mean.y - first.pose.y));
  const auto shifted = [&](int steps_from_prior) {
    const Eigen::Vector2d shift = (to_prior + steps_from_prior * kStepM) * along;
    return Pose2{first.pose.x + shift.x(), first.pose.y + shift.y(), first.pose.yaw};
  };
  const int reach = static_cast<int>(std::ceil(std::max(kMinWindowM, window_m) / kStepM));
  const double per_score = kLogPerPoint * static_cast<double>(points.surface.size());
  Profile profile(reach);
  for (int i = -reach; i <= reach; ++i) profile.add(per_score * score(shifted(i)));
  if (!profile.finite()) return first;
  const double sigma_m = kStepM * profile.sigma_steps();
  const int peak = profile.peak();
  if (sigma_m < kDeterminedM && std::abs(peak) < reach) {
    const Pose2 start = shifted(peak);
    ScanMatch found = match(map, points, start, {start, prior.sigma_m, prior.sigma_rad}, reach_m);
    weaken(found.information, along, sigma_m / 2);
    return found;
  }
  ScanMatch alike = evaluate(map, points, shifted(profile.nearest(kAsLikely)));
  weaken(alike.information, along, kUndeterminedM);
  return alike;
}

Pose2 search_near(const SurfaceMap& map, const ScanPoints& points, const Pose2& centre, double window_m,
                  double window_rad) {
  constexpr double kStepM = 0.1;
  constexpr double kStepRad = 0.03;
  constexpr std::size_t kProbes = 70;
  constexpr double kFavourNear = 0.05;  // of the score, from the middle to the rim of the window
  const std::size_t stride = 1 + points.surface.size() / kProbes;
  const NearMask mask(map);
  Pose2 best = centre;
  double best_score = -1;
  std::vector<Eigen::Vector2f> rotated;
  for (double yaw_offset = -window_rad; yaw_offset <= window_rad + 1e-9; yaw_offset += kStepRad) {
    const auto c = static_cast<float>(std::cos(centre.yaw + yaw_offset));
    const auto s = static_cast<float>(std::sin(centre.yaw + yaw_offset));
    rotated.clear();
    for (std::size_t i = 0; i < points.surface.size(); i += stride) {
      const Eigen::Vector2f& p = points.surface[i].position;
      rotated.emplace_back(c * p.x() - s * p.y() + static_cast<float>(centre.x),
                           s * p.x() + c * p.y() + static_cast<float>(centre.y));
    }
    for (double dx = -window_m; dx <= window_m + 1e-9; dx += kStepM) {
      for (double dy = -window_m; dy <= window_m + 1e-9; dy += kStepM) {
        const Eigen::Vector2f shift(static_cast<float>(dx), static_cast<float>(dy));
        int hits = 0;
        for (const auto& point : rotated) hits += mask.at(point + shift) ? 1 : 0;
        const double away = std::hypot(dx, dy) / window_m + std::abs(yaw_offset) / window_rad;
        const double score = hits / std::max(1.0, static_cast<double>(rotated.size())) - kFavourNear * away;
        if (score <= best_score) continue;
        best_score = score;
        best = {centre.x + dx, centre.y + dy, wrap_angle(centre.yaw + yaw_offset)};
      }
    }
  }
  return best;
}

}  // namespace extperfc::mapping
