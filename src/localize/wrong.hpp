#pragma once

#include <string>

#include "extperfc/base/error.hpp"

namespace extperfc::localize {

[[nodiscard]] inline tl::unexpected<Error> wrong(const std::string& what) {
  return fail(ErrorCode::kInvalidArgument, "localizer: " + what);
}

}  // namespace extperfc::localize
