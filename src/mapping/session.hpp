#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/world/pose.hpp"

#include "mapping/key_frame.hpp"
#include "mapping/pose_graph.hpp"

namespace extperfc::mapping {

/// A scan that was tracked: where, and after which key frame.
struct PassedScan {
  double stamp_s{0};
  Pose2 tracked;               ///< in the tracker's frame
  std::uint32_t key_frame{0};  ///< the newest one when it came; itself, when it is one
};

/// The state that mapping needs to resume.
struct Session {
  std::vector<KeyFrame> frames;
  PoseGraph graph;
  std::vector<PassedScan> scans;
};

/// The second behind the first, as a part of the map whose pose is unknown.
[[nodiscard]] Session concatenated(Session first, Session second);

/// Little-endian numbers behind a line that names format and version, with a checksum at the end. Written as
/// a whole or not at all. Errors name the file and what is wrong with it; hostile sizes are refused, not
/// allocated.
[[nodiscard]] Result<void> write_session(const Session& session, const std::filesystem::path& file);
[[nodiscard]] Result<Session> read_session(const std::filesystem::path& file);

}  // namespace extperfc::mapping
