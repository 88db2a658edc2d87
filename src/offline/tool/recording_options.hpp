#pragma once

#include <optional>
#include <set>
#include <string>

#include "extperfc/base/arguments.hpp"
#include "extperfc/base/error.hpp"
#include "extperfc/offline/recording.hpp"
#include "extperfc/world/pose.hpp"

namespace extperfc::offline {

/// `options`, and those that say which data of a recording count: --scan-topic and the like.
[[nodiscard]] std::set<std::string> with_recording_options(std::set<std::string> options);

/// What those say.
[[nodiscard]] RecordingOptions recording_options(const Arguments& arguments);

/// Sets `pose` to `option X,Y,YAW`, where it is given. Errors: not three numbers.
[[nodiscard]] Result<void> read_pose(const Arguments& arguments, const std::string& option,
                                     std::optional<Pose2>& pose);

}  // namespace extperfc::offline
