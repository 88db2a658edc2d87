#pragma once

#include <cstddef>

namespace extperfc::navigate {

inline constexpr std::size_t kMaxZoneCorners = 200;

}  // namespace extperfc::navigate
