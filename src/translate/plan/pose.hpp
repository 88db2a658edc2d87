#pragma once

#include <cstddef>
#include <cstdint>

#include "extperfc/translate/schema.hpp"

namespace extperfc::translate {

/// Bytes of a geometry_msgs/Pose: position x y z [m], orientation x y z w, each a float64.
inline constexpr std::size_t kPoseSize = 56;

/// True when the definition has a pose's fields, regardless of its name.
[[nodiscard]] bool is_pose(const MessageSchema& schema);

/// parent_T_child for each child: target_T_child = target_T_parent * parent_T_child, where `parent` holds
/// target_T_parent. An orientation of four zeros counts as the identity. Where the parent is the identity the
/// bytes stay exactly as they are.
void compose_poses(const std::uint8_t* parent, const std::uint8_t* children, std::uint8_t* out,
                   std::size_t count);

}  // namespace extperfc::translate
