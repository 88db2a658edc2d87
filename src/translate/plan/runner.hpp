#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/bytes.hpp"

#include "translate/plan/code.hpp"

namespace extperfc::translate::plan {

/// Why a conversion stopped. Filled on failure only.
struct Failure {
  enum class Kind : std::uint8_t {
    kNone,
    kEnds,      ///< the bytes end early
    kTrailing,  ///< bytes are left
    kCount,     ///< more elements than the bytes left can hold
    kTooLong,   ///< the converted message exceeds its bound
    kValue,     ///< a value does not fit
    kLength,    ///< an array has not the length that the target's has
    kIndex,     ///< an array is shorter than a rule needs
  };
  Kind kind{Kind::kNone};
  std::string path;   ///< with indices
  std::string value;  ///< that does not fit
  std::uint64_t number{0};
  std::uint64_t limit{0};
};
[[nodiscard]] Error to_error(const Failure& failure);

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

/// Runs one Code over one message. Every read is checked against the end.
class [[gnu::visibility("hidden")]] Runner {  // of this library alone: calls may be inlined
 public:
  Runner(const Code& code, ByteView source, Output& out, std::int64_t time_shift_ns, Failure& failure);

  /// False when the conversion failed; then `failure` says why.
  [[nodiscard]] bool run();

 private:
  bool run(const Op* op, const Op* last);
  bool step(const Op*& op);
  bool write(const Op& op);

  [[nodiscard]] std::size_t left() const {
    return static_cast<std::size_t>(end_ - at_);
  }
  bool skip(std::size_t bytes, const Op& op);
  bool read_count(std::size_t min_size, const Op& op, std::uint32_t& count);
  bool skip_array(const Op& op);
  bool skip_strings(const Op& op);
  bool loop(const Op& op);
  bool repeat(const Op& op, std::uint32_t count);
  bool index(const Op*& op);
  bool flush(const Op& op);
  bool seek(const Op& op);
  bool emit(const Op& op, const void* bytes, std::size_t size);
  bool zero(const Op& op, std::size_t size);
  bool zero_array(const Op& op);
  bool expect_count(const Op& op);
  /// Copies the wanted bytes and the count of an array of `size` bytes an element, checks that its elements
  /// are there.
  bool open_array(const Op& op, std::size_t size, std::uint32_t& count);
  bool numbers(const Op& op, std::size_t count);
  bool shift(const Op& op, std::size_t count);
  bool slash(const Op& op);
  bool signed_time(const Op& op);
  bool map(const Op*& op);
  bool poses(const Op& op, std::size_t count);
  bool chain(const Op& op);

  /// The `bytes` at the position, which then are passed and not wanted any more; null when they are not
  /// there.
  const std::uint8_t* replace(std::size_t bytes, const Op& op);

  bool fail(Failure::Kind kind, const Op& op, std::uint64_t number = 0, std::uint64_t limit = 0);
  bool fail_value(const Op& op, const std::uint8_t* value, std::size_t index);
  void fill_indices();

  const Code& code_;
  const std::uint8_t* at_;
  const std::uint8_t* anchor_;
  const std::uint8_t* end_;
  Output& out_;
  std::int64_t time_shift_ns_;
  const std::uint8_t** slots_{nullptr};
  Failure& failure_;
  std::vector<std::uint64_t> indices_;  ///< of the loops around a failure, innermost first
  static constexpr std::size_t kInlineSlots = 48;
  std::array<const std::uint8_t*, kInlineSlots> inline_slots_;
};

/// Runs conversions one after the other through memory of this thread; the last one writes to `out`.
[[nodiscard]] bool run_stages(const Stages& stages, ByteView source, Output& out, std::int64_t time_shift_ns,
                              Failure& failure);

}  // namespace extperfc::translate::plan
