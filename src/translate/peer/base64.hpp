#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace extperfc::translate {

/// Without line breaks. Source: RFC 4648, section 4.
[[nodiscard]] std::string encode_base64(std::string_view bytes);
/// Blanks are passed over. Nothing when a character or the padding is wrong.
[[nodiscard]] std::optional<std::string> decode_base64(std::string_view text);

}  // namespace extperfc::translate
