#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/face/embedder.hpp"

namespace extperfc::face {

/// Which features a gallery holds, and how many.
struct GallerySpec {
  std::string embedder;          ///< FaceEmbedder::identity()
  std::size_t size{0};           ///< FaceEmbedder::size()
  std::size_t max_features{20};  ///< of one name, at least 1; a new one replaces the oldest
  std::size_t max_names{1000};
};

/// When a face has a name.
struct IdentifyParams {
  float threshold{0.363F};  ///< smallest similarity with a feature of the name
  float margin{0.05F};      ///< by which the second name is less similar, at least; >= 0
};

/// Who a face is.
struct Identity {
  std::string name;     ///< empty: unknown
  float similarity{0};  ///< with the most similar feature of any name; 0 in an empty gallery
};

/// Names of people with several features each. One thread at a time.
class Gallery {
 public:
  using People = std::map<std::string, std::vector<Feature>>;  ///< oldest feature first

  explicit Gallery(GallerySpec spec) : spec_(std::move(spec)) {}

  /// The name of the most similar feature; unknown below the threshold, and when another name is about as
  /// similar.
  [[nodiscard]] Identity identify(const Feature& feature, const IdentifyParams& params) const;

  /// Errors: kInvalidArgument for a name that is empty, longer than 64 bytes or has control characters, for a
  /// feature of another size or without the length 1, and for one name too many.
  [[nodiscard]] Result<void> add(const std::string& name, Feature feature);
  /// The number of features that it had; 0: this name is not known.
  std::size_t forget(const std::string& name);

  [[nodiscard]] const GallerySpec& spec() const { return spec_; }
  [[nodiscard]] const People& people() const { return people_; }
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  GallerySpec spec_;
  People people_;
};

/// An error that says what is wrong with a name, and what to do.
[[nodiscard]] Result<void> check_name(const std::string& name);

/// Writes all of it to a YAML file: a reader meets the old content or the new. Makes the file's folder.
/// Features are written with six digits. Errors: those of write_text_atomically().
[[nodiscard]] Result<void> save_gallery(const Gallery& gallery, const std::filesystem::path& file);

/// Reads such a file. Errors, each with file, line and remedy: kNotFound, kCorrupt (not YAML),
/// kInvalidArgument for features of another embedder or size, and for what add() refuses. Of more than
/// `max_features` features of a name the latest are kept.
[[nodiscard]] Result<Gallery> load_gallery(const std::filesystem::path& file, const GallerySpec& spec);

}  // namespace extperfc::face
