#pragma once

#include <filesystem>
#include <vector>

#include <urdf_model/model.h>

#include "extperfc/base/error.hpp"
#include "extperfc/world/robot_model.hpp"

namespace extperfc {

/// Links and joints from the root, depth first; the child of joint i is link i + 1.
struct LinkTree {
  std::vector<Link> links;
  std::vector<Joint> joints;
};

/// Errors: those of to_link() and to_joint(); a link with two parents, a loop, a mimic of a joint that is
/// missing, fixed or a mimic itself.
[[nodiscard]] Result<LinkTree> to_link_tree(const urdf::ModelInterface& model,
                                            const std::filesystem::path& resource_root);

}  // namespace extperfc
