#pragma once

#include <string>

#include <urdf_model/model.h>
#include <urdf_world/types.h>

#include "extperfc/base/error.hpp"

namespace extperfc {

/// urdfdom's tree of a document; numbers are read in the "C" locale, independent of the process's and the
/// thread's are. The error holds what urdfdom complained of; nothing reaches its own log. Safe from several
/// threads.
[[nodiscard]] Result<urdf::ModelInterfaceSharedPtr> parse_urdf(const std::string& xml);

}  // namespace extperfc
