#pragma once

#include <filesystem>
#include <optional>
#include <vector>

namespace extperfc {

/// A portrait that an installed package brings along.
struct Photograph {
  std::filesystem::path file;
  float eye_x, eye_y;  ///< image pixels: the middle between the eyes
  float eye_distance;  ///< pixels
};

/// Those of these packages that are installed: python3-matplotlib-data, python3-skimage.
inline std::vector<Photograph> installed_photographs() {
  const std::vector<Photograph> all{
      {"/usr/share/matplotlib/mpl-data/sample_data/grace_hopper.jpg", 265, 187, 83},
      {"/usr/lib/python3/dist-packages/skimage/data/astronaut.png", 224, 102, 43}};
  std::vector<Photograph> found;
  std::error_code ignored;
  for (const auto& photograph : all)
    if (std::filesystem::is_regular_file(photograph.file, ignored)) found.push_back(photograph);
  return found;
}

/// The folder with the published YuNet networks; empty when it is not there.
inline std::optional<std::filesystem::path> yunet_folder(const std::filesystem::path& repository) {
  const auto folder = repository / "../shared/data/models/yunet";
  if (!std::filesystem::is_regular_file(folder / "yunet_n_320_320.onnx")) return std::nullopt;
  return folder;
}

}  // namespace extperfc
