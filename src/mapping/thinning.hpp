#pragma once

#include <cstddef>
#include <vector>

#include "extperfc/world/pose.hpp"

#include "mapping/key_frame.hpp"

namespace extperfc::mapping {

/// Key frames whose scans the map can do without: in groups that make up a submap, where every key frame of a
/// group has at least `kept_passes` other passes before it and as many after it that stood within a metre or
/// so and looked the same way. The newest 200 key frames are never among them. Bounded number per call,
/// oldest first; O(key frames).
[[nodiscard]] std::vector<std::size_t> seen_often(const std::vector<KeyFrame>& frames,
                                                  const std::vector<Pose2>& poses, std::size_t kept_passes);

}  // namespace extperfc::mapping
