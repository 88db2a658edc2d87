#pragma once

#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace extperfc {

/// What kind of error occurred; stable, so that callers and tests can branch on it.
enum class ErrorCode {
  kInvalidArgument,  ///< a value or a combination of values that can never work
  kNotFound,         ///< a file, device, topic or key does not exist
  kCorrupt,          ///< it exists, but its content is damaged or of another kind
  kUnsupported,      ///< well formed, but this build or machine cannot do it
  kFailed,           ///< a library call that should have worked did not
};

/// One error for people: what was wrong, where, and what to do about it, in one line.
struct Error {
  ErrorCode code{ErrorCode::kFailed};
  std::string message;
};

/// A value or an Error. For what can be recovered; exceptions are for invalid construction only.
template <typename T>
using Result = tl::expected<T, Error>;

/// `return fail(ErrorCode::kNotFound, "no such file: ...")` from a function that returns a Result.
[[nodiscard]] inline tl::unexpected<Error> fail(ErrorCode code, std::string message) {
  return tl::unexpected<Error>(Error{code, std::move(message)});
}

/// Name of a code for logs, e.g. "not_found".
[[nodiscard]] const char* to_string(ErrorCode code);

}  // namespace extperfc
