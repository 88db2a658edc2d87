#include "translate/plan/describe.hpp"

#include <optional>

namespace extperfc::translate {

namespace {

std::string range(const Remark& remark) {
  return remark.last.empty() ? remark.first : remark.first + " ... " + remark.last;
}

std::string bytes(std::uint64_t count) {
  return std::to_string(count) + (count == 1 ? " byte" : " bytes");
}

std::string times(const Op& op) {
  return op.size == 1 ? "" : std::to_string(op.size) + " x ";
}

/// Collects neighbouring fields that are copied, or passed, as one block.
struct Block {
  std::string first, last;
  std::uint64_t size{0};
  bool varies{false};
  bool open{false};

  void add(const Op& op, const Remark& remark) {
    if (!open) first = remark.first;
    last = remark.last.empty() ? remark.first : remark.last;
    if (op.code == OpCode::kSkip) {
      size += op.size;
    } else {
      varies = true;
    }
    open = true;
  }
};

class Describer {
 public:
  explicit Describer(const Code& code) : code_(code) {}

  std::vector<std::string> all() {
    steps(0, code_.ops.size(), 0);
    return std::move(lines_);
  }

 private:
  void line(std::size_t indent, const std::string& text) {
    lines_.push_back(std::string(2 * indent, ' ') + text);
  }

  void close(Block& block, const char* verb, std::size_t indent) {
    if (!block.open) return;
    const auto fields = block.first == block.last ? block.first : block.first + " ... " + block.last;
    line(indent, std::string(verb) +
                     (block.varies ? " one block of varying size: " : " " + bytes(block.size) + ": ") +
                     fields);
    block = Block();
  }

  /// True when nothing in the body writes anything else.
  [[nodiscard]] bool scans(std::size_t first, std::size_t last) const {
    for (auto i = first; i < last; ++i)
      if (!only_scans(code_.ops[i].code)) return false;
    return true;
  }

  void steps(std::size_t first, std::size_t last, std::size_t indent) {
    Block block;
    for (auto i = first; i < last; ++i) {
      const Op& op = code_.ops[i];
      if (only_scans(op.code) && scans(i + 1, i + 1 + op.body)) {
        block.add(op, code_.remarks[i]);
        i += op.body;
        continue;
      }
      if (op.code == OpCode::kMark) {
        marked_ = true;
        continue;
      }
      const bool drops = op.code == OpCode::kAnchor;
      close(block, drops ? (marked_ ? "look through" : "leave out") : "copy", indent);
      if (drops) marked_ = false;
      other(i, indent);
      i += op.body;
    }
    close(block, "copy", indent);
  }

  void other(std::size_t at, std::size_t indent) {
    const Op& op = code_.ops[at];
    const auto text = to_text(op, range(code_.remarks[at]));
    if (text) line(indent, *text);
    const bool has_steps = op.code == OpCode::kLoop || op.code == OpCode::kRepeat || op.code == OpCode::kMap;
    if (has_steps) steps(at + 1, at + 1 + op.body, indent + 1);
    if (op.code != OpCode::kChain) return;
    const auto& stages = code_.chains[op.extra];
    for (std::size_t i = 0; i < stages.size(); ++i) {
      line(indent + 1, "rule " + std::to_string(i + 1) + ":");
      for (const auto& inner : describe_code(stages[i])) line(indent + 2, inner);
    }
  }

  [[nodiscard]] static std::optional<std::string> to_text(const Op& op, const std::string& fields) {
    const std::string pair = std::string(to_string(op.from)) + " to " + to_string(op.to);
    switch (op.code) {
      case OpCode::kLoop:
        return "for each of " + fields + ":";
      case OpCode::kRepeat:
        return std::to_string(op.size) + " times, for " + fields + ":";
      case OpCode::kSeek:
        return "go to where " +
               (fields.empty() || fields.back() == '.' ? "the message ends" : fields + " comes from");
      case OpCode::kIndex:
        return "take element " + std::to_string(op.size) + " of the path to " + fields +
               (op.extra == 0 ? "" : ", or what is written otherwise");
      case OpCode::kJump:
        return "or, without such an element:";
      case OpCode::kEmit:
        return "write " + bytes(op.size) + ", always the same: " + fields;
      case OpCode::kZero:
        return "write " + bytes(op.size) + " of zeros: " + fields;
      case OpCode::kZeroArray:
        return "write " + bytes(op.size) + " of zeros for each of " + fields;
      case OpCode::kExpectCount:
        return "check that there are " + std::to_string(op.size) + ": " + fields;
      case OpCode::kNumbers:
        return "convert " + times(op) + pair + ((op.flags & kScaled) != 0 ? ", scaled: " : ": ") + fields;
      case OpCode::kNumbersArray:
        return "convert an array " + pair + ((op.flags & kScaled) != 0 ? ", scaled: " : ": ") + fields;
      case OpCode::kShift:
      case OpCode::kShiftArray:
        return "shift the time: " + fields;
      case OpCode::kSlash:
        return ((op.flags & kAddSlash) != 0 ? "add the leading slash: " : "remove leading slashes: ") +
               fields;
      case OpCode::kSignedTime:
        return "convert " + pair + ": " + fields;
      case OpCode::kMap:
        return "replace a known value; any other as follows: " + fields;
      case OpCode::kPoses:
      case OpCode::kPosesArray:
        return "express in the parent's frame: " + fields;
      case OpCode::kChain:
        return "convert through the definitions between: " + fields;
      default:
        return std::nullopt;
    }
  }

  const Code& code_;
  std::vector<std::string> lines_;
  bool marked_{false};  ///< what is passed is looked for, not left out
};

}  // namespace

std::vector<std::string> describe_code(const Code& code) {
  return Describer(code).all();
}

}  // namespace extperfc::translate
