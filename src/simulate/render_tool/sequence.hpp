#pragma once

#include <functional>

#include "extperfc/base/error.hpp"

#include "simulate/render_tool/options.hpp"

namespace extperfc::simulate {

/// Writes an RGB-D recording into `options.out`: a camera moves on an arc about the objects of a world. The
/// folder gets rgb/000000.png, depth/000000.png (16 bit, millimetres, 0: none), associations.txt (stamp,
/// image, stamp, depth), groundtruth.txt (stamp, position [m], quaternion x y z w of the optical frame in the
/// world) and camera_info.yaml. `go_on` is asked before each image with its number; false ends the recording.
/// Returns the number of images. Errors: the world, or a file that cannot be written.
[[nodiscard]] Result<int> write_sequence(const Options& options, const std::function<bool(int)>& go_on);

}  // namespace extperfc::simulate
