#include "sources/pair_list.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <locale>
#include <map>
#include <optional>
#include <sstream>
#include <system_error>

#include "sources/natural_order.hpp"

namespace extperfc::sources {

namespace {

namespace fs = std::filesystem;

constexpr double kDefaultRateHz = 30.0;

struct NaturalLess {
  bool operator()(const std::string& a, const std::string& b) const { return natural_less(a, b); }
};

/// Image files of a folder by name without extension.
using ImageFiles = std::map<std::string, fs::path, NaturalLess>;

bool is_image(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

Result<ImageFiles> images_in(const fs::path& folder) {
  ImageFiles found;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (!is_file(it->path()) || !is_image(it->path())) continue;
    const auto [same, is_new] = found.emplace(it->path().stem().string(), it->path());
    if (!is_new)
      return fail(ErrorCode::kInvalidArgument, folder.string() + " holds both " +
                                                   same->second.filename().string() + " and " +
                                                   it->path().filename().string() + "; keep one of them");
  }
  if (error) return fail(ErrorCode::kFailed, "cannot list " + folder.string() + ": " + error.message());
  return found;
}

/// Names in `a` that `b` lacks, as text; the first few only. Empty when there are none.
std::string missing_names(const ImageFiles& a, const ImageFiles& b) {
  constexpr int kShown = 5;
  std::string names;
  int count = 0;
  for (const auto& [name, path] : a) {
    if (b.count(name) != 0 || ++count > kShown) continue;
    names += (names.empty() ? "" : ", ") + path.filename().string();
  }
  return count > kShown ? names + " and " + std::to_string(count - kShown) + " more" : names;
}

Result<std::vector<Pair>> pairs_by_name(const fs::path& color_folder, const fs::path& depth_folder) {
  const auto color = images_in(color_folder);
  if (!color) return tl::unexpected(color.error());
  const auto depth = images_in(depth_folder);
  if (!depth) return tl::unexpected(depth.error());
  const auto no_depth = missing_names(*color, *depth);
  if (!no_depth.empty())
    return fail(ErrorCode::kNotFound,
                "no image of the same name in " + depth_folder.string() + " for " + no_depth);
  const auto no_color = missing_names(*depth, *color);
  if (!no_color.empty())
    return fail(ErrorCode::kNotFound,
                "no image of the same name in " + color_folder.string() + " for " + no_color);
  std::vector<Pair> pairs;
  for (const auto& [name, path] : *color)
    pairs.push_back({static_cast<double>(pairs.size()) / kDefaultRateHz, path, depth->at(name)});
  return pairs;
}

Result<std::vector<Pair>> color_only(const fs::path& folder) {
  const auto color = images_in(folder);
  if (!color) return tl::unexpected(color.error());
  std::vector<Pair> pairs;
  for (const auto& [name, path] : *color)
    pairs.push_back({static_cast<double>(pairs.size()) / kDefaultRateHz, path, {}});
  return pairs;
}

/// One line "stamp colour-file stamp depth-file".
Result<Pair> parse_association(const std::string& line, const fs::path& folder) {
  std::istringstream in(line);
  in.imbue(std::locale::classic());  // a decimal point in every locale
  Pair pair;
  double depth_stamp_s = 0.0;
  std::string color;
  std::string depth;
  if (!(in >> pair.stamp_s >> color >> depth_stamp_s >> depth))
    return fail(ErrorCode::kCorrupt, "expected 'stamp colour-file stamp depth-file', found '" + line + "'");
  pair.color = folder / color;
  pair.depth = folder / depth;
  for (const auto& file : {pair.color, pair.depth})
    if (!is_file(file)) return fail(ErrorCode::kNotFound, "no file " + file.string());
  return pair;
}

Result<std::vector<Pair>> pairs_from_associations(const fs::path& file) {
  std::ifstream in(file);
  if (!in) return fail(ErrorCode::kFailed, "cannot read " + file.string());
  std::vector<Pair> pairs;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const auto first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    auto pair = parse_association(line, file.parent_path());
    if (!pair)
      return fail(pair.error().code,
                  file.string() + " line " + std::to_string(number) + ": " + pair.error().message);
    pairs.push_back(*std::move(pair));
  }
  return pairs;
}

Result<std::vector<Pair>> find_pairs(const fs::path& folder) {
  if (is_file(folder / "associations.txt")) return pairs_from_associations(folder / "associations.txt");
  for (const char* name : {"rgb", "color"}) {
    if (!is_folder(folder / name)) continue;
    if (is_folder(folder / "depth")) return pairs_by_name(folder / name, folder / "depth");
    return fail(ErrorCode::kNotFound, folder.string() + " has " + name +
                                          "/ but no depth/; to play colour alone, give " +
                                          (folder / name).string());
  }
  return color_only(folder);
}

}  // namespace

Result<std::vector<Pair>> list_pairs(const fs::path& folder) {
  if (!is_folder(folder)) return fail(ErrorCode::kNotFound, "no such folder: " + folder.string());
  auto pairs = find_pairs(folder);
  if (pairs && pairs->empty())
    return fail(ErrorCode::kNotFound,
                "no images in " + folder.string() +
                    "; searched for associations.txt, for equal names of .png or .jpg files in "
                    "rgb/ (or color/) and depth/, and for images in the folder itself");
  return pairs;
}

}  // namespace extperfc::sources
