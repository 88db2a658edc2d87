#pragma once

#include <string>

namespace extperfc {

/// Two lower-case hexadecimal digits for each byte.
inline std::string to_hex(const unsigned char* bytes, unsigned int count) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  text.reserve(2 * count);
  for (unsigned int i = 0; i < count; ++i) {
    text += kDigits[bytes[i] >> 4U];
    text += kDigits[bytes[i] & 0x0fU];
  }
  return text;
}

}  // namespace extperfc
