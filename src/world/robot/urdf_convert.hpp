#pragma once

#include <filesystem>

#include <urdf_model/joint.h>
#include <urdf_model/link.h>

#include "extperfc/base/error.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc {

/// A link with its shapes, without its place in the tree. Errors: a shape without size, an unknown mesh, a
/// mass or an inertia that no body has.
[[nodiscard]] Result<Link> to_link(const urdf::Link& link, const std::filesystem::path& resource_root);

/// A joint without its links and its mimic. Errors: floating or planar, no axis, lower > upper, a negative
/// limit of velocity or effort.
[[nodiscard]] Result<Joint> to_joint(const urdf::Joint& joint);

}  // namespace extperfc
