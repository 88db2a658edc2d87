#include "depth/object_fit/solid_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include <Eigen/Cholesky>

#include "depth/cauchy.hpp"

namespace extperfc::depth {
namespace {

constexpr double kMinLength = 1e-3;     // of a radius, edge or height during the iterations [m]
constexpr double kMaxStep = 0.02;       // of one iteration [m], and ten times as many [rad]
constexpr double kDelta = 1e-6;         // of numerical derivatives [m] or [rad]
constexpr double kFits = 3.0;           // standard deviations
constexpr double kWidthSigma = 0.08;    // of a radius from the silhouette, as a fraction of it
constexpr double kWidthSigmaM = 0.001;  // and that many metres
/// Cauchy's scale in standard deviations: wide at first, so that a bad start is drawn in.
constexpr std::array<double, 18> kScales{32, 32, 32, 16, 16, 16, 8, 8, 8, 4, 4, 4, 2, 2, 2, 2, 2, 2};

using Row = Eigen::Matrix<double, 1, Eigen::Dynamic, 1, 1, kMaxNumbers>;

Row gradient(FitShape shape, const Numbers& numbers, const Eigen::Vector3d& point) {
  Row row(numbers.size());
  Numbers moved = numbers;
  for (Eigen::Index i = 0; i < numbers.size(); ++i) {
    moved[i] = numbers[i] + kDelta;
    const double more = distance(shape, moved, point);
    moved[i] = numbers[i] - kDelta;
    row[i] = (more - distance(shape, moved, point)) / (2 * kDelta);
    moved[i] = numbers[i];
  }
  return row;
}

/// Weighted normal equations.
struct Sums {
  NumbersCovariance normal;
  Numbers right;
};

/// What follows from the lateral extent of the samples: how wide a sphere is, or a cone at the height of the
/// lowest samples.
struct Silhouette {
  double radius_m{0};  // 0: a cube, whose silhouette depends on its yaw
  double height_m{0};
};

/// What is to be fitted. Far away the surface of a small cone or sphere is hardly more than noise: there the
/// silhouette helps.
struct Problem {
  FitShape shape;
  const std::vector<SurfaceSample>& samples;
  double independent;
  Silhouette silhouette;
};

Silhouette silhouette_of(FitShape shape, const std::vector<Eigen::Vector3d>& points) {
  if (shape == FitShape::kCube) return {};
  const auto lowest = std::min_element(points.begin(), points.end(),
                                       [](const auto& a, const auto& b) { return a.z() < b.z(); });
  return {half_width(points), shape == FitShape::kCone ? lowest->z() : 0.0};
}

void add_silhouette(const Problem& problem, const Numbers& numbers, Sums& sums) {
  const Silhouette& seen = problem.silhouette;
  if (seen.radius_m <= 0) return;
  const double sigma = kWidthSigma * seen.radius_m + kWidthSigmaM;
  const double weight = 1 / (problem.independent * sigma * sigma);  // in samples
  Row row = Row::Zero(numbers.size());
  row[2] = 1;
  double radius = numbers[2];
  if (problem.shape == FitShape::kCone) {  // radius (1 - z / height)
    row[2] = 1 - seen.height_m / numbers[3];
    row[3] = numbers[2] * seen.height_m / (numbers[3] * numbers[3]);
    radius *= row[2];
  }
  sums.normal += weight * row.transpose() * row;
  sums.right += weight * (seen.radius_m - radius) * row.transpose();
}

Sums accumulate(const Problem& problem, const Numbers& numbers, double scale) {
  const auto n = numbers.size();
  const FitShape shape = problem.shape;
  Sums sums{NumbersCovariance::Zero(n, n), Numbers::Zero(n)};
  add_silhouette(problem, numbers, sums);
  for (const SurfaceSample& sample : problem.samples) {
    const double residual = distance(shape, numbers, sample.position);
    const double weight = cauchy(residual / sample.sigma_m, scale) / (sample.sigma_m * sample.sigma_m);
    const Row row = gradient(shape, numbers, sample.position);
    sums.normal += weight * row.transpose() * row;
    sums.right -= weight * residual * row.transpose();
  }
  return sums;
}

/// A little of the diagonal is added, so that parameters that the samples do not determine stay.
NumbersCovariance damped(const NumbersCovariance& normal) {
  NumbersCovariance result = normal;
  result.diagonal() += 1e-6 * normal.trace() * Numbers::Ones(normal.rows());
  return result;
}

void advance(FitShape shape, Numbers& numbers, const Sums& sums) {
  Numbers step = damped(sums.normal).ldlt().solve(sums.right);
  for (Eigen::Index i = 0; i < step.size(); ++i) {
    const bool is_yaw = shape == FitShape::kCube && i == 3;
    const double max_step = is_yaw ? 10 * kMaxStep : kMaxStep;
    numbers[i] += std::clamp(step[i], -max_step, max_step);
    if (i >= 2 && !is_yaw) numbers[i] = std::max(numbers[i], kMinLength);
  }
}

double robust_cost(FitShape shape, const Numbers& numbers, const std::vector<SurfaceSample>& samples) {
  double cost = 0;
  for (const SurfaceSample& sample : samples) {
    const double r = distance(shape, numbers, sample.position) / sample.sigma_m / kScales.back();
    cost += std::log1p(r * r);
  }
  return cost;
}

Numbers descend(const Problem& problem, Numbers numbers) {
  for (const double scale : kScales) advance(problem.shape, numbers, accumulate(problem, numbers, scale));
  return numbers;
}

void measure(const Problem& problem, SolidFit& fit) {
  double squares = 0;
  double squares_m = 0;
  int fitting = 0;
  for (const SurfaceSample& sample : problem.samples) {
    const double residual = distance(problem.shape, fit.numbers, sample.position);
    if (std::abs(residual) > kFits * sample.sigma_m) continue;
    ++fitting;
    squares += std::pow(residual / sample.sigma_m, 2);
    squares_m += residual * residual;
  }
  const double count = std::max(1, fitting);
  fit.rms = std::sqrt(squares / count);
  fit.rms_m = std::sqrt(squares_m / count);
  fit.fitting = static_cast<double>(fitting) / static_cast<double>(problem.samples.size());
  const Sums sums = accumulate(problem, fit.numbers, kScales.back());
  fit.covariance = damped(problem.independent * sums.normal).inverse() * std::max(1.0, fit.rms * fit.rms);
}

/// About so many of the samples, spread evenly: enough to compare the starts.
std::vector<SurfaceSample> thinned(const std::vector<SurfaceSample>& samples, std::size_t count) {
  const std::size_t step = 1 + samples.size() / count;
  std::vector<SurfaceSample> few;
  for (std::size_t i = 0; i < samples.size(); i += step) few.push_back(samples[i]);
  return few;
}

/// The start that leads to the lowest cost.
Numbers best_start(const Problem& few, const std::vector<Numbers>& starts) {
  if (starts.size() == 1) return starts.front();
  Numbers best = starts.front();
  double lowest = std::numeric_limits<double>::infinity();
  for (const Numbers& start : starts) {
    const Numbers numbers = descend(few, start);
    const double cost = robust_cost(few.shape, numbers, few.samples);
    if (!(cost < lowest)) continue;
    best = numbers;
    lowest = cost;
  }
  return best;
}

}  // namespace

SolidFit fit_solid(FitShape shape, const std::vector<SurfaceSample>& samples, double independent) {
  constexpr std::size_t kFew = 120;
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(samples.size());
  for (const SurfaceSample& sample : samples) positions.push_back(sample.position);
  const Silhouette silhouette = silhouette_of(shape, positions);
  const std::vector<SurfaceSample> few = thinned(samples, kFew);
  const Numbers start = best_start({shape, few, independent, silhouette}, starts(shape, positions));
  const Problem problem{shape, samples, independent, silhouette};
  SolidFit fit;
  fit.numbers = descend(problem, start);
  measure(problem, fit);
  return fit;
}

}  // namespace extperfc::depth
