#include <cstring>
#include <string>

#include "extperfc/translate/tcpros.hpp"

namespace extperfc::translate {
namespace {

constexpr std::size_t kLength = 4;
/// ROS itself sends ten fields at most.
constexpr std::size_t kMaxFields = 256;

void put_length(std::uint8_t* at, std::size_t value) {
  for (unsigned i = 0; i < kLength; ++i) at[i] = static_cast<std::uint8_t>(value >> (8U * i));
}

std::size_t length_at(const std::uint8_t* at) {
  std::size_t value = 0;
  for (unsigned i = 0; i < kLength; ++i) value |= static_cast<std::size_t>(at[i]) << (8U * i);
  return value;
}

}  // namespace

ByteBuffer encode_header(const ConnectionHeader& header) {
  ByteBuffer bytes(256);
  bytes.extend(kLength);
  for (const auto& [key, value] : header) {
    put_length(bytes.extend(kLength), key.size() + 1 + value.size());
    bytes.append(key.data(), key.size());
    bytes.append("=", 1);
    bytes.append(value.data(), value.size());
  }
  put_length(bytes.data(), bytes.size() - kLength);
  return bytes;
}

Result<ConnectionHeader> decode_header(ByteView bytes) {
  ConnectionHeader header;
  std::size_t fields = 0;
  for (std::size_t at = 0; at < bytes.size;) {
    const auto where = " at byte " + std::to_string(at) + " of a connection header";
    if (++fields > kMaxFields) {
      return fail(ErrorCode::kCorrupt, "more than " + std::to_string(kMaxFields) + " fields" + where);
    }
    if (bytes.size - at < kLength) return fail(ErrorCode::kCorrupt, "a length is cut off" + where);
    const auto size = length_at(bytes.data + at);
    at += kLength;
    if (size > bytes.size - at) {
      return fail(ErrorCode::kCorrupt, "a field of " + std::to_string(size) + " bytes, but only " +
                                           std::to_string(bytes.size - at) + " are left," + where);
    }
    const auto* field = reinterpret_cast<const char*>(bytes.data + at);
    const auto* equals = size == 0 ? nullptr : static_cast<const char*>(std::memchr(field, '=', size));
    if (equals == nullptr) return fail(ErrorCode::kCorrupt, "a field without '='" + where);
    if (equals == field) return fail(ErrorCode::kCorrupt, "a field without a name" + where);
    header.insert_or_assign(std::string(field, equals), std::string(equals + 1, field + size));
    at += size;
  }
  return header;
}

std::string value_of(const ConnectionHeader& header, const std::string& key) {
  const auto found = header.find(key);
  return found == header.end() ? std::string() : found->second;
}

}  // namespace extperfc::translate
