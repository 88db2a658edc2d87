#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/pose.hpp"

#include "test/benchmark/localize/recording.hpp"

namespace extperfc::benchmark {

enum class Half { kFirst, kSecond };  ///< of the scans of a recording

/// A map of one half of a recording. The scans of the other half are localized in it.
struct HalfCase {
  const Recording* recording{nullptr};
  Half mapped{Half::kFirst};
  std::shared_ptr<const OccupancyGrid> map;
  std::size_t first{0};     ///< scan of the other half
  std::size_t end{0};       ///< scan behind the other half
  std::vector<bool> known;  ///< by scan from `first` on: within 1 m of a mapped key frame
};

/// `recording` must outlive the case.
[[nodiscard]] HalfCase make_half_case(const Recording& recording, Half mapped);

/// An update of a filter.
struct Step {
  std::size_t scan{0};
  Pose2 odom;        ///< with added errors
  bool known{true};  ///< on known ground
};

/// The updates of the other half, at least 0.2 m or 0.2 rad of odometry from one to the next. Errors are
/// drawn from the seed and added to the log's own odometry: lengths wrong by 3 % and a veer of 0.02 rad/m
/// (standard deviations, constant over a drive), and noise of every scan.
[[nodiscard]] std::vector<Step> steps_of(const HalfCase& half, std::uint64_t seed);

/// Numbers of the steps from which on at least `length` steps lie on known ground, up to `max_count` of
/// them, evenly spaced.
[[nodiscard]] std::vector<std::size_t> known_starts(const std::vector<Step>& steps, std::size_t length,
                                                    std::size_t max_count);

}  // namespace extperfc::benchmark
