#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "extperfc/translate/schema.hpp"

/// The instructions of a plan. Running them moves three marks: the source's position, the anchor behind it,
/// and the output's end. Bytes from the anchor to the position are wanted as they are and not copied yet: an
/// instruction that writes something else copies them first, in one block.
namespace extperfc::translate {

enum class OpCode : std::uint8_t {
  // Only move the position; bytes stay wanted.
  kSkip,         ///< `size` bytes
  kSkipArray,    ///< a count, then so many elements of `size` bytes; a string is one of size 1
  kSkipStrings,  ///< a count, then so many strings
  kLoop,    ///< a count, then the `body` for each; an element has `size` bytes at least, its target `extra`
  kRepeat,  ///< the `body`, `size` times
  // Move the marks.
  kFlush,   ///< copies what is wanted
  kAnchor,  ///< what was passed is not wanted
  kMark,    ///< stores the position in slot `extra`
  kSeek,    ///< copies what is wanted, then position and anchor from slot `extra`
  kIndex,   ///< a count, then element `size` of an array, the `body` passes one; beyond the end: on at
            ///< `extra`, or
            ///< an error when that is 0
  kJump,    ///< on at `extra`
  // Write what differs.
  kEmit,         ///< `size` bytes of the constants from `extra` on
  kZero,         ///< `size` zero bytes
  kZeroArray,    ///< a count of elements without bytes; each becomes `size` zero bytes
  kExpectCount,  ///< a count that must be `size`; dropped
  kNumbers,      ///< `size` numbers from one primitive to another
  kNumbersArray,
  kShift,  ///< `size` time stamps
  kShiftArray,
  kSlash,       ///< a string whose leading slashes go, or which gets one (`flags`)
  kSignedTime,  ///< time to duration or the other way, as `from` says
  kMap,  ///< compares a value with the keys of map `extra`; when one matches, writes its value, skips `body`
  kPoses,  ///< `size` poses, expressed in the parent of the pose at slot `extra`
  kPosesArray,
  kChain,  ///< the `body` passes an embedded message; chain `extra` converts it
};

/// Bits of Op::flags.
enum Flag : std::uint8_t {
  kSaturate = 1U,  ///< kNumbers: the nearest value that fits
  kScaled = 2U,    ///< kNumbers: with scale `extra`
  kAddSlash = 4U,  ///< kSlash: add instead of strip
  kListed = 8U,    ///< several elements: an error names the index
};

struct Op {
  OpCode code{OpCode::kFlush};
  Primitive from{Primitive::kUint8};
  Primitive to{Primitive::kUint8};
  std::uint8_t flags{0};
  std::uint32_t size{0};
  std::uint32_t body{0};   ///< number of the following instructions that belong to this one
  std::uint32_t extra{0};  ///< meaning by code; instructions as their index
};

/// Where an instruction comes from, for messages; "[]" stands for an index.
struct Remark {
  std::string first;
  std::string last;  ///< of merged instructions; else empty
};

struct Scale {
  double factor{1.0};
  double offset{0.0};
};

/// Keys and values as bytes of the fields.
struct ConstantMap {
  std::vector<std::pair<std::string, std::string>> entries;
};

struct Code;
/// Conversions one after the other, through the definitions between.
using Stages = std::vector<Code>;

/// One compiled conversion. Immutable once made.
struct Code {
  std::vector<Op> ops;
  std::vector<Remark> remarks;  ///< by instruction
  std::vector<std::uint8_t> constants;
  std::vector<Scale> scales;
  std::vector<ConstantMap> maps;
  std::vector<Stages> chains;
  std::uint32_t slots{0};
  std::size_t growth{0};     ///< bytes that the target has at least more than the source
  bool reinterprets{false};  ///< bytes keep their values, but not their meaning (a string as uint8[])
};

/// True for instructions that leave every byte as it is.
[[nodiscard]] constexpr bool only_scans(OpCode code) {
  return code <= OpCode::kRepeat;
}

}  // namespace extperfc::translate
