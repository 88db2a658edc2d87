#include "extperfc/navigate/path_tracker.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace extperfc::navigate {

namespace {

constexpr double kSearchAheadM = 1.5;
constexpr double kSearchBackM = 0.5;
constexpr double kLostM = 0.75;        // farther from the path: the whole of it is searched
constexpr double kCheckEveryM = 0.05;  // poses nearer to each other are not checked again

}  // namespace

void PathTracker::set(Path path) {
  path_ = std::move(path);
  rest_m_.assign(path_.poses.size(), 0.0);
  for (std::size_t i = path_.poses.size() - 1; i > 0; --i)
    rest_m_[i - 1] = rest_m_[i] + distance_m(path_.poses[i], path_.poses[i - 1]);
  nearest_ = 0;
  deviation_m_ = 0;
}

void PathTracker::update(const Pose2& map_T_base) {
  if (empty()) return;
  const auto search = [&](double from_m, double to_m) {  // by what is left
    double best_m = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < path_.poses.size(); ++i) {
      if (rest_m_[i] > from_m || rest_m_[i] < to_m) continue;
      const double here_m = distance_m(path_.poses[i], map_T_base);
      if (here_m > best_m) continue;
      best_m = here_m;
      nearest_ = i;
    }
    deviation_m_ = best_m;
  };
  const double rest = rest_m_[nearest_];
  search(rest + kSearchBackM, rest - kSearchAheadM);
  if (deviation_m_ > kLostM) search(rest_m_.front(), 0);
}

double PathTracker::rest_m() const {
  return empty() ? 0 : rest_m_[nearest_];
}

double PathTracker::deviation_m() const {
  return deviation_m_;
}

Path PathTracker::rest_in(const Pose2& target_T_map) const {
  Path rest;
  rest.cost = path_.cost;
  rest.poses.reserve(path_.poses.size() - nearest_);
  for (std::size_t i = nearest_; i < path_.poses.size(); ++i)
    rest.poses.push_back(compose(target_T_map, path_.poses[i]));
  return rest;
}

std::optional<Pose2> PathTracker::blocked(const CostGrid& costs, const Footprint& footprint,
                                          const Pose2& grid_T_map, double ahead_m) const {
  double checked_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = nearest_; i < path_.poses.size(); ++i) {
    if (rest_m_[nearest_] - rest_m_[i] > ahead_m) break;
    if (checked_m - rest_m_[i] < kCheckEveryM && i + 1 < path_.poses.size()) continue;
    checked_m = rest_m_[i];
    if (contact(costs, footprint, compose(grid_T_map, path_.poses[i])) == Contact::kObstacle)
      return path_.poses[i];
  }
  return std::nullopt;
}

}  // namespace extperfc::navigate
