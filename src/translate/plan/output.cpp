#include "translate/plan/output.hpp"

#include <algorithm>

namespace extperfc::translate {

Output::Output(ByteBuffer& buffer, std::size_t max_bytes, std::size_t expected)
    : buffer_(buffer), start_(buffer.size()), max_bytes_(max_bytes) {
  buffer_.reserve(start_ + std::min(expected, max_bytes));
  at_ = buffer_.data() + start_;
  update_end();
}

void Output::update_end() {
  const auto capacity = buffer_.capacity() - start_;
  end_ = buffer_.data() + start_ + std::min(capacity, max_bytes_);
}

bool Output::grow(std::size_t bytes) {
  const auto used = written();
  if (bytes > max_bytes_ - used) return false;
  buffer_.reserve(start_ + std::min(max_bytes_, std::max(used + bytes, 2 * used)));
  at_ = buffer_.data() + start_ + used;
  update_end();
  return true;
}

}  // namespace extperfc::translate
