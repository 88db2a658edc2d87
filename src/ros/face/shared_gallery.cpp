#include "ros/face/shared_gallery.hpp"

#include <utility>

#include "extperfc/base/text.hpp"

namespace extperfc::ros_face {

Result<std::unique_ptr<SharedGallery>> SharedGallery::open(const std::filesystem::path& file,
                                                           const face::GallerySpec& spec) {
  std::error_code ignored;
  if (file.empty() || !std::filesystem::exists(file, ignored))
    return std::make_unique<SharedGallery>(face::Gallery(spec), file);
  auto gallery = face::load_gallery(file, spec);
  if (!gallery) return tl::unexpected(gallery.error());
  return std::make_unique<SharedGallery>(std::move(*gallery), file);
}

SharedGallery::SharedGallery(face::Gallery gallery, std::filesystem::path file)
    : file_(std::move(file)), gallery_(std::move(gallery)) {}

face::Identity SharedGallery::identify(const face::Feature& feature,
                                       const face::IdentifyParams& params) const {
  const std::lock_guard lock(mutex_);
  return gallery_.identify(feature, params);
}

std::vector<std::string> SharedGallery::names() const {
  const std::lock_guard lock(mutex_);
  return gallery_.names();
}

Result<std::size_t> SharedGallery::enroll(const std::string& name,
                                          const std::vector<face::Feature>& features) {
  const std::lock_guard lock(change_mutex_);
  auto changed = copy();
  for (const auto& feature : features)
    if (auto added = changed.add(name, feature); !added) return tl::unexpected(added.error());
  const std::size_t total = changed.people().at(name).size();
  if (auto replaced = replace(std::move(changed)); !replaced) return tl::unexpected(replaced.error());
  return total;
}

Result<void> SharedGallery::forget(const std::string& name) {
  const std::lock_guard lock(change_mutex_);
  auto changed = copy();
  if (changed.forget(name) == 0)
    return fail(ErrorCode::kNotFound,
                "no face is enrolled as " + in_quotes(name) + hint_or_names(name, changed.names()));
  return replace(std::move(changed));
}

face::Gallery SharedGallery::copy() const {
  const std::lock_guard lock(mutex_);
  return gallery_;
}

Result<void> SharedGallery::replace(face::Gallery gallery) {
  if (!file_.empty())
    if (auto saved = face::save_gallery(gallery, file_); !saved) return saved;
  const std::lock_guard lock(mutex_);
  gallery_ = std::move(gallery);
  return {};
}

}  // namespace extperfc::ros_face
