#include "simulate/render_tool/voc_folder.hpp"

#include <array>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <system_error>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

namespace extperfc::simulate {

namespace fs = std::filesystem;

namespace {

/// Writes beside the target and renames, so that a file with its name is whole.
Result<void> write_file(const fs::path& file, const char* data, std::size_t size) {
  const fs::path partial = file.parent_path() / ("." + file.filename().string() + ".partial");
  std::ofstream out(partial, std::ios::binary);
  out.write(data, static_cast<std::streamsize>(size));
  out.close();
  std::error_code error;
  if (out) fs::rename(partial, file, error);
  if (!out || error)
    return fail(ErrorCode::kFailed,
                "cannot write " + file.string() + ": is the disk full, or the folder read-only?");
  return {};
}

Result<void> write_text(const fs::path& file, const std::string& text) {
  return write_file(file, text.data(), text.size());
}

Result<void> write_image(const fs::path& file, const cv::Mat& image, const std::vector<int>& settings) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(file.extension().string(), image, bytes, settings))
    return fail(ErrorCode::kUnsupported, "OpenCV cannot write " + file.extension().string() + " images");
  return write_file(file, reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

/// OpenCV wants blue first.
cv::Mat bgr_of(const CameraImages& images) {
  cv::Mat bgr(images.height, images.width, CV_8UC3);
  const std::size_t count = static_cast<std::size_t>(images.width) * static_cast<std::size_t>(images.height);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* rgb = &images.rgb[3 * i];
    bgr.at<cv::Vec3b>(static_cast<int>(i)) = {rgb[2], rgb[1], rgb[0]};
  }
  return bgr;
}

cv::Mat depth_of(const CameraImages& images) {
  return cv::Mat(images.height, images.width, CV_16UC1, const_cast<std::uint16_t*>(images.depth_mm.data()))
      .clone();
}

std::string file_text(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

Result<void> check_free(const Options& options) {
  std::error_code error;
  const bool used = fs::exists(options.out, error) &&
                    (!fs::is_directory(options.out, error) || !fs::is_empty(options.out, error));
  if (!used) return {};
  if (!options.resume)
    return fail(
        ErrorCode::kInvalidArgument,
        options.out.string() + " is not an empty folder: give a new one, or --resume to go on with it");
  if (file_text(options.out / "render.txt") == fingerprint(options)) return {};
  return fail(ErrorCode::kInvalidArgument, options.out.string() +
                                               " was made with other settings than these (its render.txt"
                                               " lists them): give the same ones, or a new folder");
}

Result<void> make_folders(const Options& options) {
  for (const char* name : {"JPEGImages", "Annotations", "ImageSets/Main", "Depth"}) {
    if (std::string(name) == "Depth" && !options.depth) continue;
    std::error_code error;
    fs::create_directories(options.out / name, error);
    if (error)
      return fail(ErrorCode::kFailed,
                  "cannot make the folder " + (options.out / name).string() + ": " + error.message());
  }
  return {};
}

void add_object(std::ostringstream& out, const Annotation& note) {
  out << "  <object>\n    <name>" << note.label << "</name>\n    <pose>Unspecified</pose>\n    <truncated>"
      << note.truncated << "</truncated>\n    <occluded>" << note.occluded << "</occluded>\n    <difficult>"
      << note.difficult << "</difficult>\n    <visible>" << note.visible
      << "</visible>\n    <bndbox>\n      <xmin>" << note.box.x_min + 1 << "</xmin>\n      <ymin>"
      << note.box.y_min + 1 << "</ymin>\n      <xmax>" << note.box.x_max + 1 << "</xmax>\n      <ymax>"
      << note.box.y_max + 1 << "</ymax>\n    </bndbox>\n  </object>\n";
}

}  // namespace

std::string image_name(int number) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%06d", number + 1);
  return text.data();
}

std::string voc_xml(const std::string& file_name, const AnnotatedImage& image) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(3);
  out << "<annotation>\n  <folder>JPEGImages</folder>\n  <filename>" << file_name
      << "</filename>\n  <source><database>extperfc-render</database></source>\n  <size>\n    <width>"
      << image.images.width << "</width>\n    <height>" << image.images.height
      << "</height>\n    <depth>3</depth>\n  </size>\n  <segmented>0</segmented>\n";
  for (const Annotation& note : image.annotations) add_object(out, note);
  out << "</annotation>\n";
  return out.str();
}

Result<VocFolder> VocFolder::open(const Options& options) {
  if (auto free = check_free(options); !free) return tl::unexpected(free.error());
  if (auto made = make_folders(options); !made) return tl::unexpected(made.error());
  std::string labels;
  for (const auto& name : options.classes) labels += name + "\n";
  if (auto written = write_text(options.out / "labels.txt", labels); !written)
    return tl::unexpected(written.error());
  if (auto written = write_text(options.out / "render.txt", fingerprint(options)); !written)
    return tl::unexpected(written.error());
  return VocFolder(options);
}

bool VocFolder::has(int number) const {
  std::error_code error;
  return fs::exists(options_.out / "Annotations" / (image_name(number) + ".xml"), error);
}

Result<void> VocFolder::write(int number, const AnnotatedImage& image) const {
  const std::string name = image_name(number);
  if (options_.depth)
    if (auto written = write_image(options_.out / "Depth" / (name + ".png"), depth_of(image.images), {});
        !written)
      return written;
  const std::vector<int> settings{cv::IMWRITE_JPEG_QUALITY, image.jpeg_quality};
  if (auto written =
          write_image(options_.out / "JPEGImages" / (name + ".jpg"), bgr_of(image.images), settings);
      !written)
    return written;
  return write_text(options_.out / "Annotations" / (name + ".xml"), voc_xml(name + ".jpg", image));
}

Result<int> VocFolder::write_sets() const {
  std::string train;
  std::string val;
  int count = 0;
  for (int number = 0; number < 999999; ++number) {
    if (number >= options_.count && !has(number)) break;
    if (!has(number)) continue;
    const std::uint64_t draw = mix(ImageMaker::world_of(options_, number), 0x7E57U) % 10000U;
    const bool for_val = static_cast<double>(draw) < options_.val * 10000;
    (for_val ? val : train) += image_name(number) + "\n";
    ++count;
  }
  const fs::path folder = options_.out / "ImageSets" / "Main";
  if (auto written = write_text(folder / "train.txt", train); !written)
    return tl::unexpected(written.error());
  if (auto written = write_text(folder / "val.txt", val); !written) return tl::unexpected(written.error());
  if (auto written = write_text(folder / "trainval.txt", train + val); !written)
    return tl::unexpected(written.error());
  return count;
}

}  // namespace extperfc::simulate
