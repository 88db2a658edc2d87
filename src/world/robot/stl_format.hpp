#pragma once

#include <cstddef>
#include <cstdint>

namespace extperfc {

// Binary STL: text, the number of triangles, and for each its normal, three corners and two bytes more.
inline constexpr std::size_t kStlTextBytes = 80;
inline constexpr std::size_t kStlHeaderBytes = kStlTextBytes + sizeof(std::uint32_t);
inline constexpr std::size_t kStlTriangleBytes = 50;

}  // namespace extperfc
