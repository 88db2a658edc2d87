#include "world/pgm.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <optional>

namespace extperfc {

namespace {

namespace fs = std::filesystem;

constexpr unsigned kMaxGrey = 65535;
constexpr unsigned kMaxByte = 255;

/// The next number of a PNM text, over blanks and comments; empty when another character comes first or the
/// number is above `max_value`.
std::optional<std::size_t> next_number(std::istream& in, std::size_t max_value) {
  int c = in.get();
  while (c == '#' || std::isspace(c) != 0) {
    if (c == '#')
      while (c != '\n' && c != '\r' && c != EOF) c = in.get();
    else
      c = in.get();
  }
  if (std::isdigit(c) == 0) return std::nullopt;
  std::size_t value = 0;
  for (; std::isdigit(c) != 0; c = in.get()) {
    value = value * 10 + static_cast<std::size_t>(c - '0');
    if (value > max_value) return std::nullopt;
  }
  if (c != EOF && std::isspace(c) == 0) return std::nullopt;  // exactly one blank ends a binary header
  return value;
}

Result<void> read_header(std::istream& in, GreyImage& image) {
  const auto width = next_number(in, kMaxMapCells);
  const auto height = width ? next_number(in, kMaxMapCells) : std::nullopt;
  const auto largest = height ? next_number(in, kMaxGrey) : std::nullopt;
  if (!largest || *width == 0 || *height == 0 || *largest == 0)
    return fail(ErrorCode::kCorrupt,
                "its header is damaged (width, height and the largest grey value must be "
                "positive, the last at most 65535)");
  if (*height > kMaxMapCells / *width)
    return fail(ErrorCode::kCorrupt, "it claims " + std::to_string(*width) + " x " + std::to_string(*height) +
                                         " pixels, more than 2^28");
  image.width = *width;
  image.height = *height;
  image.largest = static_cast<unsigned>(*largest);
  return {};
}

tl::unexpected<Error> broken_off(const GreyImage& image) {
  return fail(ErrorCode::kCorrupt, "it breaks off: there are fewer than the announced " +
                                       std::to_string(image.width) + " x " + std::to_string(image.height) +
                                       " pixels");
}

void append(GreyImage& image, std::size_t value) {
  if (image.largest > kMaxByte) image.bytes.push_back(static_cast<char>(value >> 8U));
  image.bytes.push_back(static_cast<char>(value & kMaxByte));
}

Result<void> read_text(std::istream& in, GreyImage& image) {
  const std::size_t pixels = image.width * image.height;
  for (std::size_t i = 0; i < pixels; ++i) {
    const auto value = next_number(in, image.largest);
    if (!value && in.eof()) return broken_off(image);
    if (!value)
      return fail(ErrorCode::kCorrupt, "pixel " + std::to_string(i) + " is not a number from 0 to " +
                                           std::to_string(image.largest));
    append(image, *value);
  }
  return {};
}

Result<void> read_pixels(std::istream& in, std::uintmax_t file_bytes, bool binary, GreyImage& image) {
  const std::size_t pixels = image.width * image.height;
  const std::size_t bytes = pixels * (image.largest > kMaxByte ? 2 : 1);
  // Before memory is taken: a digit and a blank are the minimum that a pixel of a text file needs.
  const std::uintmax_t min_bytes = binary ? bytes : 2 * std::uintmax_t{pixels} - 1;
  if (file_bytes < min_bytes) return broken_off(image);
  if (!binary) {
    image.bytes.reserve(bytes);
    return read_text(in, image);
  }
  image.bytes.resize(bytes);
  in.read(image.bytes.data(), static_cast<std::streamsize>(bytes));
  if (static_cast<std::size_t>(in.gcount()) != bytes) return broken_off(image);
  return {};
}

}  // namespace

unsigned GreyImage::at(std::size_t x, std::size_t y) const {
  const std::size_t i = y * width + x;
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(bytes[at]); };
  if (largest <= kMaxByte) return std::min<unsigned>(byte(i), largest);
  return std::min((unsigned{byte(2 * i)} << 8U) | byte(2 * i + 1), largest);
}

Result<GreyImage> read_pgm(const fs::path& file) {
  std::error_code error;
  const auto file_bytes = fs::file_size(file, error);
  std::ifstream in(file, std::ios::binary);
  if (error || !in) return fail(ErrorCode::kNotFound, "cannot read the map's image " + file.string());
  const int first = in.get();
  const int second = in.get();
  if (first != 'P' || (second != '5' && second != '2'))
    return fail(ErrorCode::kUnsupported,
                file.string() + " is neither a PGM nor a PNG image; convert it, for example: convert " +
                    file.filename().string() + " -colorspace Gray " + file.stem().string() + ".png");
  GreyImage image;
  auto read = read_header(in, image);
  if (read) read = read_pixels(in, file_bytes, second == '5', image);
  if (!read) return fail(read.error().code, file.string() + ": " + read.error().message);
  return image;
}

}  // namespace extperfc
