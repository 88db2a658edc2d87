#include "extperfc/arm/joint_path.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace extperfc::arm {

namespace {

constexpr double kSamePlaceRad = 1e-9;
constexpr double kStraightBend = 1e-9;
constexpr double kReversalBend = 1.98;
constexpr double kDeviationPerReach = 3.0 / 16.0;  // times |w - u|: distance from the lines per L

/// A waypoint that is kept, with how far the path may pass from it.
struct Corner {
  JointVector position;
  double deviation{0};
  double reach{0};  ///< L
  bool stop{false};
};

struct Line {
  JointVector direction;
  double length{0};
};

Result<void> check_waypoints(const std::vector<JointVector>& waypoints) {
  const auto invalid = [](const std::string& why) {
    return fail(ErrorCode::kInvalidArgument, "path: " + why);
  };
  if (waypoints.empty()) return invalid("no waypoint");
  if (waypoints.front().size() == 0) return invalid("waypoints without joints");
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    if (waypoints[i].size() != waypoints.front().size())
      return invalid("waypoint " + std::to_string(i) + " has " + std::to_string(waypoints[i].size()) +
                     " joints, the first one " + std::to_string(waypoints.front().size()));
    if (!waypoints[i].allFinite()) return invalid("waypoint " + std::to_string(i) + " is not finite");
  }
  return {};
}

Result<void> check_params(const JointPathParams& params, std::size_t waypoints) {
  const auto in_range = [](double value) { return value >= 0 && value <= 1; };
  if (!in_range(params.deviation_rad))
    return fail(ErrorCode::kInvalidArgument,
                "path: deviation_rad is " + std::to_string(params.deviation_rad) + ", it must lie in [0, 1]");
  const auto& each = params.corner_deviation_rad;
  if (!each.empty() && each.size() != waypoints)
    return fail(ErrorCode::kInvalidArgument, "path: corner_deviation_rad has " + std::to_string(each.size()) +
                                                 " values for " + std::to_string(waypoints) + " waypoints");
  if (!std::all_of(each.begin(), each.end(), in_range))
    return fail(ErrorCode::kInvalidArgument, "path: a value of corner_deviation_rad lies outside [0, 1]");
  return {};
}

/// Waypoints without repetitions. Of those that fall together the smallest deviation counts; the very last
/// waypoint stays as it is.
std::vector<Corner> distinct_corners(const std::vector<JointVector>& waypoints,
                                     const JointPathParams& params) {
  std::vector<Corner> corners;
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    const double deviation =
        params.corner_deviation_rad.empty() ? params.deviation_rad : params.corner_deviation_rad[i];
    if (!corners.empty() && (waypoints[i] - corners.back().position).norm() < kSamePlaceRad) {
      corners.back().deviation = std::min(corners.back().deviation, deviation);
      if (i + 1 == waypoints.size()) corners.back().position = waypoints[i];
    } else {
      corners.push_back({waypoints[i], deviation});
    }
  }
  return corners;
}

std::vector<Line> lines_between(const std::vector<Corner>& corners) {
  std::vector<Line> lines;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const JointVector delta = corners[i].position - corners[i - 1].position;
    lines.push_back({delta / delta.norm(), delta.norm()});
  }
  return lines;
}

/// What each end of a line gets of it when they want `a` and `b`: all they want, or a fair part.
std::pair<double, double> split(double length, double a, double b) {
  if (a + b <= length) return {a, b};
  if (a <= length / 2) return {a, length - a};
  if (b <= length / 2) return {length - b, b};
  return {length / 2, length / 2};
}

/// Sets reach and stop of the inner corners; returns the largest deviation.
double round_corners(std::vector<Corner>& corners, const std::vector<Line>& lines) {
  std::vector<double> bend(corners.size(), 0.0);
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    auto& corner = corners[i];
    bend[i] = (lines[i].direction - lines[i - 1].direction).norm();
    const double room = std::min(lines[i - 1].length, lines[i].length);
    corner.stop = bend[i] > kReversalBend || (corner.deviation <= 0 && bend[i] >= kStraightBend);
    if (corner.stop) continue;
    corner.reach =
        bend[i] < kStraightBend ? room : std::min(room, corner.deviation / (kDeviationPerReach * bend[i]));
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto [a, b] = split(lines[i].length, corners[i].reach, corners[i + 1].reach);
    corners[i].reach = std::min(corners[i].reach, a);
    corners[i + 1].reach = std::min(corners[i + 1].reach, b);
  }
  double deviation = 0;
  for (std::size_t i = 0; i < corners.size(); ++i)
    deviation = std::max(deviation, kDeviationPerReach * corners[i].reach * bend[i]);
  return deviation;
}

}  // namespace

PathState evaluate(const PathPiece& piece, double offset) {
  if (piece.straight)
    return {piece.position + offset * piece.direction, piece.direction,
            JointVector::Zero(piece.direction.size())};
  const double x = std::clamp(offset / piece.length, 0.0, 1.0);
  const double moved = x * x * x * (1 - x / 2) * piece.length;
  return {piece.position + offset * piece.direction + moved * piece.direction_change,
          piece.direction + x * x * (3 - 2 * x) * piece.direction_change,
          6 * x * (1 - x) / piece.length * piece.direction_change};
}

Result<JointPath> JointPath::make(const std::vector<JointVector>& waypoints, const JointPathParams& params) {
  if (auto checked = check_waypoints(waypoints); !checked) return tl::unexpected(checked.error());
  if (auto checked = check_params(params, waypoints.size()); !checked) return tl::unexpected(checked.error());
  auto corners = distinct_corners(waypoints, params);
  const auto lines = lines_between(corners);
  JointPath path;
  path.start_ = corners.front().position;
  path.end_ = corners.back().position;
  path.deviation_rad_ = round_corners(corners, lines);
  const JointVector none = JointVector::Zero(path.end_.size());
  double s = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto& [direction, length] = lines[i];
    const double before = corners[i].reach;
    const double behind = corners[i + 1].reach;
    if (length - before - behind > 1e-12 * length)
      path.pieces_.push_back({s + before, length - before - behind, corners[i].position + before * direction,
                              direction, none, true, false});
    s += length;
    if (behind > 0)
      path.pieces_.push_back({s - behind, 2 * behind, corners[i + 1].position - behind * direction, direction,
                              lines[i + 1].direction - direction, false, false});
    else if (corners[i + 1].stop)
      path.pieces_.back().stop_after = true;
  }
  path.length_ = s;
  return path;
}

PathState JointPath::at(double s) const {
  if (pieces_.empty()) return {end_, JointVector::Zero(joints()), JointVector::Zero(joints())};
  const auto behind =
      std::upper_bound(pieces_.begin() + 1, pieces_.end(), s,
                       [](double value, const PathPiece& piece) { return value < piece.begin; });
  const PathPiece& piece = *(behind - 1);
  PathState state = evaluate(piece, std::clamp(s - piece.begin, 0.0, piece.length));
  if (s <= 0) state.position = start_;
  if (s >= length_) state.position = end_;
  return state;
}

}  // namespace extperfc::arm
