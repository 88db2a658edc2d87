#pragma once

#include <cstddef>
#include <cstdint>

#include "extperfc/translate/bytes.hpp"

namespace extperfc::translate {

/// Where converted bytes go: the end of a buffer, which grows as needed up to a bound.
class Output {
 public:
  /// Up to `max_bytes` may be written; memory for `expected` bytes is reserved at once.
  Output(ByteBuffer& buffer, std::size_t max_bytes, std::size_t expected);

  [[nodiscard]] bool fits(std::size_t bytes) {
    return static_cast<std::size_t>(end_ - at_) >= bytes || grow(bytes);
  }
  /// Only after fits().
  [[nodiscard]] std::uint8_t* take(std::size_t bytes) {
    auto* begin = at_;
    at_ += bytes;
    return begin;
  }
  [[nodiscard]] std::size_t written() const {
    return static_cast<std::size_t>(at_ - buffer_.data()) - start_;
  }
  [[nodiscard]] std::size_t max_bytes() const { return max_bytes_; }
  /// Makes what was written part of the buffer.
  void finish() { buffer_.resize(start_ + written()); }

 private:
  bool grow(std::size_t bytes);
  void update_end();

  ByteBuffer& buffer_;
  std::size_t start_;
  std::size_t max_bytes_;
  std::uint8_t* at_{nullptr};
  std::uint8_t* end_{nullptr};  ///< of the capacity, or of what may be written
};

}  // namespace extperfc::translate
