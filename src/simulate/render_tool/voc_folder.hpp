#pragma once

#include <filesystem>
#include <string>

#include "extperfc/base/error.hpp"

#include "simulate/render_tool/image_maker.hpp"
#include "simulate/render_tool/options.hpp"

namespace extperfc::simulate {

/// A data set in Pascal VOC's layout. An image is there when its XML is: the XML is written last, and every
/// file gets its name when it is complete. Different images may be written by different threads.
class VocFolder {
 public:
  /// Makes the folders and writes settings and labels. Errors: cannot be written; not empty without
  /// `resume`; `resume` with other settings.
  [[nodiscard]] static Result<VocFolder> open(const Options& options);

  [[nodiscard]] bool has(int number) const;
  [[nodiscard]] Result<void> write(int number, const AnnotatedImage& image) const;
  /// Writes ImageSets/Main from the images that are there, whole worlds to one set; returns their number.
  [[nodiscard]] Result<int> write_sets() const;

 private:
  explicit VocFolder(Options options) : options_(std::move(options)) {}
  Options options_;
};

/// Content of an annotation file. Pixels count from 1, as in Pascal VOC; both ends of a box belong to it.
[[nodiscard]] std::string voc_xml(const std::string& file_name, const AnnotatedImage& image);

/// "000001" for image 0.
[[nodiscard]] std::string image_name(int number);

}  // namespace extperfc::simulate
