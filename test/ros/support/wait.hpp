#pragma once

#include <functional>

namespace extperfc::ros_test {

/// How long a test waits for what must come. Long, because a busy machine may be slow; a passing test never
/// waits it out.
constexpr double kPatienceS = 20.0;

/// How long a test watches that something does NOT happen.
constexpr double kWatchS = 1.0;

/// Polls until the condition holds. False when `patience_s` have passed without.
[[nodiscard]] bool wait_for(const std::function<bool()>& condition, double patience_s = kPatienceS);

/// The opposite, for what must not happen: true when the condition held at no time during `watch_s`.
[[nodiscard]] bool never(const std::function<bool()>& condition, double watch_s = kWatchS);

}  // namespace extperfc::ros_test
