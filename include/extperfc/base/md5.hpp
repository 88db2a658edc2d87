#pragma once

#include <string>
#include <string_view>

namespace extperfc {

/// MD5 of bytes as 32 lower-case hexadecimal digits. For names of definitions, as ROS 1 uses it; not for
/// security.
[[nodiscard]] std::string md5_hex(std::string_view bytes);

}  // namespace extperfc
