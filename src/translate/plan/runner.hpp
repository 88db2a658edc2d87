#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "extperfc/translate/bytes.hpp"

#include "translate/plan/code.hpp"
#include "translate/plan/failure.hpp"
#include "translate/plan/output.hpp"

namespace extperfc::translate {

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

  [[gnu::cold]] bool fail(Failure::Kind kind, const Op& op, std::uint64_t number = 0,
                          std::uint64_t limit = 0);
  [[gnu::cold]] bool fail_value(const Op& op, const std::uint8_t* value, std::size_t index);
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

}  // namespace extperfc::translate
