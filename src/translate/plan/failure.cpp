#include <algorithm>

#include "translate/plan/numbers.hpp"
#include "translate/plan/runner.hpp"

namespace extperfc::translate::plan {

namespace {

std::string bytes_text(std::uint64_t count) {
  return std::to_string(count) + (count == 1 ? " byte" : " bytes");
}

std::string elements_text(std::uint64_t count) {
  return std::to_string(count) + (count == 1 ? " element" : " elements");
}

/// A time or duration is shown by its seconds.
std::string value_text(Primitive primitive, const std::uint8_t* bytes) {
  if (primitive == Primitive::kTime) return number_text(Primitive::kUint32, bytes) + " s";
  if (primitive == Primitive::kDuration) return number_text(Primitive::kInt32, bytes) + " s";
  return number_text(primitive, bytes);
}

}  // namespace

bool Runner::fail(Failure::Kind kind, const Op& op, std::uint64_t number, std::uint64_t limit) {
  failure_.kind = kind;
  failure_.number = number;
  failure_.limit = limit;
  const auto* first = code_.ops.data();
  const auto* last = first + code_.ops.size();
  if (std::less_equal<>()(first, &op) && std::less<>()(&op, last)) {
    const auto& remark = code_.remarks[static_cast<std::size_t>(&op - first)];
    failure_.path = remark.last.empty() ? remark.first : remark.first + " ... " + remark.last;
  }
  return false;
}

bool Runner::fail_value(const Op& op, const std::uint8_t* value, std::size_t index) {
  failure_.value = value_text(op.from, value) + " does not fit " + to_string(op.to);
  if ((op.flags & kListed) != 0) indices_.push_back(index);
  return fail(Failure::Kind::kValue, op);
}

/// Writes the indices into the brackets of the path, outermost first.
void Runner::fill_indices() {
  auto& path = failure_.path;
  std::size_t from = 0;
  while (!indices_.empty()) {
    const auto brackets = path.find("[]", from);
    if (brackets == std::string::npos) return;
    const auto number = std::to_string(indices_.back());
    path.insert(brackets + 1, number);
    from = brackets + number.size() + 2;
    indices_.pop_back();
  }
}

Error to_error(const Failure& failure) {
  const auto where = failure.path.empty() ? std::string("the message") : "field " + failure.path;
  switch (failure.kind) {
    case Failure::Kind::kNone:
      break;
    case Failure::Kind::kEnds:
      return {ErrorCode::kCorrupt, "the message ends early: " + where + " needs " +
                                       bytes_text(failure.limit) + ", " + bytes_text(failure.number) +
                                       " left; was it sent with another definition?"};
    case Failure::Kind::kTrailing:
      return {ErrorCode::kCorrupt, "the message goes on after its last field: " + bytes_text(failure.number) +
                                       " left; was it sent with another definition?"};
    case Failure::Kind::kCount:
      return {ErrorCode::kCorrupt, where + " claims " + elements_text(failure.number) + ", which " +
                                       bytes_text(failure.limit) + " cannot hold"};
    case Failure::Kind::kTooLong:
      return {ErrorCode::kCorrupt, "converted, the message is longer than " + bytes_text(failure.limit) +
                                       " at " + where + "; raise max_message_bytes if it should be"};
    case Failure::Kind::kValue:
      return {ErrorCode::kInvalidArgument, where + ": " + failure.value +
                                               "; a rule with `overflow: saturate` would" +
                                               " take the nearest value"};
    case Failure::Kind::kLength:
      return {ErrorCode::kInvalidArgument, where + " has " + elements_text(failure.number) +
                                               ", the target takes " + std::to_string(failure.limit)};
    case Failure::Kind::kIndex:
      return {ErrorCode::kInvalidArgument,
              where + " has " + elements_text(failure.number) + ", a rule takes the one with index " +
                  std::to_string(failure.limit) + "; give the rule an `otherwise`"};
  }
  return {ErrorCode::kFailed, "the conversion failed at " + where};
}

}  // namespace extperfc::translate::plan
