#include "translate/plan/failure.hpp"

namespace extperfc::translate {

namespace {

std::string bytes_text(std::uint64_t count) {
  return std::to_string(count) + (count == 1 ? " byte" : " bytes");
}

std::string elements_text(std::uint64_t count) {
  return std::to_string(count) + (count == 1 ? " element" : " elements");
}

}  // namespace

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

}  // namespace extperfc::translate
