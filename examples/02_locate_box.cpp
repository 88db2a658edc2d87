// Puts a detected box into space with an aligned depth image; here a drawn one, a wall with a cube before it.
#include <vector>

#include "extperfc/depth/box_depth.hpp"
#include "extperfc/world/camera_model.hpp"

#include "examples/example.hpp"

using namespace extperfc;

int main() {
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 600;  // [px]
  camera.cx = 319.5;
  camera.cy = 239.5;
  examples::check(camera.validate());

  const Box2 box{280, 200, 360, 280};                    // of the detector, in pixels of the color image
  std::vector<std::uint16_t> depth_mm(640 * 480, 1500);  // a wall at 1.5 m
  for (int y = 200; y < 280; ++y)
    for (int x = 280; x < 360; ++x) depth_mm[static_cast<std::size_t>(y * 640 + x)] = 800;
  const ImageView depth{reinterpret_cast<const std::uint8_t*>(depth_mm.data()), 640, 480, 2 * 640,
                        PixelFormat::kDepth16Mm};

  depth::BoxDepthParams params;  // by default the nearest dense depth layer in the middle of the box
  examples::check(depth::validate(params));
  const auto found = depth::estimate_depth(depth, box, params);
  if (!found) return std::cerr << "no valid depth in the box\n", 1;

  const depth::Object3 object = depth::locate(camera, box, *found);
  std::cout << "depth " << found->depth_m << " m, standard deviation " << found->sigma_m << " m\n"
            << "surface " << object.surface.transpose() << " m\n"
            << "center  " << object.center.transpose() << " m\n";
}
