#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "extperfc/arm/joint_vector.hpp"

namespace extperfc::arm {

/// Recent joint positions, for measurements that arrive later than they were taken. A message may contain
/// some of the joints only; the others keep their last position. Bounded memory. Not thread-safe.
class JointHistory {
 public:
  /// `initial` has one position [rad] or [m] per name, which counts until the joint is heard of; NaN: there
  /// is no history until then. `span_s`: how long positions are kept, above 0.
  JointHistory(std::vector<std::string> names, const JointVector& initial, double span_s);

  /// Positions at `time_s`. Other names and values that are not finite are passed over, and so is what is
  /// older than the newest; a clock that went back by more than the span begins a new history.
  /// O(names * joints).
  void add(double time_s, const std::vector<std::string>& names, const std::vector<double>& positions);

  /// Between two messages linearly, so a continuous joint's angle must not wrap; after the newest, by
  /// `beyond_s` at most, where it was then. Nothing outside of that, or with a joint never heard of.
  [[nodiscard]] std::optional<JointVector> at(double time_s, double beyond_s) const;

  /// -infinity before the first one.
  [[nodiscard]] double newest_s() const;

 private:
  struct Entry {
    double time_s;
    JointVector positions;
  };
  static constexpr std::size_t kMaxEntries = 4000;

  const std::vector<std::string> names_;
  const double span_s_;
  JointVector latest_;
  std::deque<Entry> entries_;  ///< by time, complete ones only
};

}  // namespace extperfc::arm
