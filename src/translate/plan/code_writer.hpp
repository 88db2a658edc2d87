#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "extperfc/translate/bytes.hpp"

#include "translate/plan/code.hpp"

namespace extperfc::translate {

/// Writes instructions and joins neighbours: fields of fixed size become one block, arrays of such blocks one
/// array.
class CodeWriter {
 public:
  void skip(std::uint64_t bytes, const std::string& path);
  void skip_array(std::uint32_t element_size, const std::string& path);
  void flush(const std::string& path);
  void anchor(const std::string& path);
  void mark(std::uint32_t slot, const std::string& path);
  void seek(std::uint32_t slot, const std::string& path);
  void emit(ByteView constant, const std::string& path);
  void zero(std::uint64_t bytes, const std::string& path);
  /// Any other instruction; returns its index.
  std::size_t append(const Op& op, const std::string& path);

  /// The body of kLoop, kRepeat, kIndex, kMap or kChain: what is written between the two calls.
  std::size_t begin(const Op& op, const std::string& path);
  void end_loop(std::size_t at);
  void end_repeat(std::size_t at);
  void end_body(std::size_t at);

  /// The index that the next instruction gets, as the target of a jump: nothing before it joins it.
  std::uint32_t here();
  [[nodiscard]] std::uint32_t new_slot() { return code_.slots++; }
  [[nodiscard]] Code& code() { return code_; }
  /// Grows with every instruction that does more than scan.
  [[nodiscard]] std::size_t changes() const { return changes_; }
  /// Something did not fit into an instruction: the definition is too large.
  [[nodiscard]] bool overflowed() const { return overflowed_; }

 private:
  [[nodiscard]] Op* joinable(OpCode code);
  [[nodiscard]] std::uint32_t narrow(std::uint64_t size);
  void extend_remark(const std::string& path);
  void drop_from(std::size_t at);

  Code code_;
  std::size_t barrier_{0};             ///< instructions before this one stay as they are
  std::vector<std::size_t> barriers_;  ///< of the bodies around, at their begin
  std::size_t changes_{0};
  bool overflowed_{false};
};

}  // namespace extperfc::translate
