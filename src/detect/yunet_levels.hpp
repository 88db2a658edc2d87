#pragma once

#include <array>
#include <cstddef>

namespace extperfc::detect {

inline constexpr std::array<int, 3> kYunetStrides{8, 16, 32};    ///< input pixels per cell
inline constexpr std::array<int, 4> kYunetColumns{1, 1, 4, 10};  ///< of cls, obj, bbox and kps
inline constexpr std::size_t kYunetTensors = kYunetStrides.size() * kYunetColumns.size();

}  // namespace extperfc::detect
