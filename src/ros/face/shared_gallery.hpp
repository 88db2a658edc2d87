#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/face/gallery.hpp"

namespace extperfc::ros_face {

/// A gallery and its file, for any number of threads. A change that cannot be written does not happen.
class SharedGallery {
 public:
  /// Reads the file if it exists; an empty name means no file. Errors: those of face::load_gallery().
  [[nodiscard]] static Result<std::unique_ptr<SharedGallery>> open(const std::filesystem::path& file,
                                                                   const face::GallerySpec& spec);

  SharedGallery(face::Gallery gallery, std::filesystem::path file);

  [[nodiscard]] face::Identity identify(const face::Feature& feature,
                                        const face::IdentifyParams& params) const;
  [[nodiscard]] std::vector<std::string> names() const;

  /// Adds and writes; the number of features that the name has then. Errors: those of Gallery::add() and of
  /// writing.
  [[nodiscard]] Result<std::size_t> enroll(const std::string& name,
                                           const std::vector<face::Feature>& features);
  /// Errors: kNotFound for a name that is not known, and those of writing.
  [[nodiscard]] Result<void> forget(const std::string& name);

 private:
  [[nodiscard]] face::Gallery copy() const;
  [[nodiscard]] Result<void> replace(face::Gallery gallery);

  const std::filesystem::path file_;
  std::mutex change_mutex_;   ///< one change after the other, with its writing
  mutable std::mutex mutex_;  ///< guards what follows, never held over writing
  face::Gallery gallery_;
};

}  // namespace extperfc::ros_face
