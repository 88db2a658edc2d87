#include "world/png.hpp"

#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include <png.h>

#include "extperfc/base/atomic_file.hpp"
#include "extperfc/world/png_file.hpp"

namespace extperfc {

namespace {

namespace fs = std::filesystem;

/// libpng's description of an image, and what it holds.
class PngImage {
 public:
  PngImage() { image_.version = PNG_IMAGE_VERSION; }
  PngImage(const PngImage&) = delete;
  PngImage& operator=(const PngImage&) = delete;
  PngImage(PngImage&&) = delete;
  PngImage& operator=(PngImage&&) = delete;
  ~PngImage() { png_image_free(&image_); }

  png_image& operator*() { return image_; }
  png_image* operator->() { return &image_; }

 private:
  png_image image_{};
};

/// The channels that are needed: colours only where there are some, and so alpha.
png_uint_32 layout_of(png_uint_32 file_format) {
  return file_format & (PNG_FORMAT_FLAG_COLOR | PNG_FORMAT_FLAG_ALPHA);
}

GreyImage to_grey(const png_image& png, const std::vector<std::uint8_t>& pixels) {
  const bool has_alpha = (png.format & PNG_FORMAT_FLAG_ALPHA) != 0;
  const unsigned colours = (png.format & PNG_FORMAT_FLAG_COLOR) != 0 ? 3 : 1;
  const std::size_t stride = colours + (has_alpha ? 1U : 0U);
  GreyImage grey;
  grey.width = png.width;
  grey.height = png.height;
  const std::size_t count = grey.width * grey.height;
  grey.bytes.resize(count);
  if (has_alpha) grey.transparent.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* pixel = &pixels[i * stride];
    unsigned sum = 0;
    for (unsigned channel = 0; channel < colours; ++channel) sum += pixel[channel];
    grey.bytes[i] = static_cast<char>((sum + colours / 2) / colours);
    if (has_alpha) grey.transparent[i] = pixel[colours] == 0;
  }
  return grey;
}

}  // namespace

bool is_png(const fs::path& file) {
  constexpr std::array<char, 8> kSignature{'\x89', 'P', 'N', 'G', '\r', '\n', '\x1A', '\n'};
  std::array<char, 8> begin{};
  std::ifstream in(file, std::ios::binary);
  in.read(begin.data(), begin.size());
  return in.gcount() == static_cast<std::streamsize>(begin.size()) && begin == kSignature;
}

Result<GreyImage> read_png(const fs::path& file) {
  PngImage png;
  const auto damaged = [&] { return fail(ErrorCode::kCorrupt, file.string() + ": " + png->message); };
  if (png_image_begin_read_from_file(&*png, file.c_str()) == 0) return damaged();
  if (png->height > kMaxMapCells / png->width)
    return fail(ErrorCode::kCorrupt, file.string() + ": it claims " + std::to_string(png->width) + " x " +
                                         std::to_string(png->height) + " pixels, more than 2^28");
  // A pixel has one bit or more; deflate makes at most 1032 bytes of one.
  constexpr std::uintmax_t kMaxPixelsPerByte = 8 * 1032;
  std::error_code error;
  const auto file_bytes = fs::file_size(file, error);
  if (error || std::uintmax_t{png->width} * png->height > file_bytes * kMaxPixelsPerByte)
    return fail(ErrorCode::kCorrupt,
                file.string() + ": it breaks off: there are fewer than the announced pixels");
  png->format = layout_of(png->format);
  png->flags |= PNG_IMAGE_FLAG_16BIT_sRGB;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(*png));
  if (png_image_finish_read(&*png, nullptr, pixels.data(), 0, nullptr) == 0) return damaged();
  return to_grey(*png, pixels);
}

Result<void> write_png(const PngPixels& pixels, const fs::path& file) {
  if (pixels.width == 0 || pixels.height == 0 || pixels.height > kMaxMapCells / pixels.width)
    return fail(ErrorCode::kInvalidArgument,
                "cannot write the image " + file.string() + ": it must have 1 to 2^28 pixels");
  PngImage png;
  png->width = static_cast<png_uint_32>(pixels.width);
  png->height = static_cast<png_uint_32>(pixels.height);
  png->format = pixels.layout == PngLayout::kRgb         ? PNG_FORMAT_RGB
                : pixels.layout == PngLayout::kGreyAlpha ? PNG_FORMAT_GA
                                                         : PNG_FORMAT_GRAY;
  png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(*png);
  std::string packed(bytes, '\0');
  if (png_image_write_to_memory(&*png, packed.data(), &bytes, 0, pixels.bytes, 0, nullptr) == 0)
    return fail(ErrorCode::kFailed, "cannot encode the image " + file.string() + ": " + png->message);
  return write_file_atomically(
      file, [&](std::ostream& out) { out.write(packed.data(), static_cast<std::streamsize>(bytes)); });
}

}  // namespace extperfc
