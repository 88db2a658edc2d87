#pragma once

#include <cstddef>

#include "extperfc/translate/bytes.hpp"

namespace extperfc::translate {

/// Memory of this thread for the time of a conversion, used again by the next: an empty buffer. Leases end in
/// the reverse order of their start.
class ScratchLease {
 public:
  ScratchLease();
  ~ScratchLease();
  ScratchLease(const ScratchLease&) = delete;
  ScratchLease& operator=(const ScratchLease&) = delete;

  [[nodiscard]] ByteBuffer& buffer() { return *buffer_; }

 private:
  ByteBuffer* buffer_;
};

}  // namespace extperfc::translate
