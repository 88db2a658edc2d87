#pragma once

#include <cstdint>

namespace extperfc::translate {

/// Numbers as ROS writes them, on any machine and at any address.
[[nodiscard]] inline std::uint32_t load_u32(const std::uint8_t* bytes) {
  return bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8U | static_cast<std::uint32_t>(bytes[2]) << 16U |
         static_cast<std::uint32_t>(bytes[3]) << 24U;
}
inline void store_u32(std::uint8_t* bytes, std::uint32_t value) {
  for (unsigned i = 0; i < 4; ++i) bytes[i] = static_cast<std::uint8_t>(value >> (8U * i));
}

}  // namespace extperfc::translate
