#pragma once

#include <set>
#include <string>

#include "extperfc/base/arguments.hpp"
#include "extperfc/offline/recording.hpp"

namespace extperfc::offline {

/// `options`, and those that say which data of a recording count: --scan-topic and the like.
[[nodiscard]] std::set<std::string> with_recording_options(std::set<std::string> options);

/// What those say.
[[nodiscard]] RecordingOptions recording_options(const Arguments& arguments);

}  // namespace extperfc::offline
