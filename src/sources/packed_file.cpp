#include "sources/packed_file.hpp"

#include <algorithm>
#include <exception>
#include <fstream>
#include <utility>

#include <boost/iostreams/categories.hpp>
#include <boost/iostreams/filter/bzip2.hpp>
#include <boost/iostreams/filter/gzip.hpp>
#include <boost/iostreams/filtering_streambuf.hpp>

namespace extperfc::sources {

namespace {

namespace fs = std::filesystem;
namespace io = boost::iostreams;

/// The file's own bytes, counted.
struct CountedFile {
  std::ifstream file;
  std::uintmax_t size{0};
  std::uintmax_t read{0};
};

/// Boost copies its devices: this one points to the file.
class CountedSource {
 public:
  using char_type = char;
  using category = io::source_tag;

  explicit CountedSource(CountedFile& file) : file_(&file) {}
  std::streamsize read(char* bytes, std::streamsize max_bytes) {
    file_->file.read(bytes, max_bytes);
    const std::streamsize got = file_->file.gcount();
    file_->read += static_cast<std::uintmax_t>(got);
    return got > 0 ? got : -1;
  }

 private:
  CountedFile* file_;
};

bool starts_with(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

}  // namespace

struct PackedFile::Stream {
  CountedFile file;
  io::filtering_istreambuf buffer;
  bool broken{false};

  /// The next character; end of file when nothing more can be unpacked.
  int get() {
    constexpr int kEnd = std::char_traits<char>::eof();
    if (broken) return kEnd;
    try {
      return buffer.sbumpc();
    } catch (const std::exception&) {
      broken = true;
      return kEnd;
    }
  }
};

PackedFile::PackedFile(std::unique_ptr<Stream> stream) : stream_(std::move(stream)) {}
PackedFile::PackedFile(PackedFile&&) noexcept = default;
PackedFile& PackedFile::operator=(PackedFile&&) noexcept = default;
PackedFile::~PackedFile() = default;

Result<PackedFile> PackedFile::open(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return fail(ErrorCode::kNotFound, "no such file: " + file.string());
  auto stream = std::make_unique<Stream>();
  stream->file.size = fs::file_size(file, error);
  stream->file.file.open(file, std::ios::binary);
  if (error || !stream->file.file) return fail(ErrorCode::kNotFound, "cannot open " + file.string());
  std::string magic(3, '\0');
  stream->file.file.read(magic.data(), static_cast<std::streamsize>(magic.size()));
  stream->file.file.clear();
  stream->file.file.seekg(0);
  if (starts_with(magic, "\x1f\x8b")) stream->buffer.push(io::gzip_decompressor());
  if (starts_with(magic, "BZh")) stream->buffer.push(io::bzip2_decompressor());
  stream->buffer.push(CountedSource(stream->file));
  return PackedFile(std::move(stream));
}

PackedFile::Line PackedFile::next_line(std::string& line, std::size_t max_bytes) {
  line.clear();
  bool any = false;
  bool too_long = false;
  for (int c = stream_->get(); c != std::char_traits<char>::eof(); c = stream_->get()) {
    any = true;
    if (c == '\n') break;
    if (line.size() < max_bytes)
      line.push_back(static_cast<char>(c));
    else
      too_long = true;
  }
  if (stream_->broken) return Line::kBroken;
  if (!any) return Line::kEnd;
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return too_long ? Line::kTooLong : Line::kRead;
}

std::string PackedFile::read(std::size_t bytes) {
  std::string text;
  while (text.size() < bytes) {
    const int c = stream_->get();
    if (c == std::char_traits<char>::eof()) break;
    text.push_back(static_cast<char>(c));
  }
  return text;
}

double PackedFile::progress() const {
  const auto& file = stream_->file;
  return file.size == 0 ? 1.0
                        : std::min(1.0, static_cast<double>(file.read) / static_cast<double>(file.size));
}

}  // namespace extperfc::sources
