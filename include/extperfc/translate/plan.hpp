#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/translate/bytes.hpp"
#include "extperfc/translate/rules.hpp"
#include "extperfc/translate/schema.hpp"

namespace extperfc::translate {

struct PlanOptions {
  /// Add the shift given to convert() to every field of type `time`, at any depth; a stamp of 0 stays 0.
  bool shift_times{false};
  enum class Slash : std::uint8_t { kKeep, kStrip, kAdd };
  /// The leading slash of frame names: fields `frame_id` and `child_frame_id`; tf1 had it, tf2 refuses it.
  Slash frame_slash{Slash::kKeep};
  std::size_t max_message_bytes{256U << 20U};  ///< of a converted message: array counts come from strangers
};

/// How one definition's bytes become another's: compiled once, run for each message. Immutable; one plan may
/// run in several threads.
class Plan {
 public:
  enum class Kind : std::uint8_t {
    kPass,  ///< the same bytes: forward the buffer untouched
    kConvert,
  };
  /// What happens to a field, for people: "speed_ratio: from speed, times 0.01".
  struct Note {
    enum class Kind : std::uint8_t { kKept, kMoved, kConverted, kDefaulted, kDropped, kRule };
    Kind kind;
    std::string path;  ///< of the target; of the source for kDropped
    std::string text;
  };

  /// Fields pair by name; a rule of the pair (at any depth) comes first; then a chain of rules. Fields that
  /// do not convert without a rule (a string to a number, an array to a single value) are an error that names
  /// both.
  [[nodiscard]] static Result<std::shared_ptr<const Plan>> compile(const SchemaPtr& from, const SchemaPtr& to,
                                                                   const RuleSet& rules,
                                                                   const PlanOptions& options = {});
  ~Plan();

  [[nodiscard]] Kind kind() const;
  [[nodiscard]] const SchemaPtr& from() const;
  [[nodiscard]] const SchemaPtr& to() const;

  /// Appends the converted message to `out`; also for kPass (a checked copy). Errors: the bytes end early,
  /// are too many, an array is longer than the bytes left, a value does not fit its field (named with its
  /// path). `out` is as before after an error.
  [[nodiscard]] Result<void> convert(ByteView message, ByteBuffer& out, std::int64_t time_shift_ns = 0) const;

  /// Every field, in the target's order, dropped ones last.
  [[nodiscard]] const std::vector<Note>& notes() const;
  /// The plan as text, one line per step: block copies with their size, loops, conversions.
  [[nodiscard]] std::vector<std::string> describe() const;

 private:
  struct Program;
  explicit Plan(std::unique_ptr<const Program> program);
  std::unique_ptr<const Program> program_;
};
using PlanPtr = std::shared_ptr<const Plan>;

[[nodiscard]] const char* to_string(Plan::Kind kind);

/// A literal of a rule as the bytes of a field; an error when the field cannot hold it.
[[nodiscard]] Result<void> serialize(const Literal& value, const Field& field, ByteBuffer& out);
/// The bytes of a message whose every field is zero, empty or false.
void serialize_default(const MessageSchema& schema, ByteBuffer& out);

}  // namespace extperfc::translate
