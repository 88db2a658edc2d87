#include "extperfc/arm/joint_history.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace extperfc::arm {

JointHistory::JointHistory(std::vector<std::string> names, const JointVector& initial, double span_s)
    : names_(std::move(names)), span_s_(span_s), latest_(initial) {
  if (initial.size() != static_cast<Eigen::Index>(names_.size()) || !(span_s > 0))
    throw std::invalid_argument("JointHistory: one initial position per joint, a span above 0 s");
}

void JointHistory::add(double time_s, const std::vector<std::string>& names,
                       const std::vector<double>& positions) {
  if (!std::isfinite(time_s)) return;
  if (time_s < newest_s() - span_s_) entries_.clear();
  if (time_s <= newest_s()) return;
  bool ours = false;
  for (std::size_t i = 0; i < std::min(names.size(), positions.size()); ++i) {
    const auto found = std::find(names_.begin(), names_.end(), names[i]);
    if (found == names_.end() || !std::isfinite(positions[i])) continue;
    latest_[found - names_.begin()] = positions[i];
    ours = true;
  }
  if (!ours || !latest_.allFinite()) return;
  entries_.push_back({time_s, latest_});
  while (entries_.front().time_s < time_s - span_s_ || entries_.size() > kMaxEntries) entries_.pop_front();
}

std::optional<JointVector> JointHistory::at(double time_s, double beyond_s) const {
  const auto next = std::lower_bound(entries_.begin(), entries_.end(), time_s,
                                     [](const Entry& entry, double time) { return entry.time_s < time; });
  if (next == entries_.end()) {
    if (entries_.empty() || !(time_s - entries_.back().time_s <= beyond_s)) return std::nullopt;
    return entries_.back().positions;
  }
  if (next->time_s == time_s) return next->positions;
  if (next == entries_.begin()) return std::nullopt;
  const auto& before = *std::prev(next);
  const double fraction = (time_s - before.time_s) / (next->time_s - before.time_s);
  return JointVector((1 - fraction) * before.positions + fraction * next->positions);
}

double JointHistory::newest_s() const {
  return entries_.empty() ? -std::numeric_limits<double>::infinity() : entries_.back().time_s;
}

}  // namespace extperfc::arm
